//! The self-audit: measures the finished mesh against the solid that it came from, and says whether to trust it.
//!
//! Input: the boundaries of the solids and one shell mesh for all of them. Samples are spread over mesh and boundary from a seed;
//! rays find the walls on either side, distances are taken to the curved facets. Nothing of how the mesh was made is used.
//!
//! A doubt names its places ([`Place`](crate::model::report::Place)): coordinates, faces of the solid, elements, the largest first; and every element that gives
//! rise to one carries its bit. Walls without mesh have no element: there the faces say where.
//!
//! Guarantees: the same report for the same input and seed on any number of threads; elements that cannot be measured are counted
//! and doubted, never skipped in silence.
//! Limits: blind to defects smaller than a sample's share of the area (a ten-thousandth of the boundary, a quarter of that of the mesh), but for the exact counts of topology.

mod coverage;
mod homology;
mod material;
mod places;
mod sampling;
mod skin;
mod suspects;
mod topology;
mod walls;

use crate::model::brep::Brep;
use crate::model::ids::Id;
use crate::model::report::{AuditLimits, AuditReport, Doubt, DoubtRule, Verdict};
use crate::model::shell::ShellMesh;
use glam::DVec3;

/// Samples of the boundary: shares come out to a percent or better.
const SAMPLES: usize = 10_000;
/// Samples of the mesh: so many that what they leave uncertain of a share is half of what the limits keep as a margin.
const MESH_SAMPLES: usize = 40_000;

/// Audits the mesh of these solids with the default limits.
pub fn audit(pieces: &[&Brep], mesh: &ShellMesh, seed: u64) -> AuditReport {
    audit_with(pieces, mesh, seed, AuditLimits::default())
}

/// Audits the mesh of these solids.
pub fn audit_with(
    pieces: &[&Brep],
    mesh: &ShellMesh,
    seed: u64,
    limits: AuditLimits,
) -> AuditReport {
    let skin = skin::Skin::new(pieces);
    let topology = topology::look_at(mesh);
    let homology = homology::of_mesh(mesh, topology.euler, limits.homology_steps);
    let (betti_solid, voids) = homology::of_solids(pieces);
    let flat = walls::Flat::new(mesh, |id| topology::is_sound(mesh, id));
    let special: Vec<[DVec3; 2]> = topology
        .special
        .iter()
        .filter_map(|[a, b]| Some([*mesh.nodes.get(*a)?, *mesh.nodes.get(*b)?]))
        .collect();
    let measure = walls::Measure::new(&skin, mesh, &flat, &special);
    let walls = measure.samples(MESH_SAMPLES, seed);
    let off_middle = walls.off_middle(limits.r_error);
    // Another seed, so that the two sets of samples have nothing to do with each other.
    let seed = seed.wrapping_add(1);
    let coverage = coverage::measure(&skin, mesh, &flat, &topology.free, SAMPLES, seed);
    // Material over the solid's volume, less one.
    let against_volume = |material: f64| match skin.volume {
        volume if volume > 0.0 => material / volume - 1.0,
        _ => 0.0,
    };
    let material = flat.material();
    let once = material::counted_once(mesh, &flat, &topology, SAMPLES, seed.wrapping_add(1));
    let mut report = AuditReport {
        euler: topology.euler,
        euler_solid: skin.euler,
        pieces: topology.pieces,
        solids: pieces.len(),
        betti: homology.as_ref().map(|h| h.betti),
        betti_solid,
        orphans: topology.orphans.len(),
        r50: walls.r50,
        r95: walls.r95,
        off_middle,
        r_bins: walls.r_bins,
        judged_share: walls.judged_share,
        cover: coverage.cover,
        thin_share: coverage.thin_share,
        thickness_median: coverage.thickness_median,
        outside: walls.outside,
        free_off: coverage.free_off,
        free_length: coverage.free_length,
        mass: against_volume(material),
        mass_once: against_volume(material * once),
        thickness_error: walls.thickness_error,
        unsure_share: flat.share(|id| mesh.elements[id].unsure),
        flipped: topology.flipped.len(),
        misoriented: topology.misoriented.len(),
        not_finite: topology.not_finite.len(),
        limits,
        verdict: Verdict::Right,
        element_doubts: vec![0; mesh.elements.len()],
    };
    let beyond = beyond(&report);
    if beyond.is_empty() {
        return report;
    }
    let seen = suspects::Seen {
        pieces,
        skin: &skin,
        mesh,
        topology: &topology,
        homology: homology.as_ref(),
        voids: &voids,
        measure: &measure,
        walls: &walls,
        coverage: &coverage,
        limits,
    };
    let doubts = beyond
        .into_iter()
        .map(|(rule, value, limit)| {
            let findings = seen.findings(rule);
            for id in findings.iter().flat_map(|f| &f.elements) {
                report.element_doubts[id.index()] |= rule.bit();
            }
            let (places, place_count) = places::gather(&findings);
            Doubt {
                rule,
                value,
                limit,
                places,
                place_count,
            }
        })
        .collect();
    report.verdict = Verdict::Doubted(doubts);
    report
}

/// Every measure that is beyond its limit, in the order of the rules: the rule, the value, the limit.
fn beyond(report: &AuditReport) -> Vec<(DoubtRule, f64, f64)> {
    let limits = &report.limits;
    DoubtRule::ALL
        .into_iter()
        .filter_map(|rule| {
            let (value, limit, doubted) = match rule {
                DoubtRule::Euler => {
                    let (value, limit) = (report.euler as f64, report.euler_solid);
                    (value, limit, (value - limit).abs() >= 0.5)
                }
                DoubtRule::Pieces => {
                    let (value, limit) = (report.pieces as f64, report.solids as f64);
                    (value, limit, report.pieces != report.solids)
                }
                DoubtRule::RError => {
                    above(report.off_middle, limits.off_middle_of(report.judged_share))
                }
                DoubtRule::Cover => {
                    let value = report.cover;
                    (value, limits.cover, value < limits.cover)
                }
                DoubtRule::Outside => above(report.outside, limits.outside),
                DoubtRule::Thickness => above(
                    report.thickness_error.unwrap_or(0.0),
                    limits.thickness_error,
                ),
                DoubtRule::FreeEdges => above(report.free_off, limits.free_off),
                DoubtRule::Flipped => above(report.flipped as f64, 0.0),
                DoubtRule::Orientation => above(report.misoriented as f64, 0.0),
                DoubtRule::NotFinite => above(report.not_finite as f64, 0.0),
                DoubtRule::Orphans => above(report.orphans as f64, 0.0),
                DoubtRule::Unmeasured => (report.judged_share, 0.0, report.r95.is_none()),
                DoubtRule::Voids => {
                    let found = report.betti.map_or(report.betti_solid[2], |b| b[2]);
                    let (value, limit) = (found as f64, report.betti_solid[2] as f64);
                    (value, limit, value != limit)
                }
                DoubtRule::Mass => above(report.mass_once.abs(), limits.mass),
            };
            doubted.then_some((rule, value, limit))
        })
        .collect()
}

/// A measure that may not be above its limit; what is not a number is.
fn above(value: f64, limit: f64) -> (f64, f64, bool) {
    (value, limit, value > limit || value.is_nan())
}

#[cfg(test)]
mod place_tests;
#[cfg(test)]
mod tests;
