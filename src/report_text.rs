//! The reports as text for a terminal: a verdict, why, and the figures.
//!
//! Plain text, no colour, no more than 100 columns. Nothing here measures or decides.

mod mesh_audit;
mod washers;

pub use mesh_audit::render_mesh_audit;
pub use washers::washers;

use crate::model::report::{
    AuditReport, Criterion, DoubtRule, MetricSummary, QualityReport, Verdict,
};
use std::fmt::Write;

/// Widest line of the explanations.
const WIDTH: usize = 96;

/// Places of a doubt that are told: enough to begin with, and no wall of numbers.
const PLACES: usize = 3;

/// The verdict in one line, the doubts with what they mean, and two tables.
pub fn render(audit: &AuditReport, quality: &QualityReport) -> String {
    let mut out = verdict_line(audit, quality);
    out.push('\n');
    for doubt in audit.doubts() {
        let (value, limit) = (number(doubt.value), number(doubt.limit));
        let comparison = match doubt.rule {
            DoubtRule::Euler | DoubtRule::Pieces | DoubtRule::Voids => {
                format!("{value}, the solid has {limit}")
            }
            DoubtRule::Cover => format!("{value}, at least {limit} expected"),
            DoubtRule::Unmeasured => "nothing".to_owned(),
            _ => format!("{value}, at most {limit} expected"),
        };
        line(
            &mut out,
            format_args!("  ! {}: {comparison}", doubt.rule.code()),
        );
        for sentence in [doubt.rule.meaning(), doubt.rule.remedy()] {
            for part in wrapped(sentence) {
                line(&mut out, format_args!("    {part}"));
            }
        }
        for place in doubt.places.iter().take(PLACES) {
            let text = format!("at {place}{}", many(place.count));
            for part in wrapped(&text) {
                line(&mut out, format_args!("    {part}"));
            }
        }
        if let Some(more) = doubt.place_count.checked_sub(PLACES).filter(|n| *n > 0) {
            let where_else = "the report (--json) and the field 'doubt' of a VTU file";
            line(
                &mut out,
                format_args!("    and {more} places more: {where_else}"),
            );
        }
    }
    out.push('\n');
    audit_table(&mut out, audit);
    out.push('\n');
    quality_table(&mut out, quality);
    worst_line(&mut out, quality);
    out
}

/// How many things a place is made of, where that says anything.
fn many(count: usize) -> String {
    if count > 1 {
        format!(" ({count} in all)")
    } else {
        String::new()
    }
}

/// The verdict in one line.
pub fn verdict_line(audit: &AuditReport, quality: &QualityReport) -> String {
    let verdict = match &audit.verdict {
        Verdict::Right => "right".to_owned(),
        Verdict::Doubted(doubts) => {
            let codes: Vec<&str> = doubts.iter().map(|d| d.rule.code()).collect();
            format!("doubted ({})", codes.join(", "))
        }
    };
    format!(
        "{verdict}: {} elements ({} quads, {} triangles), R-error {}, {} of the walls covered, {} good",
        quality.elements,
        quality.quads,
        quality.triangles,
        audit.r95.map_or("unknown".to_owned(), percent),
        percent(audit.cover),
        percent(quality.pass_share),
    )
}

fn audit_table(out: &mut String, audit: &AuditReport) {
    let limits = &audit.limits;
    let maybe = |v: Option<f64>| v.map_or("-".to_owned(), percent);
    let betti = |b: [usize; 3]| b.map(|n| n.to_string()).join(", ");
    let rows: [(&str, String, String); 16] = [
        (
            "Euler characteristic",
            audit.euler.to_string(),
            number(audit.euler_solid),
        ),
        ("pieces", audit.pieces.to_string(), audit.solids.to_string()),
        (
            "pieces, loops, voids over Z/2",
            audit.betti.map_or("not counted".to_owned(), betti),
            betti(audit.betti_solid),
        ),
        ("R-error, median", maybe(audit.r50), String::new()),
        ("R-error, 95 % of the mesh", maybe(audit.r95), String::new()),
        (
            "mesh off the middle",
            percent(audit.off_middle),
            format!("<= {}", percent(limits.off_middle_of(audit.judged_share))),
        ),
        (
            "walls covered",
            percent(audit.cover),
            format!(">= {}", percent(limits.cover)),
        ),
        (
            "mesh outside the solid",
            percent(audit.outside),
            format!("<= {}", percent(limits.outside)),
        ),
        (
            "free edges off the rim",
            percent(audit.free_off),
            format!("<= {}", percent(limits.free_off)),
        ),
        (
            "thickness error, median",
            maybe(audit.thickness_error),
            format!("<= {}", percent(limits.thickness_error)),
        ),
        (
            "wall thickness, median",
            audit
                .thickness_median
                .map_or("-".to_owned(), |t| format!("{} mm", number(t))),
            String::new(),
        ),
        ("material against volume", signed(audit.mass), String::new()),
        (
            "without junction overlaps",
            signed(audit.mass_once),
            format!("+- {}", percent(limits.mass)),
        ),
        (
            "area without a pair of faces",
            percent(audit.unsure_share),
            String::new(),
        ),
        (
            "flipped, misoriented, broken",
            format!(
                "{}, {}, {}",
                audit.flipped, audit.misoriented, audit.not_finite
            ),
            "0, 0, 0".to_owned(),
        ),
        (
            "nodes without element",
            audit.orphans.to_string(),
            "0".to_owned(),
        ),
    ];
    line(
        out,
        format_args!("{:<31} {:>14}   {}", "audit", "mesh", "expected"),
    );
    for (name, value, expected) in rows {
        line(out, format_args!("  {name:<29} {value:>14}   {expected}"));
    }
    let bins = audit.r_bins.map(percent);
    line(
        out,
        format_args!(
            "  R-error up to 0.5 %: {}, 1 %: {}, 10 %: {}, 20 %: {}, more: {}",
            bins[0], bins[1], bins[2], bins[3], bins[4]
        ),
    );
}

fn quality_table(out: &mut String, quality: &QualityReport) {
    line(
        out,
        format_args!(
            "{:<30} {:>9} {:>9} {:>9} {:>12}   {}",
            "quality", "least", "mean", "largest", "acceptable", "histogram"
        ),
    );
    for metric in &quality.metrics {
        line(
            out,
            format_args!(
                "  {:<28} {:>9} {:>9} {:>9} {:>12}   {}",
                metric.name,
                number(metric.min),
                number(metric.mean),
                number(metric.max),
                percent(metric.share_acceptable),
                bars(metric),
            ),
        );
    }
    line(
        out,
        format_args!(
            "  {} of the elements pass profile '{}'",
            percent(quality.pass_share),
            quality.profile.name
        ),
    );
    for (criterion, count) in &quality.failures {
        line(out, format_args!("    {count} fail {}", words(criterion)));
    }
}

fn worst_line(out: &mut String, quality: &QualityReport) {
    if let Some(worst) = quality.worst.first().filter(|w| !w.fails.is_empty()) {
        let c = worst.centre;
        line(
            out,
            format_args!(
                "  worst: element {} at ({}, {}, {}), scaled Jacobian {}",
                worst.element.0,
                number(c.x),
                number(c.y),
                number(c.z),
                number(worst.scaled_jacobian)
            ),
        );
    }
}

/// A line of a report.
fn line(out: &mut String, text: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = out.write_fmt(text);
    while out.ends_with(' ') {
        out.pop();
    }
    out.push('\n');
}

/// `scaled-jacobian` as `scaled jacobian`.
fn words(criterion: &Criterion) -> String {
    criterion.code().replace('-', " ")
}

/// One block a bin, as high as its share of the fullest.
fn bars(metric: &MetricSummary) -> String {
    const BLOCKS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let most = metric.histogram.iter().copied().max().unwrap_or(0).max(1);
    metric
        .histogram
        .iter()
        // Rounded up, so that a single bad element shows.
        .map(|n| BLOCKS[(8 * n).div_ceil(most)])
        .collect()
}

fn percent(share: f64) -> String {
    if share.is_finite() {
        format!("{:.2} %", 100.0 * share)
    } else {
        "-".to_owned()
    }
}

fn signed(share: f64) -> String {
    if share.is_finite() {
        format!("{:+.2} %", 100.0 * share)
    } else {
        "-".to_owned()
    }
}

/// Four digits, and no exponent in the range that drawings use.
fn number(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        "-".to_owned()
    } else if value == value.round() && size < 1e6 {
        format!("{value:.0}")
    } else if (1e-3..1e6).contains(&size) {
        let decimals = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.2e}")
    }
}

fn wrapped(text: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let last = lines.len() - 1;
        if lines[last].is_empty() {
            lines[last].push_str(word);
        } else if lines[last].len() + 1 + word.len() <= WIDTH - 4 {
            lines[last].push(' ');
            lines[last].push_str(word);
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::report::Profile;
    use crate::model::shell::ShellMesh;
    use crate::stage::{audit::audit, quality::quality};
    use crate::test_parts::{box_brep, plate_mesh};
    use glam::DVec3;

    fn text(mesh: &ShellMesh) -> String {
        let solid = box_brep(DVec3::new(100.0, 60.0, 3.0));
        render(
            &audit(&[&solid], mesh, 1),
            &quality(mesh, &Profile::shell(), None),
        )
    }

    #[test]
    fn a_right_plate_is_called_right_in_the_first_line() {
        let text = text(&plate_mesh(20, 12));
        let first = text.lines().next().unwrap();
        assert_eq!(
            first,
            "right: 240 elements (240 quads, 0 triangles), R-error 0.00 %, 100.00 % of the walls covered, 100.00 % good"
        );
        assert!(!text.contains('!'));
        assert!(text.contains("quad.scaled_jacobian"));
    }

    #[test]
    fn a_doubted_plate_says_why_and_what_to_do() {
        let mut mesh = plate_mesh(20, 12);
        for p in mesh.nodes.iter_mut() {
            p.z += 0.3;
        }
        let text = text(&mesh);
        assert!(text.starts_with("doubted (r-error): 240 elements"));
        // 0.05 - 1.645 sqrt(0.05 * 0.95 / 10,000): all of the plate is judged.
        assert!(text.contains("! r-error: 1, at most 0.04641 expected"));
        assert!(text.contains("midway") && text.contains("smaller elements"));
        // Every line but the first, which a caller may print alone, fits a terminal.
        assert!(text.lines().skip(1).all(|l| l.chars().count() <= 100));
        assert!(text.lines().all(|l| !l.ends_with(' ')));
    }

    #[test]
    fn an_empty_mesh_renders_too() {
        assert!(text(&ShellMesh::default()).contains("! unmeasured: nothing"));
    }

    #[test]
    fn numbers_and_words_are_short() {
        assert_eq!(number(3.0), "3");
        assert_eq!(number(0.123456), "0.1235");
        assert_eq!(number(98765.4321), "98765");
        assert_eq!(number(1e-7), "1.00e-7");
        assert_eq!(number(f64::INFINITY), "-");
        assert_eq!(
            words(&crate::model::report::Criterion::ScaledJacobian),
            "scaled jacobian"
        );
    }
}
