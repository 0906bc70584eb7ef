//! Feature curves as they were before any edit: nodes on a curve move along it, and its shape bounds how far edges may cut corners.
//!
//! Without such a record each removal is judged against the last state only, and a circle shrinks a little with every round.

use super::shape::distance_to_segment;
use super::split::LONGEST;
use super::strata::{Chain, walk};
use super::surface::{Class, Surface};
use crate::model::ids::{Id, IndexVec, NodeId};
use glam::DVec3;
use smallvec::SmallVec;
use std::collections::BTreeMap;

/// Share of the slack to which a guide itself follows the curve.
const FINE: f64 = 0.1;
/// Halvings of an edge of the guide, at most: 64 points on a half circle.
const LEVELS: usize = 6;

/// Names a guide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct GuideId(u32);

impl Id for GuideId {
    fn new(index: usize) -> Self {
        Self(index as u32)
    }
    fn index(self) -> usize {
        self.0 as usize
    }
}

/// Where a curve node lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    pub guide: GuideId,
    /// Arc length from the guide's start.
    pub at: f64,
}

/// A piece of a guide between the ends of a feature edge; `to` may pass the length of a closed guide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub guide: GuideId,
    pub from: f64,
    pub to: f64,
    /// Whether `from` belongs to the first node asked for.
    pub forward: bool,
}

/// One feature curve.
#[derive(Clone, Debug)]
pub(super) struct Guide {
    /// Round: without a corner, or with one at its start.
    closed: bool,
    /// The corners at its start and end; `None` for a curve without.
    ends: Option<[NodeId; 2]>,
    /// Points; of a closed curve the last repeats the first.
    points: Vec<DVec3>,
    /// Arc length at each point.
    arc: Vec<f64>,
    /// Largest edge length at each point that follows the bends.
    limit: Vec<f64>,
    /// How far an edge may leave the curve at each point.
    slack: Vec<f64>,
    /// How many living nodes lie inside it.
    inside: usize,
}

/// What shapes guides.
pub(super) struct GuideRules<'a> {
    /// Edges on a full turn, at least.
    pub segments: f64,
    /// How far an edge may leave the curve at a node.
    pub slack: &'a dyn Fn(NodeId) -> f64,
    /// The size that no bend may undercut.
    pub floor: &'a dyn Fn(NodeId) -> f64,
    /// How far to walk for a bend that is no noise.
    pub reach: &'a dyn Fn(NodeId) -> f64,
    /// The curve's own point near a point of an edge; `None` to take the edges as they are.
    pub onto: Option<&'a dyn Fn([NodeId; 2], DVec3) -> DVec3>,
    /// How fast sizes may grow along the curve, length per length.
    pub growth: f64,
    /// The length of edges that may leave the curve as far as they must, mm.
    pub least: f64,
}

/// All feature curves, and where the curve nodes lie on them.
#[derive(Clone, Debug, Default)]
pub(super) struct Guides {
    all: IndexVec<GuideId, Guide>,
    spots: IndexVec<NodeId, Option<Spot>>,
    at_corner: BTreeMap<NodeId, SmallVec<[GuideId; 4]>>,
}

impl Guides {
    /// Records the chains at the present positions.
    pub fn new(surface: &Surface, chains: &[Chain], rules: &GuideRules) -> Self {
        let mut guides = Self {
            spots: IndexVec::filled(None, surface.node_count()),
            ..Self::default()
        };
        for chain in chains {
            let (guide, places) = Guide::new(surface, chain, rules);
            let id = GuideId::new(guides.all.len());
            for (i, &n) in chain.nodes.iter().enumerate() {
                if surface.class[n] == Class::Curve {
                    guides.spots[n] = Some(Spot {
                        guide: id,
                        at: guide.arc[places[i]],
                    });
                }
            }
            for end in guide.ends.into_iter().flatten() {
                let list = guides.at_corner.entry(end).or_default();
                if !list.contains(&id) {
                    list.push(id);
                }
            }
            guides.all.push(guide);
        }
        guides
    }

    /// Where a curve node lies.
    pub fn spot(&self, n: NodeId) -> Option<Spot> {
        self.spots.get(n).copied().flatten()
    }

    /// Moves a curve node along its guide.
    pub fn slide(&mut self, n: NodeId, at: f64) {
        if let Some(Spot { guide, .. }) = self.spot(n) {
            let at = self.all[guide].wrap(at);
            self.spots[n] = Some(Spot { guide, at });
        }
    }

    /// Records a new curve node (`spot` is `None` for a node inside a sheet). To be called for every new node, in order.
    pub fn push(&mut self, spot: Option<Spot>) {
        if let Some(s) = spot {
            self.all[s.guide].inside += 1;
        }
        self.spots.push(spot.map(|s| Spot {
            at: self.all[s.guide].wrap(s.at),
            ..s
        }));
    }

    /// Forgets a removed node.
    pub fn remove(&mut self, n: NodeId) {
        if let Some(spot) = self.spots[n].take() {
            self.all[spot.guide].inside -= 1;
        }
    }

    /// Point of a guide.
    pub fn point(&self, guide: GuideId, at: f64) -> DVec3 {
        let g = &self.all[guide];
        let (i, f) = g.locate(at);
        g.points[i].lerp(g.points[i + 1], f)
    }

    /// Largest edge length that follows the bends at a node; infinite off the curves.
    pub fn limit(&self, n: NodeId) -> f64 {
        match self.spot(n) {
            Some(spot) => {
                let g = &self.all[spot.guide];
                // Straight pieces have no limit: infinite ends cannot be interpolated.
                let (i, f) = g.locate(spot.at);
                if f > 0.0 {
                    g.limit[i].min(g.limit[i + 1])
                } else {
                    g.limit[i]
                }
            }
            None => self
                .guides_at(n)
                .iter()
                .flat_map(|&id| {
                    let g = &self.all[id];
                    let ends = g.ends.unwrap_or([n; 2]);
                    let last = g.limit.len() - 1;
                    [(ends[0], g.limit[0]), (ends[1], g.limit[last])]
                })
                .filter(|(end, _)| *end == n)
                .map(|(_, limit)| limit)
                .fold(f64::INFINITY, f64::min),
        }
    }

    /// The guides that end at a corner.
    pub fn guides_at(&self, corner: NodeId) -> &[GuideId] {
        self.at_corner.get(&corner).map_or(&[], |l| l.as_slice())
    }

    /// The corners at the ends of a guide.
    pub fn ends(&self, guide: GuideId) -> Option<[NodeId; 2]> {
        self.all[guide].ends
    }

    /// The piece of guide that feature edge `a`-`b` stands for.
    pub fn span(&self, surface: &Surface, a: NodeId, b: NodeId) -> Option<Span> {
        let (v, w, swapped) = match (self.spot(a), self.spot(b)) {
            (Some(_), _) => (a, b, false),
            (None, Some(_)) => (b, a, true),
            (None, None) => return self.whole(a, b),
        };
        let spot = self.spot(v)?;
        let guide = spot.guide;
        let g = &self.all[guide];
        let place = |n: NodeId| match self.spot(n) {
            Some(s) => (s.guide == guide).then_some(s.at),
            None => {
                let ends = g.ends?;
                if ends[0] == n {
                    Some(0.0)
                } else {
                    (ends[1] == n).then_some(g.length())
                }
            }
        };
        let at = place(w)?;
        let (from, to, forward) = if g.closed {
            let other = surface
                .feature_neighbours(v)
                .into_iter()
                .find(|&n| n != w)?;
            let ahead = |x: f64| (x - spot.at).rem_euclid(g.length());
            let (step, beyond) = (ahead(at), ahead(place(other)?));
            if beyond < step {
                (at, at + g.length() - step, false)
            } else {
                (spot.at, spot.at + step, true)
            }
        } else if spot.at <= at {
            (spot.at, at, true)
        } else {
            (at, spot.at, false)
        };
        Some(Span {
            guide,
            from,
            to,
            forward: forward != swapped,
        })
    }

    /// How far the chord `a`-`b` leaves the span, as a multiple of what is allowed.
    pub fn deviation(&self, span: &Span, a: DVec3, b: DVec3) -> f64 {
        let g = &self.all[span.guide];
        let length = g.length();
        let (first, last) = (g.locate(span.from).0, g.points.len() - 1);
        let mut worst = 0.0f64;
        let mut i = first + 1;
        let mut lap = (span.from / length).floor().max(0.0) * length;
        loop {
            if i > last {
                if !g.closed || length <= 0.0 {
                    break;
                }
                i = 1;
                lap += length;
            }
            if g.arc[i] + lap >= span.to {
                break;
            }
            worst = worst.max(distance_to_segment(g.points[i], a, b) / g.slack[i]);
            i += 1;
        }
        // Between recorded points the curve may be coarser than the edge: its middle counts too.
        let middle = 0.5 * (span.from + span.to);
        let (k, _) = g.locate(middle);
        worst.max(distance_to_segment(self.point(span.guide, middle), a, b) / g.slack[k])
    }

    fn whole(&self, a: NodeId, b: NodeId) -> Option<Span> {
        self.guides_at(a)
            .iter()
            .copied()
            .filter(|&id| self.all[id].inside == 0)
            .find_map(|guide| {
                let g = &self.all[guide];
                let ends = g.ends?;
                let forward = ends == [a, b];
                (forward || ends == [b, a]).then(|| Span {
                    guide,
                    from: 0.0,
                    to: g.length(),
                    forward,
                })
            })
    }
}

impl Guide {
    /// The guide of a chain, and at which of its points each node of the chain stands.
    fn new(surface: &Surface, chain: &Chain, rules: &GuideRules) -> (Self, Vec<usize>) {
        let mut nodes = chain.nodes.clone();
        if chain.closed {
            nodes.push(nodes[0]);
        }
        let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
        let mut points = vec![surface.points[first]];
        // For each point a node next to it, whose tolerances it takes.
        let mut owners = vec![first];
        let mut places = vec![0];
        for edge in nodes.windows(2) {
            let (a, b) = (edge[0], edge[1]);
            if let Some(onto) = rules.onto {
                let fine = FINE * (rules.slack)(a).min((rules.slack)(b));
                let ends = [surface.points[a], surface.points[b]];
                let before = points.len();
                refine(&mut points, ends, fine, LEVELS, &|p| onto([a, b], p));
                owners.extend(std::iter::repeat_n(a, points.len() - before));
            }
            places.push(points.len());
            points.push(surface.points[b]);
            owners.push(b);
        }
        let mut arc = vec![0.0; points.len()];
        for i in 1..points.len() {
            arc[i] = arc[i - 1] + points[i].distance(points[i - 1]);
        }
        let mut slack: Vec<f64> = owners.iter().map(|&n| (rules.slack)(n)).collect();
        let round = if chain.closed {
            &points[..points.len() - 1]
        } else {
            &points
        };
        let mut limit = vec![f64::INFINITY; points.len()];
        for i in 0..points.len() {
            if !chain.closed && (i == 0 || i + 1 == points.len()) {
                continue;
            }
            let (k, far) = (i % round.len(), (rules.reach)(owners[i]));
            let back = walk(round, chain.closed, k, false, far);
            let ahead = walk(round, chain.closed, k, true, far);
            let radius = circumradius(round[back], round[k], round[ahead]);
            slack[i] = slack[i].max(sag_of_least(rules.least, radius));
            let turn = std::f64::consts::TAU * radius / rules.segments;
            let sag = (8.0 * radius * slack[i]).sqrt();
            limit[i] = turn.min(sag).max((rules.floor)(owners[i]));
        }
        let mut guide = Self {
            closed: first == last,
            ends: (!chain.closed).then_some([first, last]),
            inside: nodes.len() - if chain.closed { 1 } else { 2 },
            points,
            arc,
            limit,
            slack,
        };
        guide.grade(rules.growth);
        (guide, places)
    }

    fn grade(&mut self, growth: f64) {
        let last = self.limit.len() - 1;
        for _ in 0..2 {
            for i in 1..=last {
                let most = self.limit[i - 1] + growth * (self.arc[i] - self.arc[i - 1]);
                self.limit[i] = self.limit[i].min(most);
            }
            for i in (0..last).rev() {
                let most = self.limit[i + 1] + growth * (self.arc[i + 1] - self.arc[i]);
                self.limit[i] = self.limit[i].min(most);
            }
            if self.closed {
                let least = self.limit[0].min(self.limit[last]);
                self.limit[0] = least;
                self.limit[last] = least;
            }
        }
    }

    fn length(&self) -> f64 {
        self.arc[self.arc.len() - 1]
    }

    fn wrap(&self, at: f64) -> f64 {
        if self.closed && self.length() > 0.0 {
            at.rem_euclid(self.length())
        } else {
            at.clamp(0.0, self.length())
        }
    }

    /// The segment that holds an arc length, and the fraction of the way along it.
    fn locate(&self, at: f64) -> (usize, f64) {
        let at = self.wrap(at);
        let i = self.arc.partition_point(|&s| s <= at).max(1) - 1;
        let i = i.min(self.points.len() - 2);
        let step = self.arc[i + 1] - self.arc[i];
        let f = if step > 0.0 {
            ((at - self.arc[i]) / step).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (i, f)
    }
}

/// How far the longest edge that is still one of length `least` leaves a bend of this radius; nothing leaves a curve by more than half of it.
fn sag_of_least(least: f64, radius: f64) -> f64 {
    ((LONGEST * least).powi(2) / (8.0 * radius)).min(least / 2.0)
}

/// Appends points of the curve between two of its points, until chords leave it by less than `fine`.
fn refine(
    points: &mut Vec<DVec3>,
    [a, b]: [DVec3; 2],
    fine: f64,
    levels: usize,
    onto: &dyn Fn(DVec3) -> DVec3,
) {
    if levels == 0 {
        return;
    }
    let middle = 0.5 * (a + b);
    let on = onto(middle);
    let off = on.distance(middle);
    // Further off than a half circle would be, it is another curve.
    if !(off > fine && off <= 0.5 * a.distance(b)) {
        return;
    }
    refine(points, [a, on], fine, levels - 1, onto);
    points.push(on);
    refine(points, [on, b], fine, levels - 1, onto);
}

/// Radius of the circle through three points; infinite where they lie on a line.
fn circumradius(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let area = (b - a).cross(c - a).length();
    let product = a.distance(b) * b.distance(c) * c.distance(a);
    if area > f64::EPSILON * product.cbrt().powi(2) {
        product / (2.0 * area)
    } else {
        f64::INFINITY
    }
}
