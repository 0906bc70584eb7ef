//! The expected facts of a fixture (fixtures/NAME.toml) and what a measured mesh or solid lacks of them.

use super::Wanted;
use super::measured::{Measured, SolidFacts};
use super::tools;
use serde::Deserialize;

/// The figures that a mesh of a fixture may be off by; all from the list that the project promises for its fixtures.
pub mod limit {
    /// R-error of 99 % of the samples; of 95 % where the fixture says that its mid-surface is kinked.
    pub const R_ERROR: f64 = 0.005;
    /// Thickness of 95 % of the samples, relative.
    pub const THICKNESS: f64 = 0.005;
    /// Area of the mid-surface, relative.
    pub const AREA: f64 = 0.005;
    /// Share of the wall area that must be covered: all of it, less what the sampling of curved rims can miss.
    pub const COVER: f64 = 0.995;
    /// Longest edge over shortest.
    pub const EDGE_RATIO: f64 = 5.0;
    /// Samples that the percentiles need.
    pub const SAMPLES: usize = 2000;
    /// Share of the area with one of the listed thicknesses: elements may straddle a step.
    pub const LISTED: f64 = 0.93;
    /// Volume of the solid against its closed form: intersection curves of the CAD kernel are good to 4e-6, at a thousandth of
    /// the size to 1.3e-5.
    pub const VOLUME: f64 = 2e-5;
}

/// Facts of a fixture. Lengths in mm.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    pub source: String,
    pub licence: String,
    pub solids: usize,
    /// Euler characteristic of the mid-surface, half that of the solid's boundary.
    pub euler: i64,
    pub sheets: usize,
    /// Most values that the cell array `sheet` may take, where a mesher may tell two walls of one smooth sheet apart.
    pub sheet_labels_max: Option<usize>,
    pub junction_curves: usize,
    pub crease_curves: usize,
    #[serde(default)]
    pub thickness: Vec<f64>,
    /// Whether there are places along which the exact mid-surface is no smooth sheet (steps of the thickness, slanted rims, blends cut off): elements straddle these.
    #[serde(default)]
    pub kinked: bool,
    pub thickness_min: Option<f64>,
    pub thickness_max: Option<f64>,
    pub volume: f64,
    pub mid_area: f64,
    pub size: f64,
    pub size_curvature: Option<f64>,
}

impl Facts {
    /// Reads fixtures/NAME.toml.
    pub fn of(name: &str) -> Facts {
        let path = tools::root().join(format!("fixtures/{name}.toml"));
        let text =
            std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let facts: Facts =
            toml::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let listed = !facts.thickness.is_empty();
        let ranged = facts.thickness_min.is_some() && facts.thickness_max.is_some();
        assert!(
            listed != ranged,
            "{}: thickness, or thickness_min and thickness_max",
            path.display()
        );
        facts
    }

    /// The least and the greatest thickness.
    pub fn thickness_range(&self) -> (f64, f64) {
        let low = self
            .thickness
            .iter()
            .copied()
            .chain(self.thickness_min)
            .fold(f64::INFINITY, f64::min);
        let high = self
            .thickness
            .iter()
            .copied()
            .chain(self.thickness_max)
            .fold(0.0, f64::max);
        (low, high)
    }

    /// The greatest thickness.
    pub fn thickest(&self) -> f64 {
        self.thickness_range().1
    }

    /// The size that the facts hold for.
    pub fn fine(&self) -> Wanted {
        Wanted {
            size: self.size,
            size_curvature: self.size_curvature,
            threads: 1,
            element: None,
        }
    }

    /// A size half as large again, for comparisons of one mesh with another; bends still turn by less than a crease at an edge.
    pub fn coarse(&self) -> Wanted {
        Wanted {
            size: 1.5 * self.size,
            size_curvature: self.size_curvature.map(|n| (n / 1.5).round()),
            threads: 1,
            element: None,
        }
    }

    /// What is wrong with a mesh of this fixture; empty where nothing is.
    pub fn violations(&self, m: &Measured) -> Vec<String> {
        let mut wrong = Vec::new();
        let mut must = |holds: bool, what: String| {
            if !holds {
                wrong.push(what);
            }
        };
        must(
            m.euler == self.euler,
            format!(
                "topology: Euler characteristic {}, not {}",
                m.euler, self.euler
            ),
        );
        must(
            m.pieces == self.solids,
            format!("topology: {} pieces, not {}", m.pieces, self.solids),
        );
        must(
            m.unused_points == 0,
            format!("topology: {} points that no element uses", m.unused_points),
        );
        must(
            m.sheets == self.sheets,
            format!("sheets: {}, not {}", m.sheets, self.sheets),
        );
        let labels = self.sheets..=self.sheet_labels_max.unwrap_or(self.sheets);
        must(
            labels.contains(&m.sheet_labels),
            format!("sheets: {} labels, not {labels:?}", m.sheet_labels),
        );
        must(
            m.labels_astray == 0,
            format!(
                "sheets: {} labels reach over several sheets",
                m.labels_astray
            ),
        );
        must(
            m.junction_curves == self.junction_curves,
            format!(
                "junctions: {}, not {}",
                m.junction_curves, self.junction_curves
            ),
        );
        must(
            m.crease_curves == self.crease_curves,
            format!("creases: {}, not {}", m.crease_curves, self.crease_curves),
        );
        let off = m.area / self.mid_area - 1.0;
        must(
            off.abs() <= limit::AREA,
            format!(
                "area: {:.3}, not {:.3} ({:+.3} %)",
                m.area,
                self.mid_area,
                100.0 * off
            ),
        );
        must(
            m.samples >= limit::SAMPLES,
            format!("samples: only {}", m.samples),
        );
        let (share, r_error) = if self.kinked {
            (95, m.r95)
        } else {
            (99, m.r99)
        };
        must(
            r_error <= limit::R_ERROR,
            format!("R-error: {:.3} % at {share} % of samples", 100.0 * r_error),
        );
        must(
            m.t95 <= limit::THICKNESS,
            format!(
                "thickness: off by {:.3} % at 95 % of samples",
                100.0 * m.t95
            ),
        );
        self.thickness_violations(m, &mut must);
        must(
            m.cover >= limit::COVER,
            format!("coverage: {:.2} % of the wall area", 100.0 * m.cover),
        );
        // Of curved rims the chords lie inside the tolerance: nothing is left to allow for.
        must(
            m.free_off == 0.0,
            format!(
                "rims: {:.3} mm of {:.3} mm free edges inside the solid",
                m.free_off, m.free_length
            ),
        );
        must(
            m.edge_ratio <= limit::EDGE_RATIO,
            format!("quality: longest edge over shortest {:.2}", m.edge_ratio),
        );
        must(
            m.flipped == 0,
            format!("quality: {} flipped or folded", m.flipped),
        );
        wrong
    }

    fn thickness_violations(&self, m: &Measured, must: &mut impl FnMut(bool, String)) {
        let total: f64 = m.t_area.iter().map(|&(_, a)| a).sum();
        let (low, high) = self.thickness_range();
        let near = |t: f64, want: f64| (t - want).abs() <= limit::THICKNESS * want;
        let right: f64 = if self.thickness.is_empty() {
            let inside = |t: f64| {
                t >= low * (1.0 - limit::THICKNESS) && t <= high * (1.0 + limit::THICKNESS)
            };
            m.t_area
                .iter()
                .filter(|&&(t, _)| inside(t))
                .map(|&(_, a)| a)
                .sum()
        } else {
            m.t_area
                .iter()
                .filter(|&&(t, _)| self.thickness.iter().any(|&w| near(t, w)))
                .map(|&(_, a)| a)
                .sum()
        };
        must(
            right >= limit::LISTED * total,
            format!(
                "thickness: only {:.1} % of the area as expected",
                100.0 * right / total
            ),
        );
        for &want in &self.thickness {
            must(
                m.t_area.iter().any(|&(t, _)| near(t, want)),
                format!("thickness: no element of {want} mm"),
            );
        }
    }

    /// What is wrong with the solid that the fixture's script makes.
    pub fn solid_violations(&self, s: &SolidFacts) -> Vec<String> {
        let mut wrong = Vec::new();
        if !s.closed {
            wrong.push("its boundary is not closed".to_owned());
        }
        if s.loose != 0 {
            wrong.push(format!("{} faces that bound no solid", s.loose));
        }
        if s.solids != self.solids {
            wrong.push(format!("{} solids, not {}", s.solids, self.solids));
        }
        if s.euler != self.euler as f64 {
            wrong.push(format!(
                "half the boundary's Euler characteristic is {}, not {}",
                s.euler, self.euler
            ));
        }
        if (s.volume / self.volume - 1.0).abs() > limit::VOLUME {
            wrong.push(format!("volume {}, not {}", s.volume, self.volume));
        }
        wrong
    }
}
