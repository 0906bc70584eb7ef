//! Nastran deck: `CQUAD4` and `CTRIA3` with the thickness of every corner, one `PSHELL` a sheet.
//!
//! Coordinates are in 16-character fields (`GRID*`). Every other card is in 8-character fields where these hold its numbers exactly, otherwise in 16-character ones.
//! Corner thicknesses (T1 to T4) are left out where all equal the sheet's. Sets are bulk `SET1` cards, each with its name in a comment before it: `$ SET 4 NODES RIM`.
//! Quads with a corner of 180 degrees or more, at which Nastran stops, are written as two triangles.
//!
//! Limits: 16 characters hold 11 to 14 digits of a coordinate. Solution 101 is named so that the deck reads; loads and cases are the user's.
//!
//! Reference: MSC Nastran quick reference guide, bulk data format, `CQUAD4`, `CTRIA3`, `PSHELL`, `SET1`.

use super::cells::{Cell, cells};
use super::mid_side::MidSides;
use super::number::{Style, fitted};
use super::sets::sets;
use super::{ExportError, ExportOptions, number_of, title_line};
use crate::model::ids::{Id, SheetId};
use crate::model::shell::ShellMesh;

/// The greatest number that an 8-character field holds.
const GREATEST: usize = 99_999_999;

/// One field of a card.
#[derive(Clone, Copy)]
enum Field {
    Blank,
    Int(usize),
    Real(f64),
}
use Field::{Blank, Int, Real};

pub(super) fn render(
    mesh: &ShellMesh,
    options: &ExportOptions<'_>,
) -> Result<Vec<u8>, ExportError> {
    let cells = cells(mesh);
    let needed = mesh.nodes.len().max(cells.len()).max(mesh.sheets.len());
    if needed > GREATEST {
        return Err(ExportError::TooManyForNastran {
            limit: GREATEST,
            needed,
        });
    }
    let mut out = String::new();
    head(&mut out, mesh, &cells, options);
    for (node, p) in mesh.nodes.enumerated() {
        let fields = [Int(number_of(node)), Blank, Real(p.x), Real(p.y), Real(p.z)];
        wide(&mut out, "GRID", &fields);
    }
    let plates = plate_thickness(mesh, &cells);
    for cell in &cells {
        element(&mut out, mesh, cell, &plates);
    }
    let material = options.material;
    for (sheet, thickness) in mesh.sheets.ids().zip(&plates) {
        if let Some(thickness) = *thickness {
            // The same material for membrane, bending and transverse shear.
            let fields = [
                Int(number_of(sheet)),
                Int(1),
                Real(thickness),
                Int(1),
                Blank,
                Int(1),
            ];
            card(&mut out, "PSHELL", &fields);
        }
    }
    let fields = [
        Int(1),
        Real(material.young_mpa),
        Blank,
        Real(material.poisson),
        Real(material.density_t_per_mm3),
    ];
    card(&mut out, "MAT1", &fields);
    write_sets(&mut out, mesh, &cells);
    out.push_str("ENDDATA\n");
    Ok(out.into_bytes())
}

fn head(out: &mut String, mesh: &ShellMesh, cells: &[Cell], options: &ExportOptions<'_>) {
    out.push_str(&format!(
        "$ midshell {}: {} nodes, {} elements, {} sheets\n",
        env!("CARGO_PKG_VERSION"),
        mesh.nodes.len(),
        cells.len(),
        mesh.sheets.len()
    ));
    out.push_str(
        "$ Units: mm, N, t, s; stress in MPa. Reference surface: the middle (no offset).\n",
    );
    let split = cells.len() - mesh.elements.len();
    if split > 0 {
        out.push_str(&format!(
            "$ {split} quads with a corner of 180 degrees or more are written as two triangles.\n"
        ));
    }
    let title = title_line(options);
    let title = format!("mid-surface shell mesh {title}");
    out.push_str(&format!("SOL 101\nCEND\nTITLE = {}\n", title.trim_end()));
    out.push_str("BEGIN BULK\n");
}

/// The thickness on each sheet's property: that of its corners where all are equal, otherwise the mean of its elements; `None` without elements.
fn plate_thickness(mesh: &ShellMesh, cells: &[Cell]) -> Vec<Option<f64>> {
    let mut sums = vec![(0.0, 0_u32); mesh.sheets.len()];
    let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); mesh.sheets.len()];
    for cell in cells {
        let sheet = mesh.elements[cell.element].sheet.index();
        sums[sheet].0 += cell.mean_thickness();
        sums[sheet].1 += 1;
        for &thickness in &cell.thickness {
            ranges[sheet].0 = thickness.min(ranges[sheet].0);
            ranges[sheet].1 = thickness.max(ranges[sheet].1);
        }
    }
    let plates = sums.into_iter().zip(ranges);
    plates
        .map(|((sum, count), (low, high))| match count {
            0 => None,
            _ if low == high => Some(low),
            _ => Some(sum / f64::from(count)),
        })
        .collect()
}

fn element(out: &mut String, mesh: &ShellMesh, cell: &Cell, plates: &[Option<f64>]) {
    let sheet: SheetId = mesh.elements[cell.element].sheet;
    let name = if cell.corners.len() == 3 {
        "CTRIA3"
    } else {
        "CQUAD4"
    };
    let mut fields = vec![Int(cell.number), Int(number_of(sheet))];
    fields.extend(cell.corners.iter().map(|&n| Int(number_of(n))));
    let plate = plates[sheet.index()];
    if cell.thickness.iter().any(|&t| Some(t) != plate) {
        // Material angle, offset, (for a triangle one unused field,) a blank and the thickness flag come between.
        fields.resize(10, Blank);
        fields.extend(cell.thickness.iter().map(|&t| Real(t)));
    }
    card(out, name, &fields);
}

fn write_sets(out: &mut String, mesh: &ShellMesh, cells: &[Cell]) {
    let sets = sets(mesh, cells, &MidSides::default());
    let elements = sets.elements.iter().map(|set| ("ELEMENTS", set));
    let nodes = sets.nodes.iter().map(|set| ("NODES", set));
    for (k, (kind, (name, numbers))) in elements.chain(nodes).enumerate() {
        out.push_str(&format!("$ SET {} {kind} {name}\n", k + 1));
        let mut fields = vec![Int(k + 1)];
        fields.extend(numbers.iter().map(|&n| Int(n)));
        card(out, "SET1", &fields);
    }
}

/// A card in 8-character fields if these hold every number exactly, else in 16-character ones.
fn card(out: &mut String, name: &str, fields: &[Field]) {
    let texts: Option<Vec<String>> = fields
        .iter()
        .map(|field| match text(*field, 8) {
            (text, true) => Some(text),
            (_, false) => None,
        })
        .collect();
    match texts {
        Some(texts) => lines(out, &format!("{name:<8}"), "+       ", &texts, 8),
        None => wide(out, name, fields),
    }
}

/// A card in 16-character fields.
fn wide(out: &mut String, name: &str, fields: &[Field]) {
    let mut texts: Vec<String> = fields.iter().map(|field| text(*field, 16).0).collect();
    // Such a card has an even count of lines with four fields each.
    texts.resize(texts.len().next_multiple_of(8), String::new());
    lines(
        out,
        &format!("{:<8}", format!("{name}*")),
        "*       ",
        &texts,
        16,
    );
}

/// `first` or `next` and the fields of one line each, 64 characters of them.
fn lines(out: &mut String, first: &str, next: &str, texts: &[String], width: usize) {
    for (k, line) in texts.chunks(64 / width).enumerate() {
        let start = out.len();
        out.push_str(if k == 0 { first } else { next });
        for text in line {
            out.push_str(&format!("{text:<width$}"));
        }
        let end = start + out[start..].trim_end().len();
        out.truncate(end);
        out.push('\n');
    }
}

/// A field as text, and whether it is exact.
fn text(field: Field, width: usize) -> (String, bool) {
    match field {
        Blank => (String::new(), true),
        Int(number) => (number.to_string(), true),
        Real(value) => fitted(value, width, Style::Nastran),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Format;
    use super::super::tests::{quad, text};
    use crate::model::ids::NodeId;
    use glam::DVec3;

    fn cards(deck: &str, name: &str) -> Vec<String> {
        let mut found = Vec::new();
        let mut inside = false;
        for line in deck.lines() {
            inside = line.starts_with(name) || (inside && line.starts_with(['+', '*']));
            if inside {
                found.push(line.to_owned());
            }
        }
        found
    }

    #[test]
    fn a_constant_quad_needs_no_corner_values() {
        let deck = text(Format::Nastran, &quad([1.5; 4]));
        assert_eq!(
            cards(&deck, "CQUAD4"),
            ["CQUAD4  1       1       1       2       3       4"]
        );
        assert_eq!(
            cards(&deck, "PSHELL"),
            ["PSHELL  1       1       1.5     1               1"]
        );
        assert_eq!(
            cards(&deck, "MAT1"),
            ["MAT1    1       210000.         .3      7.85-9"]
        );
        assert_eq!(
            cards(&deck, "GRID*   3"),
            [
                "GRID*   3                               1.              1.",
                "*       0."
            ]
        );
    }

    #[test]
    fn corner_values_are_exact_in_the_narrowest_field_that_holds_them() {
        let narrow = text(Format::Nastran, &quad([1.0, 1.25, 2.0, 1.5]));
        assert_eq!(
            cards(&narrow, "CQUAD4")[1],
            "+                       1.      1.25    2.      1.5"
        );
        let wide = text(Format::Nastran, &quad([1.0, 1.123_456_789, 2.0, 1.5]));
        assert_eq!(
            cards(&wide, "CQUAD4")[2..],
            [
                "*                                       1.              1.123456789",
                "*       2.              1.5"
            ]
        );
    }

    #[test]
    fn no_quad_has_a_reflex_corner() {
        let mut mesh = quad([1.0; 4]);
        mesh.nodes[NodeId(2)] = DVec3::new(0.4, 0.4, 0.0);
        let deck = text(Format::Nastran, &mesh);
        assert!(cards(&deck, "CQUAD4").is_empty());
        assert_eq!(cards(&deck, "CTRIA3").len(), 2);
    }

    #[test]
    fn sets_go_on_over_lines_of_eight() {
        let deck = text(Format::Nastran, &quad([1.0; 4]));
        assert!(deck.contains("$ SET 8 NODES RIM\nSET1    8       1       2       3       4\n"));
        let lines = deck.lines().filter(|l| !l.starts_with('$'));
        assert!(lines.map(str::len).all(|length| length <= 72));
    }
}
