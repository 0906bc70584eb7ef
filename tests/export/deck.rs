//! A CalculiX deck as the tests see it: its nodes, a static step put after it, and what came of it.

use super::tools::{calculix, table};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

pub struct Deck {
    text: String,
    /// Position of every node, mm, by number.
    pub nodes: BTreeMap<usize, DVec3>,
    /// Nodes at the corners of elements: the first three of six, the first four of eight.
    pub corners: BTreeSet<usize>,
}

/// What a static step came to.
#[derive(Clone, Debug, Default)]
pub struct Solved {
    /// Displacement of every node, mm, by number.
    pub displacements: BTreeMap<usize, DVec3>,
    /// Sum of the forces that hold the clamped nodes, N.
    pub reaction: DVec3,
}

impl Deck {
    pub fn read(text: String) -> Self {
        let mut nodes = BTreeMap::new();
        let mut corners = BTreeSet::new();
        let mut card = "";
        for line in text.lines().filter(|line| !line.starts_with("**")) {
            if line.starts_with('*') {
                card = line;
                continue;
            }
            let numbers = || -> Vec<f64> {
                let fields = line.split(',');
                fields
                    .map(|f| f.trim().parse().expect("a number"))
                    .collect()
            };
            if card.starts_with("*NODE,") {
                let row = numbers();
                nodes.insert(row[0] as usize, DVec3::new(row[1], row[2], row[3]));
            } else if card.starts_with("*ELEMENT,") {
                let row = numbers();
                let count = match row.len() - 1 {
                    n @ (3 | 4) => n,
                    n @ (6 | 8) => n / 2,
                    n => panic!("an element of {n} nodes"),
                };
                corners.extend(row[1..=count].iter().map(|&n| n as usize));
            }
        }
        assert!(!nodes.is_empty() && !corners.is_empty());
        Self {
            text,
            nodes,
            corners,
        }
    }

    /// Holds the clamped nodes in all six directions or the first three, puts forces (N) on others, and solves.
    pub fn solve(&self, clamped: &[usize], directions: usize, forces: &[(usize, DVec3)]) -> Solved {
        let mut text = self.text.clone();
        text += "*NSET, NSET=CLAMPED\n";
        for node in clamped {
            text += &format!("{node},\n");
        }
        text += &format!("*BOUNDARY\nCLAMPED, 1, {directions}\n*STEP\n*STATIC\n*CLOAD\n");
        for (node, force) in forces {
            for (k, part) in force.to_array().into_iter().enumerate() {
                if part != 0.0 {
                    // CalculiX reads no more than 20 characters of a number.
                    text += &format!("{node}, {}, {part:.9e}\n", k + 1);
                }
            }
        }
        text +=
            "*NODE PRINT, NSET=NALL\nU\n*NODE PRINT, NSET=CLAMPED, TOTALS=ONLY\nRF\n*END STEP\n";
        let dat = calculix(text.as_bytes());
        let displacements = table(&dat, "displacements");
        let reaction = table(&dat, "total force");
        assert_eq!(displacements.len(), self.nodes.len());
        assert_eq!(reaction.len(), 1);
        Solved {
            displacements: displacements
                .iter()
                .map(|row| (row[0] as usize, DVec3::new(row[1], row[2], row[3])))
                .collect(),
            reaction: DVec3::from_slice(&reaction[0]),
        }
    }
}
