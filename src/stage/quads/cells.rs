//! One sheet as cells of three or four nodes that may be exchanged for others, a few at a time, and put back.

use super::usable::is_usable;
use crate::geom::quality::quad_quality;
use crate::spatial::Hint;
use glam::DVec3;
use smallvec::SmallVec;

/// The nodes of a cell, in order round it.
pub(super) type Ring = SmallVec<[u32; 4]>;
/// Cells or nodes round a place.
pub(super) type Few = SmallVec<[u32; 8]>;

/// The surface that nodes stay on.
pub(super) trait Ground: Sync {
    /// The point of the surface nearest to `p`.
    /// `near` is a place not far from it, where there is one: the answer comes sooner.
    fn foot(&self, p: DVec3, near: Option<Hint>) -> Place;
}

/// A place on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub point: DVec3,
    /// Unit normal of the ground.
    pub normal: DVec3,
    /// Where the ground keeps it.
    pub hint: Option<Hint>,
    /// The direction in which cells are to be long there, as long as the ratio of their sides; zero where they are to be square.
    pub stretch: DVec3,
}

/// Cells of one sheet. Dead cells keep their number.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    /// #N positions, mm.
    pub points: Vec<DVec3>,
    /// #N unit normals of the ground there.
    pub normals: Vec<DVec3>,
    hints: Vec<Option<Hint>>,
    stretches: Vec<DVec3>,
    /// #N nodes that neither move nor vanish.
    pub held: Vec<bool>,
    /// #N how many cells there should be at each node.
    ideal: Vec<u8>,
    /// #N nodes at which something has changed since it was last asked for.
    fresh: Vec<bool>,
    /// #C rings, wound one way.
    pub rings: Vec<Ring>,
    /// #C whether the cell is there.
    pub lives: Vec<bool>,
    /// #N living cells at each node.
    pub stars: Vec<Few>,
    /// The sheets of the held nodes, which come first.
    pub owners: Vec<SmallVec<[u32; 3]>>,
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

/// Cells inside a sheet at a node.
const INSIDE: u8 = 4;
/// A quad may be this good and needs no better: angles of 45 degrees have 0.71.
pub(super) const GOOD: f64 = 0.75;
/// A triangle is worth as much as a quad of this quality.
const TRIANGLE: f64 = 0.4;

impl Cells {
    /// Cells at these places.
    pub(super) fn new(
        places: Vec<Place>,
        held: Vec<bool>,
        rings: Vec<Ring>,
        kept: Vec<[u32; 2]>,
    ) -> Self {
        let mut stars = vec![Few::new(); places.len()];
        for (i, ring) in rings.iter().enumerate() {
            for &n in ring {
                stars[n as usize].push(i as u32);
            }
        }
        let lives = vec![true; rings.len()];
        let mut cells = Self {
            points: places.iter().map(|p| p.point).collect(),
            normals: places.iter().map(|p| p.normal).collect(),
            hints: places.iter().map(|p| p.hint).collect(),
            stretches: places.iter().map(|p| p.stretch).collect(),
            ideal: vec![INSIDE; held.len()],
            fresh: vec![true; held.len()],
            held,
            rings,
            lives,
            stars,
            kept,
            owners: Vec::new(),
        };
        for n in 0..places.len() as u32 {
            if cells.held[n as usize] {
                cells.ideal[n as usize] = cells.right_angles(n);
            }
        }
        cells
    }

    /// Says how many cells there should be at a node, where the angles do not tell.
    pub(super) fn expect(&mut self, node: u32, count: u8) {
        self.ideal[node as usize] = count;
    }

    /// Right angles at a held node between its kept edges, one at the least between two.
    fn right_angles(&self, node: u32) -> u8 {
        let right = |fan: &Few| {
            let angle: f64 = fan.iter().map(|&c| self.angle(c, node)).sum();
            (angle / std::f64::consts::FRAC_PI_2).round().max(1.0)
        };
        self.fans(node).iter().map(right).sum::<f64>() as u8
    }

    /// How far a node is from having as many cells as there should be at it, squared: four inside a sheet, one a right angle between kept edges.
    pub(super) fn irregularity(&self, node: u32) -> i64 {
        self.irregularity_with(node, 0)
    }

    /// The same with so many cells more.
    pub(super) fn irregularity_with(&self, node: u32, more: i64) -> i64 {
        let count = self.star(node).len() as i64 + more;
        if count == 0 && !self.held[node as usize] {
            return 0;
        }
        (count - i64::from(self.ideal[node as usize])).pow(2)
    }

    /// The same of a node inside a sheet with so many cells.
    pub(super) fn irregularity_inside(count: i64) -> i64 {
        (count - i64::from(INSIDE)).pow(2)
    }

    /// By how much a cell falls short of a good one. A triangle counts as a quad of poor quality; a quad of no use, which will be two, as both.
    pub(super) fn shortfall(&self, cell: u32) -> f64 {
        let quality = self.quality(cell);
        match *self.corners(cell) {
            _ if quality <= 0.0 => 2.0 * (GOOD - TRIANGLE) - quality,
            [p, q, r, s] if quality < GOOD && !is_usable(&quad_quality([p, q, r, s])) => {
                2.0 * (GOOD - TRIANGLE)
            }
            [_, _, _, _] => (GOOD - quality).max(0.0),
            _ => GOOD - quality.min(TRIANGLE),
        }
    }

    /// Nodes at which something has changed since this was last asked: all of them at first.
    pub(super) fn take_fresh(&mut self) -> Vec<bool> {
        let none = vec![false; self.points.len()];
        std::mem::replace(&mut self.fresh, none)
    }

    /// Marks a node as changed.
    pub(super) fn refresh(&mut self, node: u32) {
        self.fresh[node as usize] = true;
    }

    /// The cells at a node that hang together round it, each fan in the order of its cells, the first node on the right.
    pub(super) fn fans(&self, node: u32) -> SmallVec<[Few; 2]> {
        let star = self.star(node);
        let mut left: Few = star.clone();
        left.sort_unstable();
        let mut all = SmallVec::new();
        // The next cell over the edge that comes in, or goes out.
        let beside = |c: u32, incoming: bool| {
            let ring = self.ring(c);
            let k = ring.iter().position(|&n| n == node)?;
            let edge = if incoming {
                (k + ring.len() - 1) % ring.len()
            } else {
                k
            };
            self.across(c, edge)
        };
        while let Some(&first) = left.first() {
            let mut start = first;
            for _ in 0..star.len() {
                match beside(start, false) {
                    Some(c) if c != first => start = c,
                    _ => break,
                }
            }
            let mut fan: Few = SmallVec::new();
            let mut at = Some(start);
            while let Some(c) = at.filter(|c| !fan.contains(c)) {
                fan.push(c);
                at = beside(c, true);
            }
            left.retain(|c| !fan.contains(c));
            all.push(fan);
        }
        all
    }

    /// The angle of a cell at one of its nodes, rad.
    fn angle(&self, cell: u32, node: u32) -> f64 {
        let ring = self.ring(cell);
        let Some(k) = ring.iter().position(|&n| n == node) else {
            return 0.0;
        };
        let at = |i: usize| self.points[ring[i % ring.len()] as usize];
        (at(k + 1) - at(k)).angle_between(at(k + ring.len() - 1) - at(k))
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
            for n in [
                ring[(k + 1) % ring.len()],
                ring[(k + ring.len() - 1) % ring.len()],
            ] {
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

    /// Whether a new edge may join two nodes: not where both are in another sheet too, which may have that edge.
    pub(super) fn may_join(&self, a: u32, b: u32) -> bool {
        match (self.owners.get(a as usize), self.owners.get(b as usize)) {
            (Some(a), Some(b)) => a.iter().filter(|s| b.contains(s)).count() < 2,
            _ => true,
        }
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
    pub(super) fn add_node(&mut self, place: Place) -> u32 {
        self.points.push(place.point);
        self.normals.push(place.normal);
        self.hints.push(place.hint);
        self.stretches.push(place.stretch);
        self.ideal.push(INSIDE);
        self.fresh.push(true);
        self.held.push(false);
        self.stars.push(Few::new());
        self.points.len() as u32 - 1
    }

    /// Keeps the place of a node, so that `undo` can move it back.
    pub(super) fn remember(&self, undo: &mut Undo, node: u32) {
        undo.places.push((node, self.place(node)));
    }

    /// Where a node is.
    pub(super) fn place(&self, node: u32) -> Place {
        Place {
            point: self.points[node as usize],
            normal: self.normals[node as usize],
            hint: self.hints[node as usize],
            stretch: self.stretches[node as usize],
        }
    }

    /// Moves a node.
    pub(super) fn put(&mut self, node: u32, place: Place) {
        self.points[node as usize] = place.point;
        self.normals[node as usize] = place.normal;
        self.hints[node as usize] = place.hint;
        self.stretches[node as usize] = place.stretch;
    }

    fn shorten(&mut self, count: usize) {
        self.points.truncate(count);
        self.normals.truncate(count);
        self.hints.truncate(count);
        self.stretches.truncate(count);
        self.held.truncate(count);
        self.ideal.truncate(count);
        self.fresh.truncate(count);
        self.stars.truncate(count);
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
        self.shorten(undo.counts[1] - nodes);
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

/// A quad that is warped by more than sixty degrees is as bad as one that is: worth something, since it is not turned over.
const MOST_WARPED: f64 = 0.5;
/// Edges may differ by this factor: beyond, a cell is worth as much less.
const STRETCHED: f64 = 4.0;

/// What a cell is worth: the scaled Jacobian of a triangle or quad, of a quad times its warpage (the cube of the lesser cosine between opposite corner normals, as Verdict
/// has it), less where its edges differ by much; below zero where its normal is against `normal`.
pub(super) fn quality(p: &[DVec3], normal: DVec3) -> f64 {
    let n = p.len();
    let edge = |k: usize| p[(k + 1) % n] - p[k % n];
    let corner = |k: usize| edge(k + n - 1).cross(edge(k));
    let own: DVec3 = (0..n).map(corner).sum();
    let Some(own) = own.try_normalize() else {
        return 0.0;
    };
    let mut lengths = [0.0; 4];
    for (k, length) in lengths.iter_mut().enumerate().take(n) {
        *length = edge(k).length();
    }
    let lengths = &lengths[..n];
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    if shortest <= 0.0 {
        return 0.0;
    }
    let share = |k: usize| own.dot(corner(k)) / (lengths[(k + n - 1) % n] * lengths[k]);
    let least = (0..n).map(share).fold(f64::INFINITY, f64::min);
    let flat = if n == 3 {
        2.0 / 3f64.sqrt()
    } else {
        let unit = |k: usize| corner(k).normalize_or_zero();
        let flat = unit(0).dot(unit(2)).min(unit(1).dot(unit(3)));
        flat.max(MOST_WARPED).powi(3)
    };
    if own.dot(normal) > 0.0 {
        least * flat * (STRETCHED * shortest / longest).min(1.0)
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
        let place = |point| Place {
            point,
            normal: DVec3::Z,
            hint: None,
            stretch: DVec3::ZERO,
        };
        let points = (0..6).map(|i| place(DVec3::new(f64::from(i % 3), f64::from(i / 3), 0.0)));
        let rings: Vec<Ring> = vec![smallvec![0, 1, 4, 3], smallvec![1, 2, 5, 4]];
        let mut cells = Cells::new(points.collect(), vec![false; 6], rings, vec![[0, 1]]);
        assert_eq!(cells.across(0, 0), None);
        assert_eq!(cells.across(0, 1), Some(1));
        let before = format!("{cells:?}");
        let node = cells.add_node(place(DVec3::splat(0.5)));
        let mut undo = cells.exchange(&[0], &[smallvec![0, 1, node], smallvec![1, 4, 3, node]]);
        cells.remember(&mut undo, 4);
        cells.put(4, place(DVec3::Y));
        assert_eq!(cells.living().collect::<Vec<_>>(), [1, 2, 3]);
        assert!(cells.joined(node, 3) && !cells.joined(node, 4));
        assert_eq!(cells.neighbours(node).as_slice(), [0, 1, 3]);
        cells.take_back(undo, 1);
        cells.stars.iter_mut().for_each(|s| s.sort_unstable());
        assert_eq!(format!("{cells:?}"), before);
    }
}
