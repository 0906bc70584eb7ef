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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::mesh_audit::{FindingKind, Located, SheetNormals};
    use crate::model::report::Profile;
    use crate::stage::quality::quality;
    use crate::test_parts::plate_mesh;
    use glam::DVec3;

    fn report(found: usize) -> MeshAuditReport {
        let quality = quality(&plate_mesh(20, 12), &Profile::shell(), None);
        let place = Located {
            at: DVec3::new(-123_456.7, 0.000_123, 98_765.4),
            nodes: vec![123_456_789; 9],
            elements: vec![987_654_321; 9],
        };
        let finding = |kind: FindingKind| FindingReport {
            kind,
            fault: kind.is_fault(),
            meaning: kind.meaning(),
            remedy: kind.remedy(),
            count: found,
            places: vec![place.clone(); found],
        };
        let sheet = |sheet| SheetNormals {
            sheet,
            elements: 12,
            area: 300.0,
            opposite_edges: usize::from(sheet == 19),
            turned: 1,
            one_sided: sheet == 19,
        };
        MeshAuditReport {
            input: "door.bdf".into(),
            format: "Nastran deck",
            notes: vec!["a note ".repeat(30)],
            without_thickness: 0,
            sheets_named: false,
            worst_numbers: (1001..=1010).collect(),
            quality,
            findings: FindingKind::ALL.map(finding).to_vec(),
            sheets: (1..=20).map(sheet).collect(),
            solid: None,
            audit: None,
            faults: vec!["t-connections: they were found ".repeat(8); found.min(1)],
        }
    }

    #[test]
    fn a_sound_mesh_is_called_so_and_a_doubted_one_says_where() {
        let sound = render_mesh_audit(&report(0));
        assert!(
            sound.contains("\nsound: 273 nodes, 240 elements (240 quads, 0 triangles), 20 sheets")
        );
        assert!(!sound.contains('!') && !sound.contains("at (-"));
        // The numbers of the file, not places in a list.
        assert!(sound.contains("\n        1001         1         1   ("));
        let doubted = render_mesh_audit(&report(5));
        assert!(doubted.contains("\ndoubted: 273 nodes"));
        // Three places of each kind that is a fault.
        assert_eq!(doubted.matches("at (-123457, ").count(), 3 * 5, "{doubted}");
        assert!(
            doubted.contains("! t connections                  5"),
            "{doubted}"
        );
        assert!(
            doubted.contains("  free edges                     5"),
            "{doubted}"
        );
    }

    #[test]
    fn lines_fit_a_terminal_and_what_is_odd_comes_first() {
        let text = render_mesh_audit(&report(5));
        for line in text.lines() {
            assert!(
                line.chars().count() <= 100 && !line.ends_with(' '),
                "{line}"
            );
        }
        let of_sheets: Vec<&str> = text
            .lines()
            .skip_while(|l| !l.contains("to turn"))
            .collect();
        assert!(of_sheets[1].starts_with("     19") && of_sheets[1].ends_with("one-sided"));
        assert!(text.contains("and 8 sheets more"));
    }
}
