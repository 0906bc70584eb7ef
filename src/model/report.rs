//! What a run says about its own result: element quality and the self-audit.
//!
//! Shares are 0 to 1, lengths mm, areas mm², angles degrees. All of it serialises, so that a report can be kept and compared.

pub use super::doubt::{Doubt, DoubtRule, Place};
use super::ids::ElementId;
pub use super::profile::{Criterion, Profile};
use glam::DVec3;
use serde::{Deserialize, Serialize};

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

/// Beyond what the audit doubts a result: the one place of its limits. Those that an outside judge has too (a twentieth of the mesh with an R-error over 0.1,
/// coverage 0.95, outside 0.01) are somewhat tighter here, since two random samples of the same mesh differ by about that much, and two tessellations of a
/// convex side by more. The margin is one of shares: percentiles leap where the mesh is either midway or far off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AuditLimits {
    /// R-error beyond which a place is off the middle: at a tenth a wall's bending stiffness is off by 3 %.
    pub r_error: f64,
    /// Share of the mesh that may be off the middle; of it [`AuditLimits::off_middle_of`] takes the margin.
    pub off_middle: f64,
    /// Share of thin wall area that must be covered: the rest is what rims and junction blocks leave of short walls.
    pub cover: f64,
    /// Share of mesh area that may lie outside the solid: a sample or two in a hundred at the ends of oblique rims.
    pub outside: f64,
    /// Median relative error of the thickness: stiffness goes with its cube, so that it is off by 15 % there.
    pub thickness_error: f64,
    /// Share of the solid's material that may be missing or there twice: right meshes of parts with large blocks lack or exceed up to a fifth.
    pub mass: f64,
    /// Share of free edge length that may lie off the rim: a torn seam is far more, a rounded rim less.
    pub free_off: f64,
    /// Steps of elimination that the homology may cost; beyond, voids are not counted, and the report says so. So many are a fraction of
    /// a second; meshes of 175,000 elements stay below.
    pub homology_steps: usize,
}

/// Samples that an outside check of a mesh takes: ours of old, and the judge's.
const OUTSIDE_SAMPLES: f64 = 10_000.0;
/// Standard deviations that a share stays below its limit by, so that another count of samples finds it below nineteen times out of twenty.
const SURE: f64 = 1.645;

impl AuditLimits {
    /// The share that may be off the middle of a mesh of which this share is judged: of a small share an outside check knows little, and its count scatters the more.
    pub fn off_middle_of(&self, judged_share: f64) -> f64 {
        let p = self.off_middle;
        let judged = (OUTSIDE_SAMPLES * judged_share).max(1.0);
        (p - SURE * (p * (1.0 - p) / judged).sqrt()).max(0.0)
    }
}

impl Default for AuditLimits {
    fn default() -> Self {
        Self {
            r_error: 0.1,
            off_middle: 0.05,
            cover: 0.955,
            outside: 0.0065,
            thickness_error: 0.05,
            mass: 0.25,
            free_off: 0.05,
            homology_steps: 20_000_000,
        }
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
    /// Betti numbers of the mesh over Z/2: pieces, loops, voids; none where they would have cost more than the limit.
    pub betti: Option<[usize; 3]>,
    /// Those of the solids.
    pub betti_solid: [usize; 3],
    /// Nodes without element.
    pub orphans: usize,
    /// Median R-error |d1 - d2| / (d1 + d2), away from junctions and folds; none where no sample could be measured.
    pub r50: Option<f64>,
    /// R-error that 95 % of the samples do not exceed.
    pub r95: Option<f64>,
    /// Share of the samples that are off the middle.
    pub off_middle: f64,
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
    /// Sum of area times thickness over volume, less one: what a solver weighs. Junction overlaps make it a little positive.
    pub mass: f64,
    /// The same, but what several sheets hold at a junction counts once: what the mesh lacks or has too much of.
    pub mass_once: f64,
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
    /// #E which doubts an element gives rise to, as sums of [`DoubtRule::bit`]: 0 for none.
    #[serde(skip)]
    pub element_doubts: Vec<u32>,
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
