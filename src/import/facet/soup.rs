//! Triangles as a facet file holds them, and what can be wrong with the bytes of such a file.

use std::fmt;

use glam::DVec3;

/// Triangles without any promise: STL has every corner three times, and nothing says that they close.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Soup {
    /// #P points; finite where they come from a reader.
    pub points: Vec<DVec3>,
    /// #T triangles, positions in `points`, counter-clockwise seen from outside if the file is right.
    pub triangles: Vec<[u32; 3]>,
}

impl Soup {
    /// The corner positions of a triangle.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| self.points[v as usize])
    }
}

/// Where in a file: text is counted in lines, binary data in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Line, from 1.
    Line(usize),
    /// Byte, from 0.
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(n) => write!(f, "line {n}"),
            Self::Byte(n) => write!(f, "byte {n}"),
        }
    }
}

/// What is wrong with the bytes of a facet file, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{place}: {kind}")]
pub struct ReadError {
    /// Where.
    pub place: Place,
    /// What.
    pub kind: ReadErrorKind,
}

impl ReadError {
    pub(super) fn line(line: usize, kind: ReadErrorKind) -> Self {
        Self {
            place: Place::Line(line),
            kind,
        }
    }

    pub(super) fn byte(byte: usize, kind: ReadErrorKind) -> Self {
        Self {
            place: Place::Byte(byte),
            kind,
        }
    }
}

/// The kinds of [`ReadError`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReadErrorKind {
    /// The file ends inside something.
    #[error("the file ends inside {0}")]
    Truncated(&'static str),
    /// Something else is expected there.
    #[error("{0} is expected")]
    Expected(&'static str),
    /// A count that the file's length cannot hold.
    #[error("{count} {what} cannot be in what is left of the file")]
    Count {
        /// What is counted.
        what: &'static str,
        /// The count as read.
        count: u64,
    },
    /// A coordinate that is infinite or no number.
    #[error("a coordinate is not a finite number")]
    NotFinite,
    /// A corner names a point that does not exist.
    #[error("point {0} is used but not defined")]
    MissingPoint(i64),
    /// A header that describes nothing readable.
    #[error("the header {0}")]
    Header(&'static str),
    /// The file has no facets.
    #[error("there is no facet in the file")]
    NoFacet,
}

/// Cuts a polygon of points into triangles: by its ears where it lies in a plane well enough, else as a fan.
///
/// Guarantee: `corners.len() - 2` triangles, whatever the points are. Reference: G. H. Meisters, Polygons have ears, Am. Math. Monthly 82 (1975),
/// doi:10.2307/2319703.
pub(super) fn triangulate(points: &[DVec3], corners: &[u32], out: &mut Vec<[u32; 3]>) {
    if let &[a, b, c] = corners {
        out.push([a, b, c]);
        return;
    }
    let p = |i: u32| points[i as usize];
    // Newell's normal.
    let normal: DVec3 = (0..corners.len())
        .map(|k| p(corners[k]).cross(p(corners[(k + 1) % corners.len()])))
        .sum();
    let mut left = corners.to_vec();
    // Long polygons of hostile files would take quadratic time: they get the fan.
    while left.len() > 3 && corners.len() <= 250 {
        let n = left.len();
        let ear = (0..n).find(|&k| {
            let [ia, ib, ic] = [left[(k + n - 1) % n], left[k], left[(k + 1) % n]];
            let (a, b, c) = (p(ia), p(ib), p(ic));
            let area = (b - a).cross(c - a).dot(normal);
            let inside = |q: DVec3| {
                [(a, b), (b, c), (c, a)]
                    .iter()
                    .all(|&(s, e)| (e - s).cross(q - s).dot(normal) >= 0.0)
            };
            area > 0.0
                && !left
                    .iter()
                    .any(|&q| q != ia && q != ib && q != ic && inside(p(q)))
        });
        let Some(k) = ear else { break };
        out.push([left[(k + n - 1) % n], left[k], left[(k + 1) % n]]);
        left.remove(k);
    }
    for k in 1..left.len().saturating_sub(1) {
        out.push([left[0], left[k], left[k + 1]]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
        triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| points[i as usize]);
                (b - a).cross(c - a).z / 2.0
            })
            .sum()
    }

    #[test]
    fn a_hollow_polygon_is_cut_inside_itself() {
        // An L of area 3: a fan from its first corner would leave it.
        let points: Vec<DVec3> = [(2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.), (0., 0.)]
            .map(|(x, y)| DVec3::new(x, y, 0.0))
            .to_vec();
        let mut out = Vec::new();
        triangulate(&points, &[0, 1, 2, 3, 4, 5], &mut out);
        assert_eq!(out.len(), 4);
        assert!((area(&points, &out) - 3.0).abs() < 1e-12);
        for t in &out {
            assert!(area(&points, &[*t]) > 0.0, "{t:?} is turned over");
        }
    }

    #[test]
    fn a_polygon_without_ears_is_a_fan_all_the_same() {
        let points = vec![DVec3::ZERO; 5];
        let mut out = Vec::new();
        triangulate(&points, &[0, 1, 2, 3, 4], &mut out);
        assert_eq!(out.len(), 3);
    }
}
