//! Every metric of every element as a table of comma-separated values, a row an element.
//!
//! Columns: `element` (its number in the file), `type` (`triangle`, `quad`), `sheet`, `x`, `y`, `z` (the mean of its corners), `area`, `shortest_edge`, `thickness` (the mean of its corners),
//! then every metric, `fails` (criteria, parted by blanks). A field is empty where the shape has no such metric or the file no thickness, `inf` where a metric has no end.
//!
//! Reference: RFC 4180, with line feeds alone.

use crate::model::mesh_audit::ElementMetrics;
use crate::model::metric::{QUAD_METRICS, TRIANGLE_METRICS, bare, place_of};
use std::fmt::Write;

/// What a row says beside the metrics.
#[derive(Clone, Debug)]
pub struct MetricRow<'a> {
    /// The element's number in the file.
    pub number: u64,
    /// The number of its sheet, from 1.
    pub sheet: usize,
    /// Mean thickness; NaN where the file has none.
    pub thickness: f64,
    /// Its metrics.
    pub metrics: &'a ElementMetrics,
}

/// The bytes of the table.
pub fn render_metrics(rows: &[MetricRow<'_>]) -> Vec<u8> {
    let names = names();
    let mut out = String::from("element,type,sheet,x,y,z,area,shortest_edge,thickness,");
    out.push_str(&names.join(","));
    out.push_str(",fails\n");
    let places = |list: &[&str]| -> Vec<Option<usize>> {
        names.iter().map(|name| place_of(list, name)).collect()
    };
    let (quad, triangle) = (places(&QUAD_METRICS), places(&TRIANGLE_METRICS));
    for row in rows {
        let m = row.metrics;
        let (shape, places) = match m.is_quad {
            true => ("quad", &quad),
            false => ("triangle", &triangle),
        };
        let [x, y, z] = m.centre.to_array();
        // Writing to a string cannot fail.
        let _ = write!(out, "{},{shape},{},{x},{y},{z}", row.number, row.sheet);
        for value in [m.area, m.shortest, row.thickness] {
            field(&mut out, value);
        }
        for place in places {
            field(&mut out, place.map_or(f64::NAN, |k| m.values[k]));
        }
        let fails: Vec<&str> = m.fails.iter().map(|c| c.code()).collect();
        let _ = writeln!(out, ",{}", fails.join(" "));
    }
    out.into_bytes()
}

/// The metrics of quads, then those that triangles alone have.
fn names() -> Vec<&'static str> {
    let mut names: Vec<&'static str> = QUAD_METRICS.iter().map(|n| bare(n)).collect();
    for name in TRIANGLE_METRICS.iter().map(|n| bare(n)) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

fn field(out: &mut String, value: f64) {
    out.push(',');
    if !value.is_nan() {
        let _ = write!(out, "{value}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ids::ElementId;
    use crate::model::report::Criterion;
    use glam::DVec3;

    #[test]
    fn rows_have_the_columns_of_the_head() {
        let metrics = |is_quad: bool| ElementMetrics {
            element: ElementId(0),
            centre: DVec3::new(1.0, 2.5, -3.0),
            area: 4.0,
            shortest: 2.0,
            is_quad,
            values: vec![0.5; if is_quad { 16 } else { 7 }],
            fails: vec![Criterion::Warp, Criterion::Metric("quad.taper")],
        };
        let (quad, triangle) = (metrics(true), metrics(false));
        let row = |metrics, thickness| MetricRow {
            number: 17,
            sheet: 2,
            thickness,
            metrics,
        };
        let text = render_metrics(&[row(&quad, 1.5), row(&triangle, f64::NAN)]);
        let text = String::from_utf8(text).unwrap();
        let rows: Vec<Vec<&str>> = text.lines().map(|l| l.split(',').collect()).collect();
        assert_eq!(rows.len(), 3);
        assert!(rows.iter().all(|r| r.len() == 9 + 17 + 1), "{text}");
        let column = |name: &str| rows[0].iter().position(|n| *n == name).unwrap();
        assert_eq!(rows[1][..9].join(","), "17,quad,2,1,2.5,-3,4,2,1.5");
        assert_eq!(
            (rows[1][column("taper")], rows[1][column("radius_ratio")]),
            ("0.5", "")
        );
        assert_eq!(
            (rows[2][column("taper")], rows[2][column("radius_ratio")]),
            ("", "0.5")
        );
        assert_eq!(
            (rows[2][column("thickness")], rows[2][column("fails")]),
            ("", "warp quad.taper")
        );
    }
}
