//! Facet input against CAD input: the same fixture as STEP and tessellated, in every dialect, gives the same topology and thickness. Needs gmsh.

#![allow(clippy::unwrap_used, clippy::panic)]

#[allow(unused_macros, reason = "fixtures are picked by name here")]
mod common;

use std::path::{Path, PathBuf};
use std::time::Duration;

use common::step::{Variant, step};
use common::tools;
use glam::DVec3;
use midshell::import::facet::FacetFormat;
use midshell::import::facet::soup::Soup;
use midshell::import::facet::weld::weld;
use midshell::import::{ImportError, ImportOptions, Imported, import_cad};
use midshell::inspection::SolidFacts;
use midshell::options::MeshOptions;
use midshell::pipeline::{Progress, inspect};

struct Silent;

impl Progress for Silent {
    fn stage(&self, _: &str) {}
}

/// The fixture as gmsh tessellates it: binary STL.
fn tessellated(name: &str, folder: &Path) -> PathBuf {
    let stl = folder.join(format!("{name}.stl"));
    let mut command = tools::with_gmsh(tools::gmsh());
    command.arg(step(name, Variant::AsMade)).arg("-2");
    command.args(["-setnumber", "Mesh.MeshSizeFromCurvature", "24"]);
    command.args(["-setnumber", "Mesh.Binary", "1", "-format", "stl", "-o"]);
    tools::run(
        {
            command.arg(&stl);
            command
        },
        Duration::from_secs(60),
    );
    stl
}

fn options() -> MeshOptions {
    MeshOptions {
        gmsh: Some(tools::gmsh().to_path_buf()),
        ..MeshOptions::default()
    }
}

fn import(path: &Path) -> Result<Imported, ImportError> {
    import_cad(
        path,
        &ImportOptions {
            gmsh: Some(tools::gmsh().to_path_buf()),
            ..ImportOptions::default()
        },
    )
}

fn facts(path: &Path) -> SolidFacts {
    let found = inspect(path, &options(), &Silent).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(found.solids.len(), 1);
    found.solids[0].clone()
}

/// Mean thickness over all walls, by area.
fn thickness(facts: &SolidFacts) -> f64 {
    let area: f64 = facts.walls.iter().map(|w| w.area).sum();
    facts.walls.iter().map(|w| w.area * w.mean).sum::<f64>() / area
}

#[track_caller]
fn agrees_with_its_step(name: &str) {
    let folder = common::scratch();
    let stl = tessellated(name, folder.path());
    let from_step = step(name, Variant::AsMade);
    let euler = |p: &Path| import(p).unwrap().pieces[0].brep.euler();
    assert_eq!(euler(&stl), euler(&from_step), "Euler characteristic");
    let (a, b) = (facts(&stl), facts(&from_step));
    // 24 chords a circle lose one per cent of what is inside it.
    let near = |x: f64, y: f64, share: f64| (x - y).abs() < share * y;
    assert!(near(a.volume, b.volume, 0.03), "{} {}", a.volume, b.volume);
    let (t, u) = (thickness(&a), thickness(&b));
    assert!(near(t, u, 0.02), "thickness {t} of facets, {u} of CAD");
    assert_eq!((a.sheets, a.junctions), (b.sheets, b.junctions));
    let sides = |f: &SolidFacts| f.faces_by_role.get("wall side").copied();
    assert_eq!(sides(&a), sides(&b), "faces that are sides of walls");
}

#[test]
fn a_t_agrees_with_its_step() {
    agrees_with_its_step("t_sharp");
}

#[test]
fn a_t_with_fillets_agrees_with_its_step() {
    agrees_with_its_step("t_fillet");
}

#[test]
fn a_bend_agrees_with_its_step() {
    agrees_with_its_step("l_bend");
}

#[test]
fn a_tube_agrees_with_its_step() {
    agrees_with_its_step("tube");
}

#[test]
fn a_box_with_a_void_agrees_with_its_step() {
    agrees_with_its_step("closed_box");
}

fn triangles(soup: &Soup) -> impl Iterator<Item = [DVec3; 3]> + '_ {
    (0..soup.triangles.len()).map(|t| soup.corners(t))
}

fn ascii_stl(soup: &Soup) -> String {
    let mut text = String::from("solid a\n");
    for t in triangles(soup) {
        text += "facet normal 0 0 0\nouter loop\n";
        for p in t {
            text += &format!("vertex {} {} {}\n", p.x, p.y, p.z);
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid a\n"
}

fn obj(soup: &Soup) -> String {
    let mut text = String::new();
    for p in &soup.points {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for t in &soup.triangles {
        text += &format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    }
    text
}

fn ply(soup: &Soup) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_big_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar uint vertex_index\nend_header\n",
        soup.points.len(),
        soup.triangles.len()
    )
    .into_bytes();
    for p in &soup.points {
        bytes.extend(p.to_array().iter().flat_map(|x| x.to_be_bytes()));
    }
    for t in &soup.triangles {
        bytes.push(3);
        bytes.extend(t.iter().flat_map(|v| v.to_be_bytes()));
    }
    bytes
}

#[test]
fn every_dialect_gives_the_same_solid() {
    let folder = common::scratch();
    let stl = tessellated("t_fillet", folder.path());
    let base = import(&stl).unwrap();
    let soup = FacetFormat::Stl
        .parse(&std::fs::read(&stl).unwrap())
        .unwrap();
    let (welded, _) = weld(&soup);
    for (name, bytes) in [
        ("ascii.stl", ascii_stl(&soup).into_bytes()),
        ("soup.obj", obj(&soup).into_bytes()),
        ("welded.obj", obj(&welded).into_bytes()),
        ("welded.ply", ply(&welded)),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let found = import(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(found.pieces, base.pieces, "{name}");
    }
}

#[test]
fn what_is_no_solid_is_refused_with_place_and_reason() {
    let folder = common::scratch();
    let stl = tessellated("t_sharp", folder.path());
    let mut soup = FacetFormat::Stl
        .parse(&std::fs::read(&stl).unwrap())
        .unwrap();
    let longest = soup.triangles.len() / 3;
    soup.triangles.truncate(2 * longest);
    let open = folder.path().join("open.obj");
    std::fs::write(&open, obj(&soup)).unwrap();
    let error = import(&open).unwrap_err();
    assert!(matches!(error, ImportError::NotASolid { .. }), "{error}");
    assert!(error.to_string().contains("open border"), "{error}");
    let cut = folder.path().join("cut.stl");
    let text = ascii_stl(&soup);
    std::fs::write(&cut, &text[..text.len() / 2]).unwrap();
    let error = import(&cut).unwrap_err();
    assert!(matches!(error, ImportError::BadFacets { .. }), "{error}");
    assert!(error.to_string().contains("line "), "{error}");
}
