//! Criteria: what an element must hold to pass, and the names of what it can break.

use super::metric::{QUAD_METRICS, TRIANGLE_METRICS, bare, place_of};
use serde::{Deserialize, Serialize, Serializer};
use std::collections::BTreeMap;

/// A metric must lie between these; none is no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// At least.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// At most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
}

/// A criteria file: what an element must hold to pass. Angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Its name in reports.
    pub name: String,
    /// Longest edge over shortest, at most.
    pub edge_ratio_max: f64,
    /// Angle between the normals of a quad's two triangles, at most.
    pub warp_deg_max: f64,
    /// Skew, at most.
    pub skew_deg_max: f64,
    /// Scaled Jacobian of a quad, at least.
    pub scaled_jacobian_min: f64,
    /// Corner angles of a quad, from and to.
    pub quad_angle_deg: [f64; 2],
    /// Corner angles of a triangle, from and to.
    pub triangle_angle_deg: [f64; 2],
    /// Share of triangles among the elements, at most. A mesh without a quad was meant to be of triangles: it is not held against it.
    pub triangle_share_max: f64,
    /// Shortest edge over the target size, at least.
    pub shortest_edge_min: f64,
    /// Limits on any metric of quads, by its name in reports without `quad.`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub quad: BTreeMap<String, Range>,
    /// Limits on any metric of triangles, by its name in reports without `triangle.`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub triangle: BTreeMap<String, Range>,
}

impl Default for Profile {
    fn default() -> Self {
        Self::shell()
    }
}

/// What is wrong with a profile.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProfileFault {
    /// A limit on a metric that does not exist.
    #[error("there is no metric '{metric}' of a {shape}; there are: {}", known.join(", "))]
    UnknownMetric {
        /// `quad` or `triangle`.
        shape: &'static str,
        /// The name.
        metric: String,
        /// The names that there are.
        known: Vec<&'static str>,
    },
    /// A limit that is no number, or a range that nothing lies in.
    #[error("the limit {limit} is {value}, which nothing can be held against")]
    BadLimit {
        /// Its name.
        limit: String,
        /// Its value.
        value: String,
    },
}

impl Profile {
    /// The profiles that come with the program.
    pub const NAMES: [&str; 2] = ["shell", "crash"];

    /// The default criteria: what pre-processors, crash guidelines and Verdict's acceptable ranges have in common.
    pub fn shell() -> Self {
        Self {
            name: "shell".to_owned(),
            edge_ratio_max: 5.0,
            warp_deg_max: 15.0,
            skew_deg_max: 60.0,
            scaled_jacobian_min: 0.6,
            quad_angle_deg: [45.0, 135.0],
            triangle_angle_deg: [20.0, 120.0],
            triangle_share_max: 0.05,
            shortest_edge_min: 0.4,
            quad: BTreeMap::new(),
            triangle: BTreeMap::new(),
        }
    }

    /// Criteria for explicit crash models: its quads have one integration point, which a warped or pointed quad turns into hourglass energy, and the time step goes with
    /// the shortest edge.
    pub fn crash() -> Self {
        Self {
            name: "crash".to_owned(),
            edge_ratio_max: 4.0,
            warp_deg_max: 10.0,
            skew_deg_max: 45.0,
            scaled_jacobian_min: 0.7,
            shortest_edge_min: 0.5,
            ..Self::shell()
        }
    }

    /// The profile of this name that comes with the program.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "shell" => Some(Self::shell()),
            "crash" => Some(Self::crash()),
            _ => None,
        }
    }

    /// Everything that is wrong.
    pub fn check(&self) -> Vec<ProfileFault> {
        let mut faults = Vec::new();
        let mut bad = |limit: &str, value: String| {
            faults.push(ProfileFault::BadLimit {
                limit: limit.to_owned(),
                value,
            });
        };
        for (limit, value) in [
            ("edge_ratio_max", self.edge_ratio_max),
            ("warp_deg_max", self.warp_deg_max),
            ("skew_deg_max", self.skew_deg_max),
            ("scaled_jacobian_min", self.scaled_jacobian_min),
            ("triangle_share_max", self.triangle_share_max),
            ("shortest_edge_min", self.shortest_edge_min),
        ] {
            if value.is_nan() {
                bad(limit, value.to_string());
            }
        }
        for (limit, [from, to]) in [
            ("quad_angle_deg", self.quad_angle_deg),
            ("triangle_angle_deg", self.triangle_angle_deg),
        ] {
            if from.is_nan() || to.is_nan() || from > to {
                bad(limit, format!("[{from}, {to}]"));
            }
        }
        let limits = [("quad", &self.quad), ("triangle", &self.triangle)];
        for (shape, limits) in limits {
            for (metric, range) in limits {
                let min = range.min.unwrap_or(f64::NEG_INFINITY);
                let max = range.max.unwrap_or(f64::INFINITY);
                if min.is_nan() || max.is_nan() || min > max {
                    bad(&format!("{shape}.{metric}"), format!("{min} .. {max}"));
                }
            }
        }
        for (shape, list, limits) in [
            ("quad", &QUAD_METRICS[..], &self.quad),
            ("triangle", &TRIANGLE_METRICS[..], &self.triangle),
        ] {
            let unknown = limits.keys().filter(|name| place_of(list, name).is_none());
            faults.extend(unknown.map(|metric| ProfileFault::UnknownMetric {
                shape,
                metric: metric.clone(),
                known: list.iter().map(|full| bare(full)).collect(),
            }));
        }
        faults
    }
}

/// A limit of a [`Profile`] that one element breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Criterion {
    /// Longest edge over shortest.
    EdgeRatio,
    /// Angle between a quad's two triangles.
    Warp,
    /// Skew.
    Skew,
    /// Scaled Jacobian.
    ScaledJacobian,
    /// A corner angle.
    Angle,
    /// Shortest edge against the target size.
    ShortEdge,
    /// A coordinate is not finite, so that nothing can be told.
    NotFinite,
    /// A limit on a metric by its full name, such as `quad.taper`.
    Metric(&'static str),
}

impl Criterion {
    /// Its name in reports, tables and fields.
    pub fn code(self) -> &'static str {
        match self {
            Criterion::EdgeRatio => "edge-ratio",
            Criterion::Warp => "warp",
            Criterion::Skew => "skew",
            Criterion::ScaledJacobian => "scaled-jacobian",
            Criterion::Angle => "angle",
            Criterion::ShortEdge => "short-edge",
            Criterion::NotFinite => "not-finite",
            Criterion::Metric(name) => name,
        }
    }
}

impl Serialize for Criterion {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.code())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_round_trips() {
        let mut profile = Profile::crash();
        let range = Range {
            min: None,
            max: Some(0.7),
        };
        profile.quad.insert("taper".to_owned(), range);
        let back: Profile = toml::from_str(&toml::to_string(&profile).unwrap()).unwrap();
        assert_eq!(back, profile);
    }

    #[test]
    fn the_profiles_of_the_program_pass_their_own_check() {
        for name in Profile::NAMES {
            let profile = Profile::named(name).unwrap();
            assert_eq!((profile.name.as_str(), profile.check()), (name, vec![]));
        }
        assert_eq!(Profile::named("none"), None);
    }

    #[test]
    fn limits_that_mean_nothing_are_found() {
        let spoilt = |spoil: fn(&mut Profile)| {
            let mut profile = Profile::shell();
            spoil(&mut profile);
            profile.check()[0].to_string()
        };
        let range = |min, max| Range { min, max };
        assert!(spoilt(|p| p.warp_deg_max = f64::NAN).contains("warp_deg_max is NaN"));
        assert!(spoilt(|p| p.quad_angle_deg = [90.0, 45.0]).contains("[90, 45]"));
        let unknown = spoilt(|p| {
            p.triangle.insert("taper".to_owned(), Range::default());
        });
        assert!(unknown.contains("'taper' of a triangle") && unknown.contains("radius_ratio"));
        let mut profile = Profile::shell();
        (profile.quad).insert("taper".to_owned(), range(Some(1.0), Some(0.5)));
        let fault = profile.check()[0].to_string();
        assert!(fault.contains("quad.taper is 1 .. 0.5"), "{fault}");
    }
}
