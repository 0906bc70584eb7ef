//! Width: how wide the narrow sheets of a mid-surface are: ribs between their foot and their rim, flanges, webs.
//!
//! **In** an untangled complex. **Out** the triangles that lie where a sheet is narrow, with its width there, mm.
//!
//! From places all along the boundary of each sheet (rims, creases, junctions) a look goes straight across it, unfolded from triangle to triangle, until it meets the boundary again. Where it meets it
//! about squarely that is the width. One short look says little: between two holes there is one too. Neighbouring looks whose lengths change slowly make a run, and a run at least about as long as the
//! sheet is wide there is a narrow sheet.
//!
//! **Guarantees.** Widths do not depend on where the part lies, and grow with it. **Limits.** Sheets that end in a point have no width there; a triangular gusset has none.
//! **Cost.** One walk through a few triangles a look, three looks an edge.

use crate::model::complex::{EdgeKind, MidComplex};
use crate::model::disjoint::Disjoint;
use crate::model::ids::{IndexVec, NodeId, TriangleId, WallId};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Looks from one edge, evenly spread.
const LOOKS: usize = 3;
/// A look meets the far side about squarely within 15 degrees: a rib whose height changes twice as fast is a wedge.
const SQUARE_COS: f64 = 0.966;
/// Looks go on in one another where their lengths change by less than this share of the distance between them: both sides of the sheet may lean by the same 15 degrees.
const SLOPE: f64 = 0.54;
/// A run is a narrow sheet if it is this many times as long as the sheet is wide: a square one still is.
const LENGTH: f64 = 0.8;
/// A look that crosses more triangles than this goes round in circles.
const MOST_CROSSED: usize = 10_000;

/// A side of a triangle.
type Side = (TriangleId, usize);

/// A look across a sheet that met the other side squarely.
struct Look {
    /// How far it went, mm.
    width: f64,
    /// The triangles that it crossed.
    crossed: Vec<TriangleId>,
}

/// Where the sheets of a complex are narrower than `most(wall)`, mm: triangles in order, each with the width of its sheet there, mm.
pub fn narrow(
    complex: &MidComplex,
    most: &(dyn Fn(WallId) -> f64 + Sync),
) -> Vec<(TriangleId, f64)> {
    let net = Net::new(complex);
    let border = net.border();
    let looks: Vec<Option<Look>> = (border.par_iter())
        .flat_map_iter(|&(t, k)| {
            let limit = most(complex.triangles[t].wall);
            (0..LOOKS).map(move |i| (t, k, (i as f64 + 0.5) / LOOKS as f64, limit))
        })
        .map(|(t, k, share, limit)| net.look((t, k), share, limit))
        .collect();
    let length = |i: usize| net.length(border[i / LOOKS]) / LOOKS as f64;
    let mut runs = Disjoint::new(looks.len());
    let mut join = |i: usize, j: usize| {
        if let (Some(a), Some(b)) = (&looks[i], &looks[j]) {
            let apart = (length(i) + length(j)) / 2.0;
            if (a.width - b.width).abs() <= SLOPE * apart {
                runs.join(i as u32, j as u32);
            }
        }
    };
    for i in 0..border.len() {
        for k in 1..LOOKS {
            join(LOOKS * i + k - 1, LOOKS * i + k);
        }
    }
    for [i, j] in net.joints(&border) {
        join(i, j);
    }
    // Length of each run, and its area.
    let mut size: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
    for (i, look) in looks.iter().enumerate() {
        if let Some(look) = look {
            let (run, area) = size.entry(runs.find(i as u32)).or_default();
            *run += length(i);
            *area += length(i) * look.width;
        }
    }
    let mut width: BTreeMap<TriangleId, f64> = BTreeMap::new();
    for (i, look) in looks.iter().enumerate() {
        let Some(look) = look else { continue };
        let (run, area) = size[&runs.find(i as u32)];
        if run * run < LENGTH * area {
            continue;
        }
        for &t in &look.crossed {
            let least = width.entry(t).or_insert(f64::INFINITY);
            *least = least.min(look.width);
        }
    }
    width.into_iter().collect()
}

/// The triangles of a complex and what lies across their sides within their sheets.
struct Net<'a> {
    complex: &'a MidComplex,
    across: IndexVec<TriangleId, [Option<Side>; 3]>,
}

impl<'a> Net<'a> {
    fn new(complex: &'a MidComplex) -> Self {
        let mut across = IndexVec::filled([None; 3], complex.triangles.len());
        let side = |t: TriangleId, ends: [NodeId; 2]| {
            let n = complex.triangles[t].nodes;
            (0..3).find(|&k| ends.contains(&n[k]) && ends.contains(&n[(k + 1) % 3]))
        };
        for edge in complex.edges() {
            if complex.kind(&edge) != EdgeKind::Inner {
                continue;
            }
            let [a, b] = [edge.triangles[0], edge.triangles[1]];
            if let (Some(i), Some(j)) = (side(a, edge.ends), side(b, edge.ends)) {
                across[a][i] = Some((b, j));
                across[b][j] = Some((a, i));
            }
        }
        Self { complex, across }
    }

    /// The sides of triangles that bound sheets.
    fn border(&self) -> Vec<Side> {
        (self.across.enumerated())
            .flat_map(|(t, sides)| (0..3).filter(|&k| sides[k].is_none()).map(move |k| (t, k)))
            .collect()
    }

    fn nodes(&self, (t, k): Side) -> [NodeId; 2] {
        let n = self.complex.triangles[t].nodes;
        [n[k], n[(k + 1) % 3]]
    }

    fn ends(&self, side: Side) -> [DVec3; 2] {
        self.nodes(side).map(|n| self.complex.nodes[n].point)
    }

    fn length(&self, side: Side) -> f64 {
        let [a, b] = self.ends(side);
        a.distance(b)
    }

    /// Looks that are neighbours over a node of the border, where two sides of one sheet follow each other there.
    fn joints(&self, border: &[Side]) -> Vec<[usize; 2]> {
        let place: BTreeMap<Side, usize> = border.iter().copied().zip(0..).collect();
        let mut found = Vec::new();
        let ends = (border.iter().enumerate()).flat_map(|(i, &s)| [(i, s, 0), (i, s, 1)]);
        for (i, (t, k), end) in ends {
            // Round the node at this end, from triangle to triangle, to the next side of the border.
            let node = self.nodes((t, k))[end];
            let mut side = (t, (k + 1 + (1 - end)) % 3);
            for _ in 0..MOST_CROSSED {
                let Some((next, j)) = self.across[side.0][side.1] else {
                    break;
                };
                // The other side of the next triangle at the node; windings may be mixed.
                let other = [(j + 1) % 3, (j + 2) % 3];
                let at = other
                    .into_iter()
                    .find(|&m| self.nodes((next, m)).contains(&node));
                side = (next, at.unwrap_or(j));
            }
            let Some(&j) = place.get(&side) else { continue };
            let begins = self.nodes(side)[0] == node;
            let near = if begins {
                LOOKS * j
            } else {
                LOOKS * j + LOOKS - 1
            };
            found.push([LOOKS * i + end * (LOOKS - 1), near]);
        }
        found
    }

    /// The unit vector in a triangle's plane, square to one of its sides, that points into it; `None` where it has no area.
    fn inwards(&self, (t, k): Side) -> Option<DVec3> {
        let [a, b, c] = self.complex.corners(&self.complex.triangles[t]);
        let corners = [a, b, c];
        let (from, to, far) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
        let along = (to - from).try_normalize()?;
        (far - from).reject_from_normalized(along).try_normalize()
    }

    /// The look across the sheet from a place on its border, if it meets the border again within `most`, mm, and squarely.
    fn look(&self, from: Side, share: f64, most: f64) -> Option<Look> {
        let [a, b] = self.ends(from);
        let mut p = a.lerp(b, share);
        let (mut side, mut way) = (from, self.inwards(from)?);
        let mut look = Look {
            width: 0.0,
            crossed: Vec::new(),
        };
        for _ in 0..MOST_CROSSED {
            let t = side.0;
            look.crossed.push(t);
            let (k, step) = self.exit(side, p, way)?;
            p += step * way;
            look.width += step;
            if look.width > most {
                return None;
            }
            let out = -self.inwards((t, k))?;
            match self.across[t][k] {
                None => return (way.dot(out) >= SQUARE_COS).then_some(look),
                Some(next) => {
                    let [a, b] = self.ends((t, k));
                    let along = (b - a).try_normalize()?;
                    let on = self.inwards(next)?;
                    way = (way.dot(along) * along + way.dot(out) * on).try_normalize()?;
                    side = next;
                }
            }
        }
        None
    }

    /// Through which side a straight line leaves a triangle that it entered at `p` through `side`, and after how far, mm.
    fn exit(&self, (t, entry): Side, p: DVec3, way: DVec3) -> Option<(usize, f64)> {
        let corners = self.complex.corners(&self.complex.triangles[t]);
        let normal = self
            .complex
            .area_vector(&self.complex.triangles[t])
            .try_normalize()?;
        // The line leaves between the corner that both other sides have and the one on the other side of the line.
        let [first, last] = [(entry + 1) % 3, (entry + 2) % 3];
        let left = |corner: usize| (corners[corner] - p).dot(normal.cross(way)) > 0.0;
        let k = if left(first) != left(last) {
            first
        } else {
            last
        };
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let across = normal.cross(b - a);
        let step = (a - p).dot(across) / way.dot(across);
        (step.is_finite() && step >= 0.0).then_some((k, step))
    }
}

#[cfg(test)]
mod tests;
