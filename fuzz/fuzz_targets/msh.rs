//! Bytes as an MSH file; what is read is built into solids.
#![no_main]

use libfuzzer_sys::fuzz_target;
use midshell::import::msh::Msh;
use midshell::import::piece::build_pieces;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(msh) = Msh::parse(bytes) {
        let _ = build_pieces(&msh);
    }
});
