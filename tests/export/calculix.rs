//! CalculiX solves the decks that we write, with nothing but a step put after them.

use super::meshes::{all, plate};
use super::tools::{calculix, has_calculix, table};
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
fn deflection(cells: [u32; 2], thickness: impl Fn(f64) -> f64, triangles: bool) -> f64 {
    let mesh = plate(SIZE, cells, thickness, triangles);
    let mut text = deck(&mesh, no_contraction());
    let row = cells[1] + 1;
    let nodes = |first: u32| (first..first + row).map(|n| (n + 1).to_string());
    let (clamped, tip) = (nodes(0), nodes(cells[0] * row));
    text += &format!(
        "*NSET, NSET=CLAMPED\n{}\n",
        clamped.collect::<Vec<_>>().join(",\n")
    );
    text += &format!(
        "*NSET, NSET=TIP\n{}\n",
        tip.clone().collect::<Vec<_>>().join(",\n")
    );
    text += "*BOUNDARY\nCLAMPED, 1, 6\n*STEP\n*STATIC\n*CLOAD\n";
    for (k, node) in tip.enumerate() {
        // A line load of 1 N in all: half a share at the ends.
        let share = if k == 0 || k == cells[1] as usize {
            0.5
        } else {
            1.0
        };
        text += &format!("{node}, 3, {}\n", share / f64::from(cells[1]));
    }
    text += "*NODE PRINT, NSET=TIP\nU\n*END STEP\n";
    let rows = table(&calculix(text.as_bytes()), "displacements");
    assert_eq!(rows.len(), row as usize);
    rows.iter().map(|row| row[3]).sum::<f64>() / rows.len() as f64
}

/// Tip deflection of a plate 1 mm thick over that of a beam, F L^3 / (3 E I).
fn deflection_ratio(cells: [u32; 2], triangles: bool) -> f64 {
    let inertia = SIZE[1] / 12.0;
    let beam = SIZE[0].powi(3) / (3.0 * no_contraction().young_mpa * inertia);
    deflection(cells, |_| 1.0, triangles) / beam
}

#[test]
fn a_plate_of_quads_bends_as_theory_says() {
    if has_calculix() {
        let ratio = deflection_ratio([20, 4], false);
        println!("quads: {ratio}");
        assert!((ratio - 1.0).abs() < 0.01, "deflection / theory = {ratio}");
    }
}

/// From 2 mm at the clamp to 1 mm at the tip: the integral of 12 F (L - x)^2 / (E b t^3) over the length.
#[test]
fn a_tapered_plate_bends_as_theory_says() {
    if has_calculix() {
        let integral = 2_f64.ln() - 0.625;
        let beam = 12.0 * SIZE[0].powi(3) * integral / (no_contraction().young_mpa * SIZE[1]);
        let ratio = deflection([20, 4], |x| 2.0 - x / SIZE[0], false) / beam;
        println!("tapered: {ratio}");
        assert!((ratio - 1.0).abs() < 0.01, "deflection / theory = {ratio}");
    }
}

/// CalculiX makes one linear wedge of an S3, which locks in bending. This holds the numbers that the writer's documentation gives, so that a better CalculiX (or element) is noticed.
#[test]
fn a_plate_of_triangles_is_too_stiff_but_converges() {
    if has_calculix() {
        // Cells of 5 and of 1.25 mm on a plate of 1 mm.
        let (coarse, fine) = (
            deflection_ratio([20, 4], true),
            deflection_ratio([80, 16], true),
        );
        println!("triangles: {coarse} and {fine}");
        assert!(
            (coarse - 0.53).abs() < 0.01,
            "deflection / theory = {coarse}"
        );
        assert!((fine - 0.89).abs() < 0.01, "deflection / theory = {fine}");
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
