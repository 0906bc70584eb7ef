//! Sizes: bounds, growth, rows across narrow sheets, and sizes of single sheets and faces, on parts whose truth is drawn. Needs gmsh.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

mod binary;

use binary::{Bench, PLATE, gmsh};
use glam::DVec3;
use midshell::import::{ImportOptions, import_cad};
use midshell::inspection::Inspection;
use midshell::model::element_shape::ElementShape;
use midshell::model::local_size::LocalSize;
use midshell::model::shell::{Element, ShellMesh};
use midshell::options::MeshOptions;
use midshell::pipeline::{self, MeshRun, Progress};
use std::path::Path;

struct Silent;

impl Progress for Silent {
    fn stage(&self, _: &str) {}
}

fn options() -> MeshOptions {
    MeshOptions {
        gmsh: Some(gmsh()),
        ..MeshOptions::default()
    }
}

/// A right mesh.
fn meshed(part: &Path, options: &MeshOptions) -> MeshRun {
    let run = pipeline::mesh(part, options, &Silent).unwrap_or_else(|e| panic!("{e}"));
    assert!(run.report.doubts.is_empty(), "{:?}", run.report.doubts);
    run
}

fn inspected(part: &Path) -> Inspection {
    pipeline::inspect(part, &options(), &Silent).unwrap_or_else(|e| panic!("{e}"))
}

/// A plate 60 x 40 x 2 with a rib 2 thick and 7 high across it: the rib's sheet reaches from z = 1 to 9.
fn t_part(scale: f64, more: &str) -> String {
    format!(
        "s = {scale}; Box(1) = {{0, 0, 0, 60*s, 40*s, 2*s}}; Box(2) = {{0, 19*s, 0, 60*s, 2*s, 9*s}}; \
         BooleanUnion(3) = {{Volume{{1}}; Delete;}}{{Volume{{2}}; Delete;}}; {more}"
    )
}

const FOOT: f64 = 1.0;
const RIM: f64 = 9.0;

fn corners<'a>(mesh: &'a ShellMesh, e: &'a Element) -> impl Iterator<Item = DVec3> + 'a {
    e.corners.as_slice().iter().map(|&n| mesh.nodes[n])
}

/// How many elements reach from the foot of the rib of a T to its rim.
fn spanning(mesh: &ShellMesh, scale: f64) -> usize {
    let near = |z: f64, want: f64| (z / scale - want).abs() < 0.05;
    let spans = |e: &&Element| {
        let on = |want: f64| corners(mesh, e).any(|p| near(p.z, want));
        on(FOOT) && on(RIM)
    };
    mesh.elements.iter().filter(spans).count()
}

/// The lengths of the edges of the elements all of whose corners are told to count, mm.
fn edges(mesh: &ShellMesh, counts: impl Fn(DVec3) -> bool) -> Vec<f64> {
    let mut lengths = Vec::new();
    for e in &mesh.elements {
        let p: Vec<DVec3> = corners(mesh, e).collect();
        if p.iter().all(|p| counts(*p)) {
            lengths.extend((0..p.len()).map(|k| p[k].distance(p[(k + 1) % p.len()])));
        }
    }
    assert!(!lengths.is_empty());
    lengths
}

fn mean(lengths: &[f64]) -> f64 {
    lengths.iter().sum::<f64>() / lengths.len() as f64
}

fn least(lengths: &[f64]) -> f64 {
    lengths.iter().copied().fold(f64::INFINITY, f64::min)
}

fn longest(lengths: &[f64]) -> f64 {
    lengths.iter().copied().fold(0.0, f64::max)
}

#[test]
fn a_rib_gets_the_rows_that_were_asked_for() {
    let bench = Bench::new();
    let part = bench.step("t.step", &t_part(1.0, ""));
    for element in [ElementShape::Triangle, ElementShape::Quad] {
        let with = |rows: u32, size_min: Option<f64>| {
            let options = MeshOptions {
                size: Some(10.0),
                size_min,
                rows,
                element,
                ..options()
            };
            meshed(&part, &options).mesh
        };
        // Edges of the rim where the rib ends.
        let rows = |mesh: &ShellMesh| {
            let at = |p: DVec3| p.x.abs() < 0.01 && p.z > FOOT - 0.05 && (p.y - 20.0).abs() < 0.01;
            let on = |e: &&[_; 2]| e.iter().all(|&n| at(mesh.nodes[n]));
            mesh.rims.iter().filter(on).count()
        };
        // What the rule is there for: without it one row spans the rib.
        let one = with(1, None);
        assert!(spanning(&one, 1.0) > 0, "{element}");
        for wanted in [2, 3] {
            let mesh = with(wanted, None);
            assert_eq!(spanning(&mesh, 1.0), 0, "{element}, {wanted} rows");
            assert!(rows(&mesh) >= wanted as usize, "{element}, {wanted} rows");
            assert!(mesh.elements.len() > one.elements.len());
        }
        // As many rows as are no lower than the wall is thick, or than the user's least size.
        let many = rows(&with(20, None));
        assert!((3..=5).contains(&many), "{element}: {many} rows");
        let bound = with(2, Some(8.0));
        assert!(spanning(&bound, 1.0) > 0, "{element}");
    }
}

#[test]
fn rows_hang_on_no_place_no_scale_and_no_thread() {
    let bench = Bench::new();
    let turn = "Rotate{{1, 2, 3}, {0, 0, 0}, 1}{Volume{3};}";
    let made = |name: &str, script: &str, scale: f64| {
        let options = MeshOptions {
            size: Some(10.0 * scale),
            ..options()
        };
        let mesh = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            (pool.unwrap()).install(|| meshed(&bench.step(name, script), &options).mesh)
        };
        let one = mesh(1);
        assert_eq!(mesh(4), one, "{name}: another mesh with 4 threads");
        one
    };
    let plain = made("plain.step", &t_part(1.0, ""), 1.0);
    assert_eq!(spanning(&plain, 1.0), 0);
    let count = plain.elements.len() as f64;
    for scale in [1e-3, 1e3] {
        let scaled = made("scaled.step", &t_part(scale, ""), scale);
        assert_eq!(spanning(&scaled, scale), 0, "{scale}");
        assert!((scaled.elements.len() as f64 / count - 1.0).abs() < 0.1);
    }
    let turned = made("turned.step", &t_part(1.0, turn), 1.0);
    assert!((turned.elements.len() as f64 / count - 1.0).abs() < 0.1);
}

/// A plate with a hole of radius 8 at (30, 20).
const HOLE: &str = "Box(1) = {0, 0, 0, 100, 60, 2}; Cylinder(2) = {30, 20, -1, 0, 0, 4, 8}; \
                    BooleanDifference(3) = {Volume{1}; Delete;}{Volume{2}; Delete;};";

fn from_hole(p: DVec3) -> f64 {
    p.truncate().distance(glam::DVec2::new(30.0, 20.0)) - 8.0
}

#[test]
fn bounds_win_against_the_part_and_its_curves() {
    let bench = Bench::new();
    let part = bench.step("hole.step", HOLE);
    let made = |size: Option<f64>, size_min: Option<f64>, size_max: Option<f64>| {
        let options = MeshOptions {
            size,
            size_min,
            size_max,
            ..options()
        };
        pipeline::mesh(&part, &options, &Silent).unwrap().mesh
    };
    // The part decides on 4.7 and less round the hole.
    let lengths = |mesh: &ShellMesh| edges(mesh, |_| true);
    let free = lengths(&made(None, None, None));
    assert!(least(&free) < 2.0 && longest(&free) > 4.0);
    // A bound below that is the size.
    assert_eq!(made(None, None, Some(2.0)), made(Some(2.0), None, None));
    assert_eq!(made(None, None, Some(50.0)), made(None, None, None));
    // A hole keeps some ten edges, however short these are; here they need not be.
    let coarse = lengths(&made(None, Some(4.0), None));
    assert!(least(&coarse) > 4.0 * 0.7, "{}", least(&coarse));
    // One above what the part decides as well.
    let coarser = lengths(&made(None, Some(9.0), None));
    assert!(mean(&coarser) > 7.0, "{}", mean(&coarser));
}

/// The number of the face all of whose corners are told to count.
fn face(part: &Path, counts: impl Fn(DVec3) -> bool) -> i32 {
    let options = ImportOptions {
        gmsh: Some(gmsh()),
        ..ImportOptions::default()
    };
    let brep = &import_cad(part, &options).unwrap().pieces[0].brep;
    let on = |face| {
        let mut facets = brep.facets.enumerated().filter(|(_, f)| f.face == face);
        facets.all(|(id, _)| brep.corners(id).into_iter().all(&counts))
    };
    let face = brep.faces.ids().find(|&f| on(f)).unwrap();
    brep.faces[face].tag
}

fn on_faces(faces: &[i32], size: f64) -> Vec<LocalSize> {
    vec![LocalSize {
        faces: faces.to_vec(),
        size,
        ..LocalSize::default()
    }]
}

#[test]
fn sizes_grow_from_a_face_no_faster_than_they_may() {
    let bench = Bench::new();
    let part = bench.step("hole.step", HOLE);
    let bore = face(&part, |p| from_hole(p).abs() < 0.01);
    let made = |growth: f64| {
        let options = MeshOptions {
            size: Some(8.0),
            growth: Some(growth),
            sizes: on_faces(&[bore], 0.6),
            ..options()
        };
        meshed(&part, &options).mesh
    };
    // The longest edge of elements, but for the worst twentieth, over what growth allows at its far end; a bore has its say a thickness round.
    let over = |mesh: &ShellMesh, growth: f64| {
        let ratios = mesh.elements.iter().map(|e| {
            let p: Vec<DVec3> = corners(mesh, e).collect();
            let far = p.iter().map(|p| from_hole(*p) - 2.0).fold(0.0, f64::max);
            let length = longest(&[
                p[0].distance(p[1]),
                p[1].distance(p[2]),
                p[2].distance(p[0]),
            ]);
            length / (0.6 + (growth - 1.0) * far)
        });
        let mut ratios: Vec<f64> = ratios.collect();
        ratios.sort_by(f64::total_cmp);
        ratios[ratios.len() * 95 / 100]
    };
    let [slow, fast] = [1.1, 1.6].map(made);
    assert!(over(&slow, 1.1) < 1.6, "{}", over(&slow, 1.1));
    assert!(over(&fast, 1.1) > 1.6, "{}", over(&fast, 1.1));
    assert!(slow.elements.len() > 2 * fast.elements.len());
    let round = edges(&fast, |p| from_hole(p) < 1.5);
    assert!((0.45..0.75).contains(&mean(&round)), "{}", mean(&round));
    assert!(mean(&edges(&fast, |p| from_hole(p) > 40.0)) > 6.0);
}

#[test]
fn a_face_on_one_side_of_a_wall_sizes_what_lies_over_it() {
    let bench = Bench::new();
    let part = bench.step("t.step", &t_part(1.0, ""));
    // The plate's upper face on one side of the rib; below the plate one face spans both.
    let top = face(&part, |p| (p.z - 2.0).abs() < 0.01 && p.y < 19.01);
    let options = MeshOptions {
        size: Some(6.0),
        sizes: on_faces(&[top], 1.5),
        ..options()
    };
    let mesh = meshed(&part, &options).mesh;
    let plate = |p: DVec3| p.z < 1.5;
    let fine = mean(&edges(&mesh, |p| plate(p) && p.y < 17.0));
    assert!((1.2..1.8).contains(&fine), "{fine}");
    let coarse = mean(&edges(&mesh, |p| plate(p) && p.y > 30.0));
    assert!(coarse > 3.0, "{coarse}");
}

#[test]
fn inspect_and_meshes_of_any_size_number_sheets_alike() {
    let bench = Bench::new();
    // Two solids, each with sheets of many sizes.
    let script = t_part(1.0, "")
        + "Box(11) = {100, 0, 0, 50, 50, 3}; Box(12) = {120, 0, 0, 2, 50, 30}; Box(13) = {100, 30, 0, 50, 2, 20}; \
                   BooleanUnion(14) = {Volume{11}; Delete;}{Volume{12, 13}; Delete;};";
    let part = bench.step("two.step", &script);
    let found = inspected(&part);
    let listed: Vec<_> = found.solids.iter().flat_map(|s| &s.sheet_list).collect();
    assert_eq!(listed.len(), 3 + 7);
    for (sheet, number) in listed.iter().zip(1..) {
        assert_eq!(sheet.sheet, number);
    }
    let wishes = [
        (None, ElementShape::Triangle),
        (Some(2.0), ElementShape::Triangle),
        (Some(9.0), ElementShape::Quad),
    ];
    for (size, element) in wishes {
        let options = MeshOptions {
            size,
            element,
            ..options()
        };
        let mesh = meshed(&part, &options).mesh;
        assert_eq!(mesh.sheets.len(), listed.len());
        for (sheet, number) in listed.iter().zip(0..) {
            let of_sheet = mesh.elements.iter().filter(|e| e.sheet.0 == number);
            let (mut area, mut centre) = (0.0, DVec3::ZERO);
            for e in of_sheet {
                let part = mesh.doubled_area(e).length() / 2.0;
                let p: Vec<DVec3> = corners(&mesh, e).collect();
                centre += part * p.iter().sum::<DVec3>() / p.len() as f64;
                area += part;
            }
            assert!((area / sheet.area - 1.0).abs() < 0.01, "sheet {number}");
            let off = (centre / area).distance(DVec3::from_array(sheet.centre));
            assert!(off < 0.3, "sheet {number}: {off}");
            let id = midshell::model::ids::SheetId(number);
            assert_eq!(mesh.sheets[id].wall.0 + 1, sheet.wall);
        }
    }
}

#[test]
fn a_sheet_gets_its_own_size_finer_or_coarser() {
    let bench = Bench::new();
    let part = bench.step("t.step", &t_part(1.0, ""));
    let sheets = &inspected(&part).solids[0].sheet_list;
    let number = |at: DVec3| {
        let near = |c: [f64; 3]| DVec3::from_array(c).distance(at) < 0.1;
        sheets.iter().find(|s| near(s.centre)).unwrap().sheet
    };
    let rib = number(DVec3::new(30.0, 20.0, 5.0));
    let half = number(DVec3::new(30.0, 30.0, 1.0));
    let made = |sizes: &[(u32, f64)]| {
        let sizes = sizes.iter().map(|&(sheet, size)| LocalSize {
            sheets: vec![sheet],
            size,
            ..LocalSize::default()
        });
        let options = MeshOptions {
            size: Some(4.0),
            sizes: sizes.collect(),
            ..options()
        };
        meshed(&part, &options).mesh
    };
    let on_rib = |mesh: &ShellMesh| mean(&edges(mesh, |p| p.z > 1.5));
    let far = |mesh: &ShellMesh| mean(&edges(mesh, |p| p.y > 32.0));
    let mesh = made(&[(rib, 1.0), (half, 7.0)]);
    assert!((0.8..1.2).contains(&on_rib(&mesh)), "{}", on_rib(&mesh));
    assert!(far(&mesh) > 5.0, "{}", far(&mesh));
    assert!(mean(&edges(&mesh, |p| p.y < 8.0 && p.z < 1.5)) < 4.5);
    // Exchanged, so that a wrong number shows.
    let other = made(&[(half, 1.0)]);
    assert!(on_rib(&other) > 1.2 && (0.8..1.2).contains(&far(&other)));
    // Where two wishes hold the shorter length counts.
    let both = made(&[(rib, 3.0), (rib, 1.0)]);
    assert!((0.8..1.2).contains(&on_rib(&both)));
}

#[test]
fn size_files_that_fit_no_part_are_refused_with_what_there_is() {
    let bench = Bench::new();
    let part = bench.step("plate.step", PLATE);
    let refused = |content: &str, words: &[&str]| {
        let file = bench.file("sizes.toml", content);
        let file = file.display().to_string();
        let ended = bench.mesh(&part, &["--sizes", &file]);
        let words: Vec<&str> = [&["sizes.toml"], words].concat();
        ended.refused(2, &words);
    };
    for (content, words) in [
        (
            "[[size]]\nsheet = 1\nsize = 2\n\n[[size]]\nsheet = 9\nsize = 2",
            &[
                "line 5",
                "no sheet 9",
                "one sheet, number 1",
                "midshell inspect",
            ][..],
        ),
        (
            "[[size]]\nface = [1, 77]\nsize = 2",
            &["line 1", "no face 77", "1 to 6"],
        ),
        ("[[size]]\nsheet = 1", &["line 1", "size"]),
        ("[[size]]\nshet = 1\nsize = 2", &["line 2", "shet", "sheet"]),
        ("[[size]]\nsheet = 1\nsize = -2", &["line 3", "-2"]),
        ("[[size]]\nsheet = 1\nsize = nan", &["line 3"]),
        (
            "[[size]]\nsheet = 1\nsize = 2000",
            &["line 1", "2000", "116.6"],
        ),
        ("[[size]]\nface = 'rib'\nsize = 2", &["line 2", "number"]),
        ("[[size]]\nsize = 2", &["line 1", "sheet"]),
        ("# nothing\n", &["[[size]]"]),
        ("sheet: 3\n", &["line 1"]),
        ("\u{0}\u{1}", &["line 1"]),
    ] {
        refused(content, words);
    }
    let file = bench.file("bytes.toml", [0xff, 0xfe, 0x00]);
    let file = file.display().to_string();
    (bench.mesh(&part, &["--sizes", &file])).refused(2, &["bytes.toml", "UTF-8"]);
    let missing = bench.at("missing.toml").display().to_string();
    (bench.mesh(&part, &["--sizes", &missing])).refused(2, &["missing.toml"]);
    // Bounds hold for sizes of single sheets too.
    let file = bench.file("sizes.toml", "[[size]]\nsheet = 1\nsize = 2");
    let file = file.display().to_string();
    let ended = bench.mesh(&part, &["--sizes", &file, "--size-min", "3"]);
    ended.refused(2, &["sizes.toml, line 1", "3 mm and more"]);
}

#[test]
fn bounds_that_cannot_be_are_refused() {
    let bench = Bench::new();
    let part = bench.step("plate.step", PLATE);
    for (arguments, words) in [
        (
            &["--size-min", "5", "--size-max", "2"][..],
            &["5 mm", "2 mm"][..],
        ),
        (&["--size-min", "0"], &["--size-min"]),
        (&["--size-max", "nan"], &["--size-max"]),
        (&["--size", "9", "--size-max", "4"], &["--size is 9 mm"]),
        (&["--size", "1", "--size-min", "4"], &["--size is 1 mm"]),
        (&["--size-min", "500"], &["500", "116.6"]),
        (&["--growth", "1"], &["1.05", "--growth"]),
        (&["--growth", "9"], &["2"]),
        (&["--rows", "0"], &["--rows"]),
    ] {
        bench.mesh(&part, arguments).refused(2, words);
    }
}
