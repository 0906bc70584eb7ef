//! What a caller may choose, and what holds where he does not: every default value of the program stands here.
//!
//! Guarantee: an option that [`MeshOptions::check`] lets pass is finite and in range, so that nothing later asks again. Whether a size suits the
//! part is known only when the part is read: [`MeshOptions::check_against`]. Sizes are mm.

use crate::model::element_shape::{ElementShape, UnknownShape};
use crate::model::length_unit::{LengthUnit, UnknownUnit};
use crate::model::profile::{Profile, ProfileFault};
use crate::model::washer::{BareHole, WasherFault, WasherRequest};
use std::path::PathBuf;
use std::time::Duration;

/// Longest that import may take over all its attempts, of processor time. Parts that gmsh can fill take seconds; fTetWild, the last resort, takes up to half
/// a minute after gmsh has given up.
/// So on a machine that has a core to spare a refusal comes within a minute; a busy one needs longer, but says the same.
const TIME_LIMIT: Duration = Duration::from_secs(58);

/// The choices of one run.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct MeshOptions {
    /// Edge length that the elements should have, mm. None: the part decides (a few thicknesses, bounded by its features).
    pub size: Option<f64>,
    /// Elements in a full turn of a curved wall. None: curvature does not refine.
    pub size_curvature: Option<f64>,
    /// Which elements.
    pub element: ElementShape,
    /// Rings of quads round holes.
    pub washer: WasherRequest,
    /// Unit of lengths in files that name none (STL, OBJ, PLY). None: mm.
    pub unit: Option<LengthUnit>,
    /// The gmsh command. None: the importer looks for one.
    pub gmsh: Option<PathBuf>,
    /// Longest that import may take over all its attempts, of processor time; four times as long by the clock.
    pub time_limit: Duration,
    /// A folder for the result of every stage, to look into a run that went wrong. None: nothing is kept.
    pub dump: Option<PathBuf>,
    /// The criteria that the report holds elements against.
    pub profile: Profile,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            size: None,
            size_curvature: None,
            element: ElementShape::default(),
            washer: WasherRequest::default(),
            unit: None,
            gmsh: None,
            time_limit: TIME_LIMIT,
            dump: None,
            profile: Profile::default(),
        }
    }
}

/// What can be wrong with the options.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OptionFault {
    /// A length that is zero, negative, infinite or no number.
    #[error("the element size is {0}, but it must be a length above zero (in mm)")]
    Size(f64),
    /// The wanted elements are larger than the part.
    #[error(
        "the element size {size} mm is larger than the part, which measures {part:.1} mm corner to corner"
    )]
    SizeBeyondPart {
        /// The size asked for, mm.
        size: f64,
        /// Diagonal of the part's box, mm.
        part: f64,
    },
    /// Too few elements a turn.
    #[error("{0} elements in a full turn: a turn takes at least {MIN_PER_TURN}, and a number")]
    SizeCurvature(f64),
    /// A time limit of zero.
    #[error("the time limit is zero: nothing can be done in no time")]
    TimeLimit,
    /// An element shape that we do not know.
    #[error(transparent)]
    Shape(#[from] UnknownShape),
    /// A unit that we do not know.
    #[error(transparent)]
    Unit(#[from] UnknownUnit),
    /// Washers that mean nothing.
    #[error(transparent)]
    Washer(#[from] WasherFault),
    /// Washers in a mesh of triangles.
    #[error("washers are rings of quads, but the elements are to be triangles")]
    WasherShape,
    /// The width asked for is more than there is room for round these holes.
    #[error("a washer is wider than the room for it\n{}", lines(.0))]
    WasherRoom(Vec<BareHole>),
    /// Criteria that mean nothing.
    #[error(transparent)]
    Profile(#[from] ProfileFault),
}

/// Holes that an error tells one by one: enough to see what they have in common.
const TOLD: usize = 10;

fn lines(holes: &[BareHole]) -> String {
    let told = holes.iter().take(TOLD).map(ToString::to_string);
    let more = holes.len().checked_sub(TOLD).filter(|n| *n > 0);
    let more = more.map(|n| format!("and holes more: {n}"));
    told.chain(more).collect::<Vec<_>>().join("\n")
}

/// Three chords are the fewest that still go round something.
const MIN_PER_TURN: f64 = 3.0;

impl OptionFault {
    /// What the user can do about it.
    pub fn remedy(&self) -> String {
        match self {
            OptionFault::Size(_) => {
                "give a length such as --size 5, or leave --size out: then the part decides".into()
            }
            OptionFault::SizeBeyondPart { part, .. } => format!(
                "give a size below {part:.1} mm (is the file in the unit that you expect?), or leave --size out: then the part decides"
            ),
            OptionFault::SizeCurvature(_) => {
                "give a number such as --size-curvature 24, or leave it out".into()
            }
            OptionFault::TimeLimit => {
                "give the seconds of processor time that reading and filling the part may take, such as --time-limit 300".into()
            }
            OptionFault::Washer(fault) => fault.remedy().into(),
            OptionFault::WasherShape => "add --element quad, or --element mixed".into(),
            OptionFault::WasherRoom(_) => "give a smaller --washer-width, or leave it out: then each washer is as wide as it can be; or fewer rings, or a range --washer-holes without these holes".into(),
            OptionFault::Shape(_) => {
                let names: Vec<&str> = ElementShape::NAMED.iter().map(|n| n.0).collect();
                format!("choose one of: {}", names.join(", "))
            }
            OptionFault::Profile(_) => {
                "mend the criteria, or choose a profile that comes with the program".into()
            }
            OptionFault::Unit(_) => {
                let names: Vec<&str> = LengthUnit::NAMED.iter().map(|n| n.0).collect();
                format!("choose one of: {}", names.join(", "))
            }
        }
    }
}

impl MeshOptions {
    /// The first thing that is wrong whatever the part is.
    pub fn check(&self) -> Result<(), OptionFault> {
        if let Some(size) = self.size
            && !(size.is_finite() && size > 0.0)
        {
            return Err(OptionFault::Size(size));
        }
        if let Some(count) = self.size_curvature
            && !(count.is_finite() && count >= MIN_PER_TURN)
        {
            return Err(OptionFault::SizeCurvature(count));
        }
        if self.time_limit.is_zero() {
            return Err(OptionFault::TimeLimit);
        }
        if let Some(fault) = self.washer.check() {
            return Err(fault.into());
        }
        if self.washer.is_wanted() && self.element == ElementShape::Triangle {
            return Err(OptionFault::WasherShape);
        }
        match self.profile.check().into_iter().next() {
            Some(fault) => Err(fault.into()),
            None => Ok(()),
        }
    }

    /// Whether the size suits a part whose box has this diagonal (mm). A larger size is refused, not clamped: it is nearly always a wrong unit.
    pub fn check_against(&self, part_diagonal: f64) -> Result<(), OptionFault> {
        match self.size {
            Some(size) if size > part_diagonal => Err(OptionFault::SizeBeyondPart {
                size,
                part: part_diagonal,
            }),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sized(size: f64) -> MeshOptions {
        MeshOptions {
            size: Some(size),
            ..MeshOptions::default()
        }
    }

    #[test]
    fn defaults_pass_their_own_check() {
        assert_eq!(MeshOptions::default().check(), Ok(()));
    }

    #[test]
    fn sizes_that_are_no_length_are_refused() {
        for bad in [0.0, -0.0, -5.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(
                matches!(sized(bad).check(), Err(OptionFault::Size(_))),
                "{bad}"
            );
        }
        assert_eq!(sized(1e-6).check(), Ok(()));
    }

    #[test]
    fn a_size_beyond_the_part_is_refused_and_names_the_part() {
        assert_eq!(sized(100.0).check_against(100.0), Ok(()));
        let fault = sized(100.5).check_against(100.0).unwrap_err();
        assert!(fault.to_string().contains("100.0 mm corner to corner"));
        assert!(fault.remedy().contains("below 100"));
    }

    #[test]
    fn too_few_elements_a_turn_and_no_time_are_refused() {
        for bad in [f64::NAN, -1.0, 0.0, 2.9, f64::INFINITY] {
            let options = MeshOptions {
                size_curvature: Some(bad),
                ..MeshOptions::default()
            };
            assert!(options.check().is_err(), "{bad}");
        }
        let options = MeshOptions {
            time_limit: Duration::ZERO,
            ..MeshOptions::default()
        };
        assert_eq!(options.check(), Err(OptionFault::TimeLimit));
    }

    #[test]
    fn washers_want_quads_and_numbers_that_mean_something() {
        let washer = WasherRequest {
            layers: 2,
            ..WasherRequest::default()
        };
        let mut options = MeshOptions {
            washer,
            ..MeshOptions::default()
        };
        assert_eq!(options.check(), Err(OptionFault::WasherShape));
        for shape in [ElementShape::Quad, ElementShape::Mixed] {
            options.element = shape;
            assert_eq!(options.check(), Ok(()));
        }
        options.washer.width = Some(0.0);
        assert!(matches!(options.check(), Err(OptionFault::Washer(_))));
    }

    #[test]
    fn of_many_narrow_holes_some_are_told_and_the_rest_counted() {
        let hole = BareHole {
            centre: glam::DVec3::new(1.0, -0.01, 2.0),
            diameter: 6.0,
            why: crate::model::washer::NoWasher::Shared,
        };
        let text = |count: usize| OptionFault::WasherRoom(vec![hole.clone(); count]).to_string();
        assert!(text(1).contains("hole of 6.00 mm at (1.0, 0.0, 2.0): its rim"));
        assert_eq!(text(10).lines().count(), 11);
        assert!(text(12).ends_with("\nand holes more: 2"));
    }

    #[test]
    fn every_shape_is_found_by_its_name_and_no_other() {
        for (name, shape) in ElementShape::NAMED {
            assert_eq!(name.parse(), Ok(shape));
            assert_eq!(shape.to_string(), name);
        }
        assert!("hex".parse::<ElementShape>().is_err());
    }
}
