//! Nodes of four boxes, which one pass of vector arithmetic tests together.
//!
//! Boxes are kept in f32, relative to the hierarchy's centre and scaled by a power of two to at most one, so that no square leaves the range of f32.
//!
//! Guarantee: a distance to a box is never more, a ray's way through it never less than with exact arithmetic: rounding may only cost time.
//!
//! Reference: H. Dammertz, J. Hanika, A. Keller, "Shallow bounding volume hierarchies for fast SIMD ray tracing of incoherent rays", CGF 27 (2008),
//! doi:10.1111/j.1467-8659.2008.01261.x.

use glam::{DVec3, Vec3A, Vec4};

/// Boxes in a node.
pub(super) const WIDTH: usize = 4;
/// What may be lost in a handful of multiplications and additions of f32, relative.
const ROUNDING: f32 = 2e-6;
/// Coordinates further off, in sizes of the hierarchy, would leave the range of f32 when squared.
const FAR: f32 = 1e18;
/// The largest reciprocal of a direction: what runs slower along an axis stands still there.
const STEEPEST: f64 = 1e30;

/// What lies in a box: a node or a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(u32);

const LEAF: u32 = 1 << 31;

impl Child {
    /// Nothing at all.
    const NONE: Self = Self(u32::MAX);

    /// Another node.
    pub(super) fn node(index: usize) -> Self {
        Self(index as u32)
    }

    /// A triangle.
    pub(super) fn leaf(index: usize) -> Self {
        Self(LEAF | index as u32)
    }

    /// The node, or the triangle.
    #[inline]
    pub(super) fn open(self) -> Result<usize, usize> {
        if self.0 & LEAF == 0 {
            Ok(self.0 as usize)
        } else {
            Err((self.0 & !LEAF) as usize)
        }
    }
}

/// A child and how near it is: sorts by that.
pub(super) type Entry = u64;

#[inline]
fn entry(near: f32, child: Child) -> Entry {
    // Non-negative numbers sort as their bits do.
    u64::from(near.to_bits()) << 32 | u64::from(child.0)
}

/// The parts of an entry.
#[inline]
pub(super) fn parts(entry: Entry) -> (f32, Child) {
    (f32::from_bits((entry >> 32) as u32), Child(entry as u32))
}

/// An entry that is looked at in any case.
pub(super) fn first(child: Child) -> Entry {
    entry(0.0, child)
}

/// Four boxes and what lies in them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wide {
    low: [Vec4; 3],
    high: [Vec4; 3],
    children: [Child; WIDTH],
}

/// A point among the boxes, and what may be lost in taking a box's distance from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe {
    at: Vec3A,
    slack: f32,
}

impl Probe {
    /// Of a point relative to the centre, in units of the boxes.
    #[inline]
    pub(super) fn new(p: DVec3) -> Self {
        let at = p.as_vec3a();
        let reach = at.abs().max_element();
        if reach < FAR {
            Self {
                at,
                // Rounding of the point, and of a difference between it and a box: a unit in the last place (2^-24) each of some coordinate of theirs.
                slack: 2.0 * f32::EPSILON * reach.max(1.0),
            }
        } else {
            Self {
                at: Vec3A::ZERO,
                slack: f32::INFINITY,
            }
        }
    }
}

/// A ray among the boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam {
    probe: Probe,
    inverse: Vec3A,
    /// Units of the boxes that one unit of the ray's parameter makes.
    speed: f64,
}

impl Beam {
    /// From a point relative to the centre along a direction other than zero, both in units of the boxes.
    pub(super) fn new(from: DVec3, direction: DVec3) -> Self {
        let speed = direction.abs().max_element();
        let inverse = (direction / speed).to_array().map(|x| {
            let inverse = x.abs().recip().min(STEEPEST);
            if x < 0.0 { -inverse } else { inverse }
        });
        Self {
            probe: Probe::new(from),
            inverse: DVec3::from_array(inverse).as_vec3a(),
            speed,
        }
    }

    /// Bounds on the parameter in units of the boxes, a little wider.
    pub(super) fn bounds(&self, [from, to]: [f64; 2]) -> [f32; 2] {
        let [from, to] = [from * self.speed, to * self.speed].map(|t| t as f32);
        [
            (from - ROUNDING * from.abs()).next_down(),
            (to + ROUNDING * to.abs()).next_up(),
        ]
    }
}

/// An upper bound for squared distances in f32, for one in units of the boxes; never infinite.
#[inline]
pub(super) fn limit(squared: f64) -> f32 {
    ((squared as f32) * (1.0 + ROUNDING))
        .next_up()
        .min(f32::MAX)
}

impl Default for Wide {
    fn default() -> Self {
        Self::new(&[])
    }
}

impl Wide {
    /// Of up to four children with their boxes.
    pub(super) fn new(boxes: &[(Vec3A, Vec3A, Child)]) -> Self {
        let mut wide = Self {
            low: [Vec4::INFINITY; 3],
            high: [Vec4::NEG_INFINITY; 3],
            children: [Child::NONE; WIDTH],
        };
        for (k, &(low, high, child)) in boxes.iter().enumerate().take(WIDTH) {
            for axis in 0..3 {
                wide.low[axis][k] = low[axis];
                wide.high[axis][k] = high[axis];
            }
            wide.children[k] = child;
        }
        wide
    }

    /// The children whose boxes are within the squared distance, the nearest first; how many.
    #[inline]
    pub(super) fn near(&self, probe: &Probe, limit: f32) -> ([Entry; WIDTH], usize) {
        let mut sum = Vec4::ZERO;
        let slack = Vec4::splat(probe.slack);
        for axis in 0..3 {
            let at = Vec4::splat(probe.at[axis]);
            let outside = (self.low[axis] - at).max(at - self.high[axis]) - slack;
            let d = outside.max(Vec4::ZERO);
            sum += d * d;
        }
        self.sorted(sum, sum.cmple(Vec4::splat(limit)).bitmask())
    }

    /// The children whose boxes the ray meets within the bounds, those nearest to its origin first; how many.
    #[inline]
    pub(super) fn ahead(&self, beam: &Beam, [from, to]: [f32; 2]) -> ([Entry; WIDTH], usize) {
        let (mut near, mut far) = (Vec4::splat(from), Vec4::splat(to));
        let slack = Vec4::splat(beam.probe.slack);
        for axis in 0..3 {
            let at = Vec4::splat(beam.probe.at[axis]);
            let inverse = Vec4::splat(beam.inverse[axis]);
            let s = (self.low[axis] - at - slack) * inverse;
            let t = (self.high[axis] - at + slack) * inverse;
            near = near.max(s.min(t));
            far = far.min(s.max(t));
        }
        let near = near - near.abs() * ROUNDING;
        let far = far + far.abs() * ROUNDING;
        let away = near.max(-far).max(Vec4::ZERO);
        self.sorted(away, near.cmple(far).bitmask())
    }

    #[inline]
    fn sorted(&self, near: Vec4, mask: u32) -> ([Entry; WIDTH], usize) {
        let near = near.to_array();
        let mut e: [Entry; WIDTH] = std::array::from_fn(|k| {
            if mask >> k & 1 == 1 && self.children[k] != Child::NONE {
                entry(near[k], self.children[k])
            } else {
                Entry::MAX
            }
        });
        // A sorting network: no branch depends on the order.
        for (i, j) in [(0, 1), (2, 3), (0, 2), (1, 3), (1, 2)] {
            (e[i], e[j]) = (e[i].min(e[j]), e[i].max(e[j]));
        }
        let count = e.iter().filter(|&&e| e != Entry::MAX).count();
        (e, count)
    }
}
