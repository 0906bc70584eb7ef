//! Facet input: STL, OBJ and PLY in, solids with faces, curves and tets out.
//!
//! Order: read ([`stl`], [`obj`], [`ply`]), weld ([`weld`]), turn outwards, close small holes and part into solids ([`shells`]), find the faces ([`segment`]),
//! bring the facets to a size that a wall can be filled at ([`remesh`]), fill by gmsh or fTetWild (`fill`).
//!
//! Guarantees: no bytes make it panic; what is mended is counted in [`Imported::notes`] where it was more than welding; what is no solid is refused with
//! the reason, the places and the counts. Limits: facet files name no unit: the caller does, or mm are assumed ([`Imported::notes`]); faces are as good as the tessellation.

mod assemble;
mod bulge;
mod cuts;
mod fill;
pub mod obj;
pub mod ply;
pub mod remesh;
pub mod segment;
pub mod shells;
mod sides;
pub mod soup;
pub mod stl;
mod unit;
pub mod weld;

use std::f64::consts::TAU;
use std::path::Path;

use super::error::{ImportError, MeshFault};
use super::gmsh::Launcher;
use super::msh::Msh;
use super::relabel::relabel;
use super::spent::Budget;
use super::tetwild::{self, FillOptions};
use super::{GMSH_SHARE, ImportOptions, Imported, Piece, TetWildError, piece, volume};
use fill::{DELAUNAY, FillFault, Filler, HXT};
use remesh::{Remeshed, Wanted};
use soup::{ReadError, Soup};

/// A facet format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FacetFormat {
    /// STL, ASCII or binary.
    Stl,
    /// Wavefront OBJ.
    Obj,
    /// PLY, ASCII or binary.
    Ply,
}

impl FacetFormat {
    /// The format with this extension in lower case.
    pub fn of_extension(extension: &str) -> Option<Self> {
        match extension {
            "stl" => Some(Self::Stl),
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            _ => None,
        }
    }

    /// Reads the bytes of a whole file.
    pub fn parse(self, bytes: &[u8]) -> Result<Soup, ReadError> {
        match self {
            Self::Stl => stl::parse_stl(bytes),
            Self::Obj => obj::parse_obj(bytes),
            Self::Ply => ply::parse_ply(bytes),
        }
    }
}

/// The surface may depart from the file's by this share of the mean thickness: a hundredth of what a wall is measured in.
const DEVIATION: f64 = 0.01;
/// Facets around a full circle, as in the CAD import.
const PER_CIRCLE: f64 = 16.0;
/// Ways to fill, in order. Beside a sliver a point on the smooth surface may lie beyond the next facet: then the facets as they are may do.
const WAYS: [(&str, u32, bool); 3] = [
    ("HXT", HXT, true),
    ("HXT on flat facets", HXT, false),
    ("Delaunay on flat facets", DELAUNAY, false),
];
/// Envelope of fTetWild in mean thicknesses, as in the CAD import.
const ENVELOPE: f64 = 0.05;
/// Facets that a fill may take at most: more take gmsh over a minute.
const MOST_FACETS: usize = 300_000;

/// Reads a facet file and fills its solids.
pub(super) fn import_facets(
    path: &Path,
    format: FacetFormat,
    options: &ImportOptions,
    tell: &mut dyn FnMut(&str),
) -> Result<Imported, ImportError> {
    let launcher = Launcher::find(options.gmsh.as_deref())?;
    let bytes = std::fs::read(path).map_err(|cause| ImportError::Unreadable {
        path: path.to_path_buf(),
        cause,
    })?;
    let soup = format
        .parse(&bytes)
        .map_err(|cause| ImportError::BadFacets {
            path: path.to_path_buf(),
            cause,
        })?;
    drop(bytes);
    let notes = unit::notes(&soup, options.unit);
    notes.iter().for_each(|note| tell(note));
    let (welded, _) = weld::weld(&soup);
    drop(soup);
    let (mut solids, mended) = shells::solids(welded).map_err(|cause| ImportError::NotASolid {
        path: path.to_path_buf(),
        cause,
    })?;
    // fTetWild would unite them, but a part drawn so has walls within walls, which no shell stands for.
    if let Some(cause) = solids.iter().find_map(|s| s.cut.clone()) {
        return Err(ImportError::NotASolid {
            path: path.to_path_buf(),
            cause,
        });
    }
    // Only now, so that refusals name places in the file's own numbers.
    let mm = options.unit.unwrap_or_default().mm();
    for p in solids.iter_mut().flat_map(|s| &mut s.facets.points) {
        *p *= mm;
    }
    let folder = tempfile::Builder::new()
        .prefix("midshell-")
        .tempdir()
        .map_err(|cause| ImportError::NoFolder {
            path: std::env::temp_dir(),
            cause,
        })?;
    let job = Job {
        path,
        options,
        filler: Filler {
            launcher: &launcher,
            folder: folder.path(),
            threads: options.threads.unwrap_or(1),
            memory_limit: options.memory_limit,
        },
        budget: Budget::new(options.time_limit),
    };
    let mut imported = Imported {
        notes,
        ..Imported::default()
    };
    if mended.holes + mended.crumbs > 0 {
        let note = format!(
            "the facets were mended: {} small holes closed, {} crumbs left out",
            mended.holes, mended.crumbs
        );
        tell(&note);
        imported.notes.push(note);
    }
    let (mut faces, mut curves) = (0, 0);
    let mut ways: Vec<String> = Vec::new();
    for (tag, solid) in (1..).zip(&solids) {
        let facets = &solid.facets;
        let first = imported.attempts.len();
        let piece = job.solid(facets, tag, (&mut faces, &mut curves), &mut imported, tell)?;
        imported.pieces.push(piece);
        if solids.len() > 1 {
            for attempt in &mut imported.attempts[first..] {
                *attempt = format!("solid {tag}: {attempt}");
            }
        }
        if !ways.contains(&imported.way) {
            ways.push(std::mem::take(&mut imported.way));
        }
    }
    imported.way = ways.join("; ");
    Ok(imported)
}

struct Job<'a> {
    path: &'a Path,
    options: &'a ImportOptions,
    filler: Filler<'a>,
    budget: Budget,
}

impl Job<'_> {
    fn solid(
        &self,
        facets: &Soup,
        tag: i32,
        numbers: (&mut i32, &mut i32),
        imported: &mut Imported,
        tell: &mut dyn FnMut(&str),
    ) -> Result<Piece, ImportError> {
        let mut last = Vec::new();
        let mut late = false;
        let of = |smooth| sized(facets, self.options.size_factor, smooth);
        let (mut surface, size) = of(true);
        for (name, mesher, smooth) in WAYS {
            if !smooth && surface.smooth {
                (surface, _) = of(false);
            }
            let left = self.budget.left_of(GMSH_SHARE);
            if left.is_zero() {
                break;
            }
            tell(name);
            let filled = (self.filler).fill(&surface.soup, size, mesher, (left, &self.budget));
            match filled {
                Ok((msh, version)) => {
                    imported.gmsh_version = version;
                    imported.way = format!("facets, {name}");
                    return self.piece(&surface, &msh, tag, numbers, imported);
                }
                Err(FillFault::TimedOut) => {
                    late = true;
                    (imported.attempts).push(format!("{name}: stopped, out of time"));
                }
                Err(FillFault::Unusable(lines)) => {
                    return Err(ImportError::GmshUnusable {
                        gmsh: self.filler.launcher.path.clone(),
                        lines,
                    });
                }
                Err(FillFault::Failed(lines)) => {
                    imported
                        .attempts
                        .push(format!("{name}: {}", lines.join(" | ")));
                    last = lines;
                }
            }
        }
        tell("fTetWild");
        match self.last_resort(&surface, size, tag, numbers) {
            Ok((piece, way)) => {
                imported.way = way;
                Ok(piece)
            }
            Err(fault) => {
                imported.attempts.push(format!("fTetWild: {fault}"));
                late |= matches!(fault, MeshFault::TetWild(TetWildError::TimedOut { .. }));
                if late {
                    return Err(ImportError::TimedOut {
                        path: self.path.to_path_buf(),
                        limit: self.options.time_limit,
                        attempts: std::mem::take(&mut imported.attempts),
                    });
                }
                Err(ImportError::GmshFailed {
                    path: self.path.to_path_buf(),
                    attempts: std::mem::take(&mut imported.attempts),
                    lines: last,
                })
            }
        }
    }

    /// fTetWild takes facets that cut each other, and fills what they enclose together.
    fn last_resort(
        &self,
        surface: &Remeshed,
        size: f64,
        tag: i32,
        (faces, curves): (&mut i32, &mut i32),
    ) -> Result<(Piece, String), MeshFault> {
        let tool = tetwild::find_tetwild(Some(&self.filler.launcher.path))?;
        let envelope = ENVELOPE * surface.thickness;
        let options = FillOptions {
            edge_length: size,
            envelope,
            time_limit: self.budget.left(),
            memory_limit: self.options.memory_limit,
        };
        let soup = &surface.soup;
        let filling =
            tetwild::fill_counted(&tool, &soup.points, &soup.triangles, &options, &self.budget)?;
        let skin = assemble::skin(surface, tag, faces, curves);
        let piece = relabel(&skin, &filling, envelope)?;
        if let Some(fault) = volume::departs(&piece, surface.volume) {
            return Err(fault);
        }
        Ok((
            piece,
            format!("facets, fTetWild (pytetwild {})", tool.version),
        ))
    }

    fn piece(
        &self,
        surface: &Remeshed,
        filling: &Msh,
        solid: i32,
        (faces, curves): (&mut i32, &mut i32),
        imported: &Imported,
    ) -> Result<Piece, ImportError> {
        let bad = |cause| ImportError::BadMesh {
            path: self.path.to_path_buf(),
            cause: MeshFault::Piece(cause),
            attempts: imported.attempts.clone(),
        };
        let whole = assemble::assemble(surface, filling, solid, faces, curves)
            .ok_or_else(|| bad(piece::PieceError::NotFilled { solid }))?;
        let pieces = piece::build_pieces(&whole).map_err(bad)?;
        pieces
            .into_iter()
            .next()
            .ok_or_else(|| bad(piece::PieceError::NoVolume))
    }
}

/// Facets of the wanted size with their faces, and the size of the tets. The sizes are those of the CAD import.
/// `smooth` lays new points on the smooth surface that the facets stand for.
pub fn sized(facets: &Soup, size_factor: f64, smooth: bool) -> (Remeshed, f64) {
    let (mut area, mut volume) = (0.0, 0.0);
    let (low, high) = weld::extent(&facets.points);
    for t in 0..facets.triangles.len() {
        let [a, b, c] = facets.corners(t).map(|p| p - low);
        area += (b - a).cross(c - a).length() / 2.0;
        volume += a.dot(b.cross(c)) / 6.0;
    }
    let diagonal = (high - low).length();
    let thickness = 2.0 * volume / area.max(f64::MIN_POSITIVE);
    let size = size_factor
        * (3.0 * thickness)
            .max(diagonal / 200.0)
            .max((8.0 * thickness).min(diagonal / 50.0));
    let faces = segment::segment(facets, thickness);
    // As fine along bends as the CAD import, which has as many elements a circle.
    let length = faces.curvature.iter().map(|&k| {
        let turn = TAU / (PER_CIRCLE * k.max(f64::MIN_POSITIVE));
        (size_factor * turn.max(thickness / 2.0)).min(size)
    });
    let wanted = Wanted {
        length: length.collect(),
        deviation: DEVIATION * thickness,
        most: MOST_FACETS,
        smooth,
    };
    let mut surface = remesh::remesh(facets, &faces, &wanted);
    surface.thickness = thickness;
    surface.volume = volume;
    surface.smooth = smooth;
    (surface, size)
}

#[cfg(test)]
mod reader_tests;
#[cfg(test)]
mod tests;
