//! The gates: which faces that see each other across material are a pair.

use crate::model::ids::{FaceId, IndexVec, WallId};
use crate::model::sighting::{LeastExtent, Sighting};
use crate::model::walls::{Aag, Convexity, FacePair};

/// What a pair must show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairOptions {
    /// Least width of the narrower face, in thicknesses. The literature's wall has a width of more than once to twice its thickness;
    /// less lets narrow ribs in, at the risk of taking lateral faces for walls.
    pub least_width: f64,
    /// Whether lumps between walls may be walls: thick floors round hubs, lugs as thick as long.
    pub lumps: bool,
    /// Least share of what is seen where the wall is wide enough, unless it is a large patch.
    pub wide: f64,
    /// A face narrower than `least_width` still is the side of a wall of which it sees this share: a broad wall may be made of narrow
    /// faces; a fillet sees the far side from a third of itself.
    pub whole: f64,
    /// Least share of the smaller face that must be seen.
    pub least_overlap: f64,
    /// Least share of a face that all its pairs together must see for it to be a wall side, unless they see a large patch.
    pub least_cover: f64,
    /// A patch of this many squared thicknesses is a wall whatever share of its face it is.
    pub large_patch: f64,
    /// Least overlap of a face beside paired faces (MidSurfer, algorithm 2: soft overlap).
    pub soft_overlap: f64,
    /// Greatest distance across such a face, in thicknesses of the pair beside it: a wall does not double its thickness over one joint.
    pub soft_thickness: f64,
}

impl Default for PairOptions {
    fn default() -> Self {
        Self {
            least_width: 1.0,
            lumps: false,
            wide: 0.5,
            whole: 0.6,
            least_overlap: 0.03,
            least_cover: 0.3,
            large_patch: 9.0,
            soft_overlap: 0.3,
            soft_thickness: 2.0,
        }
    }
}

/// What one face sees of another.
#[derive(Clone, Debug)]
struct View {
    from: FaceId,
    to: FaceId,
    area: f64,
    /// Of it, where the wall is wide enough round about.
    wide: f64,
    /// Ascending.
    distances: Vec<f64>,
}

impl View {
    fn median(&self) -> f64 {
        self.distances[self.distances.len() / 2]
    }

    fn is_wide(&self, options: &PairOptions) -> bool {
        let d = self.median();
        self.wide > options.wide * self.area || self.wide > options.large_patch * d * d
    }
}

/// All pairs, sorted by faces. Their wall is not yet known.
pub(super) fn pairs(aag: &Aag, sightings: &[Sighting], options: &PairOptions) -> Vec<FacePair> {
    let views = views(sightings, options);
    let width = |f: FaceId| width(aag, f);
    let seen = |f: FaceId, g: FaceId| find(&views, f, g).map_or(0.0, |v| v.area);
    let mut accepted: Vec<&View> = views
        .iter()
        .filter(|v| {
            let (f, g) = (v.from, v.to);
            let whole = |f: FaceId, g: FaceId| {
                width(f) > options.least_width * v.median()
                    || seen(f, g) > options.whole * aag.area[f]
            };
            f != g
                && v.is_wide(options)
                && whole(f, g)
                && whole(g, f)
                && v.area > options.least_overlap * aag.area[f].min(aag.area[g])
        })
        .collect();

    let mut cover = IndexVec::<FaceId, f64>::filled(0.0, aag.area.len());
    let mut thin = IndexVec::<FaceId, f64>::filled(f64::INFINITY, aag.area.len());
    for v in &accepted {
        cover[v.from] += v.area;
        for f in [v.from, v.to] {
            thin[f] = thin[f].min(v.median());
        }
    }
    let is_wall = |f: FaceId| {
        let round = round(aag, f);
        let seen: f64 = round.iter().map(|&h| cover[h]).sum();
        let area: f64 = round.iter().map(|&h| aag.area[h]).sum();
        seen > options.least_cover * area || seen > options.large_patch * thin[f] * thin[f]
    };
    accepted.retain(|v| is_wall(v.from) && is_wall(v.to));

    let all = mates(&accepted, aag.area.len(), |_| true);
    let feet: Vec<FaceId> = (0..aag.area.len() as u32)
        .map(FaceId)
        .filter(|&f| is_foot(aag, sightings, &all, &thin, f))
        .collect();
    let is_foot = |f: FaceId| feet.binary_search(&f).is_ok();
    accepted.retain(|v| !is_foot(v.from) && !is_foot(v.to));

    let mates = mates(&accepted, aag.area.len(), |_| true);
    accepted.extend(complement(aag, sightings, &views, &mates, options));
    gather(&views, &accepted)
}

type Mates = IndexVec<FaceId, Vec<(FaceId, f64)>>;

/// Mates of every face that is wanted, with their distance.
fn mates(accepted: &[&View], faces: usize, wanted: impl Fn(FaceId) -> bool) -> Mates {
    let mut mates: Mates = IndexVec::filled(Vec::new(), faces);
    for v in accepted {
        for (f, g) in [(v.from, v.to), (v.to, v.from)] {
            if wanted(f) {
                mates[f].push((g, v.median()));
            }
        }
    }
    mates
}

fn beside(aag: &Aag, f: FaceId, g: FaceId) -> bool {
    aag.arcs_of(f).any(|a| Aag::across(a, f) == g)
}

/// A face and those that are one round with it: the wall of a hole is often two halves that meet smoothly along two seams. Where it comes near the part's rim a
/// half sees that from a third of itself, as the side of a wall may; the round does not.
fn round(aag: &Aag, f: FaceId) -> Vec<FaceId> {
    let mut smooth: Vec<FaceId> = aag
        .arcs_of(f)
        .filter(|a| a.convexity == Convexity::Smooth)
        .map(|a| Aag::across(a, f))
        .collect();
    smooth.sort_unstable();
    let mut round: Vec<FaceId> = smooth
        .chunk_by(|a, b| a == b)
        .filter(|run| run.len() > 1)
        .map(|run| run[0])
        .collect();
    round.push(f);
    round
}

/// Neighbours that a face goes on with smoothly or nearly so.
fn continuing(aag: &Aag, f: FaceId) -> impl Iterator<Item = FaceId> {
    aag.arcs_of(f)
        .filter(|a| a.turn_rad.abs() < CONTINUES_RAD)
        .map(move |a| Aag::across(a, f))
}

/// Whether the pair of `f` with `g` goes on with the pairs of all neighbours that `f` goes on with. The bend of a sheet does, on all its sides; a
/// fillet between plate and rib sees the plate's far side like the plate does, but not the rib's.
fn goes_on(aag: &Aag, mates: &Mates, f: FaceId, g: FaceId) -> bool {
    continuing(aag, f)
        .filter(|&h| h != g && !mates[h].is_empty())
        .all(|h| mates[h].iter().any(|&(m, _)| m == g || beside(aag, m, g)))
}

/// The blend at the foot of a wall is narrower than this, in thicknesses of the wall that it stands on: a quarter circle of one and a half thicknesses, all of it
/// within the block where the walls join. A wider one thickens its wall for good.
const FOOT: f64 = 2.4;

/// Whether a face is the blend at the foot of a wall: hollow, narrow, and between a broad face whose far side it sees and one whose far side is another. It sees the
/// plate's far side like the plate does, but what it sees is the block where rib and plate join. `thin`: least distance across, a face.
fn is_foot(
    aag: &Aag,
    sightings: &[Sighting],
    mates: &Mates,
    thin: &IndexVec<FaceId, f64>,
    f: FaceId,
) -> bool {
    let is_narrow = |h: FaceId, g: FaceId| width(aag, h) < FOOT * thin[g];
    // Of the bend of a sheet the far sides meet in a corner or over its rounding.
    let joined = |m: FaceId, g: FaceId| {
        m == g || beside(aag, m, g) || continuing(aag, m).any(|c| beside(aag, c, g))
    };
    let broad: Vec<FaceId> = continuing(aag, f)
        .filter(|&h| {
            let wide = mates[h].iter().all(|&(g, _)| !is_narrow(h, g));
            !mates[h].is_empty() && (wide || !is_hollow(sightings, h))
        })
        .collect();
    mates[f].iter().any(|&(g, _)| {
        let of_plate = |h: &FaceId| mates[*h].iter().any(|&(m, _)| m == g);
        let of_rib = |h: &FaceId| mates[*h].iter().all(|&(m, _)| !joined(m, g));
        is_narrow(f, g) && broad.iter().any(of_plate) && broad.iter().any(of_rib)
    }) && is_hollow(sightings, f)
}

/// A face that turns from its neighbour by less than this goes on with its side of the wall; one that turns by more ends it. A chamfer of 45 degrees goes on:
/// the limit lies between that and 60 degrees, so that rounding never decides about an angle that drawings have.
const CONTINUES_RAD: f64 = 52.5 * std::f64::consts::PI / 180.0;

/// Faces and borders narrower than this, in thicknesses, are slivers: they say nothing of where a side ends.
const SLIVER: f64 = 0.25;

/// Whether a face leads from a side of a wall round to a face that is none: the fillet at a rib's blind end does, and the rounding of a rim. The first is no
/// side, the plate runs on flat below it; over the second the wall gets thinner up to its end.
fn leads_away(aag: &Aag, is_side: impl Fn(FaceId) -> bool, f: FaceId, across: f64) -> bool {
    aag.arcs_of(f).any(|a| {
        let h = Aag::across(a, f);
        a.convexity == Convexity::Smooth
            && !is_side(h)
            && a.length.min(width(aag, h)) > SLIVER * across
    })
}

/// Normals of a flat face differ by rounding and by what the reader allows its mid-side nodes; those of a blend differ by tenths from look to look.
const FLAT_RAD: f64 = 1e-4;

/// Whether a face is hollow: its normals come together. Sightings are in order of the faces.
fn is_hollow(sightings: &[Sighting], f: FaceId) -> bool {
    let first = sightings.partition_point(|s| s.from < f);
    let own = &sightings[first..first + sightings[first..].partition_point(|s| s.from == f)];
    let (mut opening, mut passed) = (0.0, 0.0);
    for w in own.windows(2) {
        let step = w[0].point - w[1].point;
        opening += step.dot(w[1].inward - w[0].inward);
        passed += step.length();
    }
    opening < -FLAT_RAD * passed
}

/// Mean width of a face.
fn width(aag: &Aag, f: FaceId) -> f64 {
    2.0 * aag.area[f] / aag.perimeter[f].max(f64::MIN_POSITIVE)
}

/// Faces still alone that go on with a paired face and see a neighbour of that face's mate, about as far away: MidSurfer, algorithm 2.
/// Without distance and turn two lateral faces, each beside both sides of a wall, would be a pair. Of these the ones stay that do not lead away.
fn complement<'a>(
    aag: &Aag,
    sightings: &[Sighting],
    views: &'a [View],
    mates: &Mates,
    options: &PairOptions,
) -> Vec<&'a View> {
    let mut found: Vec<&View> = views
        .iter()
        .filter(|v| {
            let (f, g) = (v.from, v.to);
            f != g
                && mates[f].is_empty()
                && !beside(aag, f, g)
                && continuing(aag, f).any(|h| {
                    mates[h]
                        .iter()
                        .any(|&(_, t)| v.median() < options.soft_thickness * t)
                })
                && goes_on(aag, mates, f, g)
        })
        .collect();
    // A quarter of a full rounding sees across by a third of itself, or by less on the hollow side of a bend and by more on the other: two that go on in one another are judged together.
    let kept: Vec<bool> = (found.iter())
        .map(|v| {
            let (f, soft) = (v.from, options.soft_overlap);
            let with_next = || {
                continuing(aag, f).any(|c| {
                    let next = found.iter().filter(|w| w.from == c).map(|w| w.area);
                    v.area + next.fold(0.0, f64::max) > soft * (aag.area[f] + aag.area[c])
                })
            };
            let share = v.area / aag.area[f];
            share > soft || (share > soft / 2.0 && with_next())
        })
        .collect();
    let mut kept = kept.into_iter();
    found.retain(|_| kept.next().unwrap_or(false));
    loop {
        let before = found.len();
        let sides: Vec<FaceId> = found.iter().map(|v| v.from).collect();
        let is_side = |h: FaceId| !mates[h].is_empty() || sides.contains(&h);
        found.retain(|v| {
            !leads_away(aag, is_side, v.from, v.median()) || !is_hollow(sightings, v.from)
        });
        if found.len() == before {
            return found;
        }
    }
}

fn views(sightings: &[Sighting], options: &PairOptions) -> Vec<View> {
    let least = if options.lumps {
        LeastExtent::of_lumps(options.least_width)
    } else {
        LeastExtent::of_walls(options.least_width)
    };
    let mut seen: Vec<(FaceId, FaceId, f64, f64, bool)> = sightings
        .iter()
        .filter_map(|s| {
            s.across
                .map(|(to, d)| (s.from, to, d, s.area, s.extent.is_wide(&least)))
        })
        .collect();
    seen.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
    seen.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
        .map(|run| View {
            from: run[0].0,
            to: run[0].1,
            area: run.iter().map(|s| s.3).sum(),
            wide: run.iter().filter(|s| s.4).map(|s| s.3).sum(),
            distances: run.iter().map(|s| s.2).collect(),
        })
        .collect()
}

fn find(views: &[View], f: FaceId, g: FaceId) -> Option<&View> {
    views
        .binary_search_by(|v| (v.from, v.to).cmp(&(f, g)))
        .ok()
        .map(|i| &views[i])
}

/// One record a pair, from the views in both directions. Least and greatest leave out one sample in fifty, where a ray met an edge.
fn gather(views: &[View], accepted: &[&View]) -> Vec<FacePair> {
    let mut keys: Vec<[FaceId; 2]> = accepted
        .iter()
        .map(|v| [v.from.min(v.to), v.from.max(v.to)])
        .collect();
    keys.sort_unstable();
    keys.dedup();
    keys.into_iter()
        .map(|[a, b]| {
            let both: Vec<&View> = [find(views, a, b), find(views, b, a)]
                .into_iter()
                .flatten()
                .collect();
            let mut d: Vec<f64> = both
                .iter()
                .flat_map(|v| v.distances.iter().copied())
                .collect();
            d.sort_by(f64::total_cmp);
            let trim = d.len() / 50;
            let kept = &d[trim..d.len() - trim];
            FacePair {
                faces: [a, b],
                overlap: both.iter().map(|v| v.area).sum::<f64>() / both.len() as f64,
                thickness: [
                    kept[0],
                    kept.iter().sum::<f64>() / kept.len() as f64,
                    kept[kept.len() - 1],
                ],
                wall: WallId(0),
            }
        })
        .collect()
}
