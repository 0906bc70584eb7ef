//! What a run says about its own result: element quality and the self-audit.
//!
//! Shares are 0 to 1, lengths mm, areas mm², angles degrees. All of it serialises, so that a report can be kept and compared.

use super::ids::ElementId;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A criteria file: what an element must hold to pass. Angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Share of triangles among the elements, at most.
    pub triangle_share_max: f64,
    /// Shortest edge over the target size, at least.
    pub shortest_edge_min: f64,
}

impl Profile {
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
        }
    }
}

/// A limit of a [`Profile`] that one element breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
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
}

/// One metric over all triangles or all quads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MetricSummary {
    /// Its name: `triangle.` or `quad.` and the metric.
    pub name: String,
    /// What Verdict (or the solver that the metric comes from) calls acceptable, from and to.
    pub acceptable: [f64; 2],
    /// Least finite value.
    pub min: f64,
    /// Mean of the finite values.
    pub mean: f64,
    /// Largest finite value.
    pub max: f64,
    /// Share of the elements in the acceptable range.
    pub share_acceptable: f64,
    /// Elements whose value is infinite or not a number.
    pub undefined: usize,
    /// Where the histogram begins and ends; values beyond count in its first and last bin.
    pub histogram_range: [f64; 2],
    /// Elements in each of equally wide bins.
    pub histogram: Vec<usize>,
}

/// One of the worst elements, and where it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorstElement {
    /// Which one.
    pub element: ElementId,
    /// Mean of its corners.
    pub centre: DVec3,
    /// Its scaled Jacobian.
    pub scaled_jacobian: f64,
    /// Its longest edge over its shortest.
    pub edge_ratio: f64,
    /// The limits that it breaks.
    pub fails: Vec<Criterion>,
}

/// Quality of all elements.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QualityReport {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of elements.
    pub elements: usize,
    /// Triangles among them.
    pub triangles: usize,
    /// Quads among them.
    pub quads: usize,
    /// Share of quads.
    pub quad_share: f64,
    /// Area of all elements.
    pub area: f64,
    /// Each metric, triangles first.
    pub metrics: Vec<MetricSummary>,
    /// The criteria used.
    pub profile: Profile,
    /// Share of the elements that pass them all (the limit on the share of triangles aside).
    pub pass_share: f64,
    /// How many elements break each criterion, in order of [`Criterion`]; those that none breaks are left out.
    pub failures: Vec<(Criterion, usize)>,
    /// Up to ten elements of least scaled Jacobian, worst first.
    pub worst: Vec<WorstElement>,
}

/// Beyond what the audit doubts a result. Each is somewhat tighter than what a strict outside judge asks for (R-error 0.1,
/// coverage 0.95, outside 0.01), since two random samples of the same mesh differ by about that much.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AuditLimits {
    /// R-error that 95 % of the mesh may not exceed.
    pub r95: f64,
    /// Share of thin wall area that must be covered.
    pub cover: f64,
    /// Share of mesh area that may lie outside the solid.
    pub outside: f64,
    /// Median relative error of the thickness.
    pub thickness_error: f64,
    /// Share of free edge length that may lie off the rim: a torn seam is far more, a rounded rim less.
    pub free_off: f64,
}

impl Default for AuditLimits {
    fn default() -> Self {
        Self {
            r95: 0.09,
            cover: 0.955,
            outside: 0.008,
            thickness_error: 0.05,
            free_off: 0.05,
        }
    }
}

/// A reason to doubt a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DoubtRule {
    /// Euler characteristics differ.
    Euler,
    /// The number of edge-connected pieces is not that of the solids.
    Pieces,
    /// Too much of the mesh is off the middle.
    RError,
    /// Wall area without mesh.
    Cover,
    /// Mesh outside the solid.
    Outside,
    /// Thickness values that do not fit the solid.
    Thickness,
    /// Free edges that are on no rim.
    FreeEdges,
    /// Elements that are folded over or inside out.
    Flipped,
    /// Neighbours in one sheet with opposite normals.
    Orientation,
    /// Coordinates or thicknesses that are not finite, or elements that name missing nodes.
    NotFinite,
    /// Nodes without element.
    Orphans,
    /// No sample could be measured.
    Unmeasured,
}

impl DoubtRule {
    /// All rules, in the order of reports.
    pub const ALL: [DoubtRule; 12] = [
        DoubtRule::Euler,
        DoubtRule::Pieces,
        DoubtRule::RError,
        DoubtRule::Cover,
        DoubtRule::Outside,
        DoubtRule::Thickness,
        DoubtRule::FreeEdges,
        DoubtRule::Flipped,
        DoubtRule::Orientation,
        DoubtRule::NotFinite,
        DoubtRule::Orphans,
        DoubtRule::Unmeasured,
    ];

    /// Its code in reports.
    pub fn code(self) -> &'static str {
        self.text().0
    }

    /// What it means for a shell model.
    pub fn meaning(self) -> &'static str {
        self.text().1
    }

    /// What to do about it.
    pub fn remedy(self) -> &'static str {
        self.text().2
    }

    fn text(self) -> (&'static str, &'static str, &'static str) {
        match self {
            DoubtRule::Euler => (
                "euler",
                "the mesh has a gap, slit, hole or void that the solid has not, or lacks one that it has",
                "look along the free edges; try another size, or split the part where walls meet in a lump",
            ),
            DoubtRule::Pieces => (
                "pieces",
                "the mesh does not hang together as the solid does: a solver would see parts fly apart",
                "look for free edges inside the part; join the pieces by hand, or try another size",
            ),
            DoubtRule::RError => (
                "r-error",
                "more than one twentieth of the mesh is not midway between the two sides of its wall: bending stiffness is off there",
                "use smaller elements on curved walls; check walls whose two sides are not alike",
            ),
            DoubtRule::Cover => (
                "cover",
                "a wall of the solid has no mesh on its middle: its stiffness and mass are missing",
                "look which wall is bare; very short or tapering walls may need a smaller size",
            ),
            DoubtRule::Outside => (
                "outside",
                "part of the mesh lies outside the material",
                "use smaller elements on curved walls; check rims and junctions",
            ),
            DoubtRule::Thickness => (
                "thickness",
                "the thickness in the mesh is not what the solid measures: stiffness goes with its cube",
                "check walls of varying thickness, or set the thickness of the sheets by hand",
            ),
            DoubtRule::FreeEdges => (
                "free-edges",
                "free edges run inside the part, where no rim is: sheets that should be joined are not, or end too early",
                "look along the free edges; join them by hand, or try another size",
            ),
            DoubtRule::Flipped => (
                "flipped",
                "elements are folded over, inside out or without area: a solver stops on them",
                "try another size; look at the listed worst elements",
            ),
            DoubtRule::Orientation => (
                "orientation",
                "neighbours in one sheet have opposite normals: pressure loads and offsets change sign there",
                "let the pre-processor align the normals of the sheet, unless it is one-sided",
            ),
            DoubtRule::NotFinite => (
                "not-finite",
                "a coordinate or a thickness is not a finite positive number, or an element names a node that does not exist",
                "report the part: no input should lead to this",
            ),
            DoubtRule::Orphans => (
                "orphans",
                "nodes belong to no element: some solvers stop on them",
                "report the part: no input should lead to this",
            ),
            DoubtRule::Unmeasured => (
                "unmeasured",
                "no point of the mesh lies between two sides of the solid, so that nothing could be measured",
                "check that the part is thin-walled and that mesh and solid belong together",
            ),
        }
    }
}

/// One doubt: a value beyond its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    /// Which rule.
    pub rule: DoubtRule,
    /// What was measured.
    pub value: f64,
    /// What would have been right.
    pub limit: f64,
}

impl std::fmt::Display for Doubt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}: {} ({:.4}, limit {:.4})",
            self.rule.code(),
            self.rule.meaning(),
            self.value,
            self.limit
        )
    }
}

impl Serialize for Doubt {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Full {
            code: &'static str,
            value: f64,
            limit: f64,
            meaning: &'static str,
            remedy: &'static str,
        }
        Full {
            code: self.rule.code(),
            value: self.value,
            limit: self.limit,
            meaning: self.rule.meaning(),
            remedy: self.rule.remedy(),
        }
        .serialize(serializer)
    }
}

/// What the audit thinks of the result.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Every measure is within its limit.
    Right,
    /// These are not.
    Doubted(Vec<Doubt>),
}

/// The self-audit: the result measured against the solid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AuditReport {
    /// Euler characteristic of the mesh, nodes - edges + elements.
    pub euler: i64,
    /// That of the solids: half of their boundaries'.
    pub euler_solid: f64,
    /// Edge-connected pieces of the mesh.
    pub pieces: usize,
    /// Number of solids.
    pub solids: usize,
    /// Nodes without element.
    pub orphans: usize,
    /// Median R-error |d1 - d2| / (d1 + d2), away from junctions and folds; none where no sample could be measured.
    pub r50: Option<f64>,
    /// R-error that 95 % of the samples do not exceed.
    pub r95: Option<f64>,
    /// Share of the samples with R-error in [0, 0.5 %), [0.5, 1 %), [1, 10 %), [10, 20 %) and more.
    pub r_bins: [f64; 5],
    /// Share of the mesh area that r50 and r95 speak of.
    pub judged_share: f64,
    /// Share of the thin wall area whose mid-point has mesh nearby.
    pub cover: f64,
    /// Share of the solid's surface that is thin wall.
    pub thin_share: f64,
    /// Median distance between the two sides of the thin wall.
    pub thickness_median: Option<f64>,
    /// Share of the mesh area outside the solid.
    pub outside: f64,
    /// Share of the free edge length that is on no rim.
    pub free_off: f64,
    /// Length of all free edges.
    pub free_length: f64,
    /// Sum of area times thickness over volume, less one; junction overlaps make it a little positive.
    pub mass: f64,
    /// Median relative error of the thickness.
    pub thickness_error: Option<f64>,
    /// Share of the mesh area in elements that no pair of faces places.
    pub unsure_share: f64,
    /// Elements that are folded over, inside out or without area.
    pub flipped: usize,
    /// Edges inside a sheet whose two elements have opposite normals.
    pub misoriented: usize,
    /// Elements with coordinates or thicknesses that are not finite and positive, or with missing nodes.
    pub not_finite: usize,
    /// The limits used.
    pub limits: AuditLimits,
    /// What follows from all that.
    pub verdict: Verdict,
}

impl AuditReport {
    /// Whether nothing is doubted.
    pub fn is_right(&self) -> bool {
        self.verdict == Verdict::Right
    }

    /// The doubts; none where the result is right.
    pub fn doubts(&self) -> &[Doubt] {
        match &self.verdict {
            Verdict::Right => &[],
            Verdict::Doubted(doubts) => doubts,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rule_has_a_code_of_its_own_and_both_sentences() {
        let mut codes: Vec<&str> = DoubtRule::ALL.iter().map(|r| r.code()).collect();
        codes.sort_unstable();
        codes.dedup();
        assert_eq!(codes.len(), DoubtRule::ALL.len());
        for rule in DoubtRule::ALL {
            assert!(rule.meaning().len() > 20 && rule.remedy().len() > 20);
            assert_eq!(
                serde_json::to_value(rule).unwrap(),
                serde_json::json!(rule.code()),
            );
        }
    }

    #[test]
    fn a_doubt_serialises_with_its_words_and_a_profile_round_trips() {
        let doubt = Doubt {
            rule: DoubtRule::Cover,
            value: 0.5,
            limit: 0.955,
        };
        let json = serde_json::to_value(Verdict::Doubted(vec![doubt])).unwrap();
        assert_eq!(json["doubted"][0]["code"], "cover");
        assert!(json["doubted"][0]["remedy"].is_string());
        let profile: Profile =
            toml::from_str(&toml::to_string(&Profile::shell()).unwrap()).unwrap();
        assert_eq!(profile, Profile::shell());
    }
}
