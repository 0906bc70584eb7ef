//! Washers: rings of quads round the holes of bolts.
//!
//! ```text
//!      rim of the hole   outer circle      Before the sheet is meshed its hole is opened to the outer circle, whose nodes
//!            |              |              get places of their own. What meshes the sheet sees a plate with a larger hole.
//!            v              v              Afterwards rings of quads are laid between that circle and the rim of the hole:
//!   (hole)   |----|----|----|  sheet       as many nodes on each, on concentric circles, along straight spokes.
//!              layers
//! ```
//! [`plan`] finds the holes and how much room each has, [`open`] opens them, [`close`] lays the rings, [`standing`] looks for them in the finished mesh, whoever changed
//! it since.
//!
//! **Guarantees.** An even number of quads goes round, so that a sheet can still be all quads; a circle's nodes lie on the exact mid-surface, and seen along the hole's axis on
//! a circle; topology and walls stay. What cannot be had is said, hole by hole. **Limits.** Holes whose rim lies in one sheet that bends little across it.
//! **Cost.** Linear in the triangles near the holes.

mod fill;
mod hole;
mod live;
mod open;
mod room;
mod standing;

pub use standing::standing;

use crate::geom::placer::{Placer, SizeField};
use crate::model::complex::{MidComplex, Support, pin};
use crate::model::ids::{IndexVec, NodeId, PinId};
use crate::model::washer::{BareHole, NoWasher, RoomEnd, Washer, WasherRequest};
use glam::{DVec2, DVec3};
use hole::Hole;
use live::Live;
use room::Seen;
use std::f64::consts::TAU;

/// Fewest quads round a hole: with fewer their corners are far from right angles.
const AROUND_MIN: f64 = 8.0;
/// Quads round a hole come in fours: the mesh round it may then be as symmetric as it is.
const FOURS: f64 = 4.0;
/// Between a washer and what is in its way there has to be this much of an element, its own or that wanted there, whichever is shorter.
const TIGHT: f64 = 0.5;
/// Where each hole decides for itself, a whole one is left, if rings may then be half as wide as they want to be: two rows of quads between two washers.
const EASY: f64 = 1.0;
const EASY_WIDTH: f64 = 0.5;
/// Holes are alike whose radii, and the sizes wanted there, differ by less than this share.
const ALIKE: f64 = 0.02;
/// A ring may be as much narrower than it wants to be where room is scarce, and no narrower than this share of its edges along the rim.
const NARROWEST: f64 = 1.0 / 3.0;

/// The washers of a complex.
#[derive(Clone, Debug)]
pub struct Plan {
    rings: Vec<Rings>,
    /// Holes of the wanted diameter that get none.
    pub left_out: Vec<BareHole>,
}

/// The rings round one hole.
#[derive(Clone, Debug)]
struct Rings {
    hole: Hole,
    layers: u32,
    /// Width of a ring, mm.
    width: f64,
    /// Quads in a ring.
    around: u32,
    /// Where the first spoke points, in the plane of the hole.
    spoke: DVec2,
    /// The place of the outer circle's first node among all pins.
    first_pin: u32,
    /// Nodes of the outer circle, once it is there, mm.
    circle: Vec<DVec3>,
}

impl Rings {
    /// Where a spoke points.
    fn way(&self, spoke: u32) -> DVec2 {
        let turn = TAU * f64::from(spoke) / f64::from(self.around);
        DVec2::from_angle(turn).rotate(self.spoke)
    }

    /// Radius of a circle, counted from the rim, mm.
    fn radius(&self, circle: u32) -> f64 {
        self.hole.radius + f64::from(circle) * self.width
    }

    /// Radius of the outer circle, mm.
    fn outer(&self) -> f64 {
        self.radius(self.layers)
    }

    /// Length of an edge of a circle of this radius, mm.
    fn edge(&self, radius: f64) -> f64 {
        TAU * radius / f64::from(self.around)
    }

    /// How far from the middle what is left of the sheet begins, at the least, mm, with so much of an element between.
    fn needs(&self, size: f64, between: f64) -> f64 {
        self.outer() + between * size.min(self.edge(self.outer()))
    }

    /// The width of a ring with which all need no more than this room from the middle, mm; below zero where nothing fits.
    fn fitting(&self, room: f64, size: f64, between: f64) -> f64 {
        let to_size = room - between * size;
        let to_edge = room / (1.0 + between * self.edge(1.0));
        (to_size.max(to_edge) - self.hole.radius) / f64::from(self.layers)
    }

    /// Rings that are narrower than this are of no use, mm.
    fn narrowest(&self) -> f64 {
        let for_edges = NARROWEST * self.edge(self.hole.radius);
        (NARROWEST * self.width).max(for_edges.min(self.width))
    }

    fn pins(&self) -> impl Iterator<Item = PinId> {
        (self.first_pin..self.first_pin + self.around).map(PinId)
    }

    fn washer(&self) -> Washer {
        Washer {
            centre: self.hole.plane.origin,
            axis: self.hole.plane.axes[2],
            diameter: 2.0 * self.hole.radius,
            layers: self.layers,
            width: self.width,
            around: self.around,
        }
    }

    fn bare(&self, why: NoWasher) -> BareHole {
        self.hole.bare(why)
    }
}

impl Plan {
    /// Whether no hole gets a washer.
    pub fn is_empty(&self) -> bool {
        self.rings.is_empty()
    }

    /// The washers.
    pub fn washers(&self) -> Vec<Washer> {
        self.rings.iter().map(Rings::washer).collect()
    }

    /// Leaves out washers (their numbers, in order) round which no good mesh was found.
    pub fn leave_out(&mut self, lost: &[usize]) {
        let bare = |&i: &usize| self.rings[i].bare(NoWasher::Unmeshed);
        self.left_out.extend(lost.iter().map(bare));
        let mut number = 0..;
        self.rings
            .retain(|_| number.next().is_none_or(|i| !lost.contains(&i)));
    }
}

/// Finds the holes and how wide their rings can be. `target` is the part's edge length, mm, `size` that at a place.
pub fn plan(
    complex: &MidComplex,
    request: &WasherRequest,
    target: f64,
    size: &SizeField,
    placer: &dyn Placer,
) -> Plan {
    let live = Live::new(complex);
    let (holes, mut left_out) = hole::holes(&live, placer, &|d| request.takes(d, target));
    let sizes: Vec<f64> = (holes.iter())
        .map(|h| size(h.plane.origin, h.wall))
        .collect();
    let coarsest = coarsest(&holes, &sizes);
    let mut wanted: Vec<Rings> = (holes.into_iter().zip(&sizes).zip(coarsest))
        .map(|((hole, &size), rim)| wished(hole, request, size, rim))
        .collect();
    let mut owner: IndexVec<NodeId, Option<u32>> = IndexVec::filled(None, complex.nodes.len());
    for (rings, i) in wanted.iter().zip(0..) {
        rings.hole.rim.iter().for_each(|r| owner[r.node] = Some(i));
    }
    // A width that was asked for may be tight.
    let between = if request.width.is_some() { TIGHT } else { EASY };
    let needs: Vec<f64> = (wanted.iter().zip(&sizes))
        .map(|(rings, &size)| rings.needs(size, between))
        .collect();
    let most = (wanted.iter().zip(&needs))
        .map(|(rings, need)| need - rings.hole.radius)
        .fold(0.0, f64::max);
    let seen: Vec<Seen> = (wanted.iter().zip(&needs).zip(0..))
        .map(|((rings, need), i)| room::look(&live, &rings.hole, need + most, &owner, i))
        .collect();
    let shared: Vec<(f64, RoomEnd)> = (seen.iter().zip(0..))
        .map(|(seen, i)| shared_room(seen, i, &wanted, &needs))
        .collect();
    let mut plan = Plan {
        rings: Vec::new(),
        left_out: Vec::new(),
    };
    let mut pins = 0;
    for (i, mut rings) in wanted.drain(..).enumerate() {
        let (room, end) = shared[i];
        if needs[i] > room {
            let mut width = rings.fitting(room, sizes[i], between);
            let easy = EASY_WIDTH * rings.width;
            if request.width.is_none() && width < easy {
                width = rings.fitting(room, sizes[i], TIGHT).min(easy);
            }
            if request.width.is_some() || width < rings.narrowest() {
                let layers = f64::from(rings.layers);
                left_out.push(rings.bare(NoWasher::Room {
                    room: (width * layers).max(0.0),
                    wanted: rings.width * layers,
                    end,
                }));
                continue;
            }
            rings.width = width;
        }
        if let Some(toward) = seen[i].toward {
            rings.spoke = toward;
        }
        rings.first_pin = pins;
        pins += rings.around;
        plan.rings.push(rings);
    }
    plan.left_out = left_out;
    plan
}

/// For each hole the fewest edges that a rim has among those like it: as many follow the others as well.
fn coarsest(holes: &[Hole], sizes: &[f64]) -> Vec<usize> {
    let near = |x: f64, y: f64| (x - y).abs() <= ALIKE * x.max(y);
    let alike =
        |i: usize, j: usize| near(holes[i].radius, holes[j].radius) && near(sizes[i], sizes[j]);
    let fewest = |i: usize| {
        let like = (0..holes.len()).filter(|&j| alike(i, j));
        like.map(|j| holes[j].rim.len()).min().unwrap_or(0)
    };
    (0..holes.len()).map(fewest).collect()
}

/// The rings that a hole gets where there is room, `rim` edges or more round it.
fn wished(hole: Hole, request: &WasherRequest, size: f64, rim: usize) -> Rings {
    let width = request.width_round(hole.radius, size);
    let middle = hole.radius + width * f64::from(request.layers) / 2.0;
    let fours = |count: f64| count * FOURS;
    let for_size = fours((TAU * middle / size / FOURS).round());
    // No coarser than the rim is without a washer.
    let for_rim = fours((rim as f64 / FOURS).ceil());
    Rings {
        layers: request.layers,
        width,
        around: AROUND_MIN.max(for_size).max(for_rim) as u32,
        spoke: hole.rim[0].place.normalize_or(DVec2::X),
        hole,
        first_pin: 0,
        circle: Vec::new(),
    }
}

/// Room from the middle of a hole, mm, and what ends it: two holes with washers share what is between them as they need it.
fn shared_room(seen: &Seen, own: usize, all: &[Rings], needs: &[f64]) -> (f64, RoomEnd) {
    let here = &all[own].hole;
    let mut room = (seen.room, seen.end);
    for &other in &seen.holes {
        let there = &all[other as usize].hole;
        let apart = here.plane.flat(there.plane.origin).length();
        let gap = apart - here.radius - there.radius;
        let share = [own, other as usize].map(|i| needs[i] - all[i].hole.radius);
        let own_part = here.radius + gap * share[0] / (share[0] + share[1]);
        if own_part < room.0 {
            room = (own_part, RoomEnd::Washer);
        }
    }
    room
}

/// The complex with each hole of the plan opened to the outer circle of its washer; one that cannot be is left out.
pub fn open(complex: &MidComplex, plan: &mut Plan, placer: &dyn Placer) -> MidComplex {
    let mut live = Live::new(complex);
    let mut lost = Vec::new();
    for (i, rings) in plan.rings.iter_mut().enumerate() {
        match open::open(&mut live, rings, placer) {
            Some(circle) => rings.circle = circle,
            None => lost.push(i),
        }
    }
    plan.leave_out(&lost);
    live.finish()
}

/// Lays the rings into the opened holes of a meshed complex, whose nodes are then free again, and adds the diagonals of their quads to those given, which stay sorted.
///
/// # Errors
/// The numbers of the washers whose outer circle is no longer what it was.
pub fn close(
    complex: &MidComplex,
    diagonals: &[[NodeId; 2]],
    plan: &Plan,
    placer: &dyn Placer,
) -> Result<(MidComplex, Vec<[NodeId; 2]>), Vec<usize>> {
    let pinned = pinned(complex);
    let circles: Vec<Option<Vec<NodeId>>> = (plan.rings.iter())
        .map(|rings| fill::circle(complex, rings, &pinned))
        .collect();
    let lost: Vec<usize> = (0..circles.len())
        .filter(|&i| circles[i].is_none())
        .collect();
    if !lost.is_empty() {
        return Err(lost);
    }
    let (mut new, mut diagonals) = (complex.clone(), diagonals.to_vec());
    for node in new.nodes.as_mut_slice() {
        node.supports.retain(|s| !matches!(s, Support::Pin(_)));
    }
    for (rings, circle) in plan.rings.iter().zip(circles.iter().flatten()) {
        diagonals.extend(fill::fill(&mut new, rings, circle, placer));
    }
    diagonals.sort_unstable();
    Ok((new, diagonals))
}

/// All nodes with places of their own, by these, sorted.
fn pinned(complex: &MidComplex) -> Vec<(PinId, NodeId)> {
    let mut all: Vec<(PinId, NodeId)> = (complex.nodes.enumerated())
        .filter_map(|(id, node)| Some((pin(&node.supports)?, id)))
        .collect();
    all.sort_unstable();
    all
}

#[cfg(test)]
mod tests;
