//! The findings of the stages, counted and put into the words of [`SolidFacts`].
//!
//! Sheets and junction curves are counted on the cleaned mid-complex: a sheet is what hangs together without crossing a rim, crease or
//! junction; a junction curve is a chain of junction edges up to its ends and forks, a closed one counts once. A lump is a group of
//! neighbouring faces with the role `Lump`.

use super::midsurface::MidSurface;
use crate::geom::kind::face_kind;
use crate::geom::six_node::{QuadraticTriangle, facets_of_faces};
use crate::inspection::{PairFacts, SheetFacts, SolidFacts, WallFacts, thickness_histogram};
use crate::model::brep::Brep;
use crate::model::complex::{EdgeKind, MidComplex};
use crate::model::ids::{FaceId, Id, IndexVec, NodeId, WallId};
use crate::model::walls::{Aag, FacePair, Role};
use crate::stage::sheets::Piece;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What the boundary alone tells.
pub(super) fn solid_facts(brep: &Brep) -> SolidFacts {
    let of_face = facets_of_faces(brep);
    let all = || of_face.iter().flatten();
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in all().flat_map(|f| f.corners.into_iter().chain(f.mids)) {
        (low, high) = (low.min(p), high.max(p));
    }
    let kinds: Vec<_> = of_face
        .as_slice()
        .par_iter()
        .map(|facets| face_kind(facets))
        .collect();
    SolidFacts {
        tag: brep.solid_tag,
        extent: if brep.facets.is_empty() {
            [0.0; 3]
        } else {
            (high - low).to_array()
        },
        volume: all().map(QuadraticTriangle::volume).sum(),
        area: all().map(QuadraticTriangle::area).sum(),
        faces_by_kind: count(kinds.iter().map(|k| k.name())),
        faces_by_role: count(brep.faces.iter().map(|_| role_name(Role::Lump))),
        lumps: 1,
        ..SolidFacts::default()
    }
}

/// The same with what the walls tell.
pub(super) fn wall_facts(
    facts: SolidFacts,
    brep: &Brep,
    found: &MidSurface,
    clean: &MidComplex,
    sheets_in_order: &[Piece],
    before: &Before,
) -> SolidFacts {
    let tags = |faces: &[FaceId]| faces.iter().map(|&f| brep.faces[f].tag).collect();
    let walls = found
        .pairing
        .walls
        .enumerated()
        .map(|(id, wall)| {
            let pairs = pairs_of(brep, &found.pairing.pairs, id);
            WallFacts {
                wall: before.wall(id),
                group: wall.group,
                sides: [tags(&wall.sides[0]), tags(&wall.sides[1])],
                area: pairs.iter().map(|p| p.area).sum(),
                least: pairs.iter().map(|p| p.least).fold(f64::INFINITY, f64::min),
                mean: wall.thickness,
                greatest: pairs.iter().map(|p| p.greatest).fold(0.0, f64::max),
                pairs,
            }
        })
        .collect();
    SolidFacts {
        faces_by_role: count(found.roles.role.iter().map(|&r| role_name(r))),
        walls,
        histogram: thickness_histogram(&found.pairing.histogram),
        sheets: sheets(clean),
        sheet_list: (sheets_in_order.iter().zip(before.sheets + 1..))
            .map(|(sheet, number)| SheetFacts {
                sheet: number,
                wall: before.wall(sheet.wall),
                area: sheet.area(),
                thickness: found.pairing.walls[sheet.wall].thickness,
                centre: sheet.centre().to_array(),
            })
            .collect(),
        junctions: junction_curves(clean),
        lumps: lumps(&found.aag, &found.roles.role),
        ..facts
    }
}

/// How much the solids before have.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Before {
    pub sheets: u32,
    pub walls: u32,
}

impl Before {
    fn wall(&self, id: WallId) -> u32 {
        self.walls + id.0 + 1
    }

    /// The same for the solid after one with these sheets, as the merged mesh counts.
    pub fn after(&self, sheets: &[Piece]) -> Self {
        let walls = sheets.iter().map(|s| s.wall.0 + 1).max().unwrap_or(0);
        Self {
            sheets: self.sheets + sheets.len() as u32,
            walls: self.walls + walls,
        }
    }
}

fn pairs_of(brep: &Brep, pairs: &[FacePair], wall: WallId) -> Vec<PairFacts> {
    pairs
        .iter()
        .filter(|p| p.wall == wall)
        .map(|p| PairFacts {
            faces: p.faces.map(|f| brep.faces[f].tag),
            area: p.overlap,
            least: p.thickness[0],
            mean: p.thickness[1],
            greatest: p.thickness[2],
        })
        .collect()
}

fn role_name(role: Role) -> &'static str {
    match role {
        Role::WallSide => "wall side",
        Role::Lateral => "lateral",
        Role::Blend => "blend",
        Role::Lump => "lump",
    }
}

fn count<'a>(names: impl Iterator<Item = &'a str>) -> BTreeMap<String, usize> {
    let mut map = BTreeMap::new();
    for name in names {
        *map.entry(name.to_owned()).or_insert(0) += 1;
    }
    map
}

/// Sets that are joined two by two.
struct Sets(Vec<u32>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }
    fn root(&mut self, mut x: usize) -> usize {
        while self.0[x] as usize != x {
            self.0[x] = self.0[self.0[x] as usize];
            x = self.0[x] as usize;
        }
        x
    }
    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b) as u32;
    }
    fn count(&mut self, members: impl Iterator<Item = usize>) -> usize {
        let mut roots: Vec<usize> = members.map(|m| self.root(m)).collect();
        roots.sort_unstable();
        roots.dedup();
        roots.len()
    }
}

/// Pieces between rims, creases and junctions.
fn sheets(complex: &MidComplex) -> usize {
    let count = complex.triangles.len();
    let mut sets = Sets::new(count);
    for edge in complex.edges() {
        if complex.kind(&edge) == EdgeKind::Inner {
            sets.join(edge.triangles[0].index(), edge.triangles[1].index());
        }
    }
    sets.count(0..count)
}

/// Chains of junction edges up to their ends and forks.
fn junction_curves(complex: &MidComplex) -> usize {
    let edges: Vec<[NodeId; 2]> = complex
        .edges()
        .iter()
        .filter(|e| complex.kind(e) == EdgeKind::Junction)
        .map(|e| e.ends)
        .collect();
    let mut at: BTreeMap<NodeId, Vec<usize>> = BTreeMap::new();
    for (i, ends) in edges.iter().enumerate() {
        for &n in ends {
            at.entry(n).or_default().push(i);
        }
    }
    let mut sets = Sets::new(edges.len());
    for round in at.values() {
        if let [a, b] = round[..] {
            sets.join(a, b);
        }
    }
    sets.count(0..edges.len())
}

/// Groups of neighbouring faces that are neither wall side, nor lateral, nor blend.
fn lumps(aag: &Aag, role: &IndexVec<FaceId, Role>) -> usize {
    let mut sets = Sets::new(role.len());
    for arc in &aag.arcs {
        if arc.faces.iter().all(|&f| role[f] == Role::Lump) {
            sets.join(arc.faces[0].index(), arc.faces[1].index());
        }
    }
    let members = role.enumerated().filter(|(_, r)| **r == Role::Lump);
    sets.count(members.map(|(f, _)| f.index()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::{MidNode, MidTriangle};
    use crate::model::ids::CurveId;
    use crate::model::walls::{Arc, Convexity};

    /// A complex of triangles with their walls; only its topology matters.
    fn complex(triangles: &[([u32; 3], u32)]) -> MidComplex {
        let most = triangles.iter().flat_map(|t| t.0).max().unwrap_or(0);
        MidComplex {
            nodes: (0..=most)
                .map(|i| MidNode {
                    point: DVec3::X * f64::from(i),
                    supports: Default::default(),
                })
                .collect(),
            triangles: triangles
                .iter()
                .map(|&(nodes, wall)| MidTriangle {
                    nodes: nodes.map(NodeId),
                    wall: WallId(wall),
                })
                .collect(),
        }
    }

    #[test]
    fn a_t_has_three_sheets_and_one_junction_curve_of_two_edges() {
        // The curve 0-1-2; a flange in two halves of one wall, and a web.
        let t = complex(&[
            ([0, 1, 3], 0),
            ([1, 2, 3], 0),
            ([1, 0, 4], 0),
            ([2, 1, 4], 0),
            ([0, 1, 5], 1),
            ([1, 2, 5], 1),
        ]);
        assert_eq!((sheets(&t), junction_curves(&t)), (3, 1));
    }

    #[test]
    fn curves_end_at_forks_and_a_plate_has_none() {
        // Junction edges 0-1, 0-2, 0-3 meet in node 0.
        let fan = |a: u32, far: u32| [([0, a, far], 0), ([0, a, far + 1], 0), ([0, a, far + 2], 0)];
        let all: Vec<_> = [fan(1, 4), fan(2, 7), fan(3, 10)].concat();
        assert_eq!(junction_curves(&complex(&all)), 3);
        let plate = complex(&[([0, 1, 2], 0), ([0, 2, 3], 0)]);
        assert_eq!((sheets(&plate), junction_curves(&plate)), (1, 0));
    }

    #[test]
    fn a_crease_parts_two_sheets() {
        let l = complex(&[([0, 1, 2], 0), ([1, 0, 3], 1)]);
        assert_eq!((sheets(&l), junction_curves(&l)), (2, 0));
    }

    #[test]
    fn lumps_are_groups_of_neighbours() {
        let arc = |a: u32, b: u32| Arc {
            faces: [FaceId(a), FaceId(b)],
            curve: CurveId(0),
            length: 1.0,
            turn_rad: 0.0,
            convexity: Convexity::Smooth,
        };
        let aag = Aag {
            arcs: vec![arc(0, 1), arc(1, 2), arc(2, 3)],
            ..Aag::default()
        };
        let role: IndexVec<FaceId, Role> =
            vec![Role::Lump, Role::Lump, Role::WallSide, Role::Lump].into();
        assert_eq!(lumps(&aag, &role), 2);
    }
}
