//! One sheet as cells of three or four nodes that may be exchanged for others, a few at a time, and put back.

use glam::DVec3;
use smallvec::SmallVec;

/// The nodes of a cell, in order round it.
pub(super) type Ring = SmallVec<[u32; 4]>;
/// Cells or nodes round a place.
pub(super) type Few = SmallVec<[u32; 8]>;

/// The surface that nodes stay on.
pub(super) trait Ground: Sync {
    /// The point of the surface nearest to `p`, and the unit normal there.
    fn foot(&self, p: DVec3) -> Place;
}

/// Cells of one sheet. Dead cells keep their number.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    /// #N positions, mm.
    pub points: Vec<DVec3>,
    /// #N unit normals of the ground there.
    pub normals: Vec<DVec3>,
    /// #N nodes that neither move nor vanish.
    pub held: Vec<bool>,
    /// #C rings, wound one way.
    pub rings: Vec<Ring>,
    /// #C whether the cell is there.
    pub lives: Vec<bool>,
    /// #N living cells at each node.
    pub stars: Vec<Few>,
    /// Edges that no change may take away, lower end first, sorted.
    pub kept: Vec<[u32; 2]>,
}

/// What a change took away and added, to take it back.
#[derive(Debug, Default)]
pub(super) struct Undo {
    gone: Few,
    /// How many cells and nodes there were.
    counts: [usize; 2],
    places: SmallVec<[(u32, Place); 16]>,
}

/// A position and the normal of the ground there.
pub(super) type Place = (DVec3, DVec3);

impl Cells {
    /// Cells at these places.
    pub(super) fn new(
        points: Vec<DVec3>,
        normals: Vec<DVec3>,
        held: Vec<bool>,
        rings: Vec<Ring>,
        kept: Vec<[u32; 2]>,
    ) -> Self {
        let mut stars = vec![Few::new(); points.len()];
        for (i, ring) in rings.iter().enumerate() {
            for &n in ring {
                stars[n as usize].push(i as u32);
            }
        }
        let lives = vec![true; rings.len()];
        Self {
            points,
            normals,
            held,
            rings,
            lives,
            stars,
            kept,
        }
    }

    /// Numbers of the living cells.
    pub(super) fn living(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.rings.len() as u32).filter(|&c| self.lives[c as usize])
    }

    pub(super) fn ring(&self, cell: u32) -> &Ring {
        &self.rings[cell as usize]
    }

    pub(super) fn star(&self, node: u32) -> &Few {
        &self.stars[node as usize]
    }

    pub(super) fn is_quad(&self, cell: u32) -> bool {
        self.ring(cell).len() == 4
    }

    pub(super) fn is_kept(&self, a: u32, b: u32) -> bool {
        self.kept.binary_search(&[a.min(b), a.max(b)]).is_ok()
    }

    /// The cell on the other side of the `k`-th edge, unless the edge is kept.
    pub(super) fn across(&self, cell: u32, k: usize) -> Option<u32> {
        let ring = self.ring(cell);
        let (a, b) = (ring[k], ring[(k + 1) % ring.len()]);
        if self.is_kept(a, b) {
            return None;
        }
        self.star(a)
            .iter()
            .copied()
            .find(|&c| c != cell && self.side(c, b, a).is_some())
    }

    /// Which edge of the cell runs from `a` to `b`.
    pub(super) fn side(&self, cell: u32, a: u32, b: u32) -> Option<usize> {
        let ring = self.ring(cell);
        (0..ring.len()).find(|&k| ring[k] == a && ring[(k + 1) % ring.len()] == b)
    }

    /// Nodes joined to a node by an edge, each once, in the order of its star.
    pub(super) fn neighbours(&self, node: u32) -> Few {
        let mut found = Few::new();
        for &c in self.star(node) {
            let ring = self.ring(c);
            let k = ring.iter().position(|&n| n == node).unwrap_or(0);
            for n in [ring[(k + 1) % ring.len()], ring[(k + ring.len() - 1) % ring.len()]] {
                if !found.contains(&n) {
                    found.push(n);
                }
            }
        }
        found
    }

    /// Whether an edge joins two nodes.
    pub(super) fn joined(&self, a: u32, b: u32) -> bool {
        self.star(a)
            .iter()
            .any(|&c| self.side(c, a, b).is_some() || self.side(c, b, a).is_some())
    }

    /// Takes cells away and puts others in their place.
    pub(super) fn exchange(&mut self, gone: &[u32], new: &[Ring]) -> Undo {
        let undo = Undo {
            gone: gone.iter().copied().collect(),
            counts: [self.rings.len(), self.points.len()],
            places: SmallVec::new(),
        };
        for &c in gone {
            self.drop_cell(c);
        }
        for ring in new {
            let id = self.rings.len() as u32;
            for &n in ring {
                self.stars[n as usize].push(id);
            }
            self.rings.push(ring.clone());
            self.lives.push(true);
        }
        undo
    }

    /// A free node more, without cells.
    pub(super) fn add_node(&mut self, (point, normal): Place) -> u32 {
        self.points.push(point);
        self.normals.push(normal);
        self.held.push(false);
        self.stars.push(Few::new());
        self.points.len() as u32 - 1
    }

    /// Takes the last node away, which has no cells.
    pub(super) fn drop_node(&mut self) {
        self.points.pop();
        self.normals.pop();
        self.held.pop();
        self.stars.pop();
    }

    /// Keeps the place of a node, so that `undo` can move it back.
    pub(super) fn remember(&self, undo: &mut Undo, node: u32) {
        undo.places.push((node, self.place(node)));
    }

    /// Where a node is.
    pub(super) fn place(&self, node: u32) -> Place {
        (self.points[node as usize], self.normals[node as usize])
    }

    /// Moves a node.
    pub(super) fn put(&mut self, node: u32, (point, normal): Place) {
        self.points[node as usize] = point;
        self.normals[node as usize] = normal;
    }

    /// As before the exchange; `nodes` were added just before it.
    pub(super) fn take_back(&mut self, undo: Undo, nodes: usize) {
        // A node that was remembered twice goes where it was first.
        for &(n, place) in undo.places.iter().rev() {
            self.put(n, place);
        }
        for c in (undo.counts[0]..self.rings.len()).rev() {
            self.drop_cell(c as u32);
        }
        self.rings.truncate(undo.counts[0]);
        self.lives.truncate(undo.counts[0]);
        for c in undo.gone {
            self.lives[c as usize] = true;
            for k in 0..self.rings[c as usize].len() {
                let n = self.rings[c as usize][k];
                self.stars[n as usize].push(c);
            }
        }
        let count = undo.counts[1] - nodes;
        self.points.truncate(count);
        self.normals.truncate(count);
        self.held.truncate(count);
        self.stars.truncate(count);
    }

    fn drop_cell(&mut self, cell: u32) {
        self.lives[cell as usize] = false;
        for k in 0..self.rings[cell as usize].len() {
            let n = self.rings[cell as usize][k];
            self.stars[n as usize].retain(|c| *c != cell);
        }
    }

    pub(super) fn corners(&self, cell: u32) -> SmallVec<[DVec3; 4]> {
        let at = |n: &u32| self.points[*n as usize];
        self.ring(cell).iter().map(at).collect()
    }

    /// The scaled Jacobian of a cell seen along the normal of the ground, of a triangle against an equilateral one; below zero where it is turned over.
    pub(super) fn quality(&self, cell: u32) -> f64 {
        self.worth(self.ring(cell))
    }

    /// The same of a cell with these nodes.
    pub(super) fn worth(&self, ring: &[u32]) -> f64 {
        let mut p = [DVec3::ZERO; 4];
        let mut normal = DVec3::ZERO;
        for (p, &n) in p.iter_mut().zip(ring) {
            *p = self.points[n as usize];
            normal += self.normals[n as usize];
        }
        quality(&p[..ring.len().min(4)], normal)
    }

    /// The least quality of some cells; infinite where there are none.
    pub(super) fn worst(&self, cells: &[u32]) -> f64 {
        (cells.iter().map(|&c| self.quality(c))).fold(f64::INFINITY, f64::min)
    }
}

/// Scaled Jacobian of a triangle or quad, with the sign of its normal against `normal`.
pub(super) fn quality(p: &[DVec3], normal: DVec3) -> f64 {
    let n = p.len();
    let edge = |k: usize| p[(k + 1) % n] - p[k % n];
    let corner = |k: usize| edge(k + n - 1).cross(edge(k));
    let own: DVec3 = (0..n).map(corner).sum();
    let Some(own) = own.try_normalize() else {
        return 0.0;
    };
    let share = |k: usize| {
        let lengths = edge(k + n - 1).length() * edge(k).length();
        if lengths > 0.0 {
            own.dot(corner(k)) / lengths
        } else {
            0.0
        }
    };
    let least = (0..n).map(share).fold(f64::INFINITY, f64::min);
    let scale = if n == 3 { 2.0 / 3f64.sqrt() } else { 1.0 };
    if own.dot(normal) > 0.0 {
        least * scale
    } else {
        least.min(0.0) - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use smallvec::smallvec;

    #[test]
    fn a_square_is_worth_one_and_less_than_nothing_from_below() {
        let square = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        assert!((quality(&square, DVec3::Z) - 1.0).abs() < 1e-15);
        assert!(quality(&square, -DVec3::Z) < 0.0);
        let caved = [DVec3::ZERO, DVec3::X, DVec3::new(0.2, 0.2, 0.0), DVec3::Y];
        assert!(quality(&caved, DVec3::Z) < 0.0);
        let equal = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, 0.75f64.sqrt(), 0.0)];
        assert!((quality(&equal, DVec3::Z) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn what_is_exchanged_can_be_taken_back() {
        // Two squares side by side.
        let points = (0..6).map(|i| DVec3::new(f64::from(i % 3), f64::from(i / 3), 0.0));
        let rings: Vec<Ring> = vec![smallvec![0, 1, 4, 3], smallvec![1, 2, 5, 4]];
        let up = vec![DVec3::Z; 6];
        let mut cells = Cells::new(points.collect(), up, vec![false; 6], rings, vec![[0, 1]]);
        assert_eq!(cells.across(0, 0), None);
        assert_eq!(cells.across(0, 1), Some(1));
        let before = format!("{cells:?}");
        let node = cells.add_node((DVec3::splat(0.5), DVec3::Z));
        let mut undo = cells.exchange(&[0], &[smallvec![0, 1, node], smallvec![1, 4, 3, node]]);
        cells.remember(&mut undo, 4);
        cells.put(4, (DVec3::ZERO, DVec3::Y));
        assert_eq!(cells.living().collect::<Vec<_>>(), [1, 2, 3]);
        assert!(cells.joined(node, 3) && !cells.joined(node, 4));
        assert_eq!(cells.neighbours(node).as_slice(), [0, 1, 3]);
        cells.take_back(undo, 1);
        cells.stars.iter_mut().for_each(|s| s.sort_unstable());
        assert_eq!(format!("{cells:?}"), before);
    }
}
