//! What tests/python/measure.py finds; its header says how each figure is measured.

use serde::Deserialize;

/// Figures of a mesh. Lengths in mm.
#[derive(Clone, Debug, Deserialize)]
pub struct Measured {
    pub nodes: usize,
    pub elements: usize,
    pub unused_points: usize,
    pub euler: i64,
    pub pieces: usize,
    pub sheets: usize,
    pub sheet_labels: usize,
    pub labels_astray: usize,
    pub junction_curves: usize,
    pub crease_curves: usize,
    pub area: f64,
    pub edge_ratio: f64,
    pub flipped: usize,
    pub samples: usize,
    pub r50: f64,
    pub r95: f64,
    pub r99: f64,
    pub t95: f64,
    /// Area by element thickness.
    pub t_area: Vec<(f64, f64)>,
    pub cover: f64,
    pub wall_share: f64,
    pub free_length: f64,
    pub free_off: f64,
}

/// Figures of a solid.
#[derive(Clone, Debug, Deserialize)]
pub struct SolidFacts {
    pub solids: usize,
    pub volume: f64,
    /// Half that of its boundary.
    pub euler: f64,
    pub closed: bool,
    pub faces: usize,
    /// Faces in the file that bound no solid.
    pub loose: usize,
}

impl Measured {
    /// How this mesh of a moved, scaled or reordered solid differs from the mesh of the solid as made; empty where it does not.
    /// The volume mesh between is another one, so that elements and samples are others too: only what they approach is compared.
    pub fn differences(&self, base: &Measured) -> Vec<String> {
        let mut found = Vec::new();
        let mut same = |what: &str, a: i64, b: i64| {
            if a != b {
                found.push(format!("{what}: {a}, of the solid as made {b}"));
            }
        };
        same("Euler characteristic", self.euler, base.euler);
        same("pieces", self.pieces as i64, base.pieces as i64);
        same("sheets", self.sheets as i64, base.sheets as i64);
        same(
            "sheet labels",
            self.sheet_labels as i64,
            base.sheet_labels as i64,
        );
        same(
            "junction curves",
            self.junction_curves as i64,
            base.junction_curves as i64,
        );
        same(
            "crease curves",
            self.crease_curves as i64,
            base.crease_curves as i64,
        );
        same("flipped elements", self.flipped as i64, base.flipped as i64);
        let mut near = |what: &str, a: f64, b: f64, tolerance: f64| {
            let close = (a - b).abs() <= tolerance;
            if !close {
                found.push(format!("{what}: {a}, of the solid as made {b}"));
            }
        };
        // Chords and, where a rim is not fixed by the solid, its place.
        near("area", self.area, base.area, 0.002 * base.area);
        // A fifth more or fewer elements is another size, not another triangulation.
        near(
            "elements",
            self.elements as f64,
            base.elements as f64,
            0.2 * base.elements as f64,
        );
        near("R-error", self.r95, base.r95, 0.002 + 0.25 * base.r95);
        near("coverage", self.cover, base.cover, 0.005);
        found
    }
}
