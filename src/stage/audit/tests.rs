use super::*;
use crate::model::ids::{ElementId, IndexVec, NodeId, SheetId};
use crate::model::shell::{Corners, Element};
use crate::test_parts::{box_brep, brep, grid_mesh, plate_mesh, sheet, tube_brep};

const SEED: u64 = 7;

pub(super) fn plate() -> Brep {
    box_brep(DVec3::new(100.0, 60.0, 3.0))
}

pub(super) fn rules(report: &AuditReport) -> Vec<DoubtRule> {
    report.doubts().iter().map(|d| d.rule).collect()
}

pub(super) fn moved(mut mesh: ShellMesh, f: impl Fn(DVec3) -> DVec3) -> ShellMesh {
    for p in mesh.nodes.iter_mut() {
        *p = f(*p);
    }
    mesh
}

pub(super) fn placed(mut solid: Brep, f: impl Fn(DVec3) -> DVec3) -> Brep {
    for p in solid.vertices.iter_mut() {
        *p = f(*p);
    }
    for facet in solid.facets.iter_mut() {
        facet.mids = facet.mids.map(&f);
    }
    solid
}

pub(super) fn keep(mesh: &ShellMesh, wanted: impl Fn(usize) -> bool) -> ShellMesh {
    let elements = mesh.elements.iter().enumerate();
    ShellMesh {
        elements: elements
            .filter(|(i, _)| wanted(*i))
            .map(|(_, e)| e.clone())
            .collect(),
        ..mesh.clone()
    }
}

/// Both meshes in one, not merged.
pub(super) fn beside(a: &ShellMesh, b: &ShellMesh) -> ShellMesh {
    let mut out = a.clone();
    let first = a.nodes.len() as u32;
    for p in &b.nodes {
        out.nodes.push(*p);
    }
    for e in &b.elements {
        let shift = |n: NodeId| NodeId(n.0 + first);
        out.elements.push(Element {
            corners: match e.corners {
                Corners::Triangle(n) => Corners::Triangle(n.map(shift)),
                Corners::Quad(n) => Corners::Quad(n.map(shift)),
            },
            sheet: SheetId(out.sheets.len() as u32),
            ..e.clone()
        });
    }
    out.sheets.push(sheet());
    out
}

/// Merges nodes that are at the same place.
fn merged(mesh: ShellMesh) -> ShellMesh {
    let mut nodes: Vec<DVec3> = Vec::new();
    let to: Vec<NodeId> = mesh
        .nodes
        .iter()
        .map(|p| {
            let at = nodes.iter().position(|q| q.distance(*p) < 1e-9);
            let at = at.unwrap_or_else(|| {
                nodes.push(*p);
                nodes.len() - 1
            });
            NodeId(at as u32)
        })
        .collect();
    let mut out = mesh;
    for e in out.elements.iter_mut() {
        let new = |n: NodeId| to[n.0 as usize];
        e.corners = match e.corners {
            Corners::Triangle(n) => Corners::Triangle(n.map(new)),
            Corners::Quad(n) => Corners::Quad(n.map(new)),
        };
    }
    out.nodes = IndexVec::from(nodes);
    out
}

#[test]
fn plate_is_right() {
    let report = audit(&[&plate()], &plate_mesh(20, 12), SEED);
    assert!(report.is_right(), "{:?}", report.doubts());
    assert!(report.r95.unwrap() < 1e-12 && report.mass.abs() < 1e-12);
    assert!(report.cover > 0.999 && report.free_off == 0.0 && report.outside == 0.0);
    assert!((report.thickness_median.unwrap() - 3.0).abs() < 1e-12);
    assert!((report.free_length - 320.0).abs() < 1e-9);
    assert_eq!(
        (report.euler, report.euler_solid, report.pieces),
        (1, 1.0, 1)
    );
    assert!(report.judged_share == 1.0 && report.unsure_share == 0.0);
}

#[test]
fn shifted_by_a_tenth_has_an_r_error_of_a_fifth() {
    let mesh = moved(plate_mesh(20, 12), |p| p + DVec3::Z * 0.3);
    let report = audit(&[&plate()], &mesh, SEED);
    assert!((report.r50.unwrap() - 0.2).abs() < 1e-9);
    assert_eq!(rules(&report), [DoubtRule::RError]);
    assert!((report.r_bins[3] + report.r_bins[4] - 1.0).abs() < 1e-9);
}

#[test]
fn one_element_missing_shows_in_the_topology() {
    let mesh = keep(&plate_mesh(20, 12), |i| i != 125);
    let report = audit(&[&plate()], &mesh, SEED);
    assert_eq!(report.euler, 0);
    assert!(rules(&report).contains(&DoubtRule::Euler));
    assert!((report.free_off - 20.0 / 340.0).abs() < 1e-9);
}

#[test]
fn half_missing_shows_in_the_coverage() {
    let mesh = keep(&plate_mesh(20, 12), |i| i < 120);
    let report = audit(&[&plate()], &mesh, SEED);
    assert!(report.cover < 0.6 && report.orphans == 126);
    assert!(rules(&report).contains(&DoubtRule::Cover));
    assert!(rules(&report).contains(&DoubtRule::FreeEdges));
}

#[test]
fn wrong_thickness_is_found() {
    let mut mesh = plate_mesh(20, 12);
    for e in mesh.elements.iter_mut() {
        e.thickness = [3.3; 4];
    }
    let report = audit(&[&plate()], &mesh, SEED);
    assert_eq!(rules(&report), [DoubtRule::Thickness]);
    assert!((report.thickness_error.unwrap() - 0.1).abs() < 1e-9);
    assert!((report.mass - 0.1).abs() < 1e-9);
}

#[test]
fn sticking_out_is_found() {
    let mesh = moved(plate_mesh(20, 12), |p| p * DVec3::new(1.2, 1.0, 1.0));
    let report = audit(&[&plate()], &mesh, SEED);
    assert!((report.outside - 1.0 / 6.0).abs() < 0.01);
    assert!(rules(&report).contains(&DoubtRule::Outside));
}

#[test]
fn what_is_off_the_middle_counts_by_its_share() {
    // Tilted about the middle by 0.15 / (1 - share) at its ends, a share of the plate 3 thick is more than 0.15 off: its R-error is over 0.1.
    let tilted = |share: f64| {
        let end = 0.15 / (1.0 - share);
        let mesh = moved(plate_mesh(20, 12), |p| {
            p + DVec3::Z * end * (p.x / 50.0 - 1.0)
        });
        audit(&[&plate()], &mesh, SEED)
    };
    // All of the mesh is judged: of a twentieth 1.645 times the root of 0.05 * 0.95 / 10,000 is kept.
    for share in [0.03, 0.039, 0.045, 0.048, 0.06, 0.2] {
        let report = tilted(share);
        assert!(
            (report.off_middle - share).abs() < 0.002,
            "{share}: {}",
            report.off_middle
        );
        assert_eq!(rules(&report).contains(&DoubtRule::RError), share > 0.0464);
    }
}

#[test]
fn an_unmerged_seam_is_found() {
    let whole = plate_mesh(20, 12);
    let (low, high) = (keep(&whole, |i| i < 120), keep(&whole, |i| i >= 120));
    let report = audit(&[&plate()], &beside(&low, &high), SEED);
    assert_eq!(report.pieces, 2);
    assert!(rules(&report).contains(&DoubtRule::Pieces));
    assert!(rules(&report).contains(&DoubtRule::FreeEdges));
}

#[test]
fn a_tube_is_right_and_its_r_error_is_the_sag_of_its_elements() {
    let n = 256;
    let mesh = grid_mesh(
        |u, v| {
            let turn = std::f64::consts::TAU * u;
            DVec3::new(49.5 * turn.cos(), 49.5 * turn.sin(), 80.0 * v)
        },
        n,
        40,
        true,
        1.0,
    );
    let solid = tube_brep(50.0, 49.0, 80.0, 24);
    let report = audit(&[&solid], &mesh, SEED);
    assert!(report.is_right(), "{:?}", report.doubts());
    assert_eq!((report.euler, report.euler_solid), (0, 0.0));
    let sag = 49.5 * (1.0 - (std::f64::consts::PI / n as f64).cos());
    assert!(report.r95.unwrap() < 2.1 * sag, "{:?}", report.r95);
    // A mesh of 24 elements a turn sags by 0.42: more than the wall allows.
    let coarse = grid_mesh(
        |u, v| {
            let turn = std::f64::consts::TAU * u;
            DVec3::new(49.5 * turn.cos(), 49.5 * turn.sin(), 80.0 * v)
        },
        24,
        4,
        true,
        1.0,
    );
    assert!(rules(&audit(&[&solid], &coarse, SEED)).contains(&DoubtRule::RError));
}

/// A base of 100 x 60 x 2 with a rib of 2 x 30 along the middle.
fn tee() -> Brep {
    let outline = [
        [0.0, 0.0],
        [60.0, 0.0],
        [60.0, 2.0],
        [31.0, 2.0],
        [31.0, 32.0],
        [29.0, 32.0],
        [29.0, 2.0],
        [0.0, 2.0],
    ];
    let n = outline.len();
    let points = [0.0, 100.0]
        .iter()
        .flat_map(|x| outline.map(|[y, z]| DVec3::new(*x, y, z)))
        .collect();
    let mut polygons: Vec<(Vec<usize>, u32)> = (0..n)
        .map(|k| {
            let next = (k + 1) % n;
            (vec![k, next, next + n, k + n], k as u32)
        })
        .collect();
    for end in [vec![0, 7, 6, 3, 2, 1], vec![6, 5, 4, 3]] {
        polygons.push((end.clone(), 8));
        polygons.push((end.iter().rev().map(|i| i + n).collect(), 9));
    }
    brep(points, &polygons, |a, b| (a + b) / 2.0)
}

#[test]
fn a_t_is_right_and_a_torn_off_rib_is_found() {
    let base = grid_mesh(
        |u, v| DVec3::new(100.0 * u, 60.0 * v, 1.0),
        20,
        12,
        false,
        2.0,
    );
    let rib = grid_mesh(
        |u, v| DVec3::new(100.0 * u, 30.0, 1.0 + 31.0 * v),
        20,
        6,
        false,
        2.0,
    );
    let solid = tee();
    let torn = beside(&base, &rib);
    let report = audit(&[&solid], &merged(torn.clone()), SEED);
    assert!(report.is_right(), "{:?}", report.doubts());
    assert_eq!(report.free_off, 0.0);
    let report = audit(&[&solid], &torn, SEED);
    // The free edge itself lies so near to the inner corners that it might be a rim.
    assert!(rules(&report).contains(&DoubtRule::Pieces));
    let bare = audit(&[&solid], &base, SEED);
    assert!(rules(&bare).contains(&DoubtRule::Cover));
}

#[test]
fn two_solids_are_two_pieces() {
    let (a, b) = (plate(), placed(plate(), |p| p + DVec3::Z * 50.0));
    let mesh = plate_mesh(20, 12);
    let other = moved(mesh.clone(), |p| p + DVec3::Z * 50.0);
    let both = audit(&[&a, &b], &beside(&mesh, &other), SEED);
    assert!(both.is_right(), "{:?}", both.doubts());
    assert_eq!((both.euler, both.euler_solid, both.solids), (2, 2.0, 2));
    let one = audit(&[&a, &b], &mesh, SEED);
    assert!(rules(&one).contains(&DoubtRule::Pieces) && one.cover < 0.6);
}

#[test]
fn flipped_broken_and_empty_meshes_are_doubted() {
    let mut mesh = plate_mesh(20, 12);
    mesh.nodes[NodeId(130)].x += 7.0;
    assert!(rules(&audit(&[&plate()], &mesh, SEED)).contains(&DoubtRule::Flipped));
    mesh.nodes[NodeId(130)].x = f64::NAN;
    let broken = audit(&[&plate()], &mesh, SEED);
    assert!(rules(&broken).contains(&DoubtRule::NotFinite) && broken.not_finite == 4);
    assert!(broken.r95.unwrap() < 1e-9);
    let empty = audit(&[&plate()], &ShellMesh::default(), SEED);
    assert!(rules(&empty).contains(&DoubtRule::Unmeasured));
    let nothing = audit(&[], &ShellMesh::default(), SEED);
    assert!(!nothing.is_right());
}

#[test]
fn one_thread_and_many_give_the_same_report() {
    let mut mesh = plate_mesh(20, 12);
    mesh.nodes[NodeId(130)].z += 0.7;
    mesh.elements[ElementId(3)].unsure = true;
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| serde_json::to_string(&audit(&[&plate()], &mesh, SEED)).unwrap())
    };
    assert_eq!(run(1), run(4));
    assert!((audit(&[&plate()], &mesh, SEED).unsure_share - 1.0 / 240.0).abs() < 1e-4);
}

#[test]
fn scale_and_rigid_motion_change_nothing() {
    let base = audit(&[&plate()], &plate_mesh(20, 12), SEED);
    let spin = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, 1.1, -0.7);
    for scale in [1e-3, 1e3] {
        let place = |p: DVec3| (spin * p + DVec3::new(31.0, -17.0, 5.0)) * scale;
        let solid = placed(plate(), place);
        let mut mesh = moved(plate_mesh(20, 12), place);
        for e in mesh.elements.iter_mut() {
            e.thickness = [3.0 * scale; 4];
        }
        let report = audit(&[&solid], &mesh, SEED);
        assert!(report.is_right(), "{:?}", report.doubts());
        assert!(report.r95.unwrap() < 1e-9 && (report.cover - base.cover).abs() < 1e-3);
    }
}
