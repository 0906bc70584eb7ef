//! A cross field over a patch: at every place four directions at right angles, one of them along the boundary where there is one near.
//!
//! Smoothest field of fourth powers (Knöppel, Crane, Pinkall & Schröder 2013, "Globally optimal direction fields", doi:10.1145/2461912.2462005)
//! with the boundary's directions held: the angle to a frame of each corner, times four, as a complex number; one sparse solve. Where the patch bends one way more than the
//! other, the field is drawn along the bend, so that quads there are not warped.
//!
//! **Guarantees.** A direction everywhere, in the plane of the old triangle there; the same for a patch moved or scaled, but for rounding.
//! **Limits.** Singular places lie where the solution vanishes; between them and the corners around the direction may turn fast. A closed patch without an edge to
//! hold on to takes its first side for one.
//! **Cost.** One sparse factorisation of twice as many unknowns as the patch has free corners.

use super::surface::{Spot, Surface};
use crate::geom::bend::{Bend, bend};
use crate::geom::placer::Lengths;
use crate::model::patch::Patch;
use crate::solve::SpdSolver;
use glam::{DVec2, DVec3};

/// Weights of sides are cotangents; beside flat triangles these are held to this range, so that the system stays definite and well conditioned.
const WEIGHTS: [f64; 2] = [0.05, 20.0];

/// A triangle whose normal turns by less than this, rad, over its longest side does not say which way the patch bends: five degrees.
const LEAST_TURN: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Nor does one that bends the other way by more than this share.
const ONE_WAY: f64 = 0.5;
/// Weight of a bend against that of a side, which is one in a good mesh.
const DRAWN: f64 = 1.0;

/// Where edges may be so many times as long one way as the other, they run that way,
const LONG: f64 = 1.2;
/// with this weight: a long quad at a slant to its bend is warped.
const ALONG: f64 = 10.0;

/// Directions at the corners of a patch.
#[derive(Clone, Debug)]
pub(super) struct Cross {
    /// #C two unit vectors at right angles in the plane that the patch has at the corner.
    frames: Vec<[DVec3; 2]>,
    /// #C fourth power of the direction, in that frame.
    powers: Vec<DVec2>,
}

impl Cross {
    /// The smoothest field along these edges (corners of the patch), and along the axes of what is wanted at the corners, where that is longer one way;
    /// `None` where the system cannot be solved, as with triangles without area.
    pub(super) fn new(surface: &Surface, edges: &[[u32; 2]], wanted: &[Lengths]) -> Option<Self> {
        let patch = surface.patch;
        let frames: Vec<[DVec3; 2]> = (surface.normals.iter())
            .map(|n| n.normalize_or(DVec3::Z).any_orthonormal_pair())
            .map(|(x, y)| [x, y])
            .collect();
        let power = |c: u32, way: DVec3| {
            let [x, y] = frames[c as usize];
            fourth(DVec2::new(way.dot(x), way.dot(y)))
        };
        let mut held = vec![DVec2::ZERO; patch.nodes.len()];
        let first = [patch.triangles.first().map(|t| [t[0], t[1]])];
        let edges: Vec<[u32; 2]> = match edges {
            [] => first.into_iter().flatten().collect(),
            _ => edges.to_vec(),
        };
        for &[a, b] in &edges {
            let way = patch.points[b as usize] - patch.points[a as usize];
            for c in [a, b] {
                held[c as usize] += power(c, way);
            }
        }
        // Where edges meet at half a right angle their crosses contradict each other.
        let held: Vec<Option<DVec2>> = (held.into_iter())
            .map(|h| (h.length() > 0.1).then(|| h.normalize()))
            .collect();
        let mut bends = bends(surface, &power);
        for (c, lengths) in wanted.iter().enumerate() {
            if lengths.along > LONG * lengths.across {
                bends[c] = (power(c as u32, lengths.axis) * ALONG, ALONG);
            }
        }
        let powers = smoothest(patch, &held, &bends, &power)?;
        Some(Self { frames, powers })
    }

    /// The two directions at a corner: unit vectors at right angles in the plane that the patch has there.
    pub(super) fn ways(&self, corner: usize) -> [DVec3; 2] {
        let (sin, cos) = (self.powers[corner].to_angle() / 4.0).sin_cos();
        let [x, y] = self.frames[corner];
        [x * cos + y * sin, y * cos - x * sin]
    }

    /// A unit direction at a spot, in the plane of its triangle; the others are at right angles to it.
    pub(super) fn at(&self, surface: &Surface, spot: &Spot) -> DVec3 {
        let normal = surface.flat_normal(spot.triangle);
        let (x, y) = normal.any_orthonormal_pair();
        let corners = surface.patch.triangles[spot.triangle as usize];
        let mut sum = DVec2::ZERO;
        for (&c, w) in corners.iter().zip(spot.weights) {
            let [way, _] = self.ways(c as usize);
            sum += fourth(DVec2::new(way.dot(x), way.dot(y))) * w;
        }
        let angle = sum.to_angle() / 4.0;
        x * angle.cos() + y * angle.sin()
    }
}

/// The fourth power of a direction, of length one: the same for all four of its cross.
fn fourth(way: DVec2) -> DVec2 {
    let unit = way.normalize_or_zero();
    let square = unit.rotate(unit);
    square.rotate(square)
}

/// For each corner the sum of the directions in which the triangles there bend, as fourth powers with weights, and the sum of these.
fn bends(surface: &Surface, power: &dyn Fn(u32, DVec3) -> DVec2) -> Vec<(DVec2, f64)> {
    let patch = surface.patch;
    let normals: Vec<DVec3> = (surface.normals.iter())
        .map(|n| n.normalize_or_zero())
        .collect();
    let mut sums = vec![(DVec2::ZERO, 0.0); patch.nodes.len()];
    for (i, t) in patch.triangles.iter().enumerate() {
        let [p, q, r] = patch.triangle_points(i);
        let Bend { way, most, least } = bend([p, q, r], t.map(|c| normals[c as usize]));
        let length = p.distance(q).max(q.distance(r)).max(r.distance(p));
        let turn = most.abs() * length;
        if !(turn.is_finite() && turn > LEAST_TURN && least.abs() < ONE_WAY * most.abs()) {
            continue;
        }
        let weight = DRAWN * (turn / LEAST_TURN - 1.0).min(1.0);
        for &c in t {
            let (sum, total) = &mut sums[c as usize];
            *sum += power(c, way) * weight;
            *total += weight;
        }
    }
    sums
}

/// Fourth powers at the corners that differ least along the sides of triangles, and from what draws them.
fn smoothest(
    patch: &Patch,
    held: &[Option<DVec2>],
    drawn: &[(DVec2, f64)],
    power: &dyn Fn(u32, DVec3) -> DVec2,
) -> Option<Vec<DVec2>> {
    let mut place = vec![u32::MAX; held.len()];
    let mut free = 0u32;
    for (c, h) in held.iter().enumerate() {
        if h.is_none() {
            place[c] = free;
            free += 1;
        }
    }
    let mut triplets: Vec<(u32, u32, f64)> = Vec::new();
    let mut right = vec![0.0; 2 * free as usize];
    for t in &patch.triangles {
        for k in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|i| t[(k + i) % 3]);
            let [p, q, r] = [a, b, c].map(|c| patch.points[c as usize]);
            let (u, v) = (p - r, q - r);
            let cotangent = u.dot(v) / u.cross(v).length();
            let weight = if cotangent.is_finite() {
                (cotangent / 2.0).clamp(WEIGHTS[0], WEIGHTS[1])
            } else {
                WEIGHTS[1]
            };
            // What `a` has, as `b` sees it: their frames see the side between them at different angles.
            let turn = power(b, q - p).rotate(conjugate(power(a, q - p)));
            for (from, to, turn) in [(a, b, turn), (b, a, conjugate(turn))] {
                let row = place[to as usize];
                if row == u32::MAX {
                    continue;
                }
                for i in 0..2 {
                    triplets.push((2 * row + i, 2 * row + i, weight));
                }
                match held[from as usize] {
                    Some(known) => {
                        let known = turn.rotate(known) * weight;
                        right[2 * row as usize] += known.x;
                        right[2 * row as usize + 1] += known.y;
                    }
                    None => {
                        let column = place[from as usize];
                        let (cos, sin) = (weight * turn.x, weight * turn.y);
                        triplets.push((2 * row, 2 * column, -cos));
                        triplets.push((2 * row, 2 * column + 1, sin));
                        triplets.push((2 * row + 1, 2 * column, -sin));
                        triplets.push((2 * row + 1, 2 * column + 1, -cos));
                    }
                }
            }
        }
    }
    for (c, &(sum, weight)) in drawn.iter().enumerate() {
        let row = place[c];
        if row != u32::MAX {
            right[2 * row as usize] += sum.x;
            right[2 * row as usize + 1] += sum.y;
            triplets.extend([0, 1].map(|i| (2 * row + i, 2 * row + i, weight)));
        }
    }
    let solved = SpdSolver::factor(2 * free as usize, &triplets)
        .ok()?
        .solve(&right);
    let at = |c: usize| match held[c] {
        Some(known) => known,
        None => {
            let i = 2 * place[c] as usize;
            DVec2::new(solved[i], solved[i + 1])
        }
    };
    // Far from what is held powers are small, but their directions are as good.
    Some(
        (0..held.len())
            .map(|c| at(c).normalize_or(DVec2::X))
            .collect(),
    )
}

fn conjugate(z: DVec2) -> DVec2 {
    DVec2::new(z.x, -z.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ids::PatchId;
    use crate::stage::flatten::flatten;
    use crate::stage::patch::patches;
    use crate::stage::test_shapes as shapes;

    /// The greatest angle, rad, between the field and a direction or one at right angles to it, in the middles of the old triangles.
    fn greatest_turn(patch: &Patch, edges: &[[u32; 2]], way: impl Fn(DVec3) -> DVec3) -> f64 {
        let chart = flatten(patch).unwrap();
        let surface = Surface::new(patch, &chart);
        let cross = Cross::new(&surface, edges, &[]).unwrap();
        (0..patch.triangles.len() as u32)
            .map(|triangle| {
                let spot = Spot {
                    triangle,
                    weights: [1.0 / 3.0; 3],
                };
                let normal = surface.flat_normal(triangle);
                let way = way(surface.lift(&spot)).reject_from(normal);
                let turn =
                    cross.at(&surface, &spot).angle_between(way) % std::f64::consts::FRAC_PI_2;
                turn.min(std::f64::consts::FRAC_PI_2 - turn)
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn on_a_rectangle_the_field_runs_along_its_sides() {
        let plate = shapes::moved(&shapes::sheet(9, 6, |u, v| {
            DVec3::new(9.0 * u, 6.0 * v, 0.0)
        }));
        let patch = patches(&plate)[PatchId(0)].clone();
        let along = patch.points[1] - patch.points[0];
        let edges: Vec<[u32; 2]> = patch.boundary().collect();
        assert!(greatest_turn(&patch, &edges, |_| along) < 1e-9);
    }

    #[test]
    fn on_a_ring_it_runs_round() {
        let ring = shapes::sheet(48, 6, |u, v| {
            let (s, c) = (std::f64::consts::TAU * u).sin_cos();
            (10.0 + 8.0 * v) * DVec3::new(c, s, 0.0)
        });
        let patch = patches(&ring)[PatchId(0)].clone();
        let edges: Vec<[u32; 2]> = patch.boundary().collect();
        // Chords of 7.5 degrees, and a field that is linear over triangles.
        assert!(greatest_turn(&patch, &edges, |p| p) < 0.07);
    }

    #[test]
    fn in_a_bend_it_follows_the_bend() {
        // A quarter of a cylinder whose free edges run across it at a slant: they alone would turn the field by up to 35 degrees.
        let bend = shapes::sheet(12, 30, |u, v| {
            let (s, c) = (std::f64::consts::FRAC_PI_2 * u).sin_cos();
            DVec3::new(4.0 * c, 4.0 * s, 30.0 * v + 4.0 * u)
        });
        let patch = patches(&bend)[PatchId(0)].clone();
        let slant: Vec<[u32; 2]> = (patch.boundary())
            .filter(|e| {
                let way = patch.points[e[1] as usize] - patch.points[e[0] as usize];
                way.normalize().z.abs() < 0.99
            })
            .collect();
        let middle = |p: DVec3| p.z > 8.0 && p.z < 26.0;
        let chart = flatten(&patch).unwrap();
        let surface = Surface::new(&patch, &chart);
        let cross = Cross::new(&surface, &slant, &[]).unwrap();
        for triangle in 0..patch.triangles.len() as u32 {
            let spot = Spot {
                triangle,
                weights: [1.0 / 3.0; 3],
            };
            if !middle(surface.lift(&spot)) {
                continue;
            }
            let turn =
                cross.at(&surface, &spot).angle_between(DVec3::Z) % std::f64::consts::FRAC_PI_2;
            assert!(turn.min(std::f64::consts::FRAC_PI_2 - turn) < 0.1);
        }
    }

    #[test]
    fn a_direction_and_its_quarter_turns_have_one_fourth_power() {
        let way = DVec2::from_angle(0.3);
        let power = fourth(way);
        for k in 1..4 {
            let turned = DVec2::from_angle(0.3 + f64::from(k) * std::f64::consts::FRAC_PI_2);
            assert!(fourth(3.0 * turned).distance(power) < 1e-12);
        }
        assert!((power.to_angle() - 1.2).abs() < 1e-12);
    }
}
