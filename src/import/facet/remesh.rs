//! Facets of a size that a wall can be filled at: long ones split, needless ones taken away, slivers flipped.
//!
//! A facet file has triangles as long as the part and as thin as rounding; tets over such facets do not join the two sides of a wall. So sides longer than the
//! wanted length are halved, short ones contracted into one of their ends, and the rest flipped towards Delaunay's criterion, in rounds
//! (M. Botsch, L. Kobbelt, A remeshing approach to multiresolution modeling, SGP 2004, doi:10.1145/1057432.1057457, without its smoothing: no point ever moves).
//! New points and the middles of sides lie on the smooth surface that the facets stand for, see `bulge`.
//!
//! Guarantees: the surface stays within the given deviation of where it was at every contraction and flip,
//! summed up over what came before at the same vertex; borders between regions stay borders, and their corners stay; the topology does not change.
//! Deterministic: sides are taken in order of their length, then of their ends.

use glam::DVec3;

use super::bulge::{Bulge, bulge, corner_normals};
use super::segment::{NONE, SHARP, Segmented};
use super::soup::Soup;
use crate::geom::triangle::{nearest_on_segment, nearest_on_triangle};

/// Sides longer than this many wanted lengths are split; a half is longer than what is contracted.
const LONG: f64 = 1.4;
/// Sides shorter than this many wanted lengths are contracted.
const SHORT: f64 = 0.5;
/// Facets turn less than this by a contraction or flip.
const TURN: f64 = 0.26;
/// Double area over the longest side squared; below it a facet is a sliver. An equilateral triangle has 0.87.
const SLIVER: f64 = 0.05;
/// Rounds of splits, contractions and flips; nothing changes any more after three or four.
const ROUNDS: usize = 6;
/// Halvings of one side in a round: a side of a thousand wanted lengths takes ten.
const HALVINGS: usize = 24;

/// Wanted sizes.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Side length by region.
    pub length: Vec<f64>,
    /// How far the surface may depart from the given one.
    pub deviation: f64,
    /// Most facets; splitting ends there.
    pub most: usize,
    /// Whether new points and middles lie on the smooth surface that the facets stand for; on the facets otherwise.
    pub smooth: bool,
}

/// Triangles with their regions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Remeshed {
    /// The triangles.
    pub soup: Soup,
    /// #T regions.
    pub region: Vec<u32>,
    /// #T points in the middle of sides (0, 1), (1, 2), (2, 0), alike for both triangles at a side.
    pub mids: Vec<[DVec3; 3]>,
    /// Mean thickness of the solid.
    pub thickness: f64,
    /// Its volume, as its facets were read.
    pub volume: f64,
    /// Whether new points lie on the smooth surface.
    pub smooth: bool,
}

struct Mesh<'a> {
    points: Vec<DVec3>,
    deviation: Vec<f64>,
    /// Dead ones have no corners.
    triangles: Vec<[u32; 3]>,
    region: Vec<u32>,
    normal: Vec<DVec3>,
    /// Normals of the smooth surface at the corners.
    corner: Vec<[DVec3; 3]>,
    around: Vec<Vec<u32>>,
    alive: usize,
    wanted: &'a Wanted,
}

const DEAD: [u32; 3] = [NONE; 3];

/// The same surface in facets of the wanted size.
pub fn remesh(soup: &Soup, faces: &Segmented, wanted: &Wanted) -> Remeshed {
    let mut around = vec![Vec::new(); soup.points.len()];
    for (t, tri) in (0u32..).zip(&soup.triangles) {
        for &v in tri {
            around[v as usize].push(t);
        }
    }
    let mut mesh = Mesh {
        deviation: vec![0.0; soup.points.len()],
        points: soup.points.clone(),
        triangles: soup.triangles.clone(),
        region: faces.region.clone(),
        normal: faces.normal.clone(),
        corner: corner_normals(soup, faces, &around),
        around,
        alive: soup.triangles.len(),
        wanted,
    };
    for _ in 0..ROUNDS {
        let mut changed = mesh.flip_all();
        changed += mesh.contract_all();
        changed += mesh.flip_all();
        changed += mesh.split_all();
        if changed == 0 {
            break;
        }
    }
    mesh.finish()
}

impl Mesh<'_> {
    fn p(&self, v: u32) -> DVec3 {
        self.points[v as usize]
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        self.p(a).distance(self.p(b))
    }

    /// The triangles at a side.
    fn at_side(&self, a: u32, b: u32) -> Vec<u32> {
        self.around[a as usize]
            .iter()
            .copied()
            .filter(|&t| self.triangles[t as usize].contains(&b))
            .collect()
    }

    fn apex(&self, t: u32, a: u32, b: u32) -> u32 {
        self.triangles[t as usize]
            .into_iter()
            .find(|&v| v != a && v != b)
            .unwrap_or(a)
    }

    fn is_border(&self, at: &[u32]) -> bool {
        let &[t, u] = at else { return true };
        let (t, u) = (t as usize, u as usize);
        self.region[t] != self.region[u] || self.normal[t].dot(self.normal[u]) < SHARP.cos()
    }

    /// The wanted length at a side: the least of its regions.
    fn wanted(&self, at: &[u32]) -> f64 {
        at.iter()
            .map(|&t| self.wanted.length[self.region[t as usize] as usize])
            .fold(f64::INFINITY, f64::min)
    }

    /// Every side once, lower end first.
    fn sides(&self) -> Vec<(u32, u32)> {
        let mut sides: Vec<(u32, u32)> = self
            .triangles
            .iter()
            .filter(|t| **t != DEAD)
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)].map(|(p, q)| (p.min(q), p.max(q))))
            .collect();
        sides.sort_unstable();
        sides.dedup();
        sides
    }

    fn round_about(&self, v: u32) -> Vec<u32> {
        let mut ring: Vec<u32> = self.around[v as usize]
            .iter()
            .flat_map(|&t| self.triangles[t as usize])
            .filter(|&w| w != v)
            .collect();
        ring.sort_unstable();
        ring.dedup();
        ring
    }

    fn split_all(&mut self) -> usize {
        let mut count = 0;
        for _ in 0..HALVINGS {
            let mut long: Vec<(f64, u32, u32)> = self
                .sides()
                .into_iter()
                .filter_map(|(a, b)| {
                    let over = self.length(a, b) / self.wanted(&self.at_side(a, b));
                    (over > LONG).then_some((over, a, b))
                })
                .collect();
            long.sort_by(|x, y| y.0.total_cmp(&x.0).then((x.1, x.2).cmp(&(y.1, y.2))));
            let before = count;
            for (over, a, b) in long {
                // A side that an earlier split of this pass made stale is met again in the next.
                if self.alive >= self.wanted.most {
                    return count;
                }
                let at = self.at_side(a, b);
                if !at.is_empty() && self.length(a, b) / self.wanted(&at) >= over {
                    self.split(a, b, &at);
                    count += 1;
                }
            }
            if count == before {
                break;
            }
            self.flip_all();
        }
        count
    }

    /// The normal of the smooth surface at a corner of a triangle.
    fn corner_at(&self, t: u32, v: u32) -> DVec3 {
        let k = self.triangles[t as usize].iter().position(|&w| w == v);
        k.map_or(DVec3::ZERO, |k| self.corner[t as usize][k])
    }

    /// The point in the middle of a side, on the smooth surface.
    fn middle(&self, a: u32, b: u32, at: &[u32]) -> DVec3 {
        if !self.wanted.smooth {
            return self.p(a).midpoint(self.p(b));
        }
        let sides: Vec<Bulge> = at
            .iter()
            .map(|&t| Bulge {
                ends: [self.corner_at(t, a), self.corner_at(t, b)],
                facet: self.normal[t as usize],
            })
            .collect();
        bulge(self.p(a), self.p(b), &sides)
    }

    fn split(&mut self, a: u32, b: u32, at: &[u32]) {
        let middle = self.points.len() as u32;
        self.points.push(self.middle(a, b, at));
        let deviation = self.deviation[a as usize].max(self.deviation[b as usize]);
        self.deviation.push(deviation);
        self.around.push(Vec::new());
        for &t in at {
            let old = self.triangles[t as usize];
            let new = self.triangles.len() as u32;
            let apex = self.apex(t, a, b);
            let own = self.corner[t as usize];
            let between =
                (self.corner_at(t, a) + self.corner_at(t, b)).normalize_or(self.normal[t as usize]);
            let with =
                |gone: u32| std::array::from_fn(|k| if old[k] == gone { between } else { own[k] });
            self.corner.push(with(a));
            self.corner[t as usize] = with(b);
            self.triangles[t as usize] = old.map(|v| if v == b { middle } else { v });
            self.triangles
                .push(old.map(|v| if v == a { middle } else { v }));
            self.region.push(self.region[t as usize]);
            self.normal.push(self.normal[t as usize]);
            self.around[b as usize].retain(|&x| x != t);
            self.around[b as usize].push(new);
            self.around[apex as usize].push(new);
            self.around[middle as usize].extend([t, new]);
            self.alive += 1;
        }
    }

    fn contract_all(&mut self) -> usize {
        let mut total = 0;
        for _ in 0..HALVINGS {
            let mut short: Vec<(f64, u32, u32)> = self
                .sides()
                .into_iter()
                .filter_map(|(a, b)| {
                    let length = self.length(a, b);
                    (length < SHORT * self.wanted(&self.at_side(a, b))).then_some((length, a, b))
                })
                .collect();
            short.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
            let count = short
                .into_iter()
                .filter(|&(_, a, b)| self.contract(a, b) || self.contract(b, a))
                .count();
            total += count;
            // The last per cent is not worth a pass over all.
            if count * 100 < self.alive {
                break;
            }
            self.flip_all();
        }
        total
    }

    /// Draws `u` into `v`, if nothing speaks against it.
    fn contract(&mut self, u: u32, v: u32) -> bool {
        let at = self.at_side(u, v);
        let &[t0, t1] = at.as_slice() else {
            return false;
        };
        let ring = self.round_about(u);
        let other = self.round_about(v);
        let common: Vec<u32> = ring
            .iter()
            .copied()
            .filter(|w| other.binary_search(w).is_ok())
            .collect();
        let mut apexes = [self.apex(t0, u, v), self.apex(t1, u, v)];
        apexes.sort_unstable();
        if common != apexes || ring.len() < 3 || other.len() < 4 {
            return false;
        }
        let borders: Vec<u32> = ring
            .iter()
            .copied()
            .filter(|&w| self.is_border(&self.at_side(u, w)))
            .collect();
        let mut away = match borders[..] {
            [] => 0.0,
            [p, q] if p == v || q == v => {
                let far = if p == v { q } else { p };
                nearest_on_segment(self.p(v), self.p(far), self.p(u)).distance(self.p(u))
            }
            _ => return false,
        };
        let fan: Vec<u32> = self.around[u as usize]
            .iter()
            .copied()
            .filter(|t| !at.contains(t))
            .collect();
        let worst = self.around[u as usize]
            .iter()
            .map(|&t| shape(self.triangles[t as usize].map(|w| self.p(w))))
            .fold(SLIVER, f64::min);
        let mut nearest = f64::INFINITY;
        for &t in &fan {
            let tri = self.triangles[t as usize].map(|w| if w == u { v } else { w });
            let corners = tri.map(|w| self.p(w));
            let normal = unit_normal(corners);
            if normal.dot(self.normal[t as usize]) < TURN.cos() || shape(corners) < worst {
                return false;
            }
            let limit = LONG * self.wanted.length[self.region[t as usize] as usize];
            let long = |w: u32| {
                let new = self.length(v, w);
                new > limit && new > self.length(u, w)
            };
            if tri.iter().any(|&w| w != v && long(w)) {
                return false;
            }
            nearest = nearest.min(nearest_on_triangle(corners, self.p(u)).distance(self.p(u)));
        }
        away = away.max(nearest) + self.deviation[u as usize];
        if away > self.wanted.deviation {
            return false;
        }
        // The normal at v, as the side's own triangles have it.
        let at_v: Vec<(u32, DVec3)> = at
            .iter()
            .map(|&t| (self.region[t as usize], self.corner_at(t, v)))
            .collect();
        for &t in &fan {
            let own = at_v.iter().find(|n| n.0 == self.region[t as usize]);
            let normal = own.map_or(self.normal[t as usize], |n| n.1);
            for k in 0..3 {
                if self.triangles[t as usize][k] == u {
                    self.corner[t as usize][k] = normal;
                }
            }
        }
        for &t in &at {
            for w in self.triangles[t as usize] {
                self.around[w as usize].retain(|&x| x != t);
            }
            self.triangles[t as usize] = DEAD;
            self.alive -= 1;
        }
        for &t in &fan {
            self.triangles[t as usize] =
                self.triangles[t as usize].map(|w| if w == u { v } else { w });
            self.around[v as usize].push(t);
        }
        self.around[u as usize].clear();
        self.deviation[v as usize] = self.deviation[v as usize].max(away);
        true
    }

    fn flip_all(&mut self) -> usize {
        let mut count = 0;
        // Delaunay's criterion ends by itself on a plane; on a bent surface the passes end it.
        for _ in 0..HALVINGS {
            let before = count;
            for (a, b) in self.sides() {
                count += usize::from(self.flip(a, b));
            }
            if count - before <= self.alive / 1000 {
                break;
            }
        }
        count
    }

    fn flip(&mut self, a: u32, b: u32) -> bool {
        let at = self.at_side(a, b);
        let &[t, u] = at.as_slice() else {
            return false;
        };
        if self.is_border(&at) {
            return false;
        }
        let (c, d) = (self.apex(t, a, b), self.apex(u, a, b));
        let angle = |x: u32| (self.p(a) - self.p(x)).angle_between(self.p(b) - self.p(x));
        // Written so that a sliver without angles is not flipped.
        let better = angle(c) + angle(d) > std::f64::consts::PI + 1e-6;
        if !better || c == d || !self.at_side(c, d).is_empty() {
            return false;
        }
        // Triangle t runs a to b or b to a; the flipped pair keeps its sense.
        let up = runs(self.triangles[t as usize], a, b);
        let new_t = if up { [c, a, d] } else { [c, d, a] };
        let new_u = if up { [c, d, b] } else { [c, b, d] };
        let normals = [self.normal[t as usize], self.normal[u as usize]];
        for tri in [new_t, new_u] {
            let n = unit_normal(tri.map(|w| self.p(w)));
            if normals.iter().any(|m| n.dot(*m) < TURN.cos()) {
                return false;
            }
        }
        let axis = (self.p(b) - self.p(a))
            .cross(self.p(d) - self.p(c))
            .normalize_or_zero();
        let gap = (self.p(c) - self.p(a)).dot(axis).abs();
        let carried = [a, b, c, d]
            .iter()
            .map(|&w| self.deviation[w as usize])
            .fold(0.0, f64::max);
        if gap + carried > self.wanted.deviation && gap > 0.0 {
            return false;
        }
        let normal = (normals[0] + normals[1]).normalize_or(normals[0]);
        let of = |v: u32| {
            let sum: DVec3 = [t, u].map(|x| self.corner_at(x, v)).into_iter().sum();
            sum.normalize_or(normal)
        };
        let corners = [new_t.map(of), new_u.map(of)];
        for (tri, own) in [t, u].into_iter().zip(corners) {
            self.corner[tri as usize] = own;
        }
        for (tri, new) in [(t, new_t), (u, new_u)] {
            self.triangles[tri as usize] = new;
            self.normal[tri as usize] = normal;
        }
        self.around[b as usize].retain(|&x| x != t);
        self.around[a as usize].retain(|&x| x != u);
        self.around[d as usize].push(t);
        self.around[c as usize].push(u);
        true
    }

    fn finish(self) -> Remeshed {
        let smooth = self.wanted.smooth;
        let stay: Vec<usize> = (0..self.triangles.len())
            .filter(|&t| self.triangles[t] != DEAD)
            .collect();
        let mids = stay
            .iter()
            .map(|&t| {
                let [a, b, c] = self.triangles[t];
                // Lower end first: both triangles at a side compute the same.
                [(a, b), (b, c), (c, a)].map(|(p, q)| {
                    let mut at = self.at_side(p, q);
                    at.sort_unstable();
                    self.middle(p.min(q), p.max(q), &at)
                })
            })
            .collect();
        let triangles = stay.iter().map(|&t| self.triangles[t]).collect();
        Remeshed {
            soup: super::shells::compact(&self.points, triangles),
            region: stay.iter().map(|&t| self.region[t]).collect(),
            mids,
            thickness: 0.0,
            volume: 0.0,
            smooth,
        }
    }
}

fn runs([p, q, r]: [u32; 3], a: u32, b: u32) -> bool {
    [(p, q), (q, r), (r, p)].contains(&(a, b))
}

fn unit_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

fn shape([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = a
        .distance_squared(b)
        .max(b.distance_squared(c))
        .max(c.distance_squared(a));
    if longest > 0.0 {
        (b - a).cross(c - a).length() / longest
    } else {
        0.0
    }
}
