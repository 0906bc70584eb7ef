//! What a run says of its own result.

use super::memory::PeakMemory;
use super::midsurface::MidSurface;
use crate::model::brep::Brep;
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
            if let Some(washers) = &s.washers {
                f.write_str(&report_text::washers(washers))?;
            }
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
    use crate::model::report::Profile;
    use crate::stage::{audit, quality};

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
