//! CalculiX solves the decks that we write, with nothing but a step put after them.

use super::deck::Deck;
use super::meshes::{Kind, all, plate};
use super::tools::{calculix, has_calculix, table};
use glam::DVec3;
use midshell::export::{ExportOptions, Format, Material, render};
use midshell::model::ids::ElementId;
use midshell::model::shell::ShellMesh;

fn deck(mesh: &ShellMesh, material: Material) -> String {
    let options = ExportOptions {
        material,
        ..ExportOptions::default()
    };
    String::from_utf8(render(Format::Calculix, mesh, &options).unwrap()).unwrap()
}

/// The plates: length, width, mm.
const SIZE: [f64; 2] = [100.0, 20.0];

/// Without lateral contraction a plate bends as a beam does.
fn no_contraction() -> Material {
    Material {
        poisson: 0.0,
        ..Material::default()
    }
}

/// Deflection of the tip, mm, of a plate clamped at one short edge under a line load of 1 N in all on the other.
fn deflection(cells: [u32; 2], thickness: impl Fn(f64) -> f64, kind: Kind) -> f64 {
    let mesh = plate(SIZE, cells, thickness, kind);
    tip_deflection(deck(&mesh, no_contraction()), cells[1] as usize)
}

/// The same of a deck with that many element sides across.
fn tip_deflection(text: String, sides: usize) -> f64 {
    let deck = Deck::read(text);
    let line = |x: f64| -> Vec<usize> {
        let mut nodes: Vec<usize> = deck
            .nodes
            .iter()
            .filter(|(_, p)| p.x == x)
            .map(|(n, _)| *n)
            .collect();
        nodes.sort_by(|a, b| deck.nodes[a].y.total_cmp(&deck.nodes[b].y));
        nodes
    };
    let (clamped, tip) = (line(0.0), line(SIZE[0]));
    // A line load of 1 N in all, as the elements' own shape functions share it out: trapezes, or Simpson's rule where there are mid-side nodes.
    let second_order = tip.len() == 2 * sides + 1;
    assert!(second_order || tip.len() == sides + 1);
    let shares = tip.iter().enumerate().map(|(k, &node)| {
        let end = k == 0 || k + 1 == tip.len();
        let share = match (second_order, k % 2) {
            (true, 1) => 4.0 / 6.0,
            (true, _) if end => 1.0 / 6.0,
            (true, _) => 2.0 / 6.0,
            (false, _) if end => 0.5,
            (false, _) => 1.0,
        };
        (node, DVec3::Z * share / sides as f64)
    });
    let solved = deck.solve(&clamped, 6, &shares.collect::<Vec<_>>());
    let sum: f64 = tip.iter().map(|node| solved.displacements[node].z).sum();
    sum / tip.len() as f64
}

/// Tip deflection of a plate 1 mm thick over that of a beam, F L^3 / (3 E I).
fn deflection_ratio(cells: [u32; 2], kind: Kind) -> f64 {
    let inertia = SIZE[1] / 12.0;
    let beam = SIZE[0].powi(3) / (3.0 * no_contraction().young_mpa * inertia);
    deflection(cells, |_| 1.0, kind) / beam
}

fn bends_as_theory_says(kind: Kind) {
    if has_calculix() {
        let ratio = deflection_ratio([20, 4], kind);
        println!("{kind:?}: {ratio}");
        assert!((ratio - 1.0).abs() < 0.01, "deflection / theory = {ratio}");
    }
}

#[test]
fn a_plate_of_quads_bends_as_theory_says() {
    bends_as_theory_says(Kind::Quads);
}

#[test]
fn a_plate_of_triangles_bends_as_theory_says() {
    bends_as_theory_says(Kind::Triangles);
}

#[test]
fn a_plate_of_quads_and_triangles_bends_as_theory_says() {
    bends_as_theory_says(Kind::Mixed);
}

/// From 2 mm at the clamp to 1 mm at the tip: the integral of 12 F (L - x)^2 / (E b t^3) over the length.
#[test]
fn a_tapered_plate_bends_as_theory_says() {
    if !has_calculix() {
        return;
    }
    let integral = 2_f64.ln() - 0.625;
    let beam = 12.0 * SIZE[0].powi(3) * integral / (no_contraction().young_mpa * SIZE[1]);
    for kind in [Kind::Quads, Kind::Triangles, Kind::Mixed] {
        let ratio = deflection([20, 4], |x| 2.0 - x / SIZE[0], kind) / beam;
        println!("tapered, {kind:?}: {ratio}");
        assert!(
            (ratio - 1.0).abs() < 0.01,
            "{kind:?}: deflection / theory = {ratio}"
        );
    }
}

/// Why triangles are written as S6: as S3 they lock. A CalculiX in which this fails no longer needs mid-side nodes.
#[test]
fn triangles_of_first_order_would_be_too_stiff() {
    if has_calculix() {
        let mesh = plate(SIZE, [20, 4], |_| 1.0, Kind::Triangles);
        let text = String::from_utf8(
            render(
                Format::Abaqus,
                &mesh,
                &ExportOptions {
                    material: no_contraction(),
                    ..ExportOptions::default()
                },
            )
            .unwrap(),
        );
        let ratio = tip_deflection(text.unwrap(), 4) * 3.0 * no_contraction().young_mpa * SIZE[1]
            / (12.0 * SIZE[0].powi(3));
        println!("S3: {ratio}");
        assert!((ratio - 0.53).abs() < 0.01, "deflection / theory = {ratio}");
    }
}

/// CalculiX's own volume of every element is its area times the thickness that we meant.
#[test]
fn every_deck_solves_a_static_step_with_the_thickness_meant() {
    if !has_calculix() {
        return;
    }
    for (name, mesh) in all() {
        let mut text = deck(&mesh, Material::default());
        text += "*BOUNDARY\n1, 1, 6\n2, 1, 6\n*STEP\n*STATIC\n*CLOAD\n3, 3, 1.\n";
        text += "*EL PRINT, ELSET=EALL\nEVOL\n*NODE PRINT, NSET=NALL\nU\n*END STEP\n";
        let dat = calculix(text.as_bytes());
        let volumes = table(&dat, "volume");
        assert_eq!(volumes.len(), mesh.elements.len(), "{name}");
        for row in &volumes {
            let element = &mesh.elements[ElementId(row[0] as u32 - 1)];
            let p: Vec<_> = element
                .corners
                .as_slice()
                .iter()
                .map(|&n| mesh.nodes[n])
                .collect();
            let diagonals = (p[2] - p[0]).cross(*p.last().unwrap() - p[1]);
            let volume = 0.5 * diagonals.length() * element.mean_thickness();
            assert!(
                (row[1] / volume - 1.0).abs() < 1e-5,
                "{name}: {row:?}, not {volume}"
            );
        }
        let moved = table(&dat, "displacements").iter().any(|row| row[3] > 0.0);
        assert!(moved, "{name} does not move");
    }
}
