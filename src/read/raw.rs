//! What every reader makes of its file, before anything is checked that does not hang on the format.

use super::error::{ReadError, ReadErrorKind};
use glam::DVec3;
use smallvec::SmallVec;
use std::collections::HashMap;

/// A shell element of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RawElement {
    /// Its number.
    pub number: u64,
    /// Its three or four corners, places in [`Raw::nodes`].
    pub corners: SmallVec<[u32; 4]>,
    /// Thickness at each corner; NaN where the file has none. The fourth value of a triangle means nothing.
    pub thickness: [f64; 4],
    /// The file's name for its sheet.
    pub sheet: Option<i64>,
}

/// The contents of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Raw {
    /// Number and place.
    pub nodes: Vec<(u64, DVec3)>,
    /// #N nodes that something other than a corner of a shell refers to: mid-side nodes, nodes of solids and lines. Shorter where no such node follows.
    pub taken: Vec<bool>,
    /// The shells.
    pub elements: Vec<RawElement>,
    /// How many shells are of higher order.
    pub higher_order: usize,
    /// How many solid elements there are.
    pub solids: usize,
    /// How many lines, points and elements of other kinds.
    pub others: usize,
    /// What the user should know.
    pub notes: Vec<String>,
}

impl Raw {
    /// A node is referred to by something other than a corner of a shell.
    pub fn take(&mut self, node: u32) {
        let place = node as usize;
        if self.taken.len() <= place {
            self.taken.resize(place + 1, false);
        }
        self.taken[place] = true;
    }

    /// A shell with this many corners and these nodes, corners first.
    pub fn shell(&mut self, number: u64, corners: usize, nodes: &[u32], sheet: Option<i64>) {
        self.elements.push(RawElement {
            number,
            corners: nodes.iter().take(corners).copied().collect(),
            thickness: [f64::NAN; 4],
            sheet,
        });
        if nodes.len() > corners {
            self.higher_order += 1;
            for &middle in &nodes[corners..] {
                self.take(middle);
            }
        }
    }
}

/// From a file's numbers to places in a list.
#[derive(Default)]
pub(super) struct Numbers(HashMap<u64, u32>);

impl Numbers {
    /// Gives a number the next place; what it had one is returned.
    pub fn add(&mut self, number: u64) -> Result<Option<u32>, ReadError> {
        let next = u32::try_from(self.0.len()).map_err(|_| ReadErrorKind::TooMany.anywhere())?;
        Ok(match self.0.entry(number) {
            std::collections::hash_map::Entry::Occupied(there) => Some(*there.get()),
            std::collections::hash_map::Entry::Vacant(free) => {
                free.insert(next);
                None
            }
        })
    }

    /// The place of a number.
    pub fn get(&self, number: u64) -> Option<u32> {
        self.0.get(&number).copied()
    }
}
