//! The last resort: gmsh meshes the surface only, which hardly ever fails, and fTetWild fills it, however bad it is.
//!
//! Guarantee: what comes back has the volume of the CAD solid within half a percent. Limits: see [`relabel`](super::relabel).

use super::error::NO_TETWILD;
use super::process::Ended;
use super::relabel::relabel;
use super::script::{self, Facts, SURFACES, SolidFacts};
use super::skin::{Skin, skins};
use super::tetwild::{self, FillOptions, TetWild};
use super::{ImportError, TetWildError};
use super::{Imported, Job, MeshFault, Piece, gmsh, msh, volume};

/// Envelopes that are tried, in mean thicknesses: wide ones are faster, narrow ones keep the volume of a part with walls far thinner than the mean.
const ENVELOPES: [f64; 2] = [0.05, 0.015];
/// A facet may sag by this share of the envelope.
const SAG: f64 = 0.5;
/// More facets than this take fTetWild over a minute.
const MOST_FACETS: usize = 150_000;

/// Fills the part; nothing where that is not possible, and then the reason is in `attempts`.
pub(super) fn try_it(
    job: &Job<'_>,
    facts: Facts,
    attempts: &mut Vec<String>,
    tell: &mut dyn FnMut(&str),
) -> Result<Option<Imported>, ImportError> {
    let tool = match tetwild::find_tetwild(Some(&job.launcher.path)) {
        Ok(tool) => tool,
        Err(error) => {
            let reason = match error {
                TetWildError::Missing { .. } => NO_TETWILD.to_owned(),
                other => other.to_string(),
            };
            attempts.push(format!("fTetWild: {reason}"));
            return Ok(None);
        }
    };
    for attempt in &SURFACES {
        let left = job.budget.left();
        if left.is_zero() {
            attempts.push(format!("{}: out of time", attempt.name));
            break;
        }
        tell(attempt.name);
        // A surface that takes longer leaves no time to fill it.
        let run = job.start(attempt, facts, left / 2)?;
        let version = gmsh::version_in(&run.log).unwrap_or_default();
        let found = match run.ended {
            Ended::TimedOut => Err("out of time in the surface".to_owned()),
            Ended::Exit(_) => {
                let solids = SolidFacts::in_log(&run.log);
                fill_all(job, &tool, &solids).map_err(|e| e.to_string())
            }
        };
        match found {
            Ok(pieces) => {
                return Ok(Some(Imported {
                    pieces,
                    gmsh_version: version,
                    way: format!("{} (pytetwild {})", attempt.name, tool.version),
                    attempts: std::mem::take(attempts),
                    notes: Vec::new(),
                }));
            }
            Err(reason) => {
                let line = format!("{}: {reason}", attempt.name);
                tell(&line);
                attempts.push(line);
            }
        }
    }
    Ok(None)
}

fn fill_all(job: &Job<'_>, tool: &TetWild, solids: &[SolidFacts]) -> Result<Vec<Piece>, MeshFault> {
    let bytes = std::fs::read(job.folder.join(script::MESH))
        .map_err(|e| MeshFault::TetWild(TetWildError::Run(e.to_string())))?;
    let skins = skins(&msh::Msh::parse(&bytes)?)?;
    let mut pieces = Vec::with_capacity(skins.len());
    for skin in &skins {
        let facts = solids.iter().find(|s| s.tag == skin.solid_tag);
        let facts = facts.filter(|f| f.volume > 0.0 && f.area > 0.0);
        let facts = *facts.ok_or(MeshFault::Surface { facets: 0 })?;
        pieces.push(fill_one(job, tool, skin, &facts)?);
    }
    Ok(pieces)
}

fn fill_one(
    job: &Job<'_>,
    tool: &TetWild,
    skin: &Skin,
    facts: &SolidFacts,
) -> Result<Piece, MeshFault> {
    let mut last = MeshFault::Surface { facets: 0 };
    for share in ENVELOPES {
        let envelope = share * facts.thickness();
        let (points, triangles) = skin.triangles(SAG * envelope);
        if triangles.is_empty() || triangles.len() > MOST_FACETS {
            return Err(MeshFault::Surface {
                facets: triangles.len(),
            });
        }
        let options = FillOptions {
            edge_length: facts.size(job.options.size_factor),
            envelope,
            time_limit: job.budget.left(),
            memory_limit: job.options.memory_limit,
        };
        let filling = tetwild::fill_counted(tool, &points, &triangles, &options, &job.budget)?;
        let piece = relabel(skin, &filling, envelope)?;
        match volume::fault(&piece, std::slice::from_ref(facts)) {
            None => return Ok(piece),
            Some(fault) => last = fault,
        }
    }
    Err(last)
}
