//! Where feature curves have corners: the ends of what may slide along a curve or be divided anew.

use crate::model::complex::{MidComplex, ends, pin};
use crate::model::ids::NodeId;

/// A curve has a corner where it turns more than this: less is a bend divided coarsely.
const CORNER_RAD: f64 = 35.0 * std::f64::consts::PI / 180.0;

/// Whether a node with these two neighbours on a feature curve lies within it: the curve goes on smoothly there, no edge of the solid says that there is a corner, and it has no place of its own.
pub fn is_within_curve(complex: &MidComplex, node: NodeId, [before, after]: [NodeId; 2]) -> bool {
    let [a, here, b] = [before, node, after].map(|n| complex.nodes[n].point);
    let turn = (here - a).angle_between(b - here);
    let supports = &complex.nodes[node].supports;
    turn < CORNER_RAD && ends(supports).count() < 2 && pin(supports).is_none()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::{MidNode, Support};
    use crate::model::ids::{FaceId, PinId};
    use glam::DVec3;

    #[test]
    fn a_sharp_turn_or_two_faces_make_a_corner() {
        let node = |point, faces: u32| MidNode {
            point,
            supports: (0..faces).map(|f| Support::Face(FaceId(f))).collect(),
        };
        let bent = |degrees: f64, faces: u32| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let mut complex = MidComplex::default();
            let a = complex.nodes.push(node(-DVec3::X, 1));
            let n = complex.nodes.push(node(DVec3::ZERO, faces));
            let b = complex.nodes.push(node(DVec3::new(cos, sin, 0.0), 1));
            is_within_curve(&complex, n, [a, b])
        };
        assert!(bent(30.0, 1) && !bent(40.0, 1) && !bent(0.0, 2));
    }

    #[test]
    fn a_place_of_its_own_makes_a_corner() {
        let mut complex = MidComplex::default();
        let nodes = [-1.0, 0.0, 1.0].map(|x| {
            let point = DVec3::X * x;
            let supports = Default::default();
            complex.nodes.push(MidNode { point, supports })
        });
        let [a, n, b] = nodes;
        assert!(is_within_curve(&complex, n, [a, b]));
        complex.nodes[n].supports.push(Support::Pin(PinId(0)));
        assert!(!is_within_curve(&complex, n, [a, b]));
    }
}
