//! What `inspect` finds out about a part, as data for JSON and as a table for the terminal. Lengths in mm, areas in mm².

use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// What is known of a part before anything is meshed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Inspection {
    /// The file that was read.
    pub input: String,
    /// What the user should know of how the file was read: an assumed unit, an absurd size.
    pub notes: Vec<String>,
    /// Its solids, in the order of the file.
    pub solids: Vec<SolidFacts>,
}

/// One solid.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SolidFacts {
    /// Its number in the file.
    pub tag: i32,
    /// Its name in the file, if any.
    pub name: Option<String>,
    /// Edge lengths of the box along the axes, mm.
    pub extent: [f64; 3],
    /// Volume, mm³.
    pub volume: f64,
    /// Area of the boundary, mm².
    pub area: f64,
    /// How many faces there are of each kind of surface (plane, cylinder...).
    pub faces_by_kind: BTreeMap<String, usize>,
    /// How many faces play each role (wall side, lateral, blend, lump).
    pub faces_by_role: BTreeMap<String, usize>,
    /// The walls, in order of their ids.
    pub walls: Vec<WallFacts>,
    /// How much wall area has which thickness.
    pub histogram: Vec<ThicknessBin>,
    /// How many sheets the mid-surface has: its pieces between rims, creases and junction curves.
    pub sheets: usize,
    /// These sheets, in order of their numbers, the largest first.
    pub sheet_list: Vec<SheetFacts>,
    /// How many junction curves: chains of edges where three sheets or more meet, from one end or fork to the next.
    pub junctions: usize,
    /// How many lumps, places too thick for a shell: groups of neighbouring faces that belong to no wall, rim or blend.
    pub lumps: usize,
}

/// One sheet of the mid-surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SheetFacts {
    /// Its number, from 1 over all solids: as the outputs of `midshell mesh` have it (`sheet` in VTU files, SHEET_n in decks), and size files.
    pub sheet: u32,
    /// The number of the wall that it is the middle of.
    pub wall: u32,
    /// Its area, mm².
    pub area: f64,
    /// Mean thickness of its wall, mm.
    pub thickness: f64,
    /// Its centre of area, mm.
    pub centre: [f64; 3],
}

/// One wall: two sides of faces with material between them.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct WallFacts {
    /// Its number, from 1 over all solids: as VTU files have it.
    pub wall: u32,
    /// The group of walls whose face pairs hang together.
    pub group: u32,
    /// Tags of the faces on either side.
    pub sides: [Vec<i32>; 2],
    /// Area of its mid-surface, mm².
    pub area: f64,
    /// Least thickness, mm.
    pub least: f64,
    /// Mean thickness, mm.
    pub mean: f64,
    /// Greatest thickness, mm.
    pub greatest: f64,
    /// The face pairs that it is made of.
    pub pairs: Vec<PairFacts>,
}

/// Two faces that face each other across a wall.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PairFacts {
    /// Their tags.
    pub faces: [i32; 2],
    /// Area that they see of each other, mm².
    pub area: f64,
    /// Least thickness, mm.
    pub least: f64,
    /// Mean thickness, mm.
    pub mean: f64,
    /// Greatest thickness, mm.
    pub greatest: f64,
}

/// A thickness counts as constant within this share of its mean: sheet metal is rolled to about 2 %.
const CONSTANT_WITHIN: f64 = 0.02;

impl WallFacts {
    /// Whether one number is enough to say how thick the wall is.
    pub fn is_constant(&self) -> bool {
        self.greatest - self.least <= CONSTANT_WITHIN * self.mean
    }
}

/// A class of the thickness histogram.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ThicknessBin {
    /// Lower bound, mm, within the class.
    pub from: f64,
    /// Upper bound, mm, outside the class.
    pub to: f64,
    /// Share of the wall area, 0 to 1.
    pub share: f64,
}

/// Most classes that a histogram has: a terminal's height.
const MOST_BINS: f64 = 16.0;
/// A class is a peak if it holds at least this share of the area: less is no gauge that a designer chose.
const PEAK_SHARE: f64 = 0.05;

/// The histogram of samples (thickness in mm, area that it stands for). Class bounds are round numbers; samples that are not finite or not positive are left out.
pub fn thickness_histogram(samples: &[(f64, f64)]) -> Vec<ThicknessBin> {
    let good = || {
        samples
            .iter()
            .filter(|(t, a)| t.is_finite() && *t > 0.0 && a.is_finite() && *a > 0.0)
    };
    let total: f64 = good().map(|s| s.1).sum();
    let least = good().map(|s| s.0).fold(f64::INFINITY, f64::min);
    let greatest = good().map(|s| s.0).fold(0.0, f64::max);
    if total <= 0.0 {
        return Vec::new();
    }
    // A wall of one thickness still needs a width: a tenth of it keeps its class narrow.
    let width = round_up_1_2_5(((greatest - least) / MOST_BINS).max(greatest / 10.0));
    // Classes are centred on the multiples of the width, so that 2.0 mm with rounding noise stays in one class.
    let class = |t: f64| (t / width).round() as i64;
    let first = class(least);
    let mut areas = vec![0.0; (class(greatest) - first + 1) as usize];
    for (t, a) in good() {
        areas[(class(*t) - first) as usize] += a;
    }
    areas
        .iter()
        .enumerate()
        .map(|(i, area)| {
            let centre = (first + i as i64) as f64 * width;
            ThicknessBin {
                from: (centre - 0.5 * width).max(0.0),
                to: centre + 0.5 * width,
                share: area / total,
            }
        })
        .collect()
}

/// The classes that stand above both neighbours: the gauges that the part is made in.
pub fn thickness_peaks(bins: &[ThicknessBin]) -> Vec<ThicknessBin> {
    let share = |i: Option<usize>| i.and_then(|i| bins.get(i)).map_or(0.0, |b| b.share);
    (0..bins.len())
        .filter(|&i| {
            bins[i].share >= PEAK_SHARE
                && bins[i].share >= share(i.checked_sub(1))
                && bins[i].share > share(Some(i + 1))
        })
        .map(|i| bins[i])
        .collect()
}

/// The least of 1, 2, 5 times a power of ten that is not below `x`.
fn round_up_1_2_5(x: f64) -> f64 {
    let power = 10f64.powf(x.log10().floor());
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|step| step * power)
        .find(|&candidate| candidate >= x)
        .unwrap_or(10.0 * power)
}

/// Cells of a histogram's longest bar.
const BAR_CELLS: f64 = 40.0;
/// Rows of the table of walls, and of that of sheets, before it is cut; the JSON has them all.
const TABLE_ROWS: usize = 24;

impl fmt::Display for Inspection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.solids.len();
        writeln!(
            f,
            "{}: {count} solid{}",
            self.input,
            if count == 1 { "" } else { "s" }
        )?;
        for note in &self.notes {
            writeln!(f, "note: {note}")?;
        }
        for solid in &self.solids {
            writeln!(f)?;
            solid.fmt(f)?;
        }
        Ok(())
    }
}

impl SolidFacts {
    fn table_of_sheets(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "  {:>5}  {:>5}  {:>10}  {:>12}  centre",
            "sheet", "wall", "area mm2", "thickness mm"
        )?;
        for sheet in self.sheet_list.iter().take(TABLE_ROWS) {
            let [x, y, z] = sheet.centre;
            writeln!(
                f,
                "  {:>5}  {:>5}  {:>10.1}  {:>12.3}  {x:.2}, {y:.2}, {z:.2}",
                sheet.sheet, sheet.wall, sheet.area, sheet.thickness
            )?;
        }
        if let Some(more) = (self.sheet_list.len())
            .checked_sub(TABLE_ROWS)
            .filter(|n| *n > 0)
        {
            writeln!(f, "  ... and {more} sheets more (see --json)")?;
        }
        Ok(())
    }
}

impl fmt::Display for SolidFacts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.extent;
        write!(f, "solid {}", self.tag)?;
        if let Some(name) = &self.name {
            write!(f, " '{name}'")?;
        }
        writeln!(f)?;
        let rows = [
            ("box", format!("{x:.3} x {y:.3} x {z:.3} mm")),
            ("volume", format!("{:.1} mm3", self.volume)),
            ("area", format!("{:.1} mm2", self.area)),
            ("faces", counts(&self.faces_by_kind)),
            ("roles", counts(&self.faces_by_role)),
            ("sheets", self.sheets.to_string()),
            ("junctions", self.junctions.to_string()),
            ("lumps", self.lumps.to_string()),
        ];
        for (name, value) in rows {
            writeln!(f, "  {name:<9}  {value}")?;
        }
        if self.walls.is_empty() {
            return writeln!(f, "  no thin wall: there is nothing to put a shell on");
        }
        writeln!(
            f,
            "  {:>5}  {:>5}  {:>10}  {:>27}  {:<8}  faces on either side",
            "wall", "group", "area mm2", "thickness min/mean/max mm", ""
        )?;
        for wall in self.walls.iter().take(TABLE_ROWS) {
            writeln!(
                f,
                "  {:>5}  {:>5}  {:>10.1}  {:>27}  {:<8}  {} | {}",
                wall.wall,
                wall.group,
                wall.area,
                format!(
                    "{:.3} / {:.3} / {:.3}",
                    wall.least, wall.mean, wall.greatest
                ),
                if wall.is_constant() {
                    "constant"
                } else {
                    "varying"
                },
                tags(&wall.sides[0]),
                tags(&wall.sides[1]),
            )?;
        }
        if self.walls.len() > TABLE_ROWS {
            writeln!(
                f,
                "  ... and {} walls more (see --json)",
                self.walls.len() - TABLE_ROWS
            )?;
        }
        self.table_of_sheets(f)?;
        let peaks = thickness_peaks(&self.histogram);
        let tallest = self.histogram.iter().map(|b| b.share).fold(0.0, f64::max);
        if tallest > 0.0 {
            writeln!(f, "  thickness (mm) by share of the wall area, * a peak")?;
        }
        for bin in &self.histogram {
            let cells = (bin.share / tallest * BAR_CELLS).round() as usize;
            writeln!(
                f,
                "  {:>9.3} .. {:<9.3} {:>5.1} % {} {}",
                bin.from,
                bin.to,
                100.0 * bin.share,
                if peaks.contains(bin) { '*' } else { ' ' },
                "#".repeat(cells)
            )?;
        }
        Ok(())
    }
}

fn counts(map: &BTreeMap<String, usize>) -> String {
    if map.is_empty() {
        return "-".into();
    }
    let items: Vec<String> = map.iter().map(|(name, n)| format!("{n} {name}")).collect();
    items.join(", ")
}

/// Face tags of one side, cut after a handful: a freeform side may have hundreds.
fn tags(side: &[i32]) -> String {
    let shown: Vec<String> = side.iter().take(6).map(i32::to_string).collect();
    let more = if side.len() > 6 { " ..." } else { "" };
    format!("{}{more}", shown.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_gauges_give_two_peaks_and_all_the_area() {
        let samples = [(1.0, 30.0), (1.0001, 30.0), (6.0, 39.0), (3.0, 1.0)];
        let bins = thickness_histogram(&samples);
        let total: f64 = bins.iter().map(|b| b.share).sum();
        assert!((total - 1.0).abs() < 1e-12);
        assert!(bins.len() <= 17, "{}", bins.len());
        let peaks = thickness_peaks(&bins);
        assert_eq!(peaks.len(), 2, "{bins:?}");
        assert!(peaks[0].from < 1.0 && 1.0 < peaks[0].to && (peaks[0].share - 0.6).abs() < 1e-12);
        assert!(peaks[1].from < 6.0 && 6.0 < peaks[1].to);
    }

    #[test]
    fn noise_round_one_gauge_is_one_class_at_any_scale() {
        for scale in [1e-3, 1.0, 1e3] {
            let samples: Vec<(f64, f64)> = (0..100)
                .map(|i| (scale * (2.0 + 1e-6 * (i as f64 - 50.0)), 1.0))
                .collect();
            assert_eq!(thickness_histogram(&samples).len(), 1, "{scale}");
        }
    }

    #[test]
    fn samples_that_mean_nothing_are_left_out() {
        assert!(thickness_histogram(&[]).is_empty());
        assert!(thickness_histogram(&[(f64::NAN, 1.0), (0.0, 1.0), (1.0, 0.0)]).is_empty());
        assert_eq!(
            thickness_histogram(&[(f64::INFINITY, 1.0), (2.0, 1.0)]).len(),
            1
        );
    }

    #[test]
    fn steps_are_round_numbers() {
        for (x, want) in [
            (0.9, 1.0),
            (1.0, 1.0),
            (1.1, 2.0),
            (3.0, 5.0),
            (7.0, 10.0),
            (0.03, 0.05),
        ] {
            assert!((round_up_1_2_5(x) - want).abs() < 1e-12 * want, "{x}");
        }
    }

    #[test]
    fn a_wedge_is_varying_and_a_rolled_sheet_is_not() {
        let wall = |least, mean, greatest| WallFacts {
            least,
            mean,
            greatest,
            ..WallFacts::default()
        };
        assert!(wall(1.99, 2.0, 2.01).is_constant());
        assert!(!wall(1.0, 2.0, 3.0).is_constant());
    }

    #[test]
    fn the_table_names_walls_thickness_and_peaks() {
        let solid = SolidFacts {
            tag: 7,
            walls: vec![WallFacts {
                wall: 0,
                sides: [vec![1, 2], vec![9]],
                area: 10.0,
                least: 1.0,
                mean: 1.5,
                greatest: 2.0,
                ..WallFacts::default()
            }],
            histogram: thickness_histogram(&[(1.5, 1.0)]),
            sheet_list: vec![SheetFacts {
                sheet: 4,
                wall: 9,
                area: 12.5,
                thickness: 1.5,
                centre: [1.0, -2.0, 0.25],
            }],
            ..SolidFacts::default()
        };
        let text = Inspection {
            input: "part.step".into(),
            notes: vec!["seen".into()],
            solids: vec![solid],
        }
        .to_string();
        for want in [
            "part.step: 1 solid\nnote: seen\n",
            "solid 7",
            "1.000 / 1.500 / 2.000",
            "varying",
            "1 2 | 9",
            "    4      9        12.5         1.500  1.00, -2.00, 0.25\n",
            "100.0 % * ####",
        ] {
            assert!(text.contains(want), "{want} not in\n{text}");
        }
    }
}
