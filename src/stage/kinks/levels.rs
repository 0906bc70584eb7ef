//! Levels: the faces of a wall's sides, parted at outer edges.

use crate::medial::Foot;
use crate::model::brep::Brep;
use crate::model::disjoint::Disjoint;
use crate::model::ids::FaceId;
use crate::model::walls::{Aag, Convexity, Wall};

/// The levels that are nearest on the two sides, as one number.
pub(super) type Class = u32;

/// The levels of one wall.
#[derive(Clone, Debug)]
pub(super) struct Levels {
    /// The faces of either side, sorted, each with its level.
    faces: [Vec<(FaceId, u32)>; 2],
    /// Levels of the second side.
    width: u32,
    /// The class that each stands for: those between which there is no kink are one.
    roots: Vec<Class>,
}

impl Levels {
    /// The levels of a wall, if outer edges part one of its sides.
    pub fn new(aag: &Aag, wall: &Wall) -> Option<Self> {
        let mut parted = false;
        let sides = wall.sides.each_ref().map(|side| {
            let at = |f: FaceId| side.binary_search(&f).ok().map(|i| i as u32);
            let mut sets = Disjoint::new(side.len());
            let mut outer = Vec::new();
            for &f in side {
                for arc in aag.arcs_of(f) {
                    if let (Some(i), Some(j)) = (at(f), at(Aag::across(arc, f))) {
                        if arc.convexity == Convexity::Convex {
                            outer.push([i, j]);
                        } else {
                            sets.join(i, j);
                        }
                    }
                }
            }
            parted |= outer.iter().any(|&[i, j]| sets.find(i) != sets.find(j));
            let mut names: Vec<u32> = Vec::new();
            let levels = (0..side.len() as u32)
                .map(|i| {
                    let root = sets.find(i);
                    let known = names.iter().position(|&r| r == root);
                    known.unwrap_or_else(|| {
                        names.push(root);
                        names.len() - 1
                    }) as u32
                })
                .collect::<Vec<u32>>();
            (names.len() as u32, levels)
        });
        let [(first, a), (width, b)] = sides;
        parted.then(|| Self {
            faces: [
                wall.sides[0].iter().copied().zip(a).collect(),
                wall.sides[1].iter().copied().zip(b).collect(),
            ],
            width,
            roots: (0..first * width).collect(),
        })
    }

    fn level(&self, side: usize, f: FaceId) -> Option<u32> {
        let list = &self.faces[side];
        let i = list.binary_search_by_key(&f, |x| x.0).ok()?;
        Some(list[i].1)
    }

    /// The class of a place with these feet.
    pub fn class(&self, brep: &Brep, feet: &[Foot; 2]) -> Option<Class> {
        let of = |s: usize| self.level(s, brep.facets[feet[s].facet].face);
        let class = of(0)? * self.width + of(1)?;
        self.roots.get(class as usize).copied()
    }

    /// Makes classes one.
    pub fn unite(&mut self, same: &[[Class; 2]]) {
        let mut sets = Disjoint::new(self.roots.len());
        for &[a, b] in same {
            sets.join(a, b);
        }
        self.roots = (0..self.roots.len() as u32).map(|c| sets.find(c)).collect();
    }

    /// The sides of the piece of each class. A level of no class goes with the level that it shares the longest outer edge with.
    pub fn sides(&self, aag: &Aag, wall: &Wall, classes: &[Class]) -> Vec<[Vec<FaceId>; 2]> {
        let mut of = [
            vec![Vec::new(); classes.len()],
            vec![Vec::new(); classes.len()],
        ];
        for (s, of) in of.iter_mut().enumerate() {
            let count = self.faces[s].iter().map(|x| x.1 + 1).max().unwrap_or(0);
            let mut members: Vec<Vec<usize>> = (0..count)
                .map(|level| {
                    (0..classes.len())
                        .filter(|&k| {
                            (self.roots.iter().enumerate()).any(|(c, &root)| {
                                let own = if s == 0 {
                                    c as u32 / self.width
                                } else {
                                    c as u32 % self.width
                                };
                                root == classes[k] && own == level
                            })
                        })
                        .collect()
                })
                .collect();
            while let Some((level, into)) = self.stray(aag, wall, s, &members) {
                members[level as usize] = members[into as usize].clone();
            }
            for &(f, level) in &self.faces[s] {
                for &k in &members[level as usize] {
                    of[k].push(f);
                }
            }
        }
        let [first, second] = of;
        first.into_iter().zip(second).map(|(a, b)| [a, b]).collect()
    }

    /// A level of no class, and a level of some class that it has the longest edge with.
    fn stray(
        &self,
        aag: &Aag,
        wall: &Wall,
        s: usize,
        members: &[Vec<usize>],
    ) -> Option<(u32, u32)> {
        let mut best: Option<(f64, u32, u32)> = None;
        for &f in &wall.sides[s] {
            let Some(level) = self.level(s, f).filter(|&l| members[l as usize].is_empty()) else {
                continue;
            };
            for arc in aag.arcs_of(f) {
                let other = self.level(s, Aag::across(arc, f));
                if let Some(into) = other.filter(|&l| !members[l as usize].is_empty())
                    && best.is_none_or(|(length, ..)| arc.length > length)
                {
                    best = Some((arc.length, level, into));
                }
            }
        }
        best.map(|(_, level, into)| (level, into))
    }
}
