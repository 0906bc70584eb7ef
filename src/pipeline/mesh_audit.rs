//! Audits a mesh that is already there, whoever made it: quality, how it hangs together, and, where its solid is given, the mesh against the solid.

use super::clock::Clock;
use super::error::PipelineError;
use super::seen::Seen;
use super::{AUDIT_SEED, Progress, import_options};
use crate::export::{CellSet, MetricRow, render_cells, render_metrics};
use crate::import::import_cad_told;
use crate::model::brep::Brep;
use crate::model::ids::{Id, IndexVec};
use crate::model::mesh_audit::{
    ElementMetrics, FindingKind, FindingReport, Findings, Found, Located, MeshAuditReport,
};
use crate::model::report::{AuditLimits, AuditReport, Criterion};
use crate::model::shell::ShellMesh;
use crate::options::MeshOptions;
use crate::read::{MeshFormat, ReadMesh};
use crate::report_text::render_mesh_audit;
use crate::stage::{audit, findings, quality};
use glam::DVec3;
use std::collections::BTreeSet;
use std::path::Path;

/// Mesh and solid of one part differ in size by little: beyond this factor one of them is in another unit.
const OTHER_UNIT: f64 = 2.0;

/// What came of an audit.
#[derive(Clone, Debug)]
pub struct MeshAudit {
    /// What it says.
    pub report: MeshAuditReport,
    /// Seconds a stage, in order.
    pub timings: Vec<(String, f64)>,
    read: ReadMesh,
    table: Vec<ElementMetrics>,
}

/// Audits the mesh in a file, against a solid if one is named. Of the options the size is what the shortest edge is held against, if there is one; the profile
/// is what elements are held against; the rest concerns the solid.
pub fn audit_mesh(
    input: &Path,
    solid: Option<&Path>,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<MeshAudit, PipelineError> {
    options.check()?;
    let mut clock = Clock::new(progress);
    let (format, mut read) = clock.time("read", || read_mesh(input))?;
    let (profile, size) = (&options.profile, options.size);
    let quality = clock.time("quality", || quality::quality(&read.mesh, profile, size));
    let table = clock.time("quality", || quality::table(&read.mesh, profile, size));
    let found = clock.time("findings", || findings::findings(&read.mesh));
    if read.without_thickness > 0 {
        let left_out = match solid {
            Some(_) => ": thickness and mass are not held against the solid",
            None => "",
        };
        read.notes.push(format!(
            "{} of {} elements have no thickness in the file{left_out}",
            read.without_thickness,
            read.mesh.elements.len()
        ));
    }
    let against = match solid {
        Some(path) => Some(against_solid(
            path, &mut read, options, progress, &mut clock,
        )?),
        None => None,
    };
    let number = |e: &crate::model::report::WorstElement| read.element_numbers[e.element.index()];
    let mut report = MeshAuditReport {
        input: input.to_owned(),
        format: format.name(),
        notes: read.notes.clone(),
        without_thickness: read.without_thickness,
        sheets_named: read.sheets_named,
        worst_numbers: quality.worst.iter().map(number).collect(),
        quality,
        findings: findings_in_file(&found, &read),
        sheets: found.sheets,
        solid: solid.map(Path::to_owned),
        audit: against,
        faults: Vec::new(),
    };
    report.faults = faults(&report, &read);
    Ok(MeshAudit {
        report,
        timings: clock.finish(),
        read,
        table,
    })
}

impl MeshAudit {
    /// The report for a terminal.
    pub fn text(&self) -> String {
        render_mesh_audit(&self.report)
    }

    /// Every metric of every element as CSV.
    pub fn csv(&self) -> Vec<u8> {
        let rows: Vec<MetricRow<'_>> = (self.table.iter())
            .map(|metrics| {
                let element = &self.read.mesh.elements[metrics.element];
                MetricRow {
                    number: self.read.element_numbers[metrics.element.index()],
                    sheet: element.sheet.index() + 1,
                    thickness: element.mean_thickness(),
                    metrics,
                }
            })
            .collect();
        render_metrics(&rows)
    }

    /// The elements that break a criterion as VTU. Cell fields: `element` (its number in the file), `sheet`, `fails` (how many criteria), and for each criterion that any
    /// element breaks a field with its name, 1 where it is broken. No cell where no element fails.
    pub fn failing(&self) -> Vec<u8> {
        let mesh = &self.read.mesh;
        let failing: Vec<&ElementMetrics> =
            self.table.iter().filter(|m| !m.fails.is_empty()).collect();
        let mut place = IndexVec::filled(None, mesh.nodes.len());
        let mut set = CellSet {
            four_are_quads: true,
            ..CellSet::default()
        };
        for metrics in &failing {
            let corners = mesh.elements[metrics.element].corners;
            let cell = corners.as_slice().iter().map(|&node| {
                *place[node].get_or_insert_with(|| {
                    set.points.push(mesh.nodes[node]);
                    set.points.len() as u32 - 1
                })
            });
            set.cells.push(cell.collect());
        }
        let field = |value: &dyn Fn(&ElementMetrics) -> f64| -> Vec<f64> {
            failing.iter().map(|m| value(m)).collect()
        };
        let number = |m: &ElementMetrics| self.read.element_numbers[m.element.index()] as f64;
        let sheet = |m: &ElementMetrics| mesh.elements[m.element].sheet.index() as f64 + 1.0;
        set.fields.push(("element", field(&number)));
        set.fields.push(("sheet", field(&sheet)));
        set.fields.push(("fails", field(&|m| m.fails.len() as f64)));
        let criteria: BTreeSet<Criterion> =
            failing.iter().flat_map(|m| &m.fails).copied().collect();
        for criterion in criteria {
            let broken = |m: &ElementMetrics| f64::from(u8::from(m.fails.contains(&criterion)));
            set.fields.push((criterion.code(), field(&broken)));
        }
        render_cells(&set)
    }
}

fn read_mesh(path: &Path) -> Result<(MeshFormat, ReadMesh), PipelineError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    let format = MeshFormat::from_extension(&extension);
    let unreadable = |cause| PipelineError::NoMeshFile {
        path: path.to_owned(),
        cause,
    };
    // A missing file is told as such, whatever its name.
    std::fs::metadata(path).map_err(unreadable)?;
    let format = format.ok_or_else(|| PipelineError::UnknownMesh {
        path: path.to_owned(),
        extension: extension.into_owned(),
    })?;
    let bytes = std::fs::read(path).map_err(unreadable)?;
    let read = format
        .parse(&bytes)
        .map_err(|cause| PipelineError::BadMesh {
            path: path.to_owned(),
            format,
            cause,
        })?;
    Ok((format, read))
}

fn against_solid(
    path: &Path,
    read: &mut ReadMesh,
    options: &MeshOptions,
    progress: &dyn Progress,
    clock: &mut Clock<'_>,
) -> Result<AuditReport, PipelineError> {
    let imported = clock.time("import", || {
        import_cad_told(path, &import_options(options), &mut |line| {
            progress.stage(&format!("import: {line}"));
        })
    })?;
    read.notes.extend(imported.notes);
    // Seen as a run sees its own solid: divided faces tell the two sides of a wall apart.
    let pieces: Vec<Seen> = (imported.pieces.into_iter())
        .map(|piece| Seen::new(piece, clock))
        .collect();
    let breps: Vec<&Brep> = pieces.iter().map(|p| &p.piece.brep).collect();
    let corners = breps.iter().flat_map(|b| b.vertices.iter());
    let (solid, mesh) = (diagonal(corners), diagonal(read.mesh.nodes.iter()));
    if mesh > OTHER_UNIT * solid || solid > OTHER_UNIT * mesh {
        read.notes.push(format!(
            "the mesh measures {mesh:.4} corner to corner, the solid {solid:.4} mm: see that both are in mm"
        ));
    }
    Ok(clock.time("audit", || audit_of(&breps, read)))
}

/// Without thickness the mesh is measured as one of the solid's usual thickness, and thickness and mass are left out.
fn audit_of(breps: &[&Brep], read: &ReadMesh) -> AuditReport {
    if read.without_thickness == 0 {
        return audit::audit(breps, &read.mesh, AUDIT_SEED);
    }
    let limits = AuditLimits {
        thickness_error: f64::INFINITY,
        mass: f64::INFINITY,
        ..AuditLimits::default()
    };
    let with = |thickness: f64| {
        let mut mesh: ShellMesh = read.mesh.clone();
        for element in mesh.elements.iter_mut() {
            for t in element.thickness.iter_mut().filter(|t| t.is_nan()) {
                *t = thickness;
            }
        }
        audit::audit_with(breps, &mesh, AUDIT_SEED, limits)
    };
    // The usual thickness is measured on the solid alone: any will do to ask for it.
    let mut report = with(1.0);
    if let Some(usual) = report.thickness_median {
        report = with(usual);
    }
    report.thickness_error = None;
    report.mass = f64::NAN;
    report.mass_once = f64::NAN;
    report
}

fn diagonal<'a>(points: impl Iterator<Item = &'a DVec3>) -> f64 {
    let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [low, high] = points.fold(none, |[l, h], &p| [l.min(p), h.max(p)]);
    (high - low).max(DVec3::ZERO).length()
}

fn findings_in_file(found: &Findings, read: &ReadMesh) -> Vec<FindingReport> {
    let located = |f: &Found| Located {
        at: f.at,
        nodes: f
            .nodes
            .iter()
            .map(|n| read.node_numbers[n.index()])
            .collect(),
        elements: (f.elements.iter())
            .map(|e| read.element_numbers[e.index()])
            .collect(),
    };
    FindingKind::ALL
        .into_iter()
        .map(|kind| {
            let of = found.of(kind);
            FindingReport {
                kind,
                fault: kind.is_fault(),
                meaning: kind.meaning(),
                remedy: kind.remedy(),
                count: of.len(),
                places: of.iter().map(located).collect(),
            }
        })
        .collect()
}

/// What speaks against the mesh, one line each.
fn faults(report: &MeshAuditReport, read: &ReadMesh) -> Vec<String> {
    let quality = &report.quality;
    let mut faults = Vec::new();
    for (criterion, count) in &quality.failures {
        faults.push(format!(
            "{}: {count} of {} elements break this limit of profile '{}'",
            criterion.code(),
            quality.elements,
            quality.profile.name
        ));
    }
    let share = 1.0 - quality.quad_share;
    if quality.quads > 0 && share > quality.profile.triangle_share_max {
        faults.push(format!(
            "triangles: {:.2} % of the elements, at most {:.2} % in profile '{}'",
            100.0 * share,
            100.0 * quality.profile.triangle_share_max,
            quality.profile.name
        ));
    }
    let bad = |t: &f64| *t <= 0.0 || t.is_infinite();
    let thin = (read.mesh.elements.iter())
        .filter(|e| e.thickness.iter().any(bad))
        .count();
    if thin > 0 {
        faults.push(format!(
            "thickness: {thin} elements have one that is not finite and positive"
        ));
    }
    for finding in report.findings.iter().filter(|f| f.fault && f.count > 0) {
        faults.push(format!(
            "{}: {}, {}",
            finding.kind.code(),
            finding.count,
            finding.meaning
        ));
    }
    let doubts = report.audit.iter().flat_map(|a| a.doubts());
    faults.extend(doubts.map(ToString::to_string));
    faults
}
