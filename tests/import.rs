//! Import of CAD files that gmsh itself makes here, with closed-form truth. Needs gmsh: `make test` installs it.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "the helpers of tests stand outside of test functions"
)]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::{DVec2, DVec3};
use midshell::import::{Gmsh, ImportError, ImportOptions, Imported, find_gmsh, import_cad};
use midshell::model::brep::Brep;
use midshell::model::ids::IndexVec;
use tempfile::TempDir;

fn gmsh_or_panic() -> Gmsh {
    find_gmsh(None).unwrap_or_else(|e| {
        panic!(
            "these tests need gmsh (run `make test`): {e} {}",
            e.remedy()
        )
    })
}

/// A CAD file made by a gmsh script.
struct Made {
    folder: TempDir,
    path: PathBuf,
}

impl Made {
    fn new(name: &str, script: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let geo = folder.path().join("make.geo");
        let text = format!("SetFactory(\"OpenCASCADE\");\n{script}\nSave \"{name}\";\n");
        std::fs::write(&geo, text).unwrap();
        let output = gmsh_or_panic()
            .command()
            .arg(&geo)
            .args(["-v", "1", "-"])
            .output()
            .unwrap();
        let path = folder.path().join(name);
        assert!(
            path.is_file(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        Self { folder, path }
    }

    fn import(&self) -> Imported {
        import_cad(&self.path, &ImportOptions::default()).unwrap_or_else(|e| panic!("{e}"))
    }

    fn edited(self, edit: impl Fn(String) -> String) -> Self {
        let text = std::fs::read_to_string(&self.path).unwrap();
        let edited = edit(text.clone());
        assert_ne!(text, edited);
        std::fs::write(&self.path, edited).unwrap();
        self
    }
}

const PLATE: &str = "Box(1) = {-50, -30, 0, 100, 60, 2};";

fn assert_near(value: f64, truth: f64, relative: f64) {
    assert!(
        (value - truth).abs() <= relative * truth.abs(),
        "{value} is not {truth}"
    );
}

fn tet_volume(imported: &Imported, piece: usize) -> f64 {
    let piece = &imported.pieces[piece];
    let volumes = piece.tets.cells.iter().map(|cell| {
        let [a, b, c, d] = cell.map(|v| piece.brep.vertices[v]);
        (b - a).dot((c - a).cross(d - a)) / 6.0
    });
    volumes
        .inspect(|&v| assert!(v > 0.0, "a tet of volume {v}"))
        .sum()
}

fn mids(brep: &Brep, tag: i32) -> Vec<DVec3> {
    let of_face = |f: &&midshell::model::brep::Facet| brep.faces[f.face].tag == tag;
    let facets = brep.facets.iter().filter(of_face);
    facets.flat_map(|f| f.mids).collect()
}

#[test]
fn a_plate_is_closed_filled_and_has_its_six_faces() {
    let imported = Made::new("plate.step", PLATE).import();
    let brep = &imported.pieces[0].brep;
    assert_eq!(imported.pieces.len(), 1);
    assert!(imported.attempts.is_empty(), "{:?}", imported.attempts);
    assert_eq!(imported.gmsh_version, gmsh_or_panic().version);
    assert_eq!((brep.faces.len(), brep.curves.len()), (6, 12));
    assert!(brep.curves.iter().all(|c| c.faces.len() == 2));
    assert!(brep.faces.iter().all(|f| f.curves.len() == 4));
    assert_near(brep.volume(), 12_000.0, 1e-9);
    assert_near(brep.area(), 12_640.0, 1e-9);
    assert_near(tet_volume(&imported, 0), 12_000.0, 1e-9);
    assert!(brep.check().is_empty());
    let lengths = brep.curves.iter().flat_map(|c| &c.segments);
    let length: f64 = lengths
        .map(|&[a, b]| brep.vertices[a].distance(brep.vertices[b]))
        .sum();
    assert_near(length, 4.0 * 162.0, 1e-9);
}

#[test]
fn middles_of_a_tube_lie_on_its_cylinders() {
    let imported = Made::new(
        "tube.step",
        "Cylinder(1) = {0,0,0, 0,0,50, 20}; Cylinder(2) = {0,0,-1, 0,0,52, 18};
         BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };",
    )
    .import();
    let brep = &imported.pieces[0].brep;
    let mut cylinders = 0;
    for face in &brep.faces {
        let points = mids(brep, face.tag);
        let radius = |p: &DVec3| DVec2::new(p.x, p.y).length();
        if points.iter().all(|p| p.z.abs() < 1e-9)
            || points.iter().all(|p| (p.z - 50.0).abs() < 1e-9)
        {
            continue;
        }
        cylinders += 1;
        let truth = if radius(&points[0]) > 19.0 {
            20.0
        } else {
            18.0
        };
        for p in &points {
            assert!((radius(p) - truth).abs() < 1e-6, "{p} off {truth}");
        }
    }
    assert_eq!(cylinders, 2);
    let seams = brep.curves.iter().filter(|c| c.faces.len() == 1).count();
    assert_eq!(seams, 2, "one a cylinder");
    // Flat facets: a polygon of at least ten sides has 0.935 of its circle's area, and both walls lose alike.
    assert_near(brep.volume(), std::f64::consts::PI * 76.0 * 50.0, 0.07);
}

#[test]
fn a_hollow_sphere_has_poles_and_two_skins() {
    let imported = Made::new(
        "ball.step",
        "Sphere(1) = {0,0,0, 30}; Sphere(2) = {0,0,0, 27};
         BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };",
    )
    .import();
    let brep = &imported.pieces[0].brep;
    assert_eq!(brep.faces.len(), 2);
    assert!(brep.curves.iter().all(|c| !c.segments.is_empty()));
    let corners: IndexVec<midshell::model::ids::VertexId, bool> = {
        let mut on = IndexVec::filled(false, brep.vertices.len());
        for facet in &brep.facets {
            for v in facet.corners {
                on[v] = true;
            }
        }
        on
    };
    let vertices = corners.iter().filter(|c| **c).count();
    assert_eq!(
        vertices + brep.facets.len() - brep.facets.len() * 3 / 2,
        4,
        "Euler characteristic of two spheres"
    );
    let split = corners.as_slice().partition_point(|c| *c);
    assert_eq!(split, vertices, "those on the boundary come first");
    for p in brep.faces.iter().flat_map(|f| mids(brep, f.tag)) {
        let off = (p.length() - 30.0).abs().min((p.length() - 27.0).abs());
        assert!(off < 1e-5, "{p}");
    }
}

#[test]
fn two_boxes_are_two_pieces_each_with_its_own_scale() {
    let imported = Made::new(
        "two.step",
        "Box(1) = {0,0,0, 100,60,2}; Box(2) = {0,0,20, 10,6,0.5};",
    )
    .import();
    let volumes: Vec<f64> = imported.pieces.iter().map(|p| p.brep.volume()).collect();
    assert_eq!(volumes.len(), 2);
    assert_near(volumes[0], 12_000.0, 1e-9);
    assert_near(volumes[1], 30.0, 1e-9);
    let facets = imported.pieces[1].brep.facets.len();
    assert!(
        (50..2000).contains(&facets),
        "{facets} facets on the small one"
    );
}

#[test]
fn two_boxes_that_touch_share_a_face_and_are_both_closed() {
    let imported = Made::new(
        "touch.brep",
        "Box(1) = {0,0,0, 40,30,2}; Box(2) = {0,0,2, 40,30,3};
         BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }",
    )
    .import();
    let [a, b] = &imported.pieces[..] else {
        panic!("{} pieces", imported.pieces.len());
    };
    assert_near(a.brep.volume(), 2400.0, 1e-9);
    assert_near(b.brep.volume(), 3600.0, 1e-9);
    let tags = |brep: &Brep| -> Vec<i32> { brep.faces.iter().map(|f| f.tag).collect() };
    let (of_a, of_b) = (tags(&a.brep), tags(&b.brep));
    assert_eq!(of_a.iter().filter(|t| of_b.contains(t)).count(), 1);
}

#[test]
fn other_units_become_mm() {
    let metres = Made::new("metres.step", PLATE)
        .edited(|text| text.replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT($,.METRE.)"));
    let brep = &metres.import().pieces[0].brep;
    assert_near(brep.volume(), 12_000.0 * 1e9, 1e-6);
    assert_near(brep.diagonal(), 116.636 * 1e3, 1e-4);
    let centimetres = Made::new("centimetres.step", PLATE)
        .edited(|text| text.replace("SI_UNIT(.MILLI.,.METRE.)", "SI_UNIT(.CENTI.,.METRE.)"));
    assert_near(
        centimetres.import().pieces[0].brep.volume(),
        12_000.0 * 1e3,
        1e-6,
    );
}

#[test]
fn the_result_is_the_same_for_any_number_of_threads() {
    let made = Made::new("plate.step", PLATE);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| made.import())
    };
    assert_eq!(on(1), on(4));
}

#[test]
fn a_smaller_size_factor_makes_more_tets() {
    let made = Made::new("plate.step", PLATE);
    let tets = |size_factor| {
        let options = ImportOptions {
            size_factor,
            ..ImportOptions::default()
        };
        let imported = import_cad(&made.path, &options).unwrap();
        imported.pieces[0].tets.cells.len()
    };
    assert!(tets(0.5) > 2 * tets(1.0));
}

#[test]
fn odd_characters_in_the_path_do_no_harm() {
    let made = Made::new("plate.step", PLATE);
    let odd = made.folder.path().join("a \"b\" 'c' $d; ü\\%s.STP");
    std::fs::rename(&made.path, &odd).unwrap();
    let imported = import_cad(&odd, &ImportOptions::default()).unwrap();
    assert_near(imported.pieces[0].brep.volume(), 12_000.0, 1e-9);
}

fn error_of(path: &Path, options: &ImportOptions) -> ImportError {
    let error = import_cad(path, options).unwrap_err();
    assert!(!error.remedy().is_empty());
    error
}

#[test]
fn surfaces_that_do_not_close_are_no_solid() {
    let open = "Box(1) = {0,0,0, 40,30,2}; Delete { Volume{1}; } Delete { Surface{1}; }";
    let error = error_of(
        &Made::new("open.step", open).path,
        &ImportOptions::default(),
    );
    assert!(
        matches!(error, ImportError::NoSolid { surfaces: 5, .. }),
        "{error:?}"
    );
}

#[test]
fn surfaces_that_close_are_sewn_into_a_solid() {
    let imported = Made::new(
        "loose.step",
        "Box(1) = {0,0,0, 40,30,2}; Delete { Volume{1}; }",
    )
    .import();
    assert_near(imported.pieces[0].brep.volume(), 2400.0, 1e-9);
    assert!(!imported.attempts.is_empty());
}

#[test]
fn a_solid_with_a_missing_face_is_not_closed() {
    // The shell is still called a closed one, but one of its faces is no longer listed.
    let made = Made::new("hole.step", PLATE).edited(|text| {
        let at = text.find("CLOSED_SHELL").unwrap();
        let first = at + text[at..].find("(#").unwrap() + 1;
        let comma = first + text[first..].find(',').unwrap() + 1;
        text[..first].to_owned() + &text[comma..]
    });
    let error = error_of(&made.path, &ImportOptions::default());
    let ImportError::NotClosed { length_mm, .. } = error else {
        panic!("{error:?}");
    };
    // The rim of the missing face: of a side, or of the top.
    let rims = [2.0 * 62.0, 2.0 * 102.0, 2.0 * 160.0];
    assert!(
        rims.iter().any(|r| (length_mm - r).abs() < 1e-6),
        "{length_mm}"
    );
}

#[test]
fn a_file_that_is_cut_short_or_garbled_is_not_cad() {
    let made = Made::new("plate.step", PLATE);
    let whole = std::fs::read(&made.path).unwrap();
    std::fs::write(&made.path, &whole[..whole.len() / 2]).unwrap();
    let error = error_of(&made.path, &ImportOptions::default());
    assert!(matches!(error, ImportError::NotCad { .. }), "{error:?}");
    std::fs::write(&made.path, "ISO-10303-21;\nnonsense\nEND-ISO-10303-21;\n").unwrap();
    let error = error_of(&made.path, &ImportOptions::default());
    assert!(matches!(error, ImportError::NotCad { .. }), "{error:?}");
}

#[cfg(unix)]
fn with_fake(made: &Made, script: &str) -> ImportOptions {
    use std::os::unix::fs::PermissionsExt;
    let path = made.folder.path().join("gmsh");
    std::fs::write(&path, script).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    ImportOptions {
        gmsh: Some(path),
        time_limit: Duration::from_secs(1),
        ..ImportOptions::default()
    }
}

#[cfg(unix)]
#[test]
fn a_gmsh_that_hangs_is_stopped_at_the_limit() {
    let made = Made::new("plate.step", PLATE);
    let start = Instant::now();
    let error = error_of(&made.path, &with_fake(&made, "#!/bin/sh\nsleep 600\n"));
    assert!(matches!(error, ImportError::TimedOut { .. }), "{error:?}");
    assert!(start.elapsed() < Duration::from_secs(30));
}

#[cfg(unix)]
#[test]
fn a_gmsh_that_crashes_every_time_is_told_with_all_attempts() {
    let made = Made::new("plate.step", PLATE);
    let script = "#!/bin/sh
echo \"Info : Running 'gmsh' [Gmsh 4.15.2, 1 node, max. 1 thread]\"
echo 'midshell: solids 1 surfaces 6 open 0 thickness 2 area 4000'
kill -SEGV $$
";
    let error = error_of(&made.path, &with_fake(&made, script));
    let ImportError::GmshFailed { attempts, .. } = &error else {
        panic!("{error:?}");
    };
    assert!(attempts.len() >= 3, "{attempts:?}");
    assert!(attempts[0].contains("SIGSEGV"), "{attempts:?}");
}

#[cfg(unix)]
#[test]
fn a_gmsh_that_writes_half_a_mesh_is_not_believed() {
    let made = Made::new("plate.step", PLATE);
    let script = "#!/bin/sh
echo \"Info : Running 'gmsh' [Gmsh 4.15.2, 1 node, max. 1 thread]\"
echo 'midshell: solids 1 surfaces 6 open 0 thickness 2 area 4000'
printf '$MeshFormat\\n4.1 1 8\\n' > mesh.msh
";
    let error = error_of(&made.path, &with_fake(&made, script));
    assert!(matches!(error, ImportError::BadMesh { .. }), "{error:?}");
}

#[cfg(unix)]
#[test]
fn a_gmsh_that_is_missing_or_does_not_start_is_told_apart() {
    let made = Made::new("plate.step", PLATE);
    let missing = ImportOptions {
        gmsh: Some(PathBuf::from("/no/such/gmsh")),
        ..ImportOptions::default()
    };
    let error = error_of(&made.path, &missing);
    assert!(
        matches!(error, ImportError::GmshMissing { .. }),
        "{error:?}"
    );
    let error = error_of(&made.path, &with_fake(&made, "#!/bin/sh\nexit 3\n"));
    assert!(
        matches!(error, ImportError::GmshUnusable { .. }),
        "{error:?}"
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_gmsh_without_memory_is_an_error() {
    let made = Made::new("plate.step", PLATE);
    let options = ImportOptions {
        memory_limit: Some(40 << 20),
        ..ImportOptions::default()
    };
    let error = error_of(&made.path, &options);
    assert!(
        matches!(
            error,
            ImportError::GmshUnusable { .. } | ImportError::GmshFailed { .. }
        ),
        "{error:?}"
    );
}
