//! What is written is read by other people's programs: meshio, Gmsh and pyNastran tell what they see, CalculiX solves.

// Clippy's allowance for tests does not reach the functions that tests share.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod calculix;
#[macro_use]
#[path = "../common/mod.rs"]
mod common;
mod deck;
mod fixture_decks;
mod meshes;
mod seen;
mod tools;

use midshell::export::{ExportOptions, Format, render, write_all};
use midshell::model::ids::{ElementId, NodeId};
use midshell::model::shell::ShellMesh;
use seen::{Seen, differences, told};
use std::path::PathBuf;
use tools::read_back;

/// The JSON between the readers and us may turn the last bit of a number; the files themselves are exact, which a unit test of the number writer shows.
const LAST_BIT: f64 = 3e-16;

/// Nastran's wide fields keep at least eleven digits; ten are asked for.
const NASTRAN_DIGITS: f64 = 1e-10;

/// Writes each mesh into a folder of its own kind and has them read back.
fn round_trip(format: Format, reader: &str, meshes: &[ShellMesh]) -> Vec<Seen> {
    let folder = tempfile::tempdir().unwrap();
    let outputs: Vec<(PathBuf, Vec<u8>)> = meshes
        .iter()
        .enumerate()
        .map(|(k, mesh)| {
            let path = folder.path().join(format!("{k}.{}", format.extension()));
            (
                path,
                render(format, mesh, &ExportOptions::default()).unwrap(),
            )
        })
        .collect();
    write_all(&outputs).unwrap();
    let files: Vec<PathBuf> = outputs.into_iter().map(|(path, _)| path).collect();
    read_back(reader, &files)
}

/// Every tiny mesh comes back whole; `tells` says what the reader must have told of it.
fn all_come_back(format: Format, reader: &str, relative: f64, tells: impl Fn(&Seen) -> bool) {
    let (names, meshes): (Vec<_>, Vec<_>) = meshes::all().into_iter().unzip();
    let answers = round_trip(format, reader, &meshes);
    assert_eq!(answers.len(), meshes.len());
    for ((name, mesh), seen) in names.iter().zip(&meshes).zip(&answers) {
        assert_eq!(differences(&told(mesh), seen, relative), [""; 0], "{name}");
        assert!(
            tells(seen),
            "{reader} does not tell enough of {name}: {seen:?}"
        );
    }
}

#[test]
fn meshio_reads_vtu() {
    all_come_back(Format::Vtu, "vtu-meshio", LAST_BIT, |seen| {
        let (node, element) = (&seen.nodes[0], &seen.elements[0]);
        node.thickness.is_some()
            && node.normal.is_some()
            && element.mean_thickness.is_some()
            && element.sheet.is_some()
            && element.source_faces.is_some()
    });
}

#[test]
fn meshio_reads_msh() {
    all_come_back(Format::Msh, "msh-meshio", LAST_BIT, |seen| {
        let (node, element) = (&seen.nodes[0], &seen.elements[0]);
        node.thickness.is_some()
            && element.mean_thickness.is_some()
            && element.sheet.is_some()
            && seen.edges.is_some()
    });
}

#[test]
fn gmsh_reads_msh() {
    all_come_back(Format::Msh, "msh-gmsh", LAST_BIT, |seen| {
        let (node, element) = (&seen.nodes[0], &seen.elements[0]);
        node.number.is_some()
            && node.thickness.is_some()
            && element.number.is_some()
            && element.mean_thickness.is_some()
            && element.corner_thickness.is_some()
            && seen.edges.is_some()
    });
}

#[test]
fn pynastran_reads_bdf() {
    all_come_back(Format::Nastran, "bdf-pynastran", NASTRAN_DIGITS, |seen| {
        let element = &seen.elements[0];
        element.number.is_some()
            && element.corner_thickness.is_some()
            && element.sheet.is_some()
            && seen.element_sets.is_some()
            && seen.node_sets.is_some()
    });
}

#[test]
fn meshio_reads_decks() {
    for format in [Format::Abaqus, Format::Calculix] {
        all_come_back(format, "inp-meshio", LAST_BIT, |seen| {
            seen.node_sets.is_some()
        });
    }
}

/// The comparison has teeth: a mesh that was changed in one place before it was written is caught by every reader that tells of that place.
#[test]
fn planted_defects_are_seen() {
    let (_, sound) = meshes::all().pop().unwrap();
    let readers = [
        (Format::Vtu, "vtu-meshio", LAST_BIT),
        (Format::Msh, "msh-meshio", LAST_BIT),
        (Format::Msh, "msh-gmsh", LAST_BIT),
        (Format::Nastran, "bdf-pynastran", NASTRAN_DIGITS),
    ];
    let mut moved = sound.clone();
    moved.nodes[NodeId(3)].y += 1e-6;
    let mut thicker = sound.clone();
    thicker.elements[ElementId(2)].thickness[1] += 1e-6;
    let mut turned = sound.clone();
    turned.elements.as_mut_slice().swap(0, 1);
    turned.elements[ElementId(0)].sheet = sound.elements[ElementId(0)].sheet;
    turned.elements[ElementId(1)].sheet = sound.elements[ElementId(1)].sheet;
    let mut rimless = sound.clone();
    rimless.rims.pop();
    rimless.junctions.clear();
    for (format, reader, relative) in readers {
        let spoilt = [
            moved.clone(),
            thicker.clone(),
            turned.clone(),
            rimless.clone(),
        ];
        let answers = round_trip(format, reader, &spoilt);
        for (k, seen) in answers.iter().enumerate() {
            // VTU has no edges.
            let blind = reader == "vtu-meshio" && k == 3;
            let found = differences(&told(&sound), seen, relative);
            assert_eq!(found.is_empty(), blind, "{reader}, defect {k}: {found:?}");
        }
    }
}

#[test]
fn same_mesh_same_bytes() {
    for (name, mesh) in meshes::all() {
        for format in Format::ALL {
            let bytes = || render(format, &mesh, &ExportOptions::default()).unwrap();
            assert_eq!(bytes(), bytes(), "{name}");
        }
    }
}
