//! Risers: the small faces over which one side of a wall steps from one level to the next.
//!
//! Where a wall changes its thickness by a step, or is joggled by less than its thickness, the medial axis goes through the step as one sheet: it climbs along the parabola
//! between the inner edge of the step and the opposite side. So the riser (with its fillets and chamfers) is a piece of the wall's side, and the walls before
//! and behind it are one wall.
//!
//! A riser joins two paired faces, faces no mate itself, and lies at heights above the opposite side between the two thicknesses. A lateral face
//! reaches down to the opposite side, a rib or a ridge rises above the thicker wall, a groove goes below the thinner one, and a fillet leads
//! into a wall at an angle: none of these is a riser. Where the thickness more than trebles nothing is said: the thin wall then ends at a block.
//!
//! A groove too narrow to leave a wall of its own is no step, yet the sheet has to keep to the middle of what it leaves: its faces belong to the side that they are cut into.
//!
//! Heights are those above a whole side, since the ledge of a lip runs round a housing, over walls and rounded corners alike. Limit: round a sharp corner the walls are
//! two, each with a part of the ledge, and it joins neither.
//!
//! Cost: one nearest-point query a vertex of every unpaired face beside a paired one.

use super::walls::other;
use crate::geom::six_node;
use crate::model::brep::Brep;
use crate::model::ids::{FaceId, FacetId, IndexVec};
use crate::model::walls::{Aag, Convexity, FacePair};
use crate::spatial::TriangleBvh;
use glam::DVec3;
use std::collections::BTreeMap;

/// Greatest ratio of the two thicknesses: beyond it the thin wall ends at a block.
const GREATEST_RATIO: f64 = 3.0;
/// Heights may leave the range of the two thicknesses by this share: chords of curved facets do.
const SLACK: f64 = 0.05;
/// A joggle leaves at least this share of the thickness between its two inner edges, and rises by as much at most: what is left is a wall still.
const LEAST_NECK: f64 = 0.5;
/// Another wall takes up less than this share of a groove's border: more, and the groove is the foot of a step or of a rib.
const FOREIGN: f64 = 0.2;
/// A face nearer than this share of its height touches the side: rounding, no more.
const TOUCHES: f64 = 1e-6;
/// A groove leaves less than this share of the thickness: a sheet that took no heed of it would be out of the middle by a seventh at least.
const SHALLOW: f64 = 0.75;
/// Heights are measured plumb to the opposite side, to this cosine, and both levels look at it: slanted lateral faces and the fillets of bends do not.
const PLUMB_COS: f64 = 0.8;
/// Share of a riser's border that lies along the side that it continues: a chamfer at the rim of the thicker wall touches it with half of its border only.
const LEAST_BORDER: f64 = 0.6;

/// Two pairs that are one wall, over risers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Step {
    /// Indices of the pairs.
    pub pairs: [u32; 2],
    /// Face of the first pair, and of the second, on the side that steps.
    pub faces: [FaceId; 2],
    /// The faces between these two.
    pub risers: Vec<FaceId>,
    /// The faces between the other two, where the other side steps as well.
    pub opposite: Vec<FaceId>,
}

/// Where a face lies above a side.
#[derive(Clone, Debug)]
struct Heights {
    /// Distance of its nearest vertex, plumb above the side or not.
    nearest: f64,
    /// Least and greatest height above each face of the side that some of its vertices are plumb above.
    over: Vec<(FaceId, [f64; 2])>,
}

impl Heights {
    /// Least and greatest height above some faces of the side.
    fn above(&self, faces: &[FaceId]) -> Option<[f64; 2]> {
        (self.over.iter())
            .filter(|(f, _)| faces.contains(f))
            .map(|(_, range)| *range)
            .reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }
}

/// Faces of one side above which heights are measured: those of the pairs in question. What runs on above others is judged there.
#[derive(Clone, Copy)]
struct Ground<'f> {
    side: Side,
    faces: &'f [FaceId],
}

/// One side of a wall as far as it is known: a set of pairs joined so far, and which of its two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    /// The pair that stands for the set.
    pub set: u32,
    /// Which side of it.
    pub second: bool,
}

impl Side {
    fn opposite(self) -> Self {
        Self {
            second: !self.second,
            ..self
        }
    }
}

/// The walls as far as they are known.
pub(super) trait Sides {
    /// The side on which a face of a pair lies.
    fn side(&self, pair: u32, face: FaceId) -> Side;
    /// Its faces, sorted.
    fn faces(&self, side: Side) -> &[FaceId];
}

/// The surface of a side, and whose facets its triangles are.
struct Base {
    bvh: TriangleBvh,
    facets: Vec<FacetId>,
}

struct Search<'a, S> {
    brep: &'a Brep,
    aag: &'a Aag,
    of_face: &'a IndexVec<FaceId, Vec<u32>>,
    sides: &'a S,
    facets: IndexVec<FaceId, Vec<FacetId>>,
    surfaces: BTreeMap<Side, Base>,
    /// Faces between the two sides of some wall.
    lateral: IndexVec<FaceId, bool>,
    heights: BTreeMap<(FaceId, Side), Heights>,
}

/// All steps, in order of their pairs.
pub(super) fn steps(
    brep: &Brep,
    aag: &Aag,
    pairs: &[FacePair],
    of_face: &IndexVec<FaceId, Vec<u32>>,
    sides: &impl Sides,
) -> Vec<Step> {
    let mut facets = IndexVec::filled(Vec::new(), brep.faces.len());
    for (id, f) in brep.facets.enumerated() {
        facets[f.face].push(id);
    }
    let mut search = Search {
        brep,
        aag,
        of_face,
        sides,
        facets,
        surfaces: BTreeMap::new(),
        lateral: lateral(aag, pairs, of_face),
        heights: BTreeMap::new(),
    };
    let most = GREATEST_RATIO * (1.0 + SLACK);
    let mut found = Vec::new();
    for (i, p) in pairs.iter().enumerate() {
        let t = p.thickness[1];
        for a in p.faces {
            let b = other(p, a);
            let side = sides.side(i as u32, b);
            let faces = search.around(b, side);
            // All that may be reached at all, then each goal under its own limits.
            let range = [(t / most).min(LEAST_NECK * t), most * t];
            found.extend(search.groove(i as u32, p, a));
            for c in search.goals(
                a,
                Ground {
                    side,
                    faces: &faces,
                },
                range,
            ) {
                for &j in &of_face[c] {
                    let q = &pairs[j as usize];
                    let d = other(q, c);
                    let u = q.thickness[1];
                    if c <= a || j as usize == i || t.max(u) > most * t.min(u) {
                        continue;
                    }
                    found.extend(search.step([i as u32, j], [p, q], [a, c], [b, d]));
                }
            }
        }
    }
    found
}

impl<S: Sides> Search<'_, S> {
    fn step(
        &mut self,
        pairs: [u32; 2],
        [p, q]: [&FacePair; 2],
        [a, c]: [FaceId; 2],
        [b, d]: [FaceId; 2],
    ) -> Option<Step> {
        let (thin, thick) = (
            p.thickness[0].min(q.thickness[0]),
            p.thickness[2].max(q.thickness[2]),
        );
        let [near, far] = [self.sides.side(pairs[0], a), self.sides.side(pairs[1], c)];
        let level = self.sides.faces(near.opposite()).binary_search(&d).is_ok()
            || self
                .aag
                .arcs_of(b)
                .any(|x| x.convexity == Convexity::Smooth && Aag::across(x, b) == d);
        let range = if level {
            [thin * (1.0 - SLACK), thick * (1.0 + SLACK)]
        } else {
            let rise = (1.0 - LEAST_NECK) * thin;
            [LEAST_NECK * thin, thick + rise * (1.0 + SLACK)]
        };
        let ground = Ground {
            side: near.opposite(),
            faces: &[b, d],
        };
        let risers = self.between([a, c], [near, far], ground, range)?;
        let opposite = if level {
            Vec::new()
        } else {
            let ends = [near.opposite(), far.opposite()];
            let ground = Ground {
                side: near,
                faces: &[a, c],
            };
            self.between([b, d], ends, ground, range)?
        };
        Some(Step {
            pairs,
            faces: [a, c],
            risers,
            opposite,
        })
    }

    /// The faces of grooves in `a` too narrow to have a mate of their own, as a step from the pair to itself.
    fn groove(&mut self, pair: u32, p: &FacePair, a: FaceId) -> Option<Step> {
        let near = self.sides.side(pair, a);
        let b = other(p, a);
        let ground = Ground {
            side: near.opposite(),
            faces: &[b],
        };
        let [_, t, _] = p.thickness;
        let range = [t / GREATEST_RATIO, t * (1.0 + SLACK)];
        let mut risers = Vec::new();
        for members in self.component(a, ground, range) {
            let kept = self.bordering(members.clone(), [near, near]);
            let deep = kept.iter().any(|&f| {
                self.height(f, ground)
                    .is_some_and(|[least, _]| least < SHALLOW * t)
            });
            if deep && self.borders_foreign(&members, near, ground) < FOREIGN {
                risers.extend(kept);
            }
        }
        risers.sort_unstable();
        risers.dedup();
        (!risers.is_empty()).then(|| Step {
            pairs: [pair; 2],
            faces: [a; 2],
            risers,
            opposite: Vec::new(),
        })
    }

    /// Length of a component's border along the sides of other walls above the same ground, as a share of that along its own side. What
    /// stands beyond the wall's end is not above it.
    fn borders_foreign(&mut self, members: &[FaceId], near: Side, ground: Ground) -> f64 {
        let (aag, sides) = (self.aag, self.sides);
        let (mut own, mut foreign) = (0.0, 0.0);
        for &f in members {
            for x in aag.arcs_of(f) {
                let g = Aag::across(x, f);
                if sides.faces(near).binary_search(&g).is_ok() {
                    own += x.length;
                } else if !self.of_face[g].is_empty() && self.height(g, ground).is_some() {
                    foreign += x.length;
                }
            }
        }
        foreign / own
    }

    /// The faces of a component that lie along the sides or along one another.
    fn bordering(&self, mut members: Vec<FaceId>, ends: [Side; 2]) -> Vec<FaceId> {
        loop {
            let kept = members.clone();
            members.retain(|&f| {
                let along: f64 = self
                    .aag
                    .arcs_of(f)
                    .filter(|x| {
                        let g = Aag::across(x, f);
                        let on = |&s: &Side| self.sides.faces(s).binary_search(&g).is_ok();
                        kept.contains(&g) || ends.iter().any(on)
                    })
                    .map(|x| x.length)
                    .sum();
                along >= LEAST_BORDER * self.aag.perimeter[f]
            });
            if members.len() == kept.len() {
                return members;
            }
        }
    }

    /// Unpaired faces that hang together with `a` and lie within the range of heights.
    fn component(&mut self, a: FaceId, ground: Ground, range: [f64; 2]) -> Vec<Vec<FaceId>> {
        let mut seen: Vec<FaceId> = Vec::new();
        let mut all = Vec::new();
        let aag = self.aag;
        for seed in aag.arcs_of(a).map(|x| Aag::across(x, a)) {
            if seen.contains(&seed) || !self.within(seed, ground, range) {
                continue;
            }
            let mut members = vec![seed];
            let mut at = 0;
            while at < members.len() {
                let f = members[at];
                at += 1;
                for g in aag.arcs_of(f).map(|x| Aag::across(x, f)) {
                    if !members.contains(&g) && self.within(g, ground, range) {
                        members.push(g);
                    }
                }
            }
            seen.extend(&members);
            all.push(members);
        }
        all
    }

    /// Paired faces beyond the unpaired ones round `a`.
    fn goals(&mut self, a: FaceId, ground: Ground, range: [f64; 2]) -> Vec<FaceId> {
        let sides = self.sides;
        let mut goals: Vec<FaceId> = self
            .component(a, ground, range)
            .into_iter()
            .flatten()
            .flat_map(|f| self.aag.arcs_of(f).map(move |x| Aag::across(x, f)))
            .filter(|&g| {
                g != a
                    && !self.of_face[g].is_empty()
                    && sides.faces(ground.side).binary_search(&g).is_err()
            })
            .collect();
        goals.sort_unstable();
        goals.dedup();
        goals
    }

    /// The risers from `a` to `c`, if there are any.
    fn between(
        &mut self,
        [a, c]: [FaceId; 2],
        ends: [Side; 2],
        ground: Ground,
        range: [f64; 2],
    ) -> Option<Vec<FaceId>> {
        let mut risers = Vec::new();
        for members in self.component(a, ground, range) {
            let members = self.bordering(members, ends);
            let touches = |g: FaceId| {
                members
                    .iter()
                    .any(|&f| self.aag.arcs_of(f).any(|x| Aag::across(x, f) == g))
            };
            if touches(a) && touches(c) {
                risers.extend(members);
            }
        }
        risers.sort_unstable();
        risers.dedup();
        let level = self.faces(a, ground.side, range[1]) && self.faces(c, ground.side, range[1]);
        (level && !risers.is_empty()).then_some(risers)
    }

    /// Whether `f` looks the other way than `base` does somewhere plumb above it, at most so high. Beyond the fillets of a bend it does not;
    /// a fillet that is paired itself does at its end.
    fn faces(&mut self, f: FaceId, base: Side, high: f64) -> bool {
        self.look_at(base);
        let brep = self.brep;
        let Some(Base { bvh, facets: own }) = self.surfaces.get(&base) else {
            return false;
        };
        self.facets[f].iter().any(|&t| {
            let corners = brep.corners(t);
            [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]
                .into_iter()
                .zip(corners)
                .any(|((u, v), p)| {
                    bvh.nearest_within(p, high).is_some_and(|near| {
                        let below = normal(brep, own[near.index]);
                        let here = six_node::normal(&corners, &brep.facets[t].mids, u, v);
                        (near.point - p).dot(below) > PLUMB_COS * near.distance
                            && here.dot(below) < -PLUMB_COS
                    })
                })
        })
    }

    fn look_at(&mut self, base: Side) {
        let (brep, sides, of_face) = (self.brep, self.sides, &self.facets);
        self.surfaces.entry(base).or_insert_with(|| {
            let facets: Vec<FacetId> = sides
                .faces(base)
                .iter()
                .flat_map(|&f| of_face[f].iter().copied())
                .collect();
            let corners: Vec<[DVec3; 3]> = facets.iter().map(|&t| brep.corners(t)).collect();
            Base {
                bvh: TriangleBvh::new(&corners),
                facets,
            }
        });
    }

    /// A face and those of its side that go on with it smoothly.
    fn around(&self, b: FaceId, side: Side) -> Vec<FaceId> {
        let smooth = (self.aag.arcs_of(b))
            .filter(|x| x.convexity == Convexity::Smooth)
            .map(|x| Aag::across(x, b))
            .filter(|g| self.sides.faces(side).binary_search(g).is_ok());
        std::iter::once(b).chain(smooth).collect()
    }

    fn within(&mut self, f: FaceId, ground: Ground, [low, high]: [f64; 2]) -> bool {
        self.of_face[f].is_empty()
            && !self.lateral[f]
            && self
                .height(f, ground)
                .is_some_and(|[least, most]| least >= low && most <= high)
    }

    /// `None` for a face that is plumb above the ground nowhere, or touches the side.
    fn height(&mut self, f: FaceId, ground: Ground) -> Option<[f64; 2]> {
        let key = (f, ground.side);
        if !self.heights.contains_key(&key) {
            let found = self.measure(f, ground.side);
            self.heights.insert(key, found);
        }
        let found = self.heights.get(&key)?;
        let [least, most] = found.above(ground.faces)?;
        (found.nearest > TOUCHES * most).then_some([least, most])
    }

    fn measure(&mut self, f: FaceId, side: Side) -> Heights {
        self.look_at(side);
        let mut found = Heights {
            nearest: f64::INFINITY,
            over: Vec::new(),
        };
        let brep = self.brep;
        let Some(Base { bvh, facets: own }) = self.surfaces.get(&side) else {
            return found;
        };
        let mut over: BTreeMap<FaceId, [f64; 2]> = BTreeMap::new();
        for v in self.facets[f].iter().flat_map(|&t| brep.facets[t].corners) {
            let p = brep.vertices[v];
            let Some(near) = bvh.nearest(p) else {
                continue;
            };
            let facet = own[near.index];
            let height = (near.point - p).dot(normal(brep, facet));
            found.nearest = found.nearest.min(near.distance);
            if height > PLUMB_COS * near.distance {
                let face = brep.facets[facet].face;
                let [least, most] = over.entry(face).or_insert([height, height]);
                (*least, *most) = (least.min(height), most.max(height));
            }
        }
        found.over = over.into_iter().collect();
        found
    }
}

/// Faces with the two faces of some pair among their neighbours.
fn lateral(
    aag: &Aag,
    pairs: &[FacePair],
    of_face: &IndexVec<FaceId, Vec<u32>>,
) -> IndexVec<FaceId, bool> {
    (aag.of_face.ids())
        .map(|f| {
            let around: Vec<FaceId> = aag.arcs_of(f).map(|x| Aag::across(x, f)).collect();
            around.iter().any(|&g| {
                (of_face[g].iter()).any(|&i| around.contains(&other(&pairs[i as usize], g)))
            })
        })
        .collect()
}

fn normal(brep: &Brep, facet: FacetId) -> DVec3 {
    brep.area_vector(facet).normalize_or_zero()
}
