//! Unite: walls that turn out to continue each other, smoothly or over a step, and labels without noise.
//!
//! Pairing joins walls over tangent faces. Where faces are missing between them (an unpaired blend, a sliver) two walls may still be one surface: where their sheets meet
//! in the raw complex, their mid-surfaces are tangent and equally thick. Such walls become one, unless that would make one wall of two that meet in a corner; so do those before and behind a step, with its riser, see `steps`. Then every triangle whose neighbours agree against it takes their wall, and
//! so does every island too small to be a sheet: what is left are the creases that matter, and no jagged ones.
//!
//! Guarantees: topology and positions untouched; only walls and supports change. Cost: linear in the creases, then in the triangles.

mod steps;

use crate::geom::placer::Placer;
use crate::model::complex::{EdgeKind, MidComplex, MidEdge, Support};
use crate::model::disjoint::{Disjoint, SidedDisjoint};
use crate::model::ids::{FaceId, Id, IndexVec, TriangleId, WallId};
use crate::model::walls::{Aag, Pairing, Wall};
use glam::DVec3;
use std::collections::BTreeMap;

/// Mid-surfaces that meet at less than this are one surface: a shell element takes a bend of this angle without a crease.
const SMOOTH_COS: f64 = 0.94;
/// Thicknesses that differ by more than this share are a step, not a continuation.
const SAME_THICKNESS: f64 = 0.1;
/// Mid-surfaces further apart than this share of the thickness do not meet where their sheets do: two layers, or a step.
const SAME_PLACE: f64 = 0.1;
/// Share of the common crease that must be smooth.
const MOST: f64 = 0.7;
/// A sheet smaller than this many squared thicknesses is an island of wrong labels, unless it lies over its wall and not over the one round about.
const ISLAND: f64 = 3.0;
/// What is further than this beyond the ends of a wall's sides does not lie over it, in thicknesses.
const BEYOND: f64 = 0.25;
/// Rounds of the majority vote; labels are wrong by one or two triangles, seldom more.
const ROUNDS: usize = 4;

/// The pairing with walls united where the complex shows them to be one, and the complex with its walls renamed.
pub fn unite(complex: MidComplex, pairing: Pairing, placer: &dyn Placer) -> (MidComplex, Pairing) {
    let mut union = SidedDisjoint::new(pairing.walls.iter().map(|w| w.sides.clone()));
    let seen = meetings(&complex, placer);
    for (&[a, b], meeting) in &seen {
        if meeting.corner > MOST * meeting.all {
            union.keep_apart(a.0, b.0);
        }
    }
    for (&[a, b], meeting) in &seen {
        if meeting.smooth > MOST * meeting.all {
            union.join(a.0, b.0, meeting.turned < 0.0);
        }
    }
    let (mut complex, pairing, new_id) = renamed(complex, pairing, union);
    let mut parts: IndexVec<WallId, Vec<WallId>> =
        IndexVec::filled(Vec::new(), pairing.walls.len());
    for (old, new) in new_id.enumerated() {
        parts[*new].push(old);
    }
    let beyond = |p: DVec3, wall: WallId| {
        (parts[wall].iter().map(|&w| placer.beyond(p, w))).fold(f64::INFINITY, f64::min)
    };
    quiet(&mut complex, &pairing, &beyond);
    complex.support_by_walls();
    (complex, pairing)
}

/// The same with walls united that lie before and behind a step of thickness, the risers on their sides; `None` where there are none. For complexes without noise in
/// their labels: walls that do not meet are not seen to be one.
pub fn over_steps(
    complex: &MidComplex,
    pairing: &Pairing,
    aag: &Aag,
    placer: &dyn Placer,
) -> Option<(MidComplex, Pairing)> {
    let steps = steps::steps(complex, pairing, aag, placer);
    if steps.is_empty() {
        return None;
    }
    let mut pairing = pairing.clone();
    let walls = pairing.walls.iter().map(|w| w.sides.clone());
    let risers = steps.iter().map(|s| {
        let mut sides = [Vec::new(), Vec::new()];
        sides[s.side].clone_from(&s.risers);
        sides
    });
    let mut union = SidedDisjoint::new(walls.chain(risers));
    for (k, step) in steps.iter().enumerate() {
        let [a, b] = step.walls;
        let riser = (pairing.walls.len() + k) as u32;
        if !union.join(a.0, b.0, step.turned) || !union.join(a.0, riser, false) {
            continue;
        }
        let like = pairing.walls[a].sides[step.side].first();
        let side = like.and_then(|&f| pairing.side[f]);
        for &f in &step.risers {
            pairing.side[f] = pairing.side[f].or(side);
        }
    }
    let (mut complex, pairing, _) = renamed(complex.clone(), pairing, union);
    complex.support_by_walls();
    Some((complex, pairing))
}

/// One wall for each set of walls, and the new name of every old one.
fn renamed(
    mut complex: MidComplex,
    mut pairing: Pairing,
    mut union: SidedDisjoint<FaceId>,
) -> (MidComplex, Pairing, IndexVec<WallId, WallId>) {
    let mut of_root: BTreeMap<u32, WallId> = BTreeMap::new();
    let mut walls: IndexVec<WallId, Wall> = IndexVec::new();
    let mut new_id: IndexVec<WallId, WallId> = IndexVec::new();
    for w in pairing.walls.ids() {
        let root = union.find(w.0).0;
        let id = *of_root.entry(root).or_insert_with(|| {
            walls.push(Wall {
                sides: union.sides(root).clone(),
                thickness: 0.0,
                group: pairing.walls[WallId(root)].group,
            })
        });
        new_id.push(id);
    }
    let mut weight: IndexVec<WallId, f64> = IndexVec::filled(0.0, walls.len());
    for pair in &mut pairing.pairs {
        pair.wall = new_id[pair.wall];
        weight[pair.wall] += pair.overlap;
        walls[pair.wall].thickness += pair.overlap * pair.thickness[1];
    }
    for (w, wall) in walls.as_mut_slice().iter_mut().enumerate() {
        wall.thickness /= weight[WallId::new(w)];
    }
    pairing.walls = walls;
    for t in complex.triangles.as_mut_slice() {
        t.wall = new_id[t.wall];
    }
    (complex, pairing, new_id)
}

/// How two walls meet where their sheets do, by the length of their common crease, mm.
#[derive(Clone, Copy, Debug, Default)]
struct Meeting {
    all: f64,
    /// Where their mid-surfaces go on with each other.
    smooth: f64,
    /// The same, less where their sides are the other way round.
    turned: f64,
    /// Where their mid-surfaces meet at an angle.
    corner: f64,
}

/// All walls whose sheets meet.
fn meetings(complex: &MidComplex, placer: &dyn Placer) -> BTreeMap<[WallId; 2], Meeting> {
    let mut seen: BTreeMap<[WallId; 2], Meeting> = BTreeMap::new();
    for edge in complex
        .edges()
        .iter()
        .filter(|e| complex.kind(e) == EdgeKind::Crease)
    {
        let [s, t] = [0, 1].map(|k| complex.triangles[edge.triangles[k]].wall);
        let [a, b] = edge.ends.map(|n| complex.nodes[n].point);
        let (middle, length) = ((a + b) / 2.0, a.distance(b));
        let entry = seen.entry([s.min(t), s.max(t)]).or_default();
        entry.all += length;
        let (Some(n), Some(m)) = (placer.normal(middle, s), placer.normal(middle, t)) else {
            continue;
        };
        let (Some(p), Some(q)) = (placer.thickness(middle, s), placer.thickness(middle, t)) else {
            continue;
        };
        let apart = placer
            .place(middle, &[Support::Mid(s)])
            .distance(placer.place(middle, &[Support::Mid(t)]));
        if apart > SAME_PLACE * (p + q) / 2.0 {
            continue;
        }
        if n.dot(m).abs() < SMOOTH_COS {
            entry.corner += length;
        } else if (p - q).abs() < SAME_THICKNESS * (p + q) / 2.0 {
            entry.smooth += length;
            entry.turned += length * n.dot(m).signum();
        }
    }
    seen
}

/// Triangles take the wall of the majority of their neighbours, then islands that of the longest border.
fn quiet(complex: &mut MidComplex, pairing: &Pairing, beyond: &dyn Fn(DVec3, WallId) -> f64) {
    let edges = complex.edges();
    let mut beside: IndexVec<TriangleId, smallvec::SmallVec<[TriangleId; 3]>> =
        IndexVec::filled(Default::default(), complex.triangles.len());
    for edge in edges.iter().filter(|e| e.triangles.len() == 2) {
        beside[edge.triangles[0]].push(edge.triangles[1]);
        beside[edge.triangles[1]].push(edge.triangles[0]);
    }
    for _ in 0..ROUNDS {
        let mut changed = false;
        for t in complex.triangles.ids() {
            let own = complex.triangles[t].wall;
            let walls = beside[t].iter().map(|&s| complex.triangles[s].wall);
            let other = walls
                .clone()
                .filter(|&w| w != own)
                .max_by_key(|&w| walls.clone().filter(|&x| x == w).count());
            if let Some(w) = other
                && walls.clone().filter(|&x| x == w).count() >= 2
            {
                complex.triangles[t].wall = w;
                changed = true;
            }
        }
        changed |= drown_islands(complex, &edges, pairing, beyond);
        if !changed {
            break;
        }
    }
}

/// Gives islands the wall of their longest border. A short wall among others lies over its own sides, and not over theirs: it is none.
fn drown_islands(
    complex: &mut MidComplex,
    edges: &[MidEdge],
    pairing: &Pairing,
    beyond: &dyn Fn(DVec3, WallId) -> f64,
) -> bool {
    let mut sets = Disjoint::new(complex.triangles.len());
    for edge in edges.iter().filter(|e| complex.kind(e) == EdgeKind::Inner) {
        sets.join(edge.triangles[0].0, edge.triangles[1].0);
    }
    let mut area = vec![0.0; complex.triangles.len()];
    for (id, t) in complex.triangles.enumerated() {
        area[sets.find(id.0) as usize] += complex.area_vector(t).length();
    }
    // Border length of every small island to every wall beyond.
    let mut border: BTreeMap<(u32, WallId), f64> = BTreeMap::new();
    for edge in edges.iter().filter(|e| complex.kind(e) == EdgeKind::Crease) {
        let [a, b] = edge.ends.map(|n| complex.nodes[n].point);
        for (s, t) in [(0, 1), (1, 0)].map(|(i, j)| (edge.triangles[i], edge.triangles[j])) {
            let island = sets.find(s.0);
            let thickness = pairing.walls[complex.triangles[s].wall].thickness;
            if area[island as usize] < ISLAND * thickness * thickness {
                *border
                    .entry((island, complex.triangles[t].wall))
                    .or_default() += a.distance(b);
            }
        }
    }
    let mut longest: BTreeMap<u32, (f64, WallId)> = BTreeMap::new();
    for ((island, wall), length) in border {
        let best = longest.entry(island).or_insert((0.0, wall));
        if length > best.0 {
            *best = (length, wall);
        }
    }
    let mut own: BTreeMap<u32, f64> = BTreeMap::new();
    for (id, t) in complex.triangles.enumerated() {
        let island = sets.find(id.0);
        let Some(&(_, wall)) = longest.get(&island) else {
            continue;
        };
        let [a, b, c] = complex.corners(t);
        let middle = (a + b + c) / 3.0;
        let off = |w: WallId| beyond(middle, w) > BEYOND * pairing.walls[t.wall].thickness;
        if !off(t.wall) && off(wall) {
            *own.entry(island).or_default() += complex.area_vector(t).length();
        }
    }
    longest.retain(|s, _| own.get(s).is_none_or(|own| *own < area[*s as usize] / 2.0));
    for t in complex.triangles.ids() {
        if let Some(&(_, wall)) = longest.get(&sets.find(t.0)) {
            complex.triangles[t].wall = wall;
        }
    }
    !longest.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::walls::FacePair;
    use crate::stage::test_shapes::Build;

    /// Walls 2 thick: the first lies over x < 10, the second from `from` on.
    struct Beside {
        from: f64,
    }

    impl Placer for Beside {
        fn place(&self, start: DVec3, _: &[Support]) -> DVec3 {
            start
        }
        fn normal(&self, _: DVec3, _: WallId) -> Option<DVec3> {
            None
        }
        fn thickness(&self, _: DVec3, _: WallId) -> Option<f64> {
            Some(2.0)
        }
        fn beyond(&self, p: DVec3, wall: WallId) -> f64 {
            let beyond = match wall {
                WallId(0) => p.x - 10.0,
                _ => self.from - p.x,
            };
            beyond.max(0.0)
        }
        fn curvature_radius(&self, _: DVec3, _: WallId) -> f64 {
            f64::INFINITY
        }
    }

    /// Triangles of the second wall that are left of a piece 2 x 4 at the end of a sheet 10 x 4 of the first.
    fn left(from: f64) -> usize {
        let mut build = Build::default();
        build.sheet(0, 10, 4, |u, v| DVec3::new(10.0 * u, 4.0 * v, 0.0));
        build.sheet(1, 2, 4, |u, v| DVec3::new(10.0 + 2.0 * u, 4.0 * v, 0.0));
        let mut pairing = Pairing::default();
        for w in 0..2 {
            let faces = [FaceId(2 * w), FaceId(2 * w + 1)];
            pairing.pairs.push(FacePair {
                faces,
                overlap: 8.0,
                thickness: [2.0; 3],
                wall: WallId(w),
            });
            pairing.walls.push(Wall {
                sides: faces.map(|f| vec![f]),
                thickness: 2.0,
                group: w,
            });
        }
        let (complex, _) = unite(build.complex, pairing, &Beside { from });
        let second = complex.triangles.iter().filter(|t| t.wall == WallId(1));
        second.count()
    }

    #[test]
    fn a_short_wall_stays_and_an_island_of_wrong_labels_goes() {
        // Two squared thicknesses in either case.
        assert_eq!(left(10.0), 16);
        assert_eq!(left(12.0), 0);
    }
}
