//! What a run says of its own result.

use super::memory::PeakMemory;
use super::midsurface::MidSurface;
use crate::model::brep::Brep;
use crate::model::keep::KeptEdge;
use crate::model::removal::{Left, Removal, SmallKind};
use crate::model::report::{AuditReport, QualityReport};
use crate::model::shell::ShellMesh;
use crate::model::walls::ThicknessPeak;
use crate::model::washer::Washers;
use crate::report_text;
use serde::Serialize;
use std::fmt;
use std::path::PathBuf;

/// One solid of the part.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SolidReport {
    /// Its number in the file.
    pub tag: i32,
    /// How many faces bound it.
    pub faces: usize,
    /// How many walls were found.
    pub walls: usize,
    /// How many sheets its mid-surface has.
    pub sheets: usize,
    /// The thicknesses that it is made of, greatest share first.
    pub peaks: Vec<ThicknessPeak>,
    /// Edge length wanted on its flat walls, mm.
    pub size: f64,
    /// Least width of a wall, in thicknesses, that the chosen mid-surface was found with.
    pub least_width: f64,
    /// The washers, where such are asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub washers: Option<Washers>,
    /// What became of the edges that were to be kept, and of those that had to be kept with them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub kept_edges: Vec<KeptEdge>,
}

impl SolidReport {
    pub(super) fn new(brep: &Brep, found: &MidSurface, size: f64, mesh: &ShellMesh) -> Self {
        Self {
            tag: brep.solid_tag,
            faces: brep.faces.len(),
            walls: found.pairing.walls.len(),
            sheets: mesh.sheets.len(),
            peaks: found.pairing.peaks.clone(),
            size,
            least_width: found.least_width,
            washers: None,
            kept_edges: Vec::new(),
        }
    }
}

/// What a run says of its own result.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RunReport {
    /// The file that was read.
    pub input: PathBuf,
    /// Version of the gmsh that read it.
    pub gmsh_version: String,
    /// The way by which import succeeded: which mesher, and what was done to the part.
    pub import_way: String,
    /// What import tried without success before it succeeded.
    pub import_attempts: Vec<String>,
    /// What the user should know of how the file was read: an assumed unit, an absurd size.
    pub notes: Vec<String>,
    /// The solids.
    pub solids: Vec<SolidReport>,
    /// What was small enough to be taken out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub removed: Vec<Removal>,
    /// What was small enough and stays.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left: Vec<Left>,
    /// Element quality.
    pub quality: Option<QualityReport>,
    /// The self-audit.
    pub audit: Option<AuditReport>,
    /// The most memory that it took.
    pub peak_memory: PeakMemory,
    /// What the audit holds against the result; nothing where it is right.
    pub doubts: Vec<String>,
}

impl RunReport {
    pub(super) fn new(
        solids: Vec<SolidReport>,
        quality: QualityReport,
        audit: AuditReport,
    ) -> Self {
        let doubts = audit.doubts().iter().map(ToString::to_string).collect();
        Self {
            solids,
            quality: Some(quality),
            audit: Some(audit),
            doubts,
            ..Self::default()
        }
    }
}

impl fmt::Display for RunReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.input.display())?;
        for note in &self.notes {
            writeln!(f, "note: {note}")?;
        }
        if self.import_way.contains("fTetWild") {
            writeln!(
                f,
                "note: gmsh could not fill the part; filled by {}",
                self.import_way
            )?;
        }
        for s in &self.solids {
            let peaks: Vec<String> = s
                .peaks
                .iter()
                .map(|p| format!("{:.3} mm ({:.0} %)", p.thickness, 100.0 * p.share))
                .collect();
            writeln!(
                f,
                "solid {}: {}, {}, {}, edge length {:.3} mm, thickness {}",
                s.tag,
                counted(s.faces, "face"),
                counted(s.walls, "wall"),
                counted(s.sheets, "sheet"),
                s.size,
                peaks.join(", ")
            )?;
            for kept in &s.kept_edges {
                let [a, b] = kept.faces;
                let edges = counted(kept.edges, "element edge");
                writeln!(f, "kept edge {a}-{b}: {edges}, {:.3} mm", kept.length)?;
            }
            if let Some(washers) = &s.washers {
                f.write_str(&report_text::washers(washers))?;
            }
        }
        for r in &self.removed {
            let (x, y, z) = (r.at.x, r.at.y, r.at.z);
            let what = match r.kind {
                SmallKind::Hole => format!("filled hole of diameter {:.3} mm", r.size),
                SmallKind::Feature => format!(
                    "flattened feature of {:.3} mm, {:.3} mm high or deep",
                    r.size, r.height
                ),
            };
            let sheet = r.sheet.map_or(String::new(), |s| format!(", sheet {s}"));
            writeln!(
                f,
                "{what} at ({x:.3}, {y:.3}, {z:.3}), solid {}{sheet}",
                r.solid
            )?;
        }
        for l in &self.left {
            let (x, y, z) = (l.at.x, l.at.y, l.at.z);
            let what = match l.kind {
                SmallKind::Hole => "hole",
                SmallKind::Feature => "feature",
            };
            let size = l.size;
            writeln!(
                f,
                "left {what} of {size:.3} mm at ({x:.3}, {y:.3}, {z:.3}): {}",
                l.why
            )?;
        }
        if let (Some(audit), Some(quality)) = (&self.audit, &self.quality) {
            write!(f, "\n{}", report_text::render(audit, quality))?;
        }
        Ok(())
    }
}

fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::removal::Obstacle;
    use crate::model::report::Profile;
    use crate::stage::{audit, quality};
    use glam::DVec3;

    #[test]
    fn a_report_tells_of_its_solids_and_of_nothing_that_was_not_measured() {
        let report = RunReport {
            input: "part.step".into(),
            solids: vec![SolidReport {
                tag: 3,
                faces: 6,
                walls: 1,
                sheets: 1,
                peaks: vec![ThicknessPeak {
                    thickness: 2.0,
                    share: 0.98,
                }],
                size: 6.0,
                ..SolidReport::default()
            }],
            ..RunReport::default()
        };
        assert_eq!(
            report.to_string(),
            "part.step\nsolid 3: 6 faces, 1 wall, 1 sheet, edge length 6.000 mm, thickness 2.000 mm (98 %)\n"
        );
        let mut kept = report.clone();
        kept.solids[0].kept_edges = vec![KeptEdge {
            faces: [4, 8],
            edges: 1,
            length: 2.5,
        }];
        assert!((kept.to_string()).ends_with("kept edge 4-8: 1 element edge, 2.500 mm\n"));
        let told = RunReport {
            removed: vec![Removal {
                kind: SmallKind::Feature,
                solid: 3,
                at: DVec3::new(1.0, 2.0, 3.5),
                size: 4.0,
                height: 0.25,
                faces: vec![7],
                sheet: Some(2),
            }],
            left: vec![Left {
                kind: SmallKind::Hole,
                solid: 3,
                at: DVec3::X,
                size: 5.0,
                why: Obstacle::End,
            }],
            ..report.clone()
        };
        assert!(told.to_string().ends_with(
            "flattened feature of 4.000 mm, 0.250 mm high or deep at (1.000, 2.000, 3.500), solid 3, sheet 2\n\
             left hole of 5.000 mm at (1.000, 0.000, 0.000): it is the end of a wall, not a hole in one\n"
        ));
        let audited = RunReport {
            audit: Some(audit::audit(&[], &ShellMesh::default(), 1)),
            quality: Some(quality::quality(
                &ShellMesh::default(),
                &Profile::shell(),
                None,
            )),
            ..report
        };
        assert!(audited.to_string().contains("walls covered"));
    }
}
