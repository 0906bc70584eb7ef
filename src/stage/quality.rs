//! Element quality of a shell mesh: every metric summed up, the criteria applied, the worst elements named.
//!
//! Input: a [`ShellMesh`]. Guarantees: the order of elements and the number of threads change nothing; degenerate elements and
//! coordinates that are not finite are counted, never hidden in a mean.

use crate::geom::quality::{QuadQuality, TriangleQuality, quad_quality, triangle_quality};
use crate::model::ids::{ElementId, IndexVec};
use crate::model::mesh_audit::ElementMetrics;
use crate::model::metric::{QUAD_METRICS, TRIANGLE_METRICS, place_of};
use crate::model::profile::Range;
use crate::model::report::{Criterion, MetricSummary, Profile, QualityReport, WorstElement};
use crate::model::shell::{Corners, ShellMesh};
use glam::DVec3;
use rayon::prelude::*;

/// How many elements a report names one by one.
const WORST: usize = 10;

/// Bins of each histogram.
const BINS: usize = 10;

/// Metrics of one element.
#[derive(Clone, Copy, Debug)]
enum Quality {
    Triangle(TriangleQuality),
    Quad(QuadQuality),
}

/// A metric in the report: its name, acceptable range, histogram range and value.
struct Column<Q> {
    name: &'static str,
    acceptable: [f64; 2],
    range: [f64; 2],
    value: fn(&Q) -> f64,
}

const fn column<Q>(
    name: &'static str,
    acceptable: [f64; 2],
    range: [f64; 2],
    value: fn(&Q) -> f64,
) -> Column<Q> {
    Column {
        name,
        acceptable,
        range,
        value,
    }
}

/// Acceptable ranges are Verdict's, or those of the solver or pre-processor that the metric comes from.
const TRIANGLE: [Column<TriangleQuality>; 7] = [
    column("scaled_jacobian", [0.5, 1.155], [0.0, 1.0], |q| {
        q.scaled_jacobian
    }),
    column("aspect_ratio", [1.0, 1.3], [1.0, 3.0], |q| q.aspect_ratio),
    column("edge_ratio", [1.0, 5.0], [1.0, 6.0], |q| q.edge_ratio),
    column("radius_ratio", [1.0, 3.0], [1.0, 5.0], |q| q.radius_ratio),
    column("min_angle_deg", [30.0, 60.0], [0.0, 60.0], |q| {
        q.min_angle_deg
    }),
    column("max_angle_deg", [60.0, 120.0], [60.0, 180.0], |q| {
        q.max_angle_deg
    }),
    column("skew_deg", [0.0, 60.0], [0.0, 90.0], |q| q.skew_deg),
];

const QUAD: [Column<QuadQuality>; 16] = [
    column("scaled_jacobian", [0.3, 1.0], [0.0, 1.0], |q| {
        q.scaled_jacobian
    }),
    column("aspect_ratio", [1.0, 1.3], [1.0, 3.0], |q| q.aspect_ratio),
    column("edge_ratio", [1.0, 5.0], [1.0, 6.0], |q| q.edge_ratio),
    column("skew", [0.0, 0.5], [0.0, 1.0], |q| q.skew),
    column("taper", [0.0, 0.7], [0.0, 1.0], |q| q.taper),
    column("warpage", [0.3, 1.0], [0.0, 1.0], |q| q.warpage),
    column("shape", [0.3, 1.0], [0.0, 1.0], |q| q.shape),
    column("condition", [1.0, 4.0], [1.0, 5.0], |q| q.condition),
    column("equiangle_skew", [0.0, 1.0], [0.0, 1.0], |q| {
        q.equiangle_skew
    }),
    column("warp_deg", [0.0, 15.0], [0.0, 30.0], |q| q.warp_deg),
    column("gauss_jacobian_ratio", [0.7, 1.0], [0.0, 1.0], |q| {
        q.gauss_jacobian_ratio
    }),
    column("skew_deg", [0.0, 60.0], [0.0, 90.0], |q| q.skew_deg),
    column("corner_taper", [0.0, 0.5], [0.0, 1.0], |q| q.corner_taper),
    column("plane_warp", [0.0, 0.05], [0.0, 0.1], |q| q.plane_warp),
    column("min_angle_deg", [45.0, 90.0], [0.0, 90.0], |q| {
        q.min_angle_deg
    }),
    column("max_angle_deg", [90.0, 135.0], [90.0, 180.0], |q| {
        q.max_angle_deg
    }),
];

/// Quality of every element, summed up. `size` is the edge length that was asked for, mm; without it no edge is too short.
pub fn quality(mesh: &ShellMesh, profile: &Profile, size: Option<f64>) -> QualityReport {
    let all = measure(mesh);
    let triangles: Vec<TriangleQuality> = all
        .iter()
        .filter_map(|q| match q {
            Quality::Triangle(q) => Some(*q).filter(|q| q.area.is_finite()),
            Quality::Quad(_) => None,
        })
        .collect();
    let quads: Vec<QuadQuality> = all
        .iter()
        .filter_map(|q| match q {
            Quality::Quad(q) => Some(*q).filter(|q| q.area.is_finite()),
            Quality::Triangle(_) => None,
        })
        .collect();
    let quad_count = mesh.elements.iter().filter(|e| e.corners.is_quad()).count();
    let triangle_count = all.len() - quad_count;
    let mut metrics: Vec<MetricSummary> = Vec::new();
    if triangle_count > 0 {
        let of = |c| summary("triangle", c, &triangles, triangle_count);
        metrics.extend(TRIANGLE.iter().map(of));
    }
    if quad_count > 0 {
        metrics.extend(QUAD.iter().map(|c| summary("quad", c, &quads, quad_count)));
    }
    let extra = Extra::of(profile);
    let fails: Vec<Vec<Criterion>> = (all.iter())
        .map(|q| broken(q, profile, &extra, size))
        .collect();
    let mut every: Vec<Criterion> = fails.iter().flatten().copied().collect();
    every.sort_unstable();
    let mut order: Vec<usize> = (0..all.len()).collect();
    // What is not a number is the worst of all.
    let rank = |i: usize| match all[i].scaled_jacobian() {
        j if j.is_nan() => f64::NEG_INFINITY,
        j => j,
    };
    order.sort_by(|&a, &b| rank(a).total_cmp(&rank(b)).then(a.cmp(&b)));
    order.truncate(WORST);
    let count = all.len().max(1) as f64;
    QualityReport {
        nodes: mesh.nodes.len(),
        elements: all.len(),
        triangles: triangle_count,
        quads: quad_count,
        quad_share: quad_count as f64 / count,
        area: all
            .iter()
            .map(Quality::area)
            .filter(|a| a.is_finite())
            .sum(),
        metrics,
        profile: profile.clone(),
        pass_share: fails.iter().filter(|f| f.is_empty()).count() as f64 / count,
        failures: every
            .chunk_by(|a, b| a == b)
            .map(|run| (run[0], run.len()))
            .collect(),
        worst: order
            .into_iter()
            .map(|i| WorstElement {
                element: ElementId(i as u32),
                centre: centre(mesh, ElementId(i as u32)),
                scaled_jacobian: all[i].scaled_jacobian(),
                edge_ratio: all[i].edge_ratio(),
                fails: fails[i].clone(),
            })
            .collect(),
    }
}

/// Scaled Jacobian of every element, for export.
pub fn scaled_jacobians(mesh: &ShellMesh) -> IndexVec<ElementId, f64> {
    measure(mesh).iter().map(Quality::scaled_jacobian).collect()
}

/// Every metric of every element, and the criteria that it breaks. `size` as for [`quality`].
pub fn table(mesh: &ShellMesh, profile: &Profile, size: Option<f64>) -> Vec<ElementMetrics> {
    let extra = Extra::of(profile);
    let measured = measure(mesh);
    mesh.elements
        .ids()
        .zip(&measured)
        .map(|(element, quality)| ElementMetrics {
            element,
            centre: centre(mesh, element),
            area: quality.area(),
            shortest: match quality {
                Quality::Triangle(q) => q.shortest,
                Quality::Quad(q) => q.shortest,
            },
            is_quad: matches!(quality, Quality::Quad(_)),
            values: quality.values(),
            fails: broken(quality, profile, &extra, size),
        })
        .collect()
}

/// The limits of a profile on single metrics, by the metric's place in its list.
struct Extra {
    quad: Vec<(usize, Range)>,
    triangle: Vec<(usize, Range)>,
}

impl Extra {
    /// Names that are no metric are left out: [`Profile::check`] finds them.
    fn of(profile: &Profile) -> Self {
        let places = |list: &[&str], limits: &std::collections::BTreeMap<String, Range>| {
            let mut found: Vec<(usize, Range)> = (limits.iter())
                .filter_map(|(name, range)| Some((place_of(list, name)?, *range)))
                .collect();
            found.sort_by_key(|(place, _)| *place);
            found
        };
        Self {
            quad: places(&QUAD_METRICS, &profile.quad),
            triangle: places(&TRIANGLE_METRICS, &profile.triangle),
        }
    }
}

fn measure(mesh: &ShellMesh) -> Vec<Quality> {
    let at = |n| mesh.nodes.get(n).copied().unwrap_or(DVec3::NAN);
    mesh.elements
        .as_slice()
        .par_iter()
        .map(|e| match e.corners {
            Corners::Triangle(n) => Quality::Triangle(triangle_quality(n.map(at))),
            Corners::Quad(n) => Quality::Quad(quad_quality(n.map(at))),
        })
        .collect()
}

fn centre(mesh: &ShellMesh, element: ElementId) -> DVec3 {
    let nodes = mesh.elements[element].corners;
    let points = nodes.as_slice().iter().filter_map(|n| mesh.nodes.get(*n));
    points.sum::<DVec3>() / nodes.as_slice().len() as f64
}

impl Quality {
    /// NaN where a coordinate is not finite.
    fn scaled_jacobian(&self) -> f64 {
        match self {
            _ if !self.area().is_finite() => f64::NAN,
            Quality::Triangle(q) => q.scaled_jacobian,
            Quality::Quad(q) => q.scaled_jacobian,
        }
    }
    /// In the order of the lists of metrics; NaN where a coordinate is not finite.
    fn values(&self) -> Vec<f64> {
        let sound = self.area().is_finite();
        let value = |v: f64| if sound { v } else { f64::NAN };
        match self {
            Quality::Triangle(q) => TRIANGLE.iter().map(|c| value((c.value)(q))).collect(),
            Quality::Quad(q) => QUAD.iter().map(|c| value((c.value)(q))).collect(),
        }
    }
    fn edge_ratio(&self) -> f64 {
        match self {
            Quality::Triangle(q) => q.edge_ratio,
            Quality::Quad(q) => q.edge_ratio,
        }
    }
    fn area(&self) -> f64 {
        match self {
            Quality::Triangle(q) => q.area,
            Quality::Quad(q) => q.area,
        }
    }
}

/// The criteria that an element breaks, in order.
fn broken(
    quality: &Quality,
    profile: &Profile,
    extra: &Extra,
    size: Option<f64>,
) -> Vec<Criterion> {
    let (min_angle, max_angle, range, skew, shortest, warp, jacobian) = match quality {
        Quality::Triangle(q) => (
            q.min_angle_deg,
            q.max_angle_deg,
            profile.triangle_angle_deg,
            q.skew_deg,
            q.shortest,
            0.0,
            // The angles say it all for a triangle.
            f64::INFINITY,
        ),
        Quality::Quad(q) => (
            q.min_angle_deg,
            q.max_angle_deg,
            profile.quad_angle_deg,
            q.skew_deg,
            q.shortest,
            q.warp_deg,
            q.scaled_jacobian,
        ),
    };
    // A right angle measured with rounding must not fail a limit of 90 degrees: this is less than any drawing resolves.
    const EPS: f64 = 1e-9;
    if !quality.area().is_finite() {
        return vec![Criterion::NotFinite];
    }
    [
        (
            Criterion::EdgeRatio,
            quality.edge_ratio() > profile.edge_ratio_max * (1.0 + EPS),
        ),
        (Criterion::Warp, warp > profile.warp_deg_max + EPS),
        (Criterion::Skew, skew > profile.skew_deg_max + EPS),
        (
            Criterion::ScaledJacobian,
            jacobian < profile.scaled_jacobian_min - EPS,
        ),
        (
            Criterion::Angle,
            min_angle < range[0] - EPS || max_angle > range[1] + EPS,
        ),
        (
            Criterion::ShortEdge,
            size.is_some_and(|h| shortest < profile.shortest_edge_min * h * (1.0 - EPS)),
        ),
    ]
    .into_iter()
    .filter_map(|(criterion, fails)| fails.then_some(criterion))
    .chain(beyond(quality, extra, EPS))
    .collect()
}

/// The limits on single metrics that an element breaks. What is not a number breaks any.
fn beyond(quality: &Quality, extra: &Extra, eps: f64) -> Vec<Criterion> {
    let (limits, names): (_, &[&'static str]) = match quality {
        Quality::Triangle(_) => (&extra.triangle, &TRIANGLE_METRICS),
        Quality::Quad(_) => (&extra.quad, &QUAD_METRICS),
    };
    if limits.is_empty() {
        return Vec::new();
    }
    let values = quality.values();
    let within = |value: f64, range: &Range| {
        let slack = |limit: f64| eps * limit.abs().max(1.0);
        range.min.is_none_or(|min| value >= min - slack(min))
            && range.max.is_none_or(|max| value <= max + slack(max))
    };
    (limits.iter())
        .filter(|(place, range)| !within(values[*place], range))
        .map(|(place, _)| Criterion::Metric(names[*place]))
        .collect()
}

/// `count` is the number of elements, those of `of` and those with coordinates that are not finite.
fn summary<Q>(shape: &str, column: &Column<Q>, of: &[Q], count: usize) -> MetricSummary {
    let [from, to] = column.range;
    let mut histogram = vec![0; BINS];
    let (mut min, mut max, mut sum) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
    let (mut finite, mut good) = (0usize, 0usize);
    for q in of {
        let value = (column.value)(q);
        if !value.is_finite() {
            continue;
        }
        finite += 1;
        sum += value;
        (min, max) = (min.min(value), max.max(value));
        // Rounding may put an ideal element a hair below 1.
        let slack = 1e-9 * (to - from);
        if value >= column.acceptable[0] - slack && value <= column.acceptable[1] + slack {
            good += 1;
        }
        let bin = ((value - from) / (to - from) * BINS as f64).floor();
        histogram[bin.clamp(0.0, (BINS - 1) as f64) as usize] += 1;
    }
    if finite == 0 {
        (min, max) = (0.0, 0.0);
    }
    MetricSummary {
        name: format!("{shape}.{}", column.name),
        acceptable: column.acceptable,
        min,
        mean: sum / finite.max(1) as f64,
        max,
        share_acceptable: good as f64 / count.max(1) as f64,
        undefined: count - finite,
        histogram_range: column.range,
        histogram,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_parts::plate_mesh;

    #[test]
    fn a_plate_of_rectangles_passes_and_counts_add_up() {
        let mesh = plate_mesh(20, 12);
        let report = quality(&mesh, &Profile::shell(), Some(5.0));
        assert_eq!(
            (report.elements, report.quads, report.nodes),
            (240, 240, 273)
        );
        assert_eq!((report.pass_share, report.quad_share), (1.0, 1.0));
        assert!(report.failures.is_empty() && (report.area - 6000.0).abs() < 1e-9);
        for m in &report.metrics {
            assert_eq!(m.histogram.iter().sum::<usize>(), 240, "{}", m.name);
            assert_eq!((m.undefined, m.share_acceptable), (0, 1.0), "{}", m.name);
            assert!(m.min <= m.mean + 1e-12 && m.mean <= m.max + 1e-12);
        }
        assert_eq!(report.worst.len(), 10);
        assert!(
            scaled_jacobians(&mesh)
                .iter()
                .all(|j| (j - 1.0).abs() < 1e-12)
        );
    }

    #[test]
    fn a_bad_element_is_found_named_and_placed() {
        let mut mesh = plate_mesh(20, 12);
        // Node 130 is an inner node; drawn across its neighbour it turns a quad inside out.
        let at = mesh.nodes[crate::model::ids::NodeId(130)];
        mesh.nodes[crate::model::ids::NodeId(130)] = at + DVec3::new(7.0, 0.0, 0.0);
        let report = quality(&mesh, &Profile::shell(), Some(5.0));
        assert!(report.pass_share < 1.0 && report.worst[0].scaled_jacobian < 0.0);
        assert!(report.worst[0].fails.contains(&Criterion::ScaledJacobian));
        assert!(report.worst[0].centre.distance(at) < 8.0);
        assert_eq!(
            scaled_jacobians(&mesh)[report.worst[0].element],
            report.worst[0].scaled_jacobian
        );
    }

    #[test]
    fn short_edges_and_broken_numbers_are_counted() {
        let mut mesh = plate_mesh(20, 12);
        let short = quality(&mesh, &Profile::shell(), Some(13.0));
        assert_eq!(short.failures, vec![(Criterion::ShortEdge, 240)]);
        mesh.nodes[crate::model::ids::NodeId(130)].x = f64::NAN;
        let broken = quality(&mesh, &Profile::shell(), None);
        assert_eq!(broken.failures, vec![(Criterion::NotFinite, 4)]);
        assert!(
            broken
                .metrics
                .iter()
                .all(|m| m.undefined == 4 && m.mean.is_finite())
        );
    }

    #[test]
    fn columns_and_names_are_one_list() {
        let bare = |list: &[&'static str]| -> Vec<&'static str> {
            list.iter().map(|n| crate::model::metric::bare(n)).collect()
        };
        let triangle: Vec<&str> = TRIANGLE.iter().map(|c| c.name).collect();
        let quad: Vec<&str> = QUAD.iter().map(|c| c.name).collect();
        assert_eq!(
            (triangle, quad),
            (bare(&TRIANGLE_METRICS), bare(&QUAD_METRICS))
        );
    }

    #[test]
    fn a_limit_on_one_metric_is_held_and_the_table_says_so() {
        // Rectangles of 5 by 5 stretched to 10 by 5: shape 4/5.
        let mut mesh = plate_mesh(20, 12);
        mesh.nodes.iter_mut().for_each(|p| p.x *= 2.0);
        let mut profile = Profile::shell();
        let range = |min, max| Range { min, max };
        (profile.quad).insert("shape".to_owned(), range(Some(0.8), None));
        (profile.quad).insert("taper".to_owned(), range(None, Some(0.0)));
        assert_eq!(quality(&mesh, &profile, None).pass_share, 1.0);
        (profile.quad).insert("shape".to_owned(), range(Some(0.81), None));
        let report = quality(&mesh, &profile, None);
        let criterion = Criterion::Metric("quad.shape");
        assert_eq!(report.failures, vec![(criterion, 240)]);
        let rows = table(&mesh, &profile, None);
        assert_eq!(rows.len(), 240);
        for row in &rows {
            assert_eq!(
                (row.fails.as_slice(), row.is_quad),
                (&[criterion][..], true)
            );
            assert!((row.values[6] - 0.8).abs() < 1e-12 && (row.area - 50.0).abs() < 1e-9);
            assert_eq!((row.values.len(), row.shortest), (QUAD_METRICS.len(), 5.0));
        }
    }

    #[test]
    fn an_empty_mesh_has_a_report() {
        let report = quality(&ShellMesh::default(), &Profile::shell(), None);
        assert_eq!((report.elements, report.worst.len()), (0, 0));
    }
}
