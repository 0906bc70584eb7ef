//! Size: how long the edges should be.
//!
//! Without a wish the part decides: three typical thicknesses, so that a shell element is a shell, but not so few elements that the part's shape is
//! lost, nor so many that a huge thin part drowns its user. On curved walls the chord must stay near the mid-surface: an edge of length h on a radius R
//! leaves it by h²/8R, and that is held to a share of the thickness; or the user gives the number of elements in a full turn.
//!
//! Equal triangles across a sharp bend are as short along it, so that the long bends of a wide sheet, and the rows beside them, would outnumber its flats
//! many times over. Where they would, bends are followed less finely, see [`Sizing::eased`].

mod count;

use crate::model::brep::Brep;
use crate::model::ids::WallId;
use crate::model::walls::Pairing;
use count::Count;
use glam::DVec3;

/// Default edge length in typical thicknesses.
const THICKNESSES: f64 = 3.0;
/// Coarsest default, as a share of the part's diagonal: forty edges along it still draw it.
const COARSEST: f64 = 1.0 / 25.0;
/// Finest default: at most about this many triangles.
const MOST_TRIANGLES: f64 = 40_000.0;
/// Chord error on curved walls, as a share of the thickness.
const CHORD: f64 = 0.005;
/// Curvature alone never asks for edges shorter than this share of the thickness: a shell element shorter than half of it is none.
const SHORTEST: f64 = 0.5;
/// The same at steps of the thickness: the parabola along which the middle climbs there is half a thickness wide and ends in a kink, so that longer edges would smear
/// it over as much again of the wall. Where bends are eased, steps are as well.
const SHORTEST_AT_STEPS: f64 = 0.35;
/// The same where bends are eased as far as they may.
const EASED: f64 = 1.0;
/// Where bends are eased, a quarter turn still gets two edges: one would cut through the wall at its corner.
const EASED_TURN: f64 = std::f64::consts::FRAC_PI_4;
/// Bends may make so many times the triangles of a flat sheet of that area, or of the finest default, whichever is more.
const MOST_BENT: f64 = 2.0;
/// A complex may ask for so many triangles, as a multiple of the same, before its shortest edges are made longer: threads that were drawn have walls of a hundredth of the part's, and sheets
/// that are carried on between them asked for two million triangles.
const MOST_ASKED: f64 = 3.0;
/// Growth of sizes, length per length, as the mesh has it.
const GROWTH: f64 = 0.3;
/// Halvings of the range between the two: the count is an estimate, and a thirtieth of the range is finer than that.
const HALVINGS: usize = 5;
/// Halvings of the target for the shortest edge: a thousandth of it.
const LEAST_HALVINGS: usize = 10;
/// What curvature asks for is a bound, but edges come out this much about the wanted length: it is asked for that much shorter.
const EVENNESS: f64 = 0.9;
/// Edges below this share of the wanted length are specks of the raw complex, to be contracted before meshing.
const SPECK: f64 = 0.2;

/// The wanted edge lengths of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizing {
    /// Edge length on flat walls, mm.
    pub target: f64,
    /// Edges in a full turn of a curved wall, if the user said so.
    pub per_turn: Option<f64>,
    /// Curvature alone asks for no edges shorter than this share of the thickness.
    pub shortest: f64,
    /// Nothing asks for edges shorter than this, mm; zero unless the user said so or there would be too many.
    pub least: f64,
    /// How fast sizes grow away from short ones, length per length.
    pub growth: f64,
}

/// What the user wishes of sizes; what he leaves open the part decides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wishes {
    /// Edge length on flat walls, mm.
    pub size: Option<f64>,
    /// Edges in a full turn of a curved wall.
    pub per_turn: Option<f64>,
    /// No shorter edges, mm.
    pub min: Option<f64>,
    /// No longer edges, mm.
    pub max: Option<f64>,
    /// Neighbouring edges differ by this factor at most.
    pub growth: Option<f64>,
}

/// The sizing of one solid.
pub fn sizing(brep: &Brep, pairing: &Pairing, wishes: &Wishes) -> Sizing {
    let target = wishes.size.unwrap_or_else(|| {
        let fewest = (brep.area() / 2.0 / (MOST_TRIANGLES * 3f64.sqrt() / 4.0)).sqrt();
        (THICKNESSES * typical_thickness(pairing))
            .min(COARSEST * brep.diagonal())
            .max(fewest)
            .min(wishes.max.unwrap_or(f64::INFINITY))
            .max(wishes.min.unwrap_or(0.0))
    });
    Sizing {
        target,
        per_turn: wishes.per_turn,
        shortest: SHORTEST,
        least: wishes.min.unwrap_or(0.0),
        growth: wishes.growth.map_or(GROWTH, |factor| factor - 1.0),
    }
}

/// Area-weighted median of the pairs' mean thickness, mm.
fn typical_thickness(pairing: &Pairing) -> f64 {
    let mut pairs: Vec<(f64, f64)> = pairing
        .pairs
        .iter()
        .map(|p| (p.thickness[1], p.overlap))
        .collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = pairs.iter().map(|p| p.1).sum::<f64>() / 2.0;
    let mut passed = 0.0;
    pairs
        .iter()
        .find(|p| {
            passed += p.1;
            passed >= half
        })
        .map_or(0.0, |p| p.0)
}

impl Sizing {
    /// Edge length where a wall of this thickness is curved with this radius, mm.
    pub fn at(&self, radius: f64, thickness: f64) -> f64 {
        let curved = match self.per_turn {
            Some(count) => std::f64::consts::TAU * radius / count,
            None => (8.0 * radius * CHORD * thickness)
                .sqrt()
                .max((self.shortest * thickness).min(EASED_TURN * radius))
                .max(SHORTEST * thickness),
        };
        (EVENNESS * curved).max(self.least).min(self.target)
    }

    /// Edge length at a step of a wall of this thickness, where the mid-surface climbs along a parabola of this radius, mm. Only the part's own sizes follow steps.
    pub fn at_step(&self, radius: f64, thickness: f64) -> f64 {
        if self.per_turn.is_some() {
            return self.target;
        }
        let climbing = (8.0 * radius * CHORD * thickness).sqrt();
        let least = SHORTEST_AT_STEPS * self.shortest / SHORTEST * thickness;
        (EVENNESS * climbing.max(least))
            .max(self.least)
            .min(self.target)
    }

    /// The same with bends followed less finely, as far as the triangles would be too many; `radius(point, wall)` tells the bends, mm, as
    /// for [`Sizing::at`]. Nothing changes where the user gave the number of elements in a turn.
    #[must_use]
    pub fn eased(
        self,
        brep: &Brep,
        pairing: &Pairing,
        radius: &(dyn Fn(DVec3, WallId) -> f64 + Sync),
    ) -> Self {
        if self.per_turn.is_some() {
            return self;
        }
        let count = Count::new(brep, pairing, radius);
        let flat = count.triangles(self.growth, |_, _| self.target);
        let most = MOST_BENT * flat.max(MOST_TRIANGLES);
        let with = |shortest: f64| Self { shortest, ..self };
        let fits =
            |shortest: f64| count.triangles(self.growth, |r, t| with(shortest).at(r, t)) <= most;
        if fits(self.shortest) {
            return self;
        }
        let (mut low, mut high) = (self.shortest, EASED);
        for _ in 0..HALVINGS {
            let middle = (low + high) / 2.0;
            if fits(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        with(high)
    }

    /// The same with the shortest edges made so long that a complex does not ask for too many triangles: `asked` holds the area of each of its triangles, mm², and the edge
    /// length wanted there, mm.
    #[must_use]
    pub fn afforded(self, asked: &[(f64, f64)]) -> Self {
        let equilateral = 3f64.sqrt() / 4.0;
        let count = |least: f64| -> f64 {
            asked
                .iter()
                .map(|(area, size)| area / (equilateral * size.max(least).powi(2)))
                .sum()
        };
        let most = MOST_ASKED * count(self.target).max(MOST_TRIANGLES);
        if count(0.0) <= most {
            return self;
        }
        // The count falls with the length, and with the target it is few enough.
        let (mut low, mut high) = (0.0, self.target);
        for _ in 0..LEAST_HALVINGS {
            let middle = (low + high) / 2.0;
            if count(middle) <= most {
                high = middle;
            } else {
                low = middle;
            }
        }
        Self {
            least: high.max(self.least),
            ..self
        }
    }

    /// Edges shorter than this are specks where edges of `size` are wanted, mm.
    pub fn speck(&self, size: f64) -> f64 {
        SPECK * size
    }
}

#[cfg(test)]
mod tests;
