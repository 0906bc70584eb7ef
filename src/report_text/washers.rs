//! Washers as text: like ones in one line, and every hole without one.

use super::{PLACES, line, wrapped};
use crate::model::washer::{Washer, Washers};
use glam::DVec3;

/// Holes without a washer that are told one by one.
const BARE: usize = 8;

/// One line for washers that are alike, with the places of a few; then the holes without one, and why.
pub fn washers(washers: &Washers) -> String {
    let mut out = String::new();
    if washers.made.is_empty() && washers.left_out.is_empty() {
        line(
            &mut out,
            format_args!("washers: none, no round hole has a wanted diameter"),
        );
    }
    let mut kinds: Vec<(String, Vec<DVec3>)> = Vec::new();
    for washer in &washers.made {
        let kind = kind(washer);
        match kinds.iter_mut().find(|k| k.0 == kind) {
            Some(known) => known.1.push(washer.centre),
            None => kinds.push((kind, vec![washer.centre])),
        }
    }
    for (kind, places) in kinds {
        let count = places.len();
        let holes = if count == 1 { "hole" } else { "holes" };
        line(
            &mut out,
            format_args!("washers: {count} {holes} of {kind}"),
        );
        let some: Vec<String> = (places.iter().take(PLACES))
            .map(|p| format!("({:.1}, {:.1}, {:.1})", p.x, p.y, p.z))
            .collect();
        let more = match count.checked_sub(PLACES).filter(|n| *n > 0) {
            Some(more) => format!(" and {more} more"),
            None => String::new(),
        };
        line(&mut out, format_args!("  at {}{more}", some.join(", ")));
    }
    for hole in washers.left_out.iter().take(BARE) {
        for part in wrapped(&format!("no washer: {hole}")) {
            line(&mut out, format_args!("{part}"));
        }
    }
    if let Some(more) = (washers.left_out.len().checked_sub(BARE)).filter(|n| *n > 0) {
        line(
            &mut out,
            format_args!("no washer: holes more: {more}, in the report (--json)"),
        );
    }
    out
}

fn kind(washer: &Washer) -> String {
    let rings = if washer.layers == 1 { "ring" } else { "rings" };
    format!(
        "{:.2} mm, {} {rings} of {} quads, each {:.2} mm wide",
        washer.diameter, washer.layers, washer.around, washer.width
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::washer::{BareHole, NoWasher, RoomEnd};

    #[test]
    fn like_washers_share_a_line_and_each_bare_hole_says_why() {
        let washer = |x: f64, diameter: f64| Washer {
            centre: DVec3::new(x, 0.0, 1.0),
            axis: DVec3::Z,
            diameter,
            layers: 2,
            width: 1.5,
            around: 12,
        };
        let bare = BareHole {
            centre: DVec3::ZERO,
            diameter: 6.0,
            why: NoWasher::Room {
                room: 1.25,
                wanted: 3.0,
                end: RoomEnd::Bend,
            },
        };
        let all = Washers {
            made: vec![washer(1.0, 6.0), washer(2.0, 4.0), washer(3.0, 6.0)],
            left_out: vec![bare; 9],
        };
        let text = washers(&all);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines[..4],
            [
                "washers: 2 holes of 6.00 mm, 2 rings of 12 quads, each 1.50 mm wide",
                "  at (1.0, 0.0, 1.0), (3.0, 0.0, 1.0)",
                "washers: 1 hole of 4.00 mm, 2 rings of 12 quads, each 1.50 mm wide",
                "  at (2.0, 0.0, 1.0)",
            ]
        );
        assert!(text.contains("a bend leaves room for 1.25 mm"), "{text}");
        assert!(text.ends_with("no washer: holes more: 1, in the report (--json)\n"));
        assert!(lines.iter().all(|l| l.len() <= 100), "{text}");
        assert!(washers(&Washers::default()).contains("no round hole"));
    }
}
