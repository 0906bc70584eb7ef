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
use crate::model::ids::NodeId;
use crate::model::washer::{BareHole, NoWasher, Washers};
use crate::options::OptionFault;
use crate::stage::chart_mesh::Pattern;
use crate::stage::quads::{self, Halves};
use crate::stage::washers::Plan;
use crate::stage::{remesh, respace, washers};

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
        if self.options.element == ElementShape::Triangle {
            return Ok(triangles(complex, Washers::default()));
        }
        let (halves, washers) = if self.options.washer.is_wanted() {
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
            washers::plan(complex, &self.options.washer, target, &sizes, placer)
        });
        if self.options.washer.width.is_some() {
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
        let placer = middle.placer();
        let lengths = middle.lengths(self.sizing);
        let squares = clock.time("charts", || {
            let even = respace::respace(complex.clone(), &lengths, placer);
            let layout = self.layout(Pattern::Squares);
            let squares = charts::mesh_charts(&even, layout, &lengths, placer).complex;
            if folds(&squares) == 0 {
                return squares;
            }
            // What is mended by contracting a curve may be odd again.
            respace::respace(
                connected(squares, |c| remesh::unfold(c, placer)),
                &lengths,
                placer,
            )
        });
        self.dump.complex("squares", &squares)?;
        let halves = clock.time("quads", || {
            let mended = |halves: Halves| {
                if folds(&halves.complex) == 0 {
                    return halves;
                }
                let mended = connected(halves.complex.clone(), |c| remesh::unfold(c, placer));
                halves.changed_to(mended)
            };
            let halves = mended(quads::quads(squares.clone(), placer));
            if folds(&halves.complex) <= folds(complex) {
                return halves;
            }
            mended(quads::unfolded_quads(squares, placer))
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
