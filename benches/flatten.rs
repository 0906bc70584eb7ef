//! How long it takes to lay a patch flat: `cargo bench --bench flatten`.
//!
//! A hundred thousand triangles each, on one thread.

use divan::Bencher;
use glam::DVec3;
use midshell::model::complex::{MidComplex, MidNode, MidTriangle, Support};
use midshell::model::ids::{NodeId, WallId};
use midshell::model::patch::Patch;
use midshell::stage::flatten::flatten;
use midshell::stage::patch::patches;

/// Squares along each side: twice their square is the number of triangles.
const SIDE: u32 = 224;

/// A surface over the unit square.
#[derive(Clone, Copy, Debug)]
enum Surface {
    Plane,
    /// A third of a turn: laid flat without distortion.
    Cylinder,
    /// A shallow cap: no chart keeps all its lengths.
    Cap,
    /// A saddle with a square hole in its middle.
    Saddle,
}

impl Surface {
    fn point(self, u: f64, v: f64) -> DVec3 {
        let (x, y) = (u - 0.5, v - 0.5);
        match self {
            Self::Plane => DVec3::new(x, y, 0.0),
            Self::Cylinder => DVec3::new((2.0 * x).sin(), y, (2.0 * x).cos()),
            Self::Cap => DVec3::new(x, y, (1.0 - x * x - y * y).sqrt()),
            Self::Saddle => DVec3::new(x, y, 0.5 * (x * x - y * y)),
        }
    }

    fn has_hole(self) -> bool {
        matches!(self, Self::Saddle)
    }

    fn patch(self) -> Patch {
        let wall = WallId(0);
        let mut complex = MidComplex::default();
        for j in 0..=SIDE {
            for i in 0..=SIDE {
                let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(SIDE));
                complex.nodes.push(MidNode {
                    point: self.point(u, v),
                    supports: [Support::Mid(wall)].into_iter().collect(),
                });
            }
        }
        let node = |i: u32, j: u32| NodeId(j * (SIDE + 1) + i);
        let inner = (SIDE / 3)..(SIDE / 2);
        for (i, j) in (0..SIDE).flat_map(|j| (0..SIDE).map(move |i| (i, j))) {
            if self.has_hole() && inner.contains(&i) && inner.contains(&j) {
                continue;
            }
            let [a, b, c, d] = [
                node(i, j),
                node(i + 1, j),
                node(i + 1, j + 1),
                node(i, j + 1),
            ];
            for nodes in [[a, b, c], [a, c, d]] {
                complex.triangles.push(MidTriangle { nodes, wall });
            }
        }
        patches(&complex).as_slice()[0].clone()
    }
}

#[divan::bench(args = [Surface::Plane, Surface::Cylinder, Surface::Cap, Surface::Saddle], sample_count = 5, sample_size = 1)]
fn lay_flat(bencher: Bencher, surface: &Surface) {
    let patch = surface.patch();
    bencher.bench(|| {
        let chart = flatten(divan::black_box(&patch));
        assert!(chart.is_ok(), "{chart:?}");
        chart
    });
}

fn main() {
    // Set before the first parallel call: the figures are those of one thread.
    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build_global();
    assert!(one.is_ok(), "{one:?}");
    divan::main();
}
