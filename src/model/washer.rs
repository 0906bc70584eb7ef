//! Washers: rings of quads round the holes of bolts, as asked for and as made.

use glam::DVec3;
use serde::Serialize;
use std::fmt;

/// A hole may be this share narrower or wider than the range of diameters says: its rim is measured on facets.
const SLACK: f64 = 0.01;
/// Most rings round a hole.
const LAYERS_MAX: u32 = 20;

/// Which washers are wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct WasherRequest {
    /// Rings of quads round each hole. Zero: no washers.
    pub layers: u32,
    /// Diameters of the holes that get one, mm, from and to. None: every round hole of up to [`WasherRequest::HOLE_SIZES`] edge lengths.
    pub holes: Option<[f64; 2]>,
    /// Width of a ring, mm. None: see [`WasherRequest::width_round`].
    pub width: Option<f64>,
}

/// What can be wrong with a [`WasherRequest`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum WasherFault {
    /// A range or a width of rings that nobody asked for.
    #[error("holes or a width of washers are given, but no washers are asked for")]
    NoLayers,
    /// More rings than make sense.
    #[error("{0} rings of a washer are asked for: at most {LAYERS_MAX} make sense")]
    Layers(u32),
    /// The range is empty, not finite or below zero.
    #[error("no hole can have a diameter from {} to {} mm", .0[0], .0[1])]
    Holes([f64; 2]),
    /// The width is zero, negative, infinite or no number.
    #[error("the width of a washer's ring is {0}, but it must be a length above zero (in mm)")]
    Width(f64),
}

impl WasherFault {
    /// What the user can do about it.
    pub fn remedy(&self) -> &'static str {
        match self {
            WasherFault::NoLayers => "add --washer with the number of rings, such as --washer 2",
            WasherFault::Layers(_) => "ask for fewer, such as --washer 2",
            WasherFault::Holes(_) => "give the diameters from and to, such as --washer-holes 4..12",
            WasherFault::Width(_) => {
                "give a length such as --washer-width 2, or leave it out: then each hole decides"
            }
        }
    }
}

impl WasherRequest {
    /// Widest hole that gets a washer unasked, in edge lengths of the part: bolts pass, and windows do not.
    pub const HOLE_SIZES: f64 = 4.0;

    /// Whether washers are wanted at all.
    pub fn is_wanted(&self) -> bool {
        self.layers > 0
    }

    /// The first thing that is wrong.
    pub fn check(&self) -> Option<WasherFault> {
        let length = |x: f64| x.is_finite() && x > 0.0;
        if self.layers == 0 && (self.holes.is_some() || self.width.is_some()) {
            return Some(WasherFault::NoLayers);
        }
        if self.layers > LAYERS_MAX {
            return Some(WasherFault::Layers(self.layers));
        }
        if let Some(holes @ [from, to]) = self.holes
            && !(from.is_finite() && from >= 0.0 && length(to) && from <= to)
        {
            return Some(WasherFault::Holes(holes));
        }
        self.width.filter(|w| !length(*w)).map(WasherFault::Width)
    }

    /// Whether a hole of this diameter gets one; `size` is the part's edge length. Both mm.
    pub fn takes(&self, diameter: f64, size: f64) -> bool {
        let [from, to] = self.holes.unwrap_or([0.0, Self::HOLE_SIZES * size]);
        diameter >= from * (1.0 - SLACK) && diameter <= to * (1.0 + SLACK)
    }

    /// Width of a ring where there is room, mm: as asked for, or such that the washer is twice as wide as its hole, as a bolt's washer is, with no ring wider than an
    /// element of `size`.
    pub fn width_round(&self, radius: f64, size: f64) -> f64 {
        let own = || (radius / f64::from(self.layers.max(1))).min(size);
        self.width.unwrap_or_else(own)
    }
}

/// A washer of the mesh. Lengths in mm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Washer {
    /// Middle of the hole.
    pub centre: DVec3,
    /// Unit normal of the sheet there.
    pub axis: DVec3,
    /// Diameter of the hole.
    pub diameter: f64,
    /// Rings of quads.
    pub layers: u32,
    /// Width of each ring.
    pub width: f64,
    /// Quads round the hole, in each ring.
    pub around: u32,
}

impl Washer {
    /// Its hole without it.
    pub fn bare(&self, why: NoWasher) -> BareHole {
        BareHole {
            centre: self.centre,
            diameter: self.diameter,
            why,
        }
    }
}

/// What stands where a washer's rings end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RoomEnd {
    /// A free edge of the sheet.
    Rim,
    /// Another hole with a washer of its own.
    Washer,
    /// Another wall.
    Junction,
    /// A bend.
    Bend,
}

impl fmt::Display for RoomEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            RoomEnd::Rim => "an edge of the sheet",
            RoomEnd::Washer => "the washer of another hole",
            RoomEnd::Junction => "another wall",
            RoomEnd::Bend => "a bend",
        })
    }
}

/// Why a hole of the wanted diameter has no washer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoWasher {
    /// Too little room for its rings.
    Room {
        /// How wide all rings together may be at most, mm.
        room: f64,
        /// How wide they want to be, mm.
        wanted: f64,
        /// What is in the way.
        end: RoomEnd,
    },
    /// The rim does not lie in one smooth sheet.
    Shared,
    /// The sheet bends too much across the hole.
    Bent,
    /// No good mesh was found with it.
    Unmeshed,
}

impl fmt::Display for NoWasher {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoWasher::Room { room, wanted, end } => write!(
                f,
                "its rings are {wanted:.2} mm wide, and {end} leaves room for {room:.2} mm"
            ),
            NoWasher::Shared => f.write_str("its rim belongs to several sheets"),
            NoWasher::Bent => f.write_str("the sheet bends too much across it"),
            NoWasher::Unmeshed => f.write_str("no good mesh was found with it"),
        }
    }
}

/// A hole of the wanted diameter without a washer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BareHole {
    /// Its middle, mm.
    pub centre: DVec3,
    /// Its diameter, mm.
    pub diameter: f64,
    /// Why it has none.
    pub why: NoWasher,
}

impl fmt::Display for BareHole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { diameter, why, .. } = self;
        // No minus before a zero.
        let c = (self.centre * 10.0).round() / 10.0 + DVec3::ZERO;
        write!(
            f,
            "hole of {diameter:.2} mm at ({:.1}, {:.1}, {:.1}): {why}",
            c.x, c.y, c.z
        )
    }
}

/// What came of the wish for washers, hole by hole.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Washers {
    /// Holes with one.
    pub made: Vec<Washer>,
    /// Holes of the wanted diameter without one.
    pub left_out: Vec<BareHole>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(layers: u32, holes: Option<[f64; 2]>, width: Option<f64>) -> WasherRequest {
        WasherRequest {
            layers,
            holes,
            width,
        }
    }

    #[test]
    fn what_means_nothing_is_refused() {
        for good in [
            asked(0, None, None),
            asked(2, None, None),
            asked(1, Some([0.0, 5.0]), Some(1e-3)),
            asked(1, Some([5.0, 5.0]), None),
        ] {
            assert_eq!(good.check(), None, "{good:?}");
        }
        for bad in [
            asked(0, Some([4.0, 12.0]), None),
            asked(0, None, Some(1.0)),
            asked(21, None, None),
            asked(1, Some([5.0, 4.0]), None),
            asked(1, Some([-1.0, 4.0]), None),
            asked(1, Some([0.0, 0.0]), None),
            asked(1, Some([f64::NAN, 4.0]), None),
            asked(1, Some([0.0, f64::INFINITY]), None),
            asked(1, None, Some(0.0)),
            asked(1, None, Some(-2.0)),
            asked(1, None, Some(f64::NAN)),
        ] {
            let fault = bad.check();
            assert!(fault.is_some_and(|f| !f.remedy().is_empty()), "{bad:?}");
        }
    }

    #[test]
    fn the_range_takes_what_is_measured_on_facets_and_no_more() {
        let range = asked(1, Some([4.0, 12.0]), None);
        let takes = [3.9, 3.97, 4.0, 12.0, 12.1, 12.2].map(|d| range.takes(d, 1.0));
        assert_eq!(takes, [false, true, true, true, true, false]);
        let unasked = asked(1, None, None);
        assert!(unasked.takes(12.0, 3.0) && !unasked.takes(12.2, 3.0));
    }

    #[test]
    fn a_washer_is_twice_as_wide_as_its_hole_unless_elements_are_smaller() {
        assert_eq!(asked(2, None, None).width_round(3.0, 5.0), 1.5);
        assert_eq!(asked(1, None, None).width_round(9.0, 5.0), 5.0);
        assert_eq!(asked(2, None, Some(0.7)).width_round(3.0, 5.0), 0.7);
    }
}
