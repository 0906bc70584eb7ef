//! What Abaqus and CalculiX decks share: the heading, nodes, elements, sets and the material.
//!
//! Real numbers take at most 20 characters, because both solvers read no more of a field; lists have 16 numbers a line at most.

use super::cells::Cell;
use super::mid_side::MidSides;
use super::number::{Style, fitted};
use super::sets::Sets;
use super::{ExportOptions, number_of, title_line};
use crate::model::shell::ShellMesh;
use glam::DVec3;

/// The name of the material in the deck.
pub(super) const MATERIAL: &str = "STEEL";

/// A deck in the making.
pub(super) struct Deck {
    out: String,
}

impl Deck {
    /// Everything before the sections. `types` are the names of triangles and quads; with `mids` they have to be of second order.
    pub fn start(
        solver: &str,
        types: [&str; 2],
        mesh: &ShellMesh,
        (cells, mids): (&[Cell], &MidSides),
        sets: &Sets,
        options: &ExportOptions<'_>,
    ) -> Self {
        let mut deck = Self { out: String::new() };
        deck.heading(solver, mesh, (cells, mids), options);
        deck.nodes(mesh, mids);
        for (kind, corners) in types.into_iter().zip([3, 4]) {
            let of_kind = cells.iter().filter(|c| c.corners.len() == corners);
            deck.elements(kind, of_kind, mids);
        }
        for (name, numbers) in &sets.elements {
            deck.element_set(name, numbers);
        }
        for (name, numbers) in &sets.nodes {
            deck.line(&format!("*NSET, NSET={name}"));
            deck.list(numbers);
        }
        deck.material(options);
        deck
    }

    fn heading(
        &mut self,
        solver: &str,
        mesh: &ShellMesh,
        (cells, mids): (&[Cell], &MidSides),
        options: &ExportOptions<'_>,
    ) {
        self.line("*HEADING");
        let title = format!("mid-surface shell mesh {}", title_line(options));
        self.line(title.trim_end());
        self.line(&format!(
            "** midshell {} for {solver}: {} nodes, {} elements, {} sheets",
            env!("CARGO_PKG_VERSION"),
            mesh.nodes.len(),
            cells.len(),
            mesh.sheets.len()
        ));
        self.line(
            "** Units: mm, N, t, s; stress in MPa. Reference surface: the middle (no offset).",
        );
        self.line("** Put your own material and steps after the last line.");
        if mids.len() > 0 {
            self.line(&format!(
                "** {} nodes more, numbered after those of the mesh, lie in the middle of the element sides.",
                mids.len()
            ));
        }
        let split = cells.len() - mesh.elements.len();
        if split > 0 {
            self.line(&format!(
                "** {split} quads with a corner of 180 degrees or more are written as two triangles."
            ));
        }
    }

    fn nodes(&mut self, mesh: &ShellMesh, mids: &MidSides) {
        self.line("*NODE, NSET=NALL");
        let corners = mesh.nodes.enumerated().map(|(n, p)| (number_of(n), *p));
        for (number, p) in corners.chain(mids.points(mesh)) {
            let text = [real(p.x), real(p.y), real(p.z)].join(", ");
            self.line(&format!("{number}, {text}"));
        }
    }

    fn elements<'a>(&mut self, kind: &str, cells: impl Iterator<Item = &'a Cell>, mids: &MidSides) {
        for (k, cell) in cells.enumerate() {
            if k == 0 {
                self.line(&format!("*ELEMENT, TYPE={kind}, ELSET=EALL"));
            }
            let corners = cell.corners.iter().map(|&n| number_of(n));
            let numbers = corners.chain(mids.of_cell(cell));
            let numbers: Vec<String> = numbers.map(|n| n.to_string()).collect();
            self.line(&format!("{}, {}", cell.number, numbers.join(", ")));
        }
    }

    fn material(&mut self, options: &ExportOptions<'_>) {
        let material = options.material;
        self.line(&format!("*MATERIAL, NAME={MATERIAL}"));
        self.line("*ELASTIC");
        let elastic = [real(material.young_mpa), real(material.poisson)];
        self.line(&elastic.join(", "));
        self.line("*DENSITY");
        self.line(&real(material.density_t_per_mm3));
    }

    /// An element set.
    pub fn element_set(&mut self, name: &str, numbers: &[usize]) {
        self.line(&format!("*ELSET, ELSET={name}"));
        self.list(numbers);
    }

    /// A shell section of the elements of `set`, with `extra` parameters (each with its comma before it).
    pub fn section(&mut self, set: &str, extra: &str, thickness: f64) {
        self.line(&format!(
            "*SHELL SECTION, ELSET={set}, MATERIAL={MATERIAL}{extra}"
        ));
        self.line(&real(thickness));
    }

    /// The thickness of nodes, by number.
    pub fn nodal_thickness(&mut self, nodal: &[(usize, f64)]) {
        if nodal.is_empty() {
            return;
        }
        self.line("*NODAL THICKNESS");
        for (number, thickness) in nodal {
            self.line(&format!("{number}, {}", real(*thickness)));
        }
    }

    /// Normals of elements at all their nodes: the places of these among `cells`, and a unit vector each.
    pub fn normals(&mut self, own: &[(usize, DVec3)], (cells, mids): (&[Cell], &MidSides)) {
        if own.is_empty() {
            return;
        }
        self.line(&format!(
            "** {} elements much shorter than they are thick have normals of their own.",
            own.len()
        ));
        self.line("*NORMAL");
        for (place, normal) in own {
            let cell = &cells[*place];
            let parts = normal.to_array().map(real).join(", ");
            let corners = cell.corners.iter().map(|&n| number_of(n));
            for node in corners.chain(mids.of_cell(cell)) {
                self.line(&format!("{}, {node}, {parts}", cell.number));
            }
        }
    }

    /// A line of its own.
    pub fn line(&mut self, text: &str) {
        self.out.push_str(text);
        self.out.push('\n');
    }

    fn list(&mut self, numbers: &[usize]) {
        for sixteen in numbers.chunks(16) {
            let texts: Vec<String> = sixteen.iter().map(usize::to_string).collect();
            self.line(&texts.join(", "));
        }
    }

    /// The finished bytes.
    pub fn finish(self) -> Vec<u8> {
        self.out.into_bytes()
    }
}

/// A real number in the 20 characters that both solvers read.
pub(super) fn real(value: f64) -> String {
    fitted(value, 20, Style::Plain).0
}
