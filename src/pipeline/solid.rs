//! From one filled solid to its shell.

use super::clock::Clock;
use super::dump::Dump;
use super::error::PipelineError;
use super::halved::Meshed;
use super::middle::Middle;
use super::midsurface::{self, MidSurface};
use super::report::SolidReport;
use super::seen::Seen;
use super::small::{self, Plain};
use super::targets::{self, Targets};
use super::tidy::{self, connected, folds};
use super::wished;
use crate::charts;
use crate::geom::placer::{Lengths, Placer};
use crate::medial::Medial;
use crate::model::brep::Brep;
use crate::model::complex::MidComplex;
use crate::model::element_shape::ElementShape;
use crate::model::ids::WallId;
use crate::model::pieces::Pieces;
use crate::model::shell::ShellMesh;
use crate::model::washer::{NoWasher, Washers};
use crate::options::MeshOptions;
use crate::stage::chart_mesh::{Layout, Pattern};
use crate::stage::keep;
use crate::stage::kinks::{self, Kinked};
use crate::stage::quads::{self, Halves};
use crate::stage::remesh::{self, RemeshOptions};
use crate::stage::sheets::Sheets;
use crate::stage::size::{self, Sizing, Wishes};
use crate::stage::{balance, shell, washers};
use glam::DVec3;
use std::cell::OnceCell;

/// Where a solid stands among those of the part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    /// How many sheets those before it have.
    pub sheets_before: usize,
    /// Whether none comes after it.
    pub is_last: bool,
}

/// The shell of one solid, of quads where such are asked for; and the solid that it stands for, where that is not the one that was read.
pub(super) fn mesh_solid(
    seen: &Seen,
    turn: Turn,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<(ShellMesh, SolidReport, Option<Plain>), PipelineError> {
    let piece = &seen.piece;
    let brep = &piece.brep;
    let dump = Dump::new(options, Some(brep.solid_tag))?;
    dump.import(piece)?;
    let as_read = midsurface::mid_surface(seen, clock)?;
    dump.mid_surface(piece, &as_read)?;
    let without = small::plain(brep, &as_read, &options.small, clock);
    let (brep, found) = match &without {
        Some(plain) => (&plain.brep, &plain.found),
        None => (brep, &as_read),
    };
    let Untangled {
        walls: medial,
        sizing,
        complex: fair,
        leaves,
    } = Untangled::new(brep, found, options, clock);
    dump.complex("fair", &fair)?;
    let sheets = clock.time("size", || Sheets::new(&fair));
    if turn.is_last {
        // A wrong number is told before anything is meshed.
        wished::sheets_are_there(turn.sheets_before + sheets.count(), options)?;
    }
    let targets = clock.time("size", || {
        let source = targets::Source {
            brep,
            pairing: &found.pairing,
            walls: &medial,
            complex: &fair,
            sheets: &sheets,
            sheets_before: turn.sheets_before,
        };
        Targets::new(&source, &sizing, options)
    });
    let kept = match options.keep.as_slice() {
        [] => None,
        wishes => clock.time("keep", || {
            keep::keep(&fair, brep, &found.aag, &found.pairing, &medial, wishes)
                .map_err(wished::unkept)
        })?,
    };
    let (fair, pairing, walls) = match &kept {
        Some(kept) => (&kept.complex, &kept.pairing, &kept.walls),
        None => (&fair, &found.pairing, &medial),
    };
    if kept.is_some() {
        dump.complex("kept", fair)?;
    }
    let kinked = clock.time("kinks", || {
        let kinked = kinks::kinks(fair, brep, &found.aag, pairing, walls)?;
        let parted = walls.paired(&found.aag, &kinked.pairing);
        let lines = walls.lines().parted(&kinked.pieces);
        Some((kinked, parted.cut_along(lines)))
    });
    let job = Job {
        sizing: &sizing,
        options,
        dump: &dump,
    };
    let pieces: Vec<&Pieces> = kept.iter().map(|kept| &kept.pieces).collect();
    let plain = Middle::new(walls, leaves).aiming(&targets, &pieces);
    let Meshed {
        complex,
        diagonals,
        washers,
    } = match &kinked {
        None => {
            let clean = clock.time("clean", || job.clean(fair, &plain));
            job.meshed(clean, &plain, clock)?
        }
        Some((kinked, parted)) => {
            let pieces: Vec<&Pieces> = [&kinked.pieces].into_iter().chain(pieces.clone()).collect();
            let parted = Middle::new(parted, leaves).aiming(&targets, &pieces);
            job.kinked_or_not(fair, &plain, kinked, &parted, clock)?
        }
    };
    let kept_edges = (kept.iter())
        .flat_map(|kept| kept.standing(&complex))
        .collect();
    let complex = kept.iter().fold(complex, |c, kept| kept.pieces.joined(c));
    let mesh = clock.time("shell", || {
        shell::shell(brep, &found.pairing, &medial, &complex)
    });
    let mesh = match options.element {
        ElementShape::Triangle => mesh,
        shape => clock.time("quads", || {
            quads::pair_quads(&mesh, &diagonals, shape, &options.profile)
        }),
    };
    let mesh = clock.time("shell", || sheets.in_order(mesh));
    let mut solid = SolidReport::new(&piece.brep, &as_read, sizing.target, &mesh);
    solid.kept_edges = kept_edges;
    if options.washer.is_wanted() {
        solid.washers = Some(standing(washers, &mesh));
    }
    Ok((mesh, solid, without))
}

/// The washers that the mesh has in the end: it may have been mended since they were laid.
fn standing(washers: Washers, mesh: &ShellMesh) -> Washers {
    let stands = washers::standing(mesh, &washers.made);
    let mut left = Washers {
        left_out: washers.left_out,
        ..Washers::default()
    };
    for (washer, stands) in washers.made.into_iter().zip(stands) {
        if stands {
            left.made.push(washer);
        } else {
            left.left_out.push(washer.bare(NoWasher::Unmeshed));
        }
    }
    left
}

/// A mid-surface in order, with all that is asked of it from there on.
pub(super) struct Untangled<'a> {
    /// What places nodes.
    pub walls: Medial<'a>,
    /// The wanted edge lengths.
    pub sizing: Sizing,
    /// The mid-surface itself, with edges of no size.
    pub complex: MidComplex,
    /// Whether its sheets had to be held in the material.
    pub leaves: bool,
}

impl<'a> Untangled<'a> {
    pub fn new(
        brep: &'a Brep,
        found: &'a MidSurface,
        options: &MeshOptions,
        clock: &mut Clock<'_>,
    ) -> Self {
        let mut walls = Medial::new(brep, &found.aag, &found.pairing);
        // Bevels are cut back when sheets are whole.
        walls.let_bevels_stand(true);
        let sizing = clock.time("size", || {
            size::sizing(brep, &found.pairing, &wishes(options)).eased(
                brep,
                &found.pairing,
                &|p, w| walls.curvature_radius(p, w),
            )
        });
        let (complex, leaves) = tidy::untangled(found, &walls, clock);
        walls.let_bevels_stand(false);
        let sizing = clock.time("size", || {
            let middle = Middle::new(&walls, leaves);
            sizing.afforded(&middle.asked(&complex, &sizing))
        });
        Self {
            walls,
            sizing,
            complex,
            leaves,
        }
    }
}

/// What meshing needs besides a complex and the surfaces that it lies on.
pub(super) struct Job<'a> {
    pub sizing: &'a Sizing,
    pub options: &'a MeshOptions,
    pub dump: &'a Dump<'a>,
}

/// What the user wishes of sizes.
fn wishes(options: &MeshOptions) -> Wishes {
    Wishes {
        size: options.size,
        per_turn: options.size_curvature,
        min: options.size_min,
        max: options.size_max,
        growth: options.growth,
    }
}

impl Job<'_> {
    fn remesh_options(&self) -> RemeshOptions {
        let options = match self.options.element {
            ElementShape::Triangle => RemeshOptions::default(),
            ElementShape::Quad | ElementShape::Mixed => RemeshOptions::for_quads(),
        };
        RemeshOptions {
            gradation: self.options.growth.unwrap_or(options.gradation),
            least: self.options.size_min.unwrap_or(options.least),
            ..options
        }
    }

    pub(super) fn layout(&self, pattern: Pattern) -> Layout {
        let layout = Layout::from(pattern);
        Layout {
            growth: self.options.growth.unwrap_or(layout.growth),
            ..layout
        }
    }

    fn clean(&self, fair: &MidComplex, middle: &Middle<'_>) -> MidComplex {
        tidy::clean(fair.clone(), self.sizing, middle)
    }

    /// A clean complex meshed at the wanted sizes.
    fn meshed(
        &self,
        clean: MidComplex,
        middle: &Middle<'_>,
        clock: &mut Clock<'_>,
    ) -> Result<Meshed, PipelineError> {
        let Self { sizing, dump, .. } = self;
        let (field, placer) = (middle.field(sizing), middle.placer());
        dump.complex("clean", &clean)?;
        let options = self.remesh_options();
        let complex = clock.time("remesh", || {
            remesh::remesh(clean, &field, placer, &options).0
        });
        dump.complex("remeshed", &complex)?;
        let complex = clock.time("charts", || {
            let equal = |p: DVec3, w: WallId| Lengths::equal(field(p, w));
            charts::mesh_charts(&complex, self.layout(Pattern::Triangles), &equal, placer).complex
        });
        dump.complex("charted", &complex)?;
        let complex = clock.time("polish", || {
            tidy::unfolded(remesh::polish(complex, &field, placer, &options), placer)
        });
        dump.complex("polished", &complex)?;
        let mut meshed = self.halved(complex, middle, clock)?;
        meshed.complex = clock.time("balance", || balance::balance(meshed.complex, middle.walls));
        dump.complex("balanced", &meshed.complex)?;
        Ok(meshed)
    }

    /// Meshed with the kinks cut; without them where that leaves folds and this does not: less exact at steps, but fit for a solver.
    fn kinked_or_not(
        &self,
        fair: &MidComplex,
        middle: &Middle<'_>,
        kinked: &Kinked,
        parted: &Middle<'_>,
        clock: &mut Clock<'_>,
    ) -> Result<Meshed, PipelineError> {
        let uncut = OnceCell::new();
        let cleaned = || self.clean(fair, middle);
        let cut = clock.time("clean", || {
            let cut = || self.clean(&kinked.complex, parted);
            if folds(&kinked.complex) == 0 {
                return cut();
            }
            // Where cutting made folds both are mostly wanted.
            let (made, cut) = rayon::join(cleaned, cut);
            uncut.get_or_init(|| made);
            cut
        });
        if folds(&cut) > 0 {
            let uncut = clock.time("clean", || uncut.get_or_init(cleaned));
            if folds(&cut) > folds(uncut) {
                return self.meshed(uncut.clone(), middle, clock);
            }
        }
        let Meshed {
            complex: cut,
            diagonals,
            washers,
        } = self.meshed(cut, parted, clock)?;
        let cut = kinked.pieces.joined(cut);
        if !diagonals.is_empty() && folds(&cut) == 0 {
            let complex = cut;
            return Ok(Meshed {
                complex,
                diagonals,
                washers,
            });
        }
        // What was parted at a kink has no neighbours there; joined, it may show a fold.
        let halves = clock.time("polish", || {
            let unfolded = connected(cut.clone(), |c| remesh::unfold(c, middle.placer()));
            let complex = cut;
            Halves { complex, diagonals }.changed_to(unfolded)
        });
        let cut = Meshed {
            complex: halves.complex,
            diagonals: halves.diagonals,
            washers,
        };
        if folds(&cut.complex) == 0 {
            return Ok(cut);
        }
        let uncut = clock.time("clean", || uncut.get_or_init(cleaned));
        if folds(uncut) > 0 {
            return Ok(cut);
        }
        let uncut = self.meshed(uncut.clone(), middle, clock)?;
        Ok(if folds(&uncut.complex) == 0 {
            uncut
        } else {
            cut
        })
    }
}
