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
    let mut kinds: Vec<(String, Vec<&Washer>)> = Vec::new();
    for washer in &washers.made {
        let kind = kind(washer);
        match kinds.iter_mut().find(|k| k.0 == kind) {
            Some(known) => known.1.push(washer),
            None => kinds.push((kind, vec![washer])),
        }
    }
    for (kind, alike) in kinds {
        let count = alike.len();
        let holes = if count == 1 { "hole" } else { "holes" };
        line(
            &mut out,
            format_args!(
                "washers: {count} {holes} of {kind}, {} mm wide",
                widths(&alike)
            ),
        );
        let some: Vec<String> = alike.iter().take(PLACES).map(|w| place(w.centre)).collect();
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

/// What like washers have in common. A tenth of a millimetre is more than facets take from a hole.
fn kind(washer: &Washer) -> String {
    let rings = if washer.layers == 1 { "ring" } else { "rings" };
    format!(
        "{:.1} mm: {} {rings} of {} quads",
        washer.diameter, washer.layers, washer.around
    )
}

/// The widths of their rings, mm.
fn widths(alike: &[&Washer]) -> String {
    let [low, high] = (alike.iter()).fold([f64::INFINITY, 0.0f64], |[l, h], w| {
        [l.min(w.width), h.max(w.width)]
    });
    let [low, high] = [low, high].map(|w| format!("{w:.2}"));
    if low == high {
        low
    } else {
        format!("{low} to {high}")
    }
}

fn place(p: DVec3) -> String {
    // No minus before a zero.
    let p = (p * 10.0).round() / 10.0 + DVec3::ZERO;
    format!("({:.1}, {:.1}, {:.1})", p.x, p.y, p.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::washer::{BareHole, NoWasher, RoomEnd};

    #[test]
    fn like_washers_share_a_line_and_each_bare_hole_says_why() {
        let washer = |x: f64, diameter: f64, width: f64| Washer {
            centre: DVec3::new(x, -0.01, 1.0),
            axis: DVec3::Z,
            diameter,
            layers: 2,
            width,
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
            made: vec![
                washer(1.0, 6.0, 1.5),
                washer(2.0, 4.0, 1.0),
                washer(3.0, 6.01, 1.25),
            ],
            left_out: vec![bare; 9],
        };
        let text = washers(&all);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines[..4],
            [
                "washers: 2 holes of 6.0 mm: 2 rings of 12 quads, 1.25 to 1.50 mm wide",
                "  at (1.0, 0.0, 1.0), (3.0, 0.0, 1.0)",
                "washers: 1 hole of 4.0 mm: 2 rings of 12 quads, 1.00 mm wide",
                "  at (2.0, 0.0, 1.0)",
            ]
        );
        assert!(
            text.contains("and a bend leaves\nroom for 1.25 mm"),
            "{text}"
        );
        assert!(text.ends_with("no washer: holes more: 1, in the report (--json)\n"));
        assert!(lines.iter().all(|l| l.len() <= 100), "{text}");
        assert!(washers(&Washers::default()).contains("no round hole"));
    }
}
