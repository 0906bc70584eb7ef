//! The report on a mesh that was audited, for a terminal.

use super::{audit_table, line, number, quality_table, verdict_line, words, wrapped};
use crate::model::mesh_audit::{FindingReport, MeshAuditReport};

/// Places of a finding that are told; the JSON has them all.
const PLACES: usize = 3;
/// Sheets that are told one by one; the JSON has them all.
const SHEETS: usize = 12;

/// Verdict, findings, quality with the worst elements, normals by sheet, and the audit against the solid where there was one.
pub fn render_mesh_audit(report: &MeshAuditReport) -> String {
    let mut out = String::new();
    head(&mut out, report);
    out.push('\n');
    findings(&mut out, report);
    out.push('\n');
    normals(&mut out, report);
    out.push('\n');
    quality_table(&mut out, &report.quality);
    worst(&mut out, report);
    if let (Some(solid), Some(audit)) = (&report.solid, &report.audit) {
        line(&mut out, format_args!("\nagainst {}", solid.display()));
        line(
            &mut out,
            format_args!("{}\n", verdict_line(audit, &report.quality)),
        );
        audit_table(&mut out, audit);
    }
    out
}

fn head(out: &mut String, report: &MeshAuditReport) {
    let quality = &report.quality;
    line(
        out,
        format_args!("{} ({})", report.input.display(), report.format),
    );
    for note in &report.notes {
        for (k, part) in wrapped(note).into_iter().enumerate() {
            let lead = if k == 0 { "note: " } else { "      " };
            line(out, format_args!("{lead}{part}"));
        }
    }
    let verdict = if report.faults.is_empty() {
        "sound"
    } else {
        "doubted"
    };
    line(
        out,
        format_args!(
            "{verdict}: {} nodes, {} elements ({} quads, {} triangles), {} sheets, area {}",
            quality.nodes,
            quality.elements,
            quality.quads,
            quality.triangles,
            report.sheets.len(),
            number(quality.area)
        ),
    );
    for fault in &report.faults {
        for (k, part) in wrapped(fault).into_iter().enumerate() {
            let lead = if k == 0 { "  ! " } else { "    " };
            line(out, format_args!("{lead}{part}"));
        }
    }
}

fn findings(out: &mut String, report: &MeshAuditReport) {
    line(out, format_args!("{:<24} {:>9}", "found", "count"));
    for finding in &report.findings {
        let mark = if finding.fault && finding.count > 0 {
            '!'
        } else {
            ' '
        };
        let name = finding.kind.code().replace('-', " ");
        line(out, format_args!("{mark} {name:<22} {:>9}", finding.count));
        // Free edges and junctions are on every part: their places are for the JSON.
        if finding.fault {
            places(out, finding);
        }
    }
}

fn places(out: &mut String, finding: &FindingReport) {
    for place in finding.places.iter().take(PLACES) {
        let [x, y, z] = place.at.to_array().map(number);
        let list = |what: &str, numbers: &[u64]| match numbers {
            [] => String::new(),
            some => {
                let few: Vec<String> = some.iter().take(4).map(u64::to_string).collect();
                let more = if some.len() > 4 { " ..." } else { "" };
                format!(", {what} {}{more}", few.join(" "))
            }
        };
        let (nodes, elements) = (
            list("nodes", &place.nodes),
            list("elements", &place.elements),
        );
        for part in wrapped(&format!("at ({x}, {y}, {z}){nodes}{elements}")) {
            line(out, format_args!("    {part}"));
        }
    }
}

fn normals(out: &mut String, report: &MeshAuditReport) {
    line(
        out,
        format_args!(
            "{:>7} {:>9} {:>12} {:>16} {:>10}",
            "sheet", "elements", "area", "opposite edges", "to turn"
        ),
    );
    // The sheets with something to tell come first.
    let mut sheets: Vec<_> = report.sheets.iter().collect();
    sheets.sort_by_key(|s| (s.opposite_edges == 0, s.sheet));
    for sheet in sheets.iter().take(SHEETS) {
        let one_sided = if sheet.one_sided { "  one-sided" } else { "" };
        line(
            out,
            format_args!(
                "{:>7} {:>9} {:>12} {:>16} {:>10}{one_sided}",
                sheet.sheet,
                sheet.elements,
                number(sheet.area),
                sheet.opposite_edges,
                sheet.turned
            ),
        );
    }
    if sheets.len() > SHEETS {
        let more = sheets.len() - SHEETS;
        line(
            out,
            format_args!("  ... and {more} sheets more (see --json)"),
        );
    }
}

fn worst(out: &mut String, report: &MeshAuditReport) {
    line(
        out,
        format_args!("{:<12} {:>9} {:>9}   at", "worst", "jacobian", "edges"),
    );
    for (worst, file) in report.quality.worst.iter().zip(&report.worst_numbers) {
        let [x, y, z] = worst.centre.to_array().map(number);
        let fails: Vec<String> = worst.fails.iter().map(words).collect();
        let fails = if fails.is_empty() {
            String::new()
        } else {
            format!("  fails {}", fails.join(", "))
        };
        line(
            out,
            format_args!(
                "{file:>12} {:>9} {:>9}   ({x}, {y}, {z}){fails}",
                number(worst.scaled_jacobian),
                number(worst.edge_ratio)
            ),
        );
    }
}
