//! Bytes as a file of this format: what is read is sound.
#![no_main]

use libfuzzer_sys::fuzz_target;
use midshell::import::facet::FacetFormat;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(soup) = FacetFormat::Stl.parse(bytes) {
        assert!(soup.points.iter().all(|p| p.is_finite()));
        let count = soup.points.len();
        assert!(soup.triangles.iter().flatten().all(|&v| (v as usize) < count));
    }
});
