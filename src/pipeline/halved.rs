//! From a sheet of triangles to the halves of quads, with washers round the holes where these are asked for.

use super::clock::Clock;
use super::error::PipelineError;
use super::middle::Middle;
use super::solid::Job;
use super::tidy::{connected, folds};
use crate::charts;
use crate::geom::placer::Placer;
use crate::model::complex::MidComplex;
use crate::model::element_shape::ElementShape;
use crate::model::ids::{NodeId, WallId};
use crate::model::washer::{BareHole, NoWasher, Washers};
use crate::options::OptionFault;
use crate::stage::chart_mesh::Pattern;
use crate::stage::quads::{self, Halves};
use crate::stage::washers::Plan;
use crate::stage::{remesh, respace, washers};
use glam::{DVec3, FloatExt};

/// Side of a square, where it bends much, over that of a triangle: the mesh leaves a bend by as much with both.
const SQUARE_AT_BENDS: f64 = 0.75;

/// A meshed complex with what is known of its elements.
pub(super) struct Meshed {
    /// Triangles; many are halves of quads.
    pub complex: MidComplex,
    /// Edges between the two halves of a quad, lower node first, sorted.
    pub diagonals: Vec<[NodeId; 2]>,
    /// The washers laid.
    pub washers: Washers,
}

impl Job<'_> {
    /// A meshed complex as halves of quads, where these are asked for.
    pub(super) fn halved(
        &self,
        complex: MidComplex,
        middle: &Middle<'_>,
        clock: &mut Clock<'_>,
    ) -> Result<Meshed, PipelineError> {
        let meshed = |halves: Halves, washers| Meshed {
            complex: halves.complex,
            diagonals: halves.diagonals,
            washers,
        };
        let triangles = |complex, washers| Meshed {
            complex,
            diagonals: Vec::new(),
            washers,
        };
        if self.shape == ElementShape::Triangle {
            return Ok(triangles(complex, Washers::default()));
        }
        let (halves, washers) = if self.washers.is_wanted() {
            self.with_washers(&complex, middle, clock)?
        } else {
            (self.squared(&complex, middle, clock)?, Washers::default())
        };
        // Where something folds the triangles are the better mesh.
        Ok(if folds(&halves.complex) > folds(&complex) {
            triangles(complex, washers)
        } else {
            meshed(halves, washers)
        })
    }

    /// Sheets in squares, with washers.
    fn with_washers(
        &self,
        complex: &MidComplex,
        middle: &Middle<'_>,
        clock: &mut Clock<'_>,
    ) -> Result<(Halves, Washers), PipelineError> {
        let (sizes, placer) = (middle.field(self.sizing), middle.placer());
        let target = self.sizing.target;
        let mut plan = clock.time("washers", || {
            washers::plan(complex, self.washers, target, &sizes, placer)
        });
        if self.washers.width.is_some() {
            let narrow = |h: &&BareHole| matches!(h.why, NoWasher::Room { .. });
            let narrow: Vec<BareHole> = plan.left_out.iter().filter(narrow).cloned().collect();
            if !narrow.is_empty() {
                return Err(OptionFault::WasherRoom(narrow).into());
            }
        }
        // Each round leaves some out; the last has none left.
        loop {
            let opened = clock.time("washers", || washers::open(complex, &mut plan, placer));
            let halves = self.squared(&opened, middle, clock)?;
            let closed = clock.time("washers", || closed(&halves, &plan, placer));
            match closed {
                Ok(halves) => {
                    let made = plan.washers();
                    let left_out = plan.left_out;
                    return Ok((halves, Washers { made, left_out }));
                }
                Err(lost) => plan.leave_out(&lost),
            }
        }
    }

    /// Sheets in squares.
    fn squared(
        &self,
        complex: &MidComplex,
        middle: &Middle<'_>,
        clock: &mut Clock<'_>,
    ) -> Result<Halves, PipelineError> {
        let (sizes, placer) = (middle.field(self.sizing), middle.placer());
        // Where the wall bends, a square has to be smaller than a triangle to leave it as little: its diagonal is longer.
        let target = self.sizing.target;
        let field = |p: DVec3, w: WallId| {
            let size = sizes(p, w);
            size * SQUARE_AT_BENDS.lerp(1.0, (size / target).clamp(0.0, 1.0))
        };
        let squares = clock.time("charts", || {
            let even = respace::respace(complex.clone(), &field, placer);
            let squares = charts::mesh_charts(&even, Pattern::Squares, &field, placer).complex;
            if folds(&squares) == 0 {
                return squares;
            }
            // What is mended by contracting a curve may be odd again.
            respace::respace(
                connected(squares, |c| remesh::unfold(c, placer)),
                &field,
                placer,
            )
        });
        self.dump.complex("squares", &squares)?;
        let halves = clock.time("quads", || {
            let halves = quads::quads(squares, placer);
            if folds(&halves.complex) == 0 {
                return halves;
            }
            let mended = connected(halves.complex.clone(), |c| remesh::unfold(c, placer));
            halves.changed_to(mended)
        });
        self.dump.complex("halves", &halves.complex)?;
        Ok(halves)
    }
}

/// The meshed sheets with the rings of their washers, or the numbers of those that cannot be laid.
fn closed(halves: &Halves, plan: &Plan, placer: &dyn Placer) -> Result<Halves, Vec<usize>> {
    let (complex, diagonals) = washers::close(&halves.complex, &halves.diagonals, plan, placer)?;
    Ok(Halves { complex, diagonals })
}
