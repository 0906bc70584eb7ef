//! The boundary of the solids, made ready to be asked: rays, nearest points, inside or outside.
//!
//! Curved facets are cut into flat ones until these sag by no more than a fiftieth of the mean thickness, so that a ray finds the
//! right wall; distances are then taken to the curved facet itself. A side is cut by its own sag, so that facets on both sides of it agree.

use crate::geom::six_node::{QuadraticTriangle, flat_parameters};
use crate::model::brep::Brep;
use crate::model::ids::{FacetId, Id, VertexId};
use crate::spatial::TriangleBvh;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// A facet whose normals differ by less than this cosine is flat.
const FLAT_COS: f64 = 1.0 - 1e-9;
/// Sag of the flat triangles over the mean thickness: a mid-point off by this much still has its walls on the right sides.
const SAG: f64 = 0.02;
/// Each halving quarters the sag; after six a facet has been cut 4096-fold, and what sags still is no wall but a broken facet.
const DEEPEST: u32 = 6;
/// A place is straight above its foot within this sine: facets meet at angles greater than that of rounding.
const PLUMB: f64 = 0.02;
/// A bend that turns by less than this over the distance in question, rad, is a plane: the difference is less than rounding.
const STRAIGHT: f64 = 1e-6;
/// Edges of the solid sharper than this may carry a rim.
const SHARP_DEG: f64 = 30.0;

/// A flat piece of a facet.
#[derive(Clone, Copy, Debug)]
struct Piece {
    facet: u32,
    /// Parameters of its corners on the facet.
    at: [DVec2; 3],
}

/// The boundary of all solids.
pub(super) struct Skin {
    facets: Vec<QuadraticTriangle>,
    /// For each facet the number of its face, counted over all solids.
    faces: Vec<u32>,
    /// For each of these numbers the tag of the face in its file.
    tags: Vec<i32>,
    pieces: Vec<Piece>,
    flat: Vec<[DVec3; 3]>,
    bvh: TriangleBvh,
    /// For each face its flat pieces: among all of them a search for a far face would look at everything nearer.
    by_face: Vec<(Vec<u32>, TriangleBvh)>,
    /// Half of the Euler characteristic of the boundaries.
    pub euler: f64,
    /// Volume of the solids, mm³.
    pub volume: f64,
    /// Diagonal of the box around them, mm.
    pub diagonal: f64,
    /// Edges where the boundary bends sharply, as short straight pieces.
    pub sharp: Vec<[DVec3; 2]>,
}

/// Where a ray meets the skin.
pub(super) struct SkinHit {
    pub face: u32,
    pub t: f64,
    /// Distance to the plane of the facet there, if it is flat.
    pub plumb: Option<f64>,
    /// Outward unit normal of the curved facet there.
    pub normal: DVec3,
}

impl Skin {
    pub fn new(solids: &[&Brep]) -> Self {
        let (mut facets, mut faces, mut sharp) = (Vec::new(), Vec::new(), Vec::new());
        let mut tags: Vec<i32> = Vec::new();
        let (mut characteristic, mut first_face) = (0i64, 0u32);
        for solid in solids {
            let first = facets.len();
            for facet in &solid.facets {
                facets.push(QuadraticTriangle {
                    corners: facet.corners.map(|v| solid.vertices[v]),
                    mids: facet.mids,
                });
                faces.push(first_face + facet.face.0);
            }
            sharp_sides(solid, &facets[first..], &mut sharp);
            characteristic += solid.euler();
            let named = solid.facets.iter().map(|f| f.face.0 + 1).max();
            first_face += named.unwrap_or(0).max(solid.faces.len() as u32);
            tags.extend(solid.faces.iter().map(|f| f.tag));
            tags.resize(first_face as usize, 0);
        }
        let volume = facets.iter().map(QuadraticTriangle::volume).sum::<f64>();
        let area: f64 = facets.iter().map(|f| area(f.corners)).sum();
        // That of a plate without rims.
        let mean_thickness = if area > 0.0 {
            2.0 * volume.abs() / area
        } else {
            0.0
        };
        let mut pieces = Vec::with_capacity(facets.len());
        for (i, facet) in facets.iter().enumerate() {
            let whole = [DVec2::ZERO, DVec2::X, DVec2::Y];
            cut(
                facet,
                i as u32,
                whole,
                SAG * mean_thickness,
                DEEPEST,
                &mut pieces,
            );
        }
        let flat: Vec<[DVec3; 3]> = pieces
            .iter()
            .map(|p| {
                let facet = &facets[p.facet as usize];
                if p.at == [DVec2::ZERO, DVec2::X, DVec2::Y] {
                    facet.corners
                } else {
                    p.at.map(|w| facet.point(w))
                }
            })
            .collect();
        let mut of_face: Vec<Vec<u32>> = vec![Vec::new(); first_face as usize];
        for (i, piece) in pieces.iter().enumerate() {
            of_face[faces[piece.facet as usize] as usize].push(i as u32);
        }
        let by_face = of_face
            .into_par_iter()
            .map(|of| {
                let flat: Vec<[DVec3; 3]> = of.iter().map(|i| flat[*i as usize]).collect();
                (of, TriangleBvh::new(&flat))
            })
            .collect();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in flat.iter().flatten() {
            (low, high) = (low.min(*p), high.max(*p));
        }
        Self {
            euler: characteristic as f64 / 2.0,
            volume,
            diagonal: if flat.is_empty() {
                0.0
            } else {
                (high - low).length()
            },
            bvh: TriangleBvh::new(&flat),
            by_face,
            facets,
            faces,
            tags,
            pieces,
            flat,
            sharp,
        }
    }

    /// The tag of a face in its file; 0 where it has none.
    pub fn tag(&self, face: u32) -> i32 {
        self.tags.get(face as usize).copied().unwrap_or(0)
    }

    /// Areas of the flat pieces.
    pub fn areas(&self) -> Vec<f64> {
        self.flat.iter().map(|t| area(*t)).collect()
    }

    /// Of a flat piece: its corners, the face that it lies on, and the point and unit normal of the curved facet above `weights`.
    pub fn above(&self, piece: usize, weights: [f64; 3]) -> ([DVec3; 3], u32, DVec3, DVec3) {
        let p = self.pieces[piece];
        let facet = &self.facets[p.facet as usize];
        let w = p.at[0] * weights[0] + p.at[1] * weights[1] + p.at[2] * weights[2];
        let face = self.faces[p.facet as usize];
        (self.flat[piece], face, facet.point(w), facet.normal(w))
    }

    /// The first wall in this unit direction, at `least` or further.
    pub fn hit(&self, origin: DVec3, direction: DVec3, least: f64) -> Option<SkinHit> {
        let (i, hit) = self.bvh.first_hit_beyond(origin, direction, least)?;
        let (_, face, _, normal) = self.above(i, hit.weights);
        let facet = &self.facets[self.pieces[i].facet as usize];
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let is_flat = corners
            .iter()
            .all(|w| facet.normal(*w).dot(normal) > FLAT_COS);
        Some(SkinHit {
            face,
            t: hit.t,
            plumb: is_flat.then(|| hit.t * normal.dot(direction).abs()),
            normal,
        })
    }

    /// The flat piece that is nearest to `p`, at most `reach` away, and the corner weights there.
    pub fn nearest(&self, p: DVec3, reach: f64) -> Option<(usize, [f64; 3])> {
        let near = self.bvh.nearest_within(p, reach)?;
        let w = flat_parameters(self.flat[near.index], near.point);
        Some((near.index, [1.0 - w.x - w.y, w.x, w.y]))
    }

    /// Distance from a place to what a ray from there has met: to the face, or to the surface that it goes on as, a plane or a bend. On the slope over a step the sheet
    /// stands for the level that lies across, also where that ends before the foot of the plumb line; and so it does under a rounding that ends above it.
    pub fn across(&self, p: DVec3, hit: &SkinHit) -> f64 {
        let Some((facet, w)) = self.foot(p, hit.face, hit.t) else {
            return hit.plumb.map_or(hit.t, |plumb| plumb.min(hit.t));
        };
        let near = facet.point(w).distance(p);
        near.min(hit.plumb.unwrap_or_else(|| carried_on(&facet, w, p)))
    }

    /// The facet of a face that is nearest to `p`, and the parameters of the place; none where none is nearer than `at_most`, which a ray found.
    fn foot(&self, p: DVec3, face: u32, at_most: f64) -> Option<(QuadraticTriangle, DVec2)> {
        let (pieces, bvh) = &self.by_face[face as usize];
        // Room for the ray's own rounding, so that the triangle that it met is found again.
        let near = bvh.nearest_within(p, at_most * (1.0 + 1e-9))?;
        Some(self.curved_foot(p, pieces[near.index] as usize, near.point))
    }

    /// Distance from `p` to the curved facets of a face; `at_most`, which a ray found, where none is nearer.
    pub fn distance(&self, p: DVec3, face: u32, at_most: f64) -> f64 {
        self.foot(p, face, at_most)
            .map_or(at_most, |(facet, w)| facet.point(w).distance(p))
    }

    /// Whether `p` is in the material, or no further than `tolerance` outside.
    pub fn holds(&self, p: DVec3, tolerance: f64) -> bool {
        self.bvh.inside(p)
            || self.bvh.nearest(p).is_some_and(|near| {
                near.distance < tolerance
                    || self.curved_distance(p, near.index, near.point) < tolerance
            })
    }

    fn curved_distance(&self, p: DVec3, piece: usize, foot: DVec3) -> f64 {
        let (facet, w) = self.curved_foot(p, piece, foot);
        facet.point(w).distance(p)
    }

    /// The nearest place of the curved facet that `foot` lies on a flat piece of.
    fn curved_foot(&self, p: DVec3, piece: usize, foot: DVec3) -> (QuadraticTriangle, DVec2) {
        let Piece { facet, at } = self.pieces[piece];
        let w = flat_parameters(self.flat[piece], foot);
        let start = at[0] * (1.0 - w.x - w.y) + at[1] * w.x + at[2] * w.y;
        let facet = self.facets[facet as usize];
        (facet, facet.nearest(p, start))
    }
}

/// Distance from `p` to what a facet goes on as beyond its place `w`: the circle that it bends along towards `p`.
fn carried_on(facet: &QuadraticTriangle, w: DVec2, p: DVec3) -> f64 {
    let (foot, normal) = (facet.point(w), facet.normal(w));
    let look = p - foot;
    let (up, along) = (look.dot(normal), look.reject_from(normal));
    let beyond = along.length();
    if beyond <= PLUMB * look.length() {
        return look.length();
    }
    let bend = facet.bend(w, along / beyond);
    if bend.abs() * look.length() < STRAIGHT {
        return up.abs();
    }
    let radius = 1.0 / bend;
    ((up + radius).hypot(beyond) - radius.abs()).abs()
}

fn area([a, b, c]: [DVec3; 3]) -> f64 {
    (b - a).cross(c - a).length() / 2.0
}

/// The sharp sides of one boundary go to `sharp`. `facets` are those of the solid, in its order.
fn sharp_sides(solid: &Brep, facets: &[QuadraticTriangle], sharp: &mut Vec<[DVec3; 2]>) {
    let mut sides: Vec<(VertexId, VertexId, FacetId, u8)> = Vec::with_capacity(3 * facets.len());
    for (id, facet) in solid.facets.enumerated() {
        for k in 0..3u8 {
            let (a, b) = (
                facet.corners[usize::from(k)],
                facet.corners[usize::from(k + 1) % 3],
            );
            sides.push((a.min(b), a.max(b), id, k));
        }
    }
    sides.sort_unstable();
    let middle = [
        DVec2::new(0.5, 0.0),
        DVec2::splat(0.5),
        DVec2::new(0.0, 0.5),
    ];
    for run in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let normal = |s: &(VertexId, VertexId, FacetId, u8)| {
            facets[s.2.index()].normal(middle[usize::from(s.3)])
        };
        if run.len() != 2 || normal(&run[0]).angle_between(normal(&run[1])) > SHARP_DEG.to_radians()
        {
            let mid = solid.facets[run[0].2].mids[usize::from(run[0].3)];
            sharp.push([solid.vertices[run[0].0], mid]);
            sharp.push([mid, solid.vertices[run[0].1]]);
        }
    }
}

/// Halves the sides of `at` that sag by more than `sag`, until none does.
fn cut(
    facet: &QuadraticTriangle,
    index: u32,
    at: [DVec2; 3],
    sag: f64,
    deepest: u32,
    pieces: &mut Vec<Piece>,
) {
    let point = at.map(|w| facet.point(w));
    let middle: [DVec2; 3] = std::array::from_fn(|k| (at[k] + at[(k + 1) % 3]) / 2.0);
    let sags: [bool; 3] = std::array::from_fn(|k| {
        let straight = (point[k] + point[(k + 1) % 3]) / 2.0;
        deepest > 0 && facet.point(middle[k]).distance(straight) > sag
    });
    let mut down = |at: [DVec2; 3]| cut(facet, index, at, sag, deepest - 1, pieces);
    match sags.iter().filter(|s| **s).count() {
        0 => pieces.push(Piece { facet: index, at }),
        3 => {
            for k in 0..3 {
                down([at[k], middle[k], middle[(k + 2) % 3]]);
            }
            down(middle);
        }
        1 => {
            let k = sags.iter().position(|s| *s).unwrap_or(0);
            let (a, b, c) = (at[k], at[(k + 1) % 3], at[(k + 2) % 3]);
            down([a, middle[k], c]);
            down([middle[k], b, c]);
        }
        _ => {
            // The two sides that sag meet in corner b.
            let k = sags.iter().position(|s| !*s).unwrap_or(0);
            let (c, a, b) = (at[k], at[(k + 1) % 3], at[(k + 2) % 3]);
            let (ab, bc) = (middle[(k + 1) % 3], middle[(k + 2) % 3]);
            down([ab, b, bc]);
            down([a, ab, bc]);
            down([a, bc, c]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_parts::{box_brep, tube_brep};

    #[test]
    fn a_box_is_a_ball_in_topology_and_has_twelve_sharp_edges() {
        let solid = box_brep(DVec3::new(100.0, 60.0, 3.0));
        let skin = Skin::new(&[&solid]);
        assert_eq!(skin.euler, 1.0);
        assert!((skin.volume - 18_000.0).abs() < 1e-8);
        let length: f64 = skin.sharp.iter().map(|[a, b]| a.distance(*b)).sum();
        assert!((length - 4.0 * 163.0).abs() < 1e-9);
        let middle = DVec3::new(50.1, 30.3, 1.0);
        assert!(skin.holds(middle, 0.0) && !skin.holds(middle + DVec3::Z * 2.1, 0.05));
        assert!(skin.holds(middle + DVec3::Z * 2.1, 0.15));
        let hit = skin.hit(middle, DVec3::Z, 0.0).unwrap();
        assert!((hit.t - 2.0).abs() < 1e-12 && hit.normal.distance(DVec3::Z) < 1e-12);
        assert!((skin.distance(middle, hit.face, hit.t) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn beyond_its_end_a_rounding_goes_on_as_a_circle() {
        // A plate 3 thick whose upper side ends in a rounding of 2 round (18, 1), drawn in four facets' widths; all of it is face 2.
        let centre = DVec3::new(0.0, 18.0, 1.0);
        let arc = |k: i32| (f64::from(k) * std::f64::consts::FRAC_PI_8).sin_cos();
        let mut outline = vec![(0.0, 0.0), (20.0, 0.0)];
        outline.extend((0..=4).map(|k| (18.0 + 2.0 * arc(k).1, 1.0 + 2.0 * arc(k).0)));
        outline.push((0.0, 3.0));
        let n = outline.len();
        let points = [0.0, 30.0]
            .into_iter()
            .flat_map(|x| outline.iter().map(move |&(y, z)| DVec3::new(x, y, z)))
            .collect();
        let face = |i: usize| if (2..6).contains(&i) { 2 } else { i as u32 };
        let mut polygons: Vec<(Vec<usize>, u32)> = (0..n)
            .map(|i| (vec![i, (i + 1) % n, (i + 1) % n + n, i + n], face(i)))
            .collect();
        polygons.push(((0..n).rev().collect(), 8));
        polygons.push(((n..2 * n).collect(), 9));
        let solid = crate::test_parts::brep(points, &polygons, |a, b| {
            let m = (a + b) / 2.0;
            let from = (m - centre).with_x(0.0);
            let on = |p: DVec3| ((p - centre).with_x(0.0).length() - 2.0).abs() < 1e-9;
            if on(a) && on(b) && a.y >= 18.0 && a.z >= 1.0 {
                m + from.normalize() * (2.0 - from.length())
            } else {
                m
            }
        });
        let skin = Skin::new(&[&solid]);
        // Straight under the rounding, and below its end at z = 1: there the face is further off, and the circle is not.
        for (y, z) in [(19.0, 1.5), (18.7, 0.6), (19.2, 0.5), (18.4, 0.9)] {
            let p = DVec3::new(15.0, y, z);
            let hit = skin
                .hit(p, DVec3::new(0.0, 0.5, 1.0).normalize(), 0.0)
                .unwrap();
            assert_eq!(hit.face, 2);
            let away = 2.0 - (p - centre).with_x(0.0).length();
            let found = skin.across(p, &hit);
            // Four facets know the bend of a quarter circle to a percent.
            assert!((found - away).abs() < 0.02, "{y} {z}: {found} for {away}");
            let trimmed = skin.distance(p, hit.face, hit.t);
            assert_eq!(trimmed > away + 0.05, z < 0.7, "{y} {z}: {trimmed}");
        }
    }

    #[test]
    fn a_coarse_tube_thinner_than_its_facets_sag_is_cut_fine_enough() {
        // 24 facets round a radius of 50 sag by 0.43, nearly half of the wall of 1.
        let solid = tube_brep(50.0, 49.0, 80.0, 24);
        let skin = Skin::new(&[&solid]);
        assert_eq!(skin.euler, 0.0);
        let exact = std::f64::consts::PI * (50.0_f64.powi(2) - 49.0_f64.powi(2)) * 80.0;
        assert!((skin.volume / exact - 1.0).abs() < 1e-4);
        assert!((skin.areas().iter().sum::<f64>() / (solid.area() * 1.003) - 1.0).abs() < 5e-3);
        for i in 0..200 {
            let turn = f64::from(i) * 0.1;
            let out = DVec3::new(turn.cos(), turn.sin(), 0.0);
            let p = out * 49.5 + DVec3::Z * (1.0 + 0.39 * f64::from(i));
            assert!(skin.holds(p, 0.0), "{i}");
            for (direction, normal) in [(out, out), (-out, -out)] {
                let hit = skin.hit(p, direction, 0.0).unwrap();
                let d = skin.distance(p, hit.face, hit.t);
                // Six-node facets of 15 degrees are off a circle by 4e-4 here.
                assert!((d - 0.5).abs() < 5e-4, "{d}");
                assert!(hit.normal.dot(normal) > 0.9999);
            }
        }
    }
}
