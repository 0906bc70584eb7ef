//! What lengths a facet file means: its format names no unit, so the caller does, or mm are assumed; and what makes a size absurd.

use super::soup::Soup;
use super::weld::extent;
use crate::model::length_unit::LengthUnit;

/// Diagonals of parts that a shell model is made of, mm: less is a grain, more a building.
const USUAL: std::ops::RangeInclusive<f64> = 1.0..=1e5;
/// Units that are named as likely ones, the commonest in facet files first.
const LIKELY: [LengthUnit; 3] = [
    LengthUnit::Metre,
    LengthUnit::Centimetre,
    LengthUnit::Micrometre,
];

/// What there is to say about the unit of a file whose points these are, before they are brought to mm.
pub(super) fn notes(facets: &Soup, chosen: Option<LengthUnit>) -> Vec<String> {
    let (low, high) = extent(&facets.points);
    let long = (high - low).length();
    let unit = chosen.unwrap_or_default();
    let mut notes = Vec::new();
    if chosen.is_none() {
        notes.push(format!(
            "facet files name no unit: {unit} are assumed (--unit says otherwise)"
        ));
    }
    let diagonal = long * unit.mm();
    if !USUAL.contains(&diagonal) {
        let other = LIKELY.iter().find(|u| USUAL.contains(&(long * u.mm())));
        let guess = other.map_or_else(String::new, |u| {
            format!("; with --unit {u} it would be {:.1} mm", long * u.mm())
        });
        notes.push(format!(
            "the part measures {diagonal:.3e} mm corner to corner, in {unit}: is the unit right?{guess}"
        ));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn part(long: f64) -> Soup {
        Soup {
            points: vec![DVec3::ZERO, DVec3::X * long],
            triangles: Vec::new(),
        }
    }

    #[test]
    fn an_assumed_unit_is_told_and_a_chosen_one_is_not() {
        assert_eq!(notes(&part(80.0), None).len(), 1);
        assert!(notes(&part(80.0), Some(LengthUnit::Inch)).is_empty());
    }

    #[test]
    fn absurd_sizes_are_told_with_the_unit_that_would_make_them_usual() {
        let found = notes(&part(0.3), None);
        assert!(
            found[1].contains("--unit m it would be 300.0 mm"),
            "{found:?}"
        );
        let found = notes(&part(2e6), None);
        assert!(
            found[1].contains("--unit um it would be 2000.0 mm"),
            "{found:?}"
        );
        // Nothing makes a part of this.
        let found = notes(&part(1e-9), Some(LengthUnit::Metre));
        assert!(found[0].ends_with("is the unit right?"), "{found:?}");
        // In the right unit the same is usual.
        assert!(notes(&part(0.3), Some(LengthUnit::Metre)).is_empty());
    }
}
