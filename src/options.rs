//! What a caller may choose, and what holds where he does not: every default value of the program stands here.
//!
//! Guarantee: an option that [`MeshOptions::check`] lets pass is finite and in range, so that nothing later asks again. Whether a size suits the
//! part is known only when the part is read: [`MeshOptions::check_against`]. Sizes are mm.

mod fault;

pub use fault::OptionFault;

use crate::model::element_shape::ElementShape;
use crate::model::keep::KeepEdge;
use crate::model::length_unit::LengthUnit;
use crate::model::local_size::LocalSize;
use crate::model::profile::Profile;
use crate::model::removal::SmallLimits;
use crate::model::washer::WasherRequest;
use std::path::PathBuf;
use std::time::Duration;

/// Longest that import may take over all its attempts, of processor time. Parts that gmsh can fill take seconds; fTetWild, the last resort, takes up to half
/// a minute after gmsh has given up.
/// So on a machine that has a core to spare a refusal comes within a minute; a busy one needs longer, but says the same.
const TIME_LIMIT: Duration = Duration::from_secs(58);

/// Rows of elements across a narrow sheet: a single row bends as stiffly as its shape functions make it.
const ROWS: u32 = 2;

/// The choices of one run.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct MeshOptions {
    /// Edge length that the elements should have, mm. None: the part decides (a few thicknesses, bounded by its features).
    pub size: Option<f64>,
    /// Elements in a full turn of a curved wall. None: the chord stays near the mid-surface, to a share of the thickness.
    pub size_curvature: Option<f64>,
    /// No shorter edges are wanted anywhere, mm, whatever bends, steps and narrow places ask for. None: no bound.
    pub size_min: Option<f64>,
    /// No longer edges are wanted anywhere, mm, also where the part decides. None: no bound.
    pub size_max: Option<f64>,
    /// Neighbouring edges differ in length by this factor at most. None: 1.3 along edges of the mesh, 1.4 from row to row within a sheet.
    pub growth: Option<f64>,
    /// Rows of elements across a rib, flange or web; fewer where they would be lower than it is thick.
    pub rows: u32,
    /// Sizes of single sheets and faces.
    pub sizes: Vec<LocalSize>,
    /// Edges between faces on one side of a wall that stay in the mesh as lines of element edges.
    pub keep: Vec<KeepEdge>,
    /// Which elements.
    pub element: ElementShape,
    /// What is so small that the mesh does without it.
    pub small: SmallLimits,
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
            size_min: None,
            size_max: None,
            growth: None,
            rows: ROWS,
            sizes: Vec::new(),
            keep: Vec::new(),
            element: ElementShape::default(),
            small: SmallLimits::default(),
            washer: WasherRequest::default(),
            unit: None,
            gmsh: None,
            time_limit: TIME_LIMIT,
            dump: None,
            profile: Profile::default(),
        }
    }
}

/// Three chords are the fewest that still go round something.
const MIN_PER_TURN: f64 = 3.0;
/// Factors between neighbouring edges: below the first a mesh would be as fine as its finest place all over, above the second triangles have angles below 30 degrees.
const GROWTH: [f64; 2] = [1.05, 2.0];
/// More rows than that across a rib are a wrong number.
const MOST_ROWS: u32 = 50;

impl MeshOptions {
    /// The first thing that is wrong whatever the part is.
    pub fn check(&self) -> Result<(), OptionFault> {
        self.check_sizes()?;
        if let Some((what, limit)) =
            (self.small.named()).find(|(_, limit)| !(limit.is_finite() && *limit > 0.0))
        {
            return Err(OptionFault::Small(what, limit));
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

    /// Every size that was given, after where it was.
    fn sizes_told(&self) -> impl Iterator<Item = (String, f64)> {
        let local = (self.sizes.iter()).map(|wish| (wish.origin.clone(), wish.size));
        let all = self.size.map(|size| ("--size".to_owned(), size));
        all.into_iter().chain(local)
    }

    fn check_sizes(&self) -> Result<(), OptionFault> {
        let is_length = |x: f64| x.is_finite() && x > 0.0;
        if let Some(size) = self.size
            && !is_length(size)
        {
            return Err(OptionFault::Size(size));
        }
        for (name, bound) in [("--size-min", self.size_min), ("--size-max", self.size_max)] {
            if let Some(bound) = bound
                && !is_length(bound)
            {
                return Err(OptionFault::Bound(name, bound));
            }
        }
        let (min, max) = (
            self.size_min.unwrap_or(0.0),
            self.size_max.unwrap_or(f64::INFINITY),
        );
        if min > max {
            return Err(OptionFault::Bounds { min, max });
        }
        for (what, size) in self.sizes_told() {
            if !(size >= min && size <= max) {
                return Err(OptionFault::OutOfBounds {
                    what,
                    size,
                    min,
                    max,
                });
            }
        }
        if let Some(growth) = self.growth
            && !(GROWTH[0]..=GROWTH[1]).contains(&growth)
        {
            return Err(OptionFault::Growth(growth));
        }
        if !(1..=MOST_ROWS).contains(&self.rows) {
            return Err(OptionFault::Rows(self.rows));
        }
        Ok(())
    }

    /// Whether the size suits a part whose box has this diagonal (mm). A larger size is refused, not clamped: it is nearly always a wrong unit.
    pub fn check_against(&self, part_diagonal: f64) -> Result<(), OptionFault> {
        if let Some((what, limit)) = self.small.named().find(|(_, l)| *l > part_diagonal) {
            return Err(OptionFault::SmallBeyondPart(what, limit, part_diagonal));
        }
        for (what, size) in self
            .sizes_told()
            .chain(self.size_min.map(|min| ("--size-min".to_owned(), min)))
        {
            if size > part_diagonal {
                return Err(OptionFault::SizeBeyondPart {
                    what,
                    size,
                    part: part_diagonal,
                });
            }
        }
        Ok(())
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
    fn least_holes_and_features_that_are_no_length_or_beyond_the_part_are_refused() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            for (hole, feature) in [(Some(bad), None), (None, Some(bad))] {
                let options = MeshOptions {
                    small: SmallLimits { hole, feature },
                    ..MeshOptions::default()
                };
                assert!(
                    matches!(options.check(), Err(OptionFault::Small(..))),
                    "{bad}"
                );
            }
        }
        let options = MeshOptions {
            small: SmallLimits {
                hole: Some(5.0),
                feature: Some(120.0),
            },
            ..MeshOptions::default()
        };
        assert_eq!(options.check(), Ok(()));
        assert_eq!(options.check_against(120.0), Ok(()));
        let fault = options.check_against(100.0).unwrap_err();
        assert!(fault.to_string().contains("feature size 120 mm"), "{fault}");
    }

    #[test]
    fn bounds_hold_between_each_other_and_round_every_size() {
        let with = |min: Option<f64>, max: Option<f64>, size: Option<f64>, local: &[f64]| {
            let sizes = local.iter().map(|&size| LocalSize {
                size,
                origin: "a file".into(),
                ..LocalSize::default()
            });
            let options = MeshOptions {
                size,
                size_min: min,
                size_max: max,
                sizes: sizes.collect(),
                ..MeshOptions::default()
            };
            options.check()
        };
        assert_eq!(with(Some(1.0), Some(1.0), Some(1.0), &[1.0]), Ok(()));
        assert_eq!(with(Some(1.0), None, Some(9.0), &[2.0]), Ok(()));
        assert_eq!(with(None, Some(9.0), None, &[2.0, 9.0]), Ok(()));
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let bound = |fault| matches!(fault, Err(OptionFault::Bound(..)));
            assert!(bound(with(Some(bad), None, None, &[])), "{bad}");
            assert!(bound(with(None, Some(bad), None, &[])), "{bad}");
            // The file is read by other hands than these: what comes through is refused all the same.
            assert!(bad > 0.0 || with(Some(1.0), None, None, &[bad]).is_err());
        }
        assert!(matches!(
            with(Some(2.0), Some(1.0), None, &[]),
            Err(OptionFault::Bounds { .. })
        ));
        for (size, local) in [(Some(0.9), 2.0), (Some(4.1), 2.0), (None, 0.9), (None, 4.1)] {
            let fault = with(Some(1.0), Some(4.0), size, &[local]).unwrap_err();
            assert!(matches!(fault, OptionFault::OutOfBounds { .. }), "{fault}");
            let named = if size.is_some() { "--size" } else { "a file" };
            assert!(fault.to_string().starts_with(named), "{fault}");
        }
    }

    #[test]
    fn growth_and_rows_have_a_range() {
        let with = |growth, rows| {
            let options = MeshOptions {
                growth,
                rows,
                ..MeshOptions::default()
            };
            options.check()
        };
        for good in [1.05, 1.2, 2.0] {
            assert_eq!(with(Some(good), 1), Ok(()));
        }
        for bad in [f64::NAN, 1.0, 0.5, -2.0, 2.1, f64::INFINITY] {
            assert!(
                matches!(with(Some(bad), 2), Err(OptionFault::Growth(_))),
                "{bad}"
            );
        }
        assert_eq!(with(None, 0), Err(OptionFault::Rows(0)));
        assert_eq!(with(None, MOST_ROWS), Ok(()));
        assert!(with(None, MOST_ROWS + 1).is_err());
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
        let hole = crate::model::washer::BareHole {
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
