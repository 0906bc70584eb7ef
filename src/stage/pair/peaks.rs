//! Thickness peaks: which thicknesses a part is made of.

use crate::model::sighting::Sighting;
use crate::model::walls::{Pairing, ThicknessPeak};

/// Ratio of one bin's thickness to the last: gauges of sheet differ by more than this, draft by less.
const BIN: f64 = 1.05;
/// A peak holds at least this share of the paired area.
const LEAST_SHARE: f64 = 0.03;

/// Histogram over logarithmic bins of the paired sightings, and its peaks by share.
pub(super) fn peaks(
    pairing: &Pairing,
    sightings: &[Sighting],
) -> (Vec<(f64, f64)>, Vec<ThicknessPeak>) {
    let mut bins: Vec<(i32, f64, f64)> = sightings
        .iter()
        .filter_map(|s| {
            let (to, d) = s.across?;
            pairing.pair(s.from, to)?;
            // Offset by half a bin, so that round numbers do not sit on a limit.
            Some(((d.ln() / BIN.ln() + 0.5).floor() as i32, d, s.area))
        })
        .collect();
    bins.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let histogram: Vec<(i32, f64, f64)> = bins
        .chunk_by(|a, b| a.0 == b.0)
        .map(|run| {
            let area: f64 = run.iter().map(|r| r.2).sum();
            (
                run[0].0,
                run.iter().map(|r| r.1 * r.2).sum::<f64>() / area,
                area,
            )
        })
        .collect();
    let total: f64 = histogram.iter().map(|h| h.2).sum();
    let at = |bin: i32| histogram.iter().find(|h| h.0 == bin).map_or(0.0, |h| h.2);
    let mut peaks: Vec<ThicknessPeak> = histogram
        .iter()
        .filter(|h| h.2 > at(h.0 - 1) && h.2 >= at(h.0 + 1))
        .map(|h| ThicknessPeak {
            thickness: h.1,
            share: (at(h.0 - 1) + h.2 + at(h.0 + 1)) / total,
        })
        .filter(|p| p.share >= LEAST_SHARE)
        .collect();
    peaks.sort_by(|a, b| {
        b.share
            .total_cmp(&a.share)
            .then(a.thickness.total_cmp(&b.thickness))
    });
    (histogram.into_iter().map(|h| (h.1, h.2)).collect(), peaks)
}
