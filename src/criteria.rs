//! Criteria files: a profile as TOML.
//!
//! Every limit is optional and stands on top of those of `base` (`shell` where none is named), so that a company's file says only what differs:
//!
//! ```toml
//! name = "body in white"
//! base = "crash"
//! warp_deg_max = 8
//! quad_angle_deg = [40, 140]
//!
//! [quad]
//! taper = { max = 0.5 }
//!
//! [triangle]
//! radius_ratio = { max = 2.5 }
//! ```
//!
//! A name that is no limit and no metric is refused, and the message lists those that there are: a misspelt limit that counts for nothing is worse than none.

use crate::model::profile::{Profile, ProfileFault, Range};
use crate::toml_text;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Why a criteria file is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CriteriaError {
    /// It is no TOML, or has a key that means nothing.
    #[error("{0}")]
    Toml(String),
    /// Its base is unknown.
    #[error("there is no profile '{0}' to stand on; there are: {names}", names = Profile::NAMES.join(", "))]
    UnknownBase(String),
    /// A limit means nothing.
    #[error(transparent)]
    Profile(#[from] ProfileFault),
}

impl CriteriaError {
    /// What the user can do.
    pub fn remedy(&self) -> String {
        match self {
            CriteriaError::Toml(_) => {
                "write it as TOML with the limits that `midshell audit --help` names".into()
            }
            CriteriaError::UnknownBase(_) => {
                format!("name one of: {}", Profile::NAMES.join(", "))
            }
            CriteriaError::Profile(ProfileFault::UnknownMetric { .. }) => {
                "use one of these names, as in taper = { max = 0.7 }".into()
            }
            CriteriaError::Profile(ProfileFault::BadLimit { .. }) => {
                "give a number, or leave the limit out: then that of the base holds".into()
            }
        }
    }
}

/// A criteria file as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: Option<String>,
    base: Option<String>,
    edge_ratio_max: Option<f64>,
    warp_deg_max: Option<f64>,
    skew_deg_max: Option<f64>,
    scaled_jacobian_min: Option<f64>,
    quad_angle_deg: Option<[f64; 2]>,
    triangle_angle_deg: Option<[f64; 2]>,
    triangle_share_max: Option<f64>,
    shortest_edge_min: Option<f64>,
    #[serde(default)]
    quad: BTreeMap<String, Range>,
    #[serde(default)]
    triangle: BTreeMap<String, Range>,
}

/// Reads a criteria file; `name` is what it is called where it does not say so itself.
pub fn parse(text: &str, name: &str) -> Result<Profile, CriteriaError> {
    let file: File = toml_text::parse(text).map_err(CriteriaError::Toml)?;
    let base = file.base.as_deref().unwrap_or("shell");
    let base = Profile::named(base).ok_or_else(|| CriteriaError::UnknownBase(base.to_owned()))?;
    let mut profile = Profile {
        name: file.name.unwrap_or_else(|| name.to_owned()),
        edge_ratio_max: file.edge_ratio_max.unwrap_or(base.edge_ratio_max),
        warp_deg_max: file.warp_deg_max.unwrap_or(base.warp_deg_max),
        skew_deg_max: file.skew_deg_max.unwrap_or(base.skew_deg_max),
        scaled_jacobian_min: file.scaled_jacobian_min.unwrap_or(base.scaled_jacobian_min),
        quad_angle_deg: file.quad_angle_deg.unwrap_or(base.quad_angle_deg),
        triangle_angle_deg: file.triangle_angle_deg.unwrap_or(base.triangle_angle_deg),
        triangle_share_max: file.triangle_share_max.unwrap_or(base.triangle_share_max),
        shortest_edge_min: file.shortest_edge_min.unwrap_or(base.shortest_edge_min),
        quad: base.quad,
        triangle: base.triangle,
    };
    profile.quad.extend(file.quad);
    profile.triangle.extend(file.triangle);
    match profile.check().into_iter().next() {
        Some(fault) => Err(fault.into()),
        None => Ok(profile),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_file_leaves_out_is_that_of_its_base() {
        assert_eq!(parse("name = \"shell\"", "x"), Ok(Profile::shell()));
        let file = "base = 'crash'\nwarp_deg_max = 8\n[quad]\ntaper = { max = 0.5 }";
        let profile = parse(file, "ours").unwrap();
        let range = Range {
            min: None,
            max: Some(0.5),
        };
        let want = Profile {
            name: "ours".into(),
            warp_deg_max: 8.0,
            quad: BTreeMap::from([("taper".to_owned(), range)]),
            ..Profile::crash()
        };
        assert_eq!(profile, want);
    }

    #[test]
    fn names_that_mean_nothing_are_told_with_those_that_do() {
        for (text, words) in [
            ("warpage_max = 5", &["warpage_max", "warp_deg_max"][..]),
            (
                "[quad]\nradius = { max = 1 }",
                &["'radius' of a quad", "taper"],
            ),
            ("[quad]\ntaper = { most = 1 }", &["most", "max"]),
            ("base = 'steel'", &["steel", "crash"]),
            ("warp_deg_max = nan", &["warp_deg_max"]),
            ("warp_deg_max = 'x'", &["line 1"]),
            ("warp_deg_max", &["line 1"]),
        ] {
            let error = parse(text, "x").unwrap_err();
            for word in words {
                assert!(error.to_string().contains(word), "{text}: {error}");
            }
            assert!(error.remedy().len() > 10);
        }
    }
}
