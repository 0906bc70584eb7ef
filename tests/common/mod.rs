//! Fixtures for tests: their STEP files and facts, runs of the binary, and measurements made by other code than the product's.
//!
//! `step` makes a fixture's solid with Gmsh (kept under `target/fixtures` by the content of its script), `mesh` runs the binary on it,
//! `measure` measures the result against the exact solid (tests/python/measure.py), `Facts::violations` says what is wrong with it.

// Each test binary uses a part of this; and clippy takes only `#[test]` functions themselves for tests.
#![allow(dead_code, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

/// Calls a macro with the names of all fixtures, the one list that tests of every fixture are made from: those whose facts the product
/// meets, and those that it does not meet yet, whose truth is tested but not their meshes.
macro_rules! for_all_fixtures {
    ($test:ident) => {
        $test!(
            met: [
                blade,
                boss_on_rib,
                boss_ribs,
                bottle,
                bspline_bowl,
                bspline_shell,
                c_tube,
                chamfer_t,
                chamfered_rim,
                closed_box,
                cone_shell,
                countersunk,
                countersunk_wide,
                egg_crate,
                emboss,
                fillet_one_side,
                fillet_stepped,
                fillet_variable,
                fillet_wide,
                five_arms,
                flange_thin_web_thick,
                flat_plate,
                half_sphere,
                hat_bend,
                hollow_sphere,
                joggle,
                l_bend,
                l_sharp,
                lens_duct,
                meeting_point,
                nut_boss,
                nut_pocket,
                open_box,
                perforated,
                plate_holes,
                plate_pocket,
                plate_web,
                quarter_round,
                rib_draft,
                rib_partial,
                rib_partial_fillet,
                rib_shallow,
                rib_tapered,
                rib_to_fillet,
                ribs_crossing,
                rounded_rim,
                slanted_rim,
                sliver_rim,
                slot_rim,
                slots,
                spiral,
                split_plate,
                split_tube,
                spot_tray,
                step_flush,
                step_symmetric,
                strip_plate,
                t_fillet,
                t_sharp,
                tight_bend,
                torus_shell,
                touching,
                tube,
                tubes_t,
                two_solids,
                two_thickness,
                u_bend,
                wedge,
                wide_rim,
                wing_skin,
                x_cross,
                y_plates,
                z_bend,
            ],
            unmet: [
                pinhole,
            ],
        );
    };
}

pub mod facts;
pub mod measured;
pub mod step;
pub mod tools;

use facts::Facts;
use measured::Measured;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A folder of its own for one test's files, taken away when dropped.
pub fn scratch() -> tempfile::TempDir {
    tempfile::Builder::new()
        .prefix("case-")
        .tempdir_in(tools::cache())
        .expect("a temporary folder")
}

/// What the binary is asked for beside the input and the outputs.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// Element size, in the length unit of the input.
    pub size: f64,
    /// Elements on a full circle.
    pub size_curvature: Option<f64>,
    /// Worker threads.
    pub threads: usize,
    /// Value of `--element`.
    pub element: Option<&'static str>,
}

/// Meshes `step` with the built binary; the VTU file that it wrote. Panics with the binary's own words unless it exits with 0.
pub fn mesh(step: &Path, folder: &Path, name: &str, wanted: Wanted) -> PathBuf {
    let vtu = folder.join(format!("{name}.vtu"));
    let json = folder.join(format!("{name}.json"));
    let mut command = tools::with_gmsh(env!("CARGO_BIN_EXE_midshell"));
    command
        .arg("mesh")
        .arg(step)
        .arg("-o")
        .arg(&vtu)
        .arg("--json")
        .arg(&json);
    command.args([
        "--size",
        &wanted.size.to_string(),
        "--threads",
        &wanted.threads.to_string(),
    ]);
    if let Some(n) = wanted.size_curvature {
        command.args(["--size-curvature", &n.to_string()]);
    }
    if let Some(element) = wanted.element {
        command.args(["--element", element]);
    }
    tools::run(command, Duration::from_secs(300));
    report(&vtu);
    vtu
}

/// The report that was written beside a mesh.
pub fn report(vtu: &Path) -> serde_json::Value {
    let json = vtu.with_extension("json");
    let report = std::fs::read_to_string(json).expect("the report was written");
    serde_json::from_str(&report).expect("the report is JSON")
}

/// Measures a mesh against a solid; `scale` multiplies the mesh first.
pub fn measure(step: &Path, vtu: &Path, facts: &Facts, scale: f64) -> Measured {
    let mut command = tools::python("measure.py");
    command.arg("mesh").arg(step).arg(vtu);
    command.args([
        "--thickest",
        &facts.thickest().to_string(),
        "--scale",
        &scale.to_string(),
    ]);
    let out = tools::run(command, Duration::from_secs(300));
    serde_json::from_str(&out).unwrap_or_else(|e| panic!("measure.py: {e}: {out}"))
}

/// Ideal meshes are so much finer than the fixtures' size: their nodes lie on the mid-surface, so that their chords err one way.
const FINER: f64 = 0.9;

/// The mid-surface drawn by hand and meshed by Gmsh, with a planted defect if one is named.
pub fn ideal(name: &str, folder: &Path, facts: &Facts, defect: Option<&str>) -> PathBuf {
    let vtu = folder.join(format!("{name}.vtu"));
    let mut command = tools::python("measure_ideal.py");
    command
        .arg(name)
        .arg(&vtu)
        .args(["--size", &(FINER * facts.size).to_string()]);
    if let Some(n) = facts.size_curvature {
        command.args(["--size-curvature", &(n / FINER).ceil().to_string()]);
    }
    if let Some(d) = defect {
        command.args(["--plant", d]);
    }
    tools::run(command, Duration::from_secs(300));
    vtu
}
