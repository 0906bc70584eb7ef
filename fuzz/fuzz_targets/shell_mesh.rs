//! Bytes as a mesh of any format that is audited; the first says which. What is read is sound.
#![no_main]

use libfuzzer_sys::fuzz_target;
use midshell::read::MeshFormat;

fuzz_target!(|bytes: &[u8]| {
    let Some((which, bytes)) = bytes.split_first() else {
        return;
    };
    let format = MeshFormat::ALL[usize::from(*which) % MeshFormat::ALL.len()];
    if let Ok(read) = format.parse(bytes) {
        assert!(read.mesh.nodes.iter().all(|p| p.is_finite()));
        assert_eq!(read.node_numbers.len(), read.mesh.nodes.len());
        assert_eq!(read.element_numbers.len(), read.mesh.elements.len());
        let corners = read.mesh.elements.iter().flat_map(|e| e.corners.as_slice());
        assert!(corners.into_iter().all(|n| read.mesh.nodes.get(*n).is_some()));
    }
});
