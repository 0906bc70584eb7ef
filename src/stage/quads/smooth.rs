//! Smoothing: free nodes go where their cells are squares, then where the worst of their cells is best.
//!
//! First the cells round a node each say where it would lie if they were the nearest square, or later the nearest rectangle (shape matching: Bouaziz et al. 2012,
//! "Shape-Up", doi:10.1111/j.1467-8659.2012.03171.x), and it goes to the mean; bad cells weigh more. Where quads were laid long,
//! squares are as long, and rectangles lie along. Then a pattern search at the nodes of what is still bad
//! (Freitag & Ollivier-Gooch 1997). Nodes stay on the ground; the worst cell of a node never gets worse than what is good enough (`cells::GOOD`).

use super::cells::{Cells, Few, GOOD, Ground, Place, quality};
use super::stretch::{done, undone};
use glam::DVec3;
use std::f64::consts::TAU;

/// Sweeps towards squares, which even out sizes, and towards rectangles after them, which leave sizes alone and straighten angles.
const SQUARES: usize = 8;
const RECTANGLES: usize = 24;
/// A node that moved less than this share of the mean edge length at it sleeps until a neighbour moves more.
const ASLEEP: f64 = 0.003;
/// Cells worse than this are worth a search.
const WANTED: f64 = 0.85;
/// Steps of the search, as shares of the mean edge length.
const STEPS: [f64; 5] = [0.3, 0.15, 0.08, 0.04, 0.02];
/// Sweeps of the search.
const SEARCHES: usize = 3;

/// How long to smooth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effort {
    /// Between two changes of topology.
    Brief,
    /// At the end.
    Whole,
}

/// Smooths all free nodes.
pub(super) fn smooth(cells: &mut Cells, ground: &dyn Ground, effort: Effort) {
    let free: Vec<u32> = (0..cells.points.len() as u32)
        .filter(|&n| !cells.held[n as usize] && !cells.star(n).is_empty())
        .collect();
    let share = if effort == Effort::Brief { 4 } else { 1 };
    let mut awake = vec![true; cells.points.len()];
    for sweep in 0..(SQUARES + RECTANGLES) / share {
        let mut moves = false;
        for &n in &free {
            if !std::mem::replace(&mut awake[n as usize], false) {
                continue;
            }
            let before = cells.points[n as usize];
            if !settle(cells, n, sweep < SQUARES / share, ground) {
                continue;
            }
            let moved = before.distance(cells.points[n as usize]);
            if moved > ASLEEP * mean_edge(cells, n) {
                moves = true;
                awake[n as usize] = true;
                for i in 0..cells.star(n).len() {
                    let c = cells.star(n)[i];
                    cells.ring(c).iter().for_each(|&m| awake[m as usize] = true);
                }
            }
        }
        // Rectangles are another aim.
        if sweep + 1 == SQUARES / share {
            awake.fill(true);
        } else if !moves && sweep >= SQUARES / share {
            break;
        }
    }
    if effort == Effort::Brief {
        return;
    }
    for _ in 0..SEARCHES {
        for &n in &free {
            search(cells, n, ground);
        }
    }
}

/// The mean length of the edges at a node, mm.
pub(super) fn mean_edge(cells: &Cells, node: u32) -> f64 {
    let neighbours = cells.neighbours(node);
    let home = cells.points[node as usize];
    let all: f64 = (neighbours.iter())
        .map(|&n| home.distance(cells.points[n as usize]))
        .sum();
    all / neighbours.len().max(1) as f64
}

/// Moves a node to the mean of where its cells want it; whether it moved.
pub(super) fn settle(cells: &mut Cells, node: u32, square: bool, ground: &dyn Ground) -> bool {
    let star: Few = cells.star(node).clone();
    match wanted(cells, node, square) {
        Some((sum, total)) => {
            let target = ground.foot(sum / total, cells.place(node).hint);
            try_move(cells, node, target, &star)
        }
        None => false,
    }
}

/// Where the cells of a node want it: the sum of their wishes, and of the weights of these.
pub(super) fn wanted(cells: &Cells, node: u32, square: bool) -> Option<(DVec3, f64)> {
    let stretch = cells.place(node).stretch;
    let (mut sum, mut total) = (DVec3::ZERO, 0.0);
    for &c in cells.star(node) {
        let ring = cells.ring(c);
        let Some(k) = ring.iter().position(|&n| n == node) else {
            continue;
        };
        let p = cells.corners(c);
        let (wish, worth) = match p.as_slice() {
            &[p0, p1, p2, p3] => {
                let p = [p0, p1, p2, p3];
                let normal = (p2 - p0).cross(p3 - p1);
                // Between a share of a good cell and all of a bad one.
                (
                    match square {
                        true => done(wish(p.map(|p| undone(p, stretch)), k, true), stretch),
                        false if stretch == DVec3::ZERO => wish(p, k, false),
                        false => along(p, k, stretch),
                    },
                    1.1 - quality(&p, normal).clamp(0.0, 1.0),
                )
            }
            p => (apex(p, k), 0.5),
        };
        sum += wish * worth;
        total += worth;
    }
    (total > 0.0).then_some((sum, total))
}

/// Moves a node unless its cells become bad by it, or worse than they were.
fn try_move(cells: &mut Cells, node: u32, target: Place, star: &[u32]) -> bool {
    let before = cells.worst(star);
    let old = cells.place(node);
    cells.put(node, target);
    let after = cells.worst(star);
    let fine = target.point.is_finite() && (after >= before || after >= GOOD);
    if !fine {
        cells.put(node, old);
    }
    fine
}

/// Where the `k`-th corner of a quad lies in the nearest square or rectangle.
fn wish(p: [DVec3; 4], k: usize, square: bool) -> DVec3 {
    let (centre, x, y) = axes(p);
    let normal = x.cross(y).normalize_or_zero();
    // Both are turned by the same angle to stand at right angles, the way that leaves their bisector.
    let turned = normal.cross(x);
    let (u, v) = if square {
        // Least squares: the mean of x and y turned back by a quarter.
        let u = (x + y.cross(normal)) / 2.0;
        (u, normal.cross(u))
    } else {
        let along =
            (x.normalize_or_zero() + y.normalize_or_zero().cross(normal)).normalize_or_zero();
        (along * x.length(), normal.cross(along) * y.length())
    };
    if turned == DVec3::ZERO {
        return p[k];
    }
    let [su, sv] = SIGNS[k];
    centre + u * su + v * sv
}

/// Where the `k`-th corner of a quad lies in the rectangle of the same sides along a direction: rows along a bend stay where they were laid, and straight.
fn along(p: [DVec3; 4], k: usize, direction: DVec3) -> DVec3 {
    let (centre, x, y) = axes(p);
    let normal = x.cross(y).normalize_or_zero();
    let a = direction.reject_from(normal).normalize_or_zero();
    let b = normal.cross(a);
    // Of the two it is the nearer one that runs along.
    let (u, v) = if x.normalize_or_zero().dot(a).abs() >= y.normalize_or_zero().dot(a).abs() {
        (
            a * x.length().copysign(x.dot(a)),
            b * y.length().copysign(y.dot(b)),
        )
    } else {
        (
            b * x.length().copysign(x.dot(b)),
            a * y.length().copysign(y.dot(a)),
        )
    };
    if u.cross(v).dot(normal) <= 0.0 {
        return wish(p, k, false);
    }
    let [su, sv] = SIGNS[k];
    centre + u * su + v * sv
}

/// The centre of a quad, and half the vectors between the middles of opposite sides.
fn axes(p: [DVec3; 4]) -> (DVec3, DVec3, DVec3) {
    (
        p.iter().sum::<DVec3>() / 4.0,
        (p[1] + p[2] - p[0] - p[3]) / 4.0,
        (p[2] + p[3] - p[0] - p[1]) / 4.0,
    )
}

/// Where the corners of a quad lie along its axes.
const SIGNS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// Where the `k`-th corner of a triangle would stand over the middle of its base, at a right angle's distance.
fn apex(p: &[DVec3], k: usize) -> DVec3 {
    let n = p.len();
    let (a, b) = (p[(k + 1) % n], p[(k + n - 1) % n]);
    let middle = (a + b) / 2.0;
    let up = (p[k] - middle).reject_from(b - a);
    middle + up.normalize_or_zero() * a.distance(b) / 2.0
}

/// Looks round a node for a place where its worst cell is better.
pub(super) fn search(cells: &mut Cells, node: u32, ground: &dyn Ground) {
    let star: Few = cells.star(node).clone();
    let mut best = cells.worst(&star);
    if best >= WANTED {
        return;
    }
    let neighbours = cells.neighbours(node);
    let mut place = cells.place(node);
    let (home, normal) = (place.point, place.normal);
    let mean = mean_edge(cells, node);
    // Directions from the mesh itself, so that a part that is turned comes out the same.
    let Some(x) = (neighbours.iter())
        .map(|&n| (cells.points[n as usize] - home).reject_from(normal))
        .find_map(DVec3::try_normalize)
    else {
        return;
    };
    let y = normal.cross(x);
    for share in STEPS {
        let from = place.point;
        for i in 0..8 {
            let (sin, cos) = (TAU * f64::from(i) / 8.0).sin_cos();
            let to = ground.foot(from + (x * cos + y * sin) * share * mean, place.hint);
            cells.put(node, to);
            let now = cells.worst(&star);
            // A gain below rounding would make the choice depend on the part's position.
            if now > best + 1e-6 {
                (best, place) = (now, to);
            }
        }
    }
    cells.put(node, place);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_and_a_rectangle_want_to_stay() {
        let square = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let long = square.map(|p| DVec3::new(3.0 * p.x, p.y, 1.0));
        for k in 0..4 {
            assert!(wish(square, k, true).distance(square[k]) < 1e-15);
            assert!(wish(long, k, false).distance(long[k]) < 1e-15);
            // A long one wants to be two by two, round the same centre.
            assert!(
                (wish(long, k, true) - DVec3::new(1.5, 0.5, 1.0)).length() - 2f64.sqrt() < 1e-15
            );
        }
    }

    #[test]
    fn a_long_quad_at_a_slant_turns_to_its_direction_and_keeps_its_sides() {
        let (sin, cos) = 0.2f64.sin_cos();
        let [a, b] = [DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0)];
        let slant = [-a * 2.0 - b, a * 2.0 - b, a * 2.0 + b, b - a * 2.0];
        let wanted = [[-2.0, -1.0], [2.0, -1.0], [2.0, 1.0], [-2.0, 1.0]];
        // Whichever of its corners comes first, and either way along.
        for first in 0..4 {
            for direction in [DVec3::X * 3.0, -DVec3::X] {
                let ring: [DVec3; 4] = std::array::from_fn(|i| slant[(first + i) % 4]);
                for k in 0..4 {
                    let [x, y] = wanted[(first + k) % 4];
                    let found = along(ring, k, direction);
                    assert!(found.distance(DVec3::new(x, y, 0.0)) < 1e-12, "{found}");
                }
            }
        }
    }

    #[test]
    fn a_rhombus_straightens_both_ways_alike() {
        let (s, c) = (0.3f64.sin(), 0.3f64.cos());
        let rhombus = [
            DVec3::ZERO,
            DVec3::new(c, s, 0.0),
            DVec3::new(c + s, s + c, 0.0),
            DVec3::new(s, c, 0.0),
        ];
        let straight: Vec<DVec3> = (0..4).map(|k| wish(rhombus, k, false)).collect();
        let side = straight[1] - straight[0];
        assert!((side - DVec3::X).length() < 1e-12 && quality(&straight, DVec3::Z) > 1.0 - 1e-12);
    }
}
