//! Cutting: edges over which the nearest levels change are split at the jump.

use super::levels::{Class, Levels};
use crate::geom::placer::Placer;
use crate::geom::split;
use crate::medial::Medial;
use crate::model::brep::Brep;
use crate::model::complex::{MidComplex, MidTriangle, Support};
use crate::model::ids::{IndexVec, NodeId, TriangleId, WallId};
use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;
use std::collections::BTreeMap;

/// Kinks of less than 15 degrees are none: the meeting of two planes takes them for one. The cosine of that.
const KINK: f64 = 0.966;
/// Halvings on the way to a jump: to a millionth of an edge, and the placing does the rest.
const HALVINGS: usize = 20;
/// Changes of level along one edge at most; more are noise.
const CHANGES: usize = 4;
/// A jump this near to the end of an edge, as a share of its length, moves that end instead: no needles.
const NEAR: f64 = 0.15;
/// A piece of a kink whose middle lies further off it, as a share of its length, may be bent: the chord of an eighth of a circle lies a tenth off.
const BOW: f64 = 0.1;
/// It is bent where the mid-surfaces turn by less than 20 degrees at its middle, the cosine of which this is: a third more than what is no kink. A chord across
/// the arc round a corner comes that near to the corner, where the one is almost parallel to the other and nothing pulls a node out to the kink.
const SLIGHT: f64 = 0.94;
/// Rounds of bending: each halves what a piece turns by.
const BENDS: usize = 3;

type Classes = SmallVec<[Class; 2]>;

/// A complex being cut.
pub(super) struct Cutter<'a> {
    complex: MidComplex,
    brep: &'a Brep,
    medial: &'a Medial<'a>,
    levels: BTreeMap<WallId, Levels>,
    /// The pieces of a wall that a node lies in.
    sets: BTreeMap<(NodeId, WallId), Classes>,
}

/// Where an edge leaves some classes.
struct Change {
    /// Share of the way, and the classes before and behind.
    at: f64,
    classes: [Class; 2],
    /// Cosine of the turn of the mid-surface.
    cos: f64,
}

/// The middle of a chord that lies off its kink.
struct Middle {
    wall: WallId,
    class: Class,
    /// The node that the kink lies towards, and whether it lies next to that.
    apex: NodeId,
    reached: bool,
}

impl<'a> Cutter<'a> {
    pub fn new(
        complex: MidComplex,
        brep: &'a Brep,
        medial: &'a Medial<'a>,
        levels: BTreeMap<WallId, Levels>,
    ) -> Self {
        Self {
            complex,
            brep,
            medial,
            levels,
            sets: BTreeMap::new(),
        }
    }

    pub fn finish(self) -> (MidComplex, BTreeMap<WallId, Levels>) {
        (self.complex, self.levels)
    }

    fn class(&self, p: DVec3, w: WallId) -> Option<Class> {
        let feet = self.medial.feet(p, w)?;
        self.levels.get(&w)?.class(self.brep, &feet)
    }

    fn classify(&mut self) {
        let mut keys: Vec<(NodeId, WallId)> = (self.complex.triangles.iter())
            .filter(|t| self.levels.contains_key(&t.wall))
            .flat_map(|t| t.nodes.map(|n| (n, t.wall)))
            .collect();
        keys.sort_unstable();
        keys.dedup();
        let classes: Vec<Option<Class>> = (keys.par_iter())
            .map(|&(n, w)| self.class(self.complex.nodes[n].point, w))
            .collect();
        self.sets = (keys.into_iter().zip(classes))
            .map(|(key, class)| (key, class.into_iter().collect()))
            .collect();
    }

    /// Edges of walls with levels over which the classes change, each with its wall.
    fn crossed(&self) -> Vec<([NodeId; 2], WallId)> {
        let mut all: Vec<([NodeId; 2], WallId)> = (self.complex.triangles.iter())
            .filter(|t| self.levels.contains_key(&t.wall))
            .flat_map(|t| {
                [0, 1, 2].map(|k| {
                    let (a, b) = (t.nodes[k], t.nodes[(k + 1) % 3]);
                    ([a.min(b), a.max(b)], t.wall)
                })
            })
            .collect();
        all.sort_unstable();
        all.dedup();
        all.retain(|&([a, b], w)| {
            let (s, t) = (&self.sets[&(a, w)], &self.sets[&(b, w)]);
            !s.is_empty() && !t.is_empty() && !s.iter().any(|c| t.contains(c))
        });
        all
    }

    /// Where the way from `a` to `b` leaves the given classes after the share `from`.
    fn change(&self, [a, b]: [DVec3; 2], w: WallId, from: f64, left: &[Class]) -> Option<Change> {
        let (mut low, mut high) = (from, 1.0);
        let mut classes = [*left.first()?, self.class(b, w)?];
        for _ in 0..HALVINGS {
            let middle = (low + high) / 2.0;
            let class = self.class(a.lerp(b, middle), w)?;
            if left.contains(&class) {
                (low, classes[0]) = (middle, class);
            } else {
                (high, classes[1]) = (middle, class);
            }
        }
        let normal = |t: f64| self.medial.normal(a.lerp(b, t), w);
        let cos = normal(low)?.dot(normal(high)?);
        Some(Change {
            at: high,
            classes,
            cos,
        })
    }

    /// Finds the classes, and makes those one between which there is no kink; says whether there are kinks.
    pub fn part(&mut self) -> bool {
        self.classify();
        let crossed = self.crossed();
        let found: Vec<Vec<(WallId, Change, f64)>> = crossed
            .par_iter()
            .map(|&([a, b], w)| {
                let ends = [a, b].map(|n| self.complex.nodes[n].point);
                let length = ends[0].distance(ends[1]);
                let last = self.sets[&(b, w)].clone();
                let mut left = self.sets[&(a, w)].clone();
                let mut from = 0.0;
                let mut list = Vec::new();
                while list.len() < CHANGES && left != last {
                    let Some(change) = self.change(ends, w, from, &left) else {
                        break;
                    };
                    from = change.at;
                    left = smallvec::smallvec![change.classes[1]];
                    list.push((w, change, length));
                }
                list
            })
            .collect();
        let mut turns: BTreeMap<(WallId, [Class; 2]), [f64; 2]> = BTreeMap::new();
        for (w, change, length) in found.into_iter().flatten() {
            let [a, b] = change.classes;
            let sum = turns.entry((w, [a.min(b), a.max(b)])).or_default();
            sum[0] += length * change.cos;
            sum[1] += length;
        }
        let mut same: BTreeMap<WallId, Vec<[Class; 2]>> = BTreeMap::new();
        let mut kinked = false;
        for ((w, classes), [cos, all]) in turns {
            if cos > KINK * all {
                same.entry(w).or_default().push(classes);
            } else {
                kinked = true;
            }
        }
        for (w, list) in same {
            if let Some(levels) = self.levels.get_mut(&w) {
                levels.unite(&list);
            }
        }
        self.classify();
        kinked
    }

    /// Cuts all edges over which the class changes, and bends the cuts round corners.
    pub fn cut(&mut self) {
        self.snap();
        self.slice();
        for _ in 0..BENDS {
            if !self.bend() {
                break;
            }
            self.slice();
        }
    }

    fn slice(&mut self) {
        for _ in 0..CHANGES {
            let crossed = self.crossed();
            if crossed.is_empty() {
                break;
            }
            let changes: Vec<Option<Change>> = crossed
                .par_iter()
                .map(|&([a, b], w)| {
                    let ends = [a, b].map(|n| self.complex.nodes[n].point);
                    self.change(ends, w, 0.0, &self.sets[&(a, w)])
                })
                .collect();
            let edges = self.complex.edges();
            let mut cuts: BTreeMap<[NodeId; 2], NodeId> = BTreeMap::new();
            for ((ends, w), change) in crossed.into_iter().zip(changes) {
                let Some(change) = change else {
                    continue;
                };
                if cuts.contains_key(&ends) {
                    continue;
                }
                let Ok(i) = edges.binary_search_by(|e| e.ends.cmp(&ends)) else {
                    continue;
                };
                let m = self.node_on(ends, change.at, &edges[i].triangles);
                for t in &edges[i].triangles {
                    let wall = self.complex.triangles[*t].wall;
                    if !self.levels.contains_key(&wall) {
                        continue;
                    }
                    let set = if wall == w {
                        Classes::from_slice(&change.classes)
                    } else {
                        let class = self.class(self.complex.nodes[m].point, wall);
                        class.into_iter().collect()
                    };
                    self.sets.insert((m, wall), set);
                }
                cuts.insert(ends, m);
            }
            if cuts.is_empty() {
                break;
            }
            self.split(&cuts);
        }
    }

    /// Splits the chords that lie off their kink, so that the edges from their middles cross it; says whether there were any.
    fn bend(&mut self) -> bool {
        let labels = self.labels();
        let edges = self.complex.edges();
        let middles: Vec<Option<Middle>> = edges
            .par_iter()
            .map(|e| {
                let &[s, t] = e.triangles.as_slice() else {
                    return None;
                };
                self.middle(e.ends, [s, t], &labels)
            })
            .collect();
        let mut cuts: BTreeMap<[NodeId; 2], NodeId> = BTreeMap::new();
        for (e, middle) in edges.iter().zip(middles) {
            let Some(middle) = middle else {
                continue;
            };
            let m = self.node_on(e.ends, 0.5, &e.triangles);
            let key = (m, middle.wall);
            self.sets.insert(key, Classes::from_slice(&[middle.class]));
            if middle.reached
                && let Some(set) = self.sets.get_mut(&(middle.apex, middle.wall))
                && !set.contains(&middle.class)
            {
                set.push(middle.class);
            }
            cuts.insert(e.ends, m);
        }
        self.split(&cuts);
        !cuts.is_empty()
    }

    /// The middle of an edge between two pieces of one wall, if it lies off the kink.
    fn middle(
        &self,
        [a, b]: [NodeId; 2],
        ring: [TriangleId; 2],
        labels: &IndexVec<TriangleId, Option<Class>>,
    ) -> Option<Middle> {
        let [s, t] = ring.map(|t| &self.complex.triangles[t]);
        let wall = s.wall;
        let pieces = [labels[ring[0]]?, labels[ring[1]]?];
        if t.wall != wall || pieces[0] == pieces[1] {
            return None;
        }
        let ends = [a, b].map(|n| self.complex.nodes[n].point);
        let from = ends[0].midpoint(ends[1]);
        let class = self.class(from, wall)?;
        let beyond = match pieces.iter().position(|&p| p == class)? {
            0 => t,
            _ => s,
        };
        let apex = *beyond.nodes.iter().find(|n| ![a, b].contains(n))?;
        let to = self.complex.nodes[apex].point;
        let change = self.change([from, to], wall, 0.0, &[class])?;
        let off = change.at * from.distance(to);
        let inner = self.medial.place(from, &[Support::Mid(wall)]);
        let normals = [inner, from.lerp(to, change.at)].map(|p| self.medial.normal(p, wall));
        let slight = normals[0]?.dot(normals[1]?) > SLIGHT;
        // Where labels are noise the mid-surface does not turn at the jump either.
        let far = change.cos < KINK && off > BOW * ends[0].distance(ends[1]);
        (far && slight).then_some(Middle {
            wall,
            class,
            apex,
            reached: change.at > 1.0 - NEAR,
        })
    }

    /// Ends of edges that lie next to a jump take the class behind it as well.
    fn snap(&mut self) {
        let crossed = self.crossed();
        let near: Vec<Option<(NodeId, WallId, Class)>> = crossed
            .par_iter()
            .map(|&([a, b], w)| {
                let ends = [a, b].map(|n| self.complex.nodes[n].point);
                let change = self.change(ends, w, 0.0, &self.sets[&(a, w)])?;
                let last = *self.sets[&(b, w)].first()?;
                let [before, behind] = change.classes;
                if change.at < NEAR && behind == last {
                    Some((a, w, behind))
                } else if change.at > 1.0 - NEAR && behind == last {
                    Some((b, w, before))
                } else {
                    None
                }
            })
            .collect();
        for (n, w, class) in near.into_iter().flatten() {
            if let Some(set) = self.sets.get_mut(&(n, w))
                && !set.contains(&class)
            {
                set.push(class);
            }
        }
    }

    fn node_on(&mut self, ends: [NodeId; 2], at: f64, ring: &[TriangleId]) -> NodeId {
        let node = split::node_on(&self.complex, ends, at, ring, self.medial);
        self.complex.nodes.push(node)
    }

    fn split(&mut self, cuts: &BTreeMap<[NodeId; 2], NodeId>) {
        split::split(&mut self.complex, cuts);
    }

    /// The class of every triangle of a wall with levels.
    pub fn labels(&self) -> IndexVec<TriangleId, Option<Class>> {
        let one = |t: &MidTriangle| {
            if !self.levels.contains_key(&t.wall) {
                return None;
            }
            let [a, b, c] = t.nodes.map(|n| &self.sets[&(n, t.wall)]);
            let common: Classes = (a.iter())
                .filter(|x| b.contains(x) && c.contains(x))
                .copied()
                .collect();
            if let &[class] = common.as_slice() {
                return Some(class);
            }
            let centre = self.complex.corners(t);
            let class = self.class(centre.into_iter().sum::<DVec3>() / 3.0, t.wall);
            match class {
                Some(class) if common.is_empty() || common.contains(&class) => Some(class),
                _ => common.first().copied().or(class),
            }
        };
        let triangles: Vec<&MidTriangle> = self.complex.triangles.iter().collect();
        let labels: Vec<Option<Class>> = triangles.par_iter().map(|t| one(t)).collect();
        labels.into()
    }
}
