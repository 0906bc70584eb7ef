//! A byte a coordinate and a byte a corner: hostile little meshes through welding, closing, segmentation and sizing.
#![no_main]

use glam::DVec3;
use libfuzzer_sys::fuzz_target;
use midshell::import::facet::shells::solids;
use midshell::import::facet::sized;
use midshell::import::facet::soup::Soup;
use midshell::import::facet::weld::weld;

/// Sizes so many times the usual ones: at those a needle takes hundreds of thousands of facets, and a run of the fuzzer most of a minute.
const COARSE: f64 = 20.0;

fuzz_target!(|bytes: &[u8]| {
    let Some((&count, rest)) = bytes.split_first() else {
        return;
    };
    let count = usize::from(count % 32) + 3;
    if rest.len() < 3 * count {
        return;
    }
    let (points, corners) = rest.split_at(3 * count);
    let soup = Soup {
        points: points
            .chunks_exact(3)
            .map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into()))
            .collect(),
        triangles: corners
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]].map(|v| u32::from(v) % count as u32))
            .collect(),
    };
    if let Ok((found, _)) = solids(weld(&soup).0) {
        for solid in found.iter().filter(|s| s.cut.is_none()) {
            let _ = sized(&solid.facets, COARSE, true);
        }
    }
});
