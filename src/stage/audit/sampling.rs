//! Points spread evenly over triangles, and percentiles of what is measured there.

use crate::geom::random::Pcg;
use glam::DVec3;

/// A sample: which triangle, and the weights of its three corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub triangle: usize,
    pub weights: [f64; 3],
}

impl Sample {
    pub fn of(&self, values: [DVec3; 3]) -> DVec3 {
        values[0] * self.weights[0] + values[1] * self.weights[1] + values[2] * self.weights[2]
    }
}

/// `count` samples, as many a triangle as its share of the area, one in each of `count` equal strips of the area: no triangle larger
/// than a strip goes unseen. None where there is no area. Areas that are not finite count as zero.
pub(super) fn spread(areas: &[f64], count: usize, seed: u64) -> Vec<Sample> {
    let clean = |a: f64| if a.is_finite() { a.max(0.0) } else { 0.0 };
    let total: f64 = areas.iter().map(|a| clean(*a)).sum();
    let Some(last) = areas.iter().rposition(|a| clean(*a) > 0.0) else {
        return Vec::new();
    };
    let mut rng = Pcg::new(seed);
    let (mut at, mut below) = (0, 0.0);
    (0..count)
        .map(|i| {
            let target = (i as f64 + rng.unit()) / count as f64 * total;
            while at < last && below + clean(areas[at]) <= target {
                below += clean(areas[at]);
                at += 1;
            }
            let (mut u, mut v) = (rng.unit(), rng.unit());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            Sample {
                triangle: at,
                weights: [1.0 - u - v, u, v],
            }
        })
        .collect()
}

/// The `q`-quantile (0 to 1) of sorted values, linear between them.
pub(super) fn quantile(sorted: &[f64], q: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let at = q * last as f64;
    let below = (at.floor() as usize).min(last);
    let above = (below + 1).min(last);
    Some(sorted[below] + (sorted[above] - sorted[below]) * (at - below as f64))
}

/// The middle value; none where there is none.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    quantile(&values, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_follow_the_area_and_stay_inside() {
        let areas = [1.0, 0.0, 3.0, f64::NAN, 6.0];
        let samples = spread(&areas, 1000, 9);
        let mut hits = [0_i32; 5];
        for s in &samples {
            hits[s.triangle] += 1;
            assert!(s.weights.iter().all(|w| (0.0..=1.0).contains(w)));
            assert!((s.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
        for (hits, expected) in hits.iter().zip([100, 0, 300, 0, 600]) {
            assert!((hits - expected).abs() <= 1);
        }
        assert_eq!(samples, spread(&areas, 1000, 9));
        assert!(spread(&[0.0, f64::NAN], 10, 1).is_empty());
    }

    #[test]
    fn quantiles_are_linear_between_values() {
        let v = [1.0, 2.0, 4.0];
        assert_eq!(quantile(&v, 0.5), Some(2.0));
        assert_eq!(quantile(&v, 0.75), Some(3.0));
        assert_eq!(quantile(&v, 1.0), Some(4.0));
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(median(vec![9.0, 1.0, 5.0]), Some(5.0));
    }
}
