//! From a filled solid to its placed mid-complex: several least widths of walls are tried, and the one that is right and covers most wall is kept.
//!
//! The topology certificate costs nothing, so the choice of what counts as a wall need not be made beforehand.

use super::clock::Clock;
use super::error::PipelineError;
use super::seen::Seen;
use crate::geom::orient;
use crate::medial::Medial;
use crate::model::brep::Brep;
use crate::model::complex::MidComplex;
use crate::model::decomposition::{FaceRoles, Grade, Passage};
use crate::model::ids::{IndexVec, TetEdgeId};
use crate::model::sighting::Sighting;
use crate::model::tet_graph::TetGraph;
use crate::model::walls::{Aag, Pairing};
use crate::stage::assess::{Assessment, assess};
use crate::stage::pair::PairOptions;
use crate::stage::{
    adjacency, collapse, decompose, extract, pair, prune, reach, role, unite, widen,
};

/// Least widths of a wall that are tried, in thicknesses, the literature's first.
const WIDTHS: [f64; 3] = [1.0, 0.5, 0.25];
/// Least width of the walls between bores and the faces beside them.
const BESIDE_BORES: f64 = 0.5;
/// Least share of a face that must be seen for it to be a side of such a wall: looks within 30 degrees meet a strip of the bore half its diameter wide, so that
/// this lets in faces three times as wide as the bore.
const BORE_COVER: f64 = 0.15;
/// Walls beside bores and lumps are tried where no complex so far is this good: less than a tenth is lost at rims and in blocks.
const WALLS_MISSED: f64 = 0.9;
/// They must win by this much: what differs by less is chance, and more sheets in narrow places are more that can fold.
const CLEARLY: f64 = 0.02;
/// A complex this good is taken without trying further: what is left is a sample or two at the rims.
const GOOD_ENOUGH: f64 = 0.985;
/// Rounds of widening bars; one is nearly always enough, since every bar is widened at once.
const ROUNDS: usize = 10;

/// The mid-surface of one solid, with what it was read from.
#[derive(Clone, Debug)]
pub struct MidSurface {
    /// Adjacency of the faces.
    pub aag: Aag,
    /// Pairs and walls.
    pub pairing: Pairing,
    /// Roles of the faces.
    pub roles: FaceRoles,
    /// The placed complex.
    pub complex: MidComplex,
    /// How well it stands for the solid.
    pub assessment: Assessment,
    /// Whether its topology is right and all its sheets have two sides.
    pub right: bool,
    /// The wall width that was asked for.
    pub least_width: f64,
}

struct Source<'a> {
    brep: &'a Brep,
    graph: TetGraph,
    aag: Aag,
    sightings: &'a [Sighting],
    /// Euler characteristic of the mid-surface: half of the boundary's.
    euler: f64,
}

/// Finds the mid-surface.
pub(super) fn mid_surface(seen: &Seen, clock: &mut Clock<'_>) -> Result<MidSurface, PipelineError> {
    let Seen { piece, sightings } = seen;
    let brep = &piece.brep;
    let aag = clock.time("adjacency", || adjacency::adjacency(brep));
    let graph = clock.time("decompose", || TetGraph::new(&piece.tets));
    let euler = brep.euler() as f64 / 2.0;
    let source = Source {
        brep,
        graph,
        aag,
        sightings,
        euler,
    };
    let mut best: Option<MidSurface> = None;
    for least_width in WIDTHS {
        let options = PairOptions {
            least_width,
            ..PairOptions::default()
        };
        let Some(found) = candidate(&source, &options, clock)? else {
            continue;
        };
        if best.as_ref().is_none_or(|b| rank(&found) > rank(b)) {
            best = Some(found);
        }
        if best.as_ref().is_some_and(|b| rank(b) > (true, GOOD_ENOUGH)) {
            break;
        }
    }
    // Lumps alone are no thin-walled part: where no wall was found none can have been missed.
    if let Some(walls) = best.as_ref().map(rank)
        && walls < (true, WALLS_MISSED)
    {
        for options in beside_bores() {
            let Some(found) = candidate(&source, &options, clock)? else {
                continue;
            };
            let (right, score) = rank(&found);
            let clearly = (right, score - CLEARLY) > walls;
            if clearly && best.as_ref().is_none_or(|b| rank(&found) > rank(b)) {
                best = Some(found);
            }
        }
    }
    best.ok_or(PipelineError::NoThinWall {
        solid: brep.solid_tag,
        faces: brep.faces.len(),
    })
}

/// Walls beside bores, first without and then with the lumps between walls.
fn beside_bores() -> [PairOptions; 2] {
    [false, true].map(|lumps| PairOptions {
        least_width: BESIDE_BORES,
        least_cover: BORE_COVER,
        lumps,
        ..PairOptions::default()
    })
}

/// Right topology first, then the score. A wall has two sides, and so has its sheet: one with a single side goes over from a wall's one side to its other, as sheets do where a bore
/// beside a rim was taken for a wall.
fn rank(found: &MidSurface) -> (bool, f64) {
    (found.right, found.assessment.score())
}

fn candidate(
    source: &Source<'_>,
    options: &PairOptions,
    clock: &mut Clock<'_>,
) -> Result<Option<MidSurface>, PipelineError> {
    let Source {
        brep,
        graph,
        aag,
        sightings,
        euler,
    } = source;
    let pairing = clock.time("pair", || pair::pair(brep, aag, sightings, options));
    if pairing.pairs.is_empty() {
        return Ok(None);
    }
    fault("pair", pairing.check().first())?;
    let roles = clock.time("role", || role::roles(aag, &pairing));
    let decomposition = clock.time("decompose", || {
        decompose::decompose(brep, graph, &pairing, &roles)
    });
    let collapsed = clock.time("collapse", || {
        let grade: IndexVec<TetEdgeId, Grade> =
            decomposition.passage.iter().map(|&p| p as Grade).collect();
        let mut protected: IndexVec<TetEdgeId, bool> = decomposition
            .passage
            .iter()
            .map(|&p| p != Passage::Along)
            .collect();
        let mut collapsed = collapse::collapse(graph, brep.vertices.len(), &protected, &grade);
        for _ in 0..ROUNDS {
            let more = widen::widen(graph, &collapsed, &grade);
            if more.is_empty() {
                break;
            }
            for e in more {
                protected[e] = true;
            }
            collapsed = collapse::collapse(graph, brep.vertices.len(), &protected, &grade);
        }
        collapsed
    });
    let medial = clock.time("midpoint", || {
        let mut medial = Medial::new(brep, aag, &pairing);
        medial.let_bevels_stand(true);
        medial
    });
    let complex = clock.time("midpoint", || {
        let (walls, _) = extract::cell_walls(
            brep,
            graph,
            &pairing,
            &decomposition,
            &collapsed.cells,
            &medial,
        );
        extract::extract(brep, graph, &pairing, &walls, &medial)
    });
    if complex.triangles.is_empty() {
        return Ok(None);
    }
    fault("midpoint", complex.check().first())?;
    let (complex, pairing, medial) = clock.time("unite", || {
        let (complex, pairing) = unite::unite(complex, pairing, &medial);
        let medial = medial.paired(aag, &pairing);
        let complex = extract::place(complex, &medial);
        match unite::over_steps(&complex, &pairing, aag, &medial) {
            Some((complex, pairing)) => {
                let medial = medial.paired(aag, &pairing);
                (extract::place(complex, &medial), pairing, medial)
            }
            None => (complex, pairing, medial),
        }
    });
    let complex = clock.time("unite", || {
        let (complex, _) = prune::prune(complex, &medial);
        let complex = reach::reach_rims(complex, brep, aag, &pairing, &medial);
        extract::place(complex, &medial)
    });
    drop(medial);
    fault("unite", pairing.check().first())?;
    let assessment = clock.time("assess", || assess(brep, sightings, &complex));
    let right =
        complex.euler() as f64 == *euler && complex.pieces() == 1 && orient::two_sided(&complex);
    Ok(Some(MidSurface {
        aag: aag.clone(),
        pairing,
        roles,
        complex,
        assessment,
        right,
        least_width: options.least_width,
    }))
}

fn fault<F: ToString>(stage: &'static str, first: Option<F>) -> Result<(), PipelineError> {
    match first {
        None => Ok(()),
        Some(f) => Err(PipelineError::Internal {
            stage,
            what: f.to_string(),
        }),
    }
}
