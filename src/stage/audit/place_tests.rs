//! A planted defect of every kind is found, at its place.

use super::tests::{beside, keep, moved, placed, plate};
use super::*;
use crate::model::ids::{ElementId, NodeId};
use crate::model::report::Place;
use crate::model::shell::Corners;
use crate::test_parts::{drum_mesh, hollow_brep, plate_mesh};

/// A plate of 100 x 60 x 3 in quads of 5 x 5, with a defect; where it is, how far the told place may be from there, and the elements that it marks, where it
/// marks them and no others.
struct Planted {
    mesh: ShellMesh,
    at: DVec3,
    within: f64,
    marked: Option<Vec<usize>>,
}

/// The elements of the plate in this range of x.
fn between(low: f64, high: f64) -> Vec<usize> {
    let x = |i: &usize| (i % 20) as f64 * 5.0 + 2.5;
    (0..240).filter(|i| (low..high).contains(&x(i))).collect()
}

fn planted(rule: DoubtRule) -> Planted {
    let whole = plate_mesh(20, 12);
    let cell = DVec3::new(27.5, 32.5, 1.5);
    let (mesh, at, within, marked) = match rule {
        DoubtRule::Euler => (keep(&whole, |i| i != 125), cell, 3.6, None),
        DoubtRule::Pieces => {
            let (low, high) = (keep(&whole, |i| i < 180), keep(&whole, |i| i >= 180));
            let marked = (180..240).collect();
            let middle = DVec3::new(50.0, 52.5, 1.5);
            (beside(&low, &high), middle, 51.0, Some(marked))
        }
        DoubtRule::RError => {
            let up = |p: DVec3| if p.x < 31.0 { p + DVec3::Z * 0.3 } else { p };
            (moved(whole, up), DVec3::new(15.0, 30.0, 1.8), 35.0, None)
        }
        DoubtRule::Cover => {
            let half = keep(&whole, |i| i % 20 < 10);
            (half, DVec3::new(75.0, 30.0, 1.5), 40.0, Some(vec![]))
        }
        DoubtRule::Outside => {
            let out = |p: DVec3| if p.x > 99.0 { p + DVec3::X * 10.0 } else { p };
            let place = DVec3::new(105.0, 30.0, 1.5);
            (moved(whole, out), place, 30.5, Some(between(95.0, 100.0)))
        }
        DoubtRule::Thickness => {
            let mut mesh = whole;
            for i in between(0.0, 60.0) {
                mesh.elements[ElementId(i as u32)].thickness = [3.3; 4];
            }
            let place = DVec3::new(30.0, 30.0, 1.5);
            (mesh, place, 43.0, Some(between(0.0, 60.0)))
        }
        DoubtRule::Mass => {
            // Of two fifths, so that the median thickness is right.
            let mut mesh = whole;
            for i in between(0.0, 40.0) {
                mesh.elements[ElementId(i as u32)].thickness = [6.0; 4];
            }
            let place = DVec3::new(20.0, 30.0, 1.5);
            (mesh, place, 37.0, Some(between(0.0, 40.0)))
        }
        DoubtRule::FreeEdges => {
            let half = keep(&whole, |i| i % 20 < 10);
            (half, DVec3::new(50.0, 30.0, 1.5), 30.0, None)
        }
        DoubtRule::Flipped => {
            let mut mesh = whole;
            mesh.nodes[NodeId(130)].x += 7.0;
            (mesh, DVec3::new(22.0, 30.0, 1.5), 6.0, None)
        }
        DoubtRule::Orientation => {
            let mut mesh = whole;
            if let Corners::Quad(n) = &mut mesh.elements[ElementId(125)].corners {
                n.reverse();
            }
            (mesh, cell, 2.6, Some(vec![105, 124, 125, 126, 145]))
        }
        DoubtRule::NotFinite => {
            let mut mesh = whole;
            mesh.elements[ElementId(125)].thickness[1] = f64::NAN;
            (mesh, cell, 1e-9, Some(vec![125]))
        }
        DoubtRule::Orphans => {
            let mut mesh = whole;
            let at = DVec3::new(1.0, 2.0, 3.0);
            mesh.nodes.push(at);
            (mesh, at, 0.0, Some(vec![]))
        }
        DoubtRule::Unmeasured => {
            let away = moved(whole, |p| p + DVec3::Z * 1e4);
            let place = DVec3::new(50.0, 30.0, 1e4);
            (away, place, 60.0, Some((0..240).collect()))
        }
        DoubtRule::Voids => {
            let bubble = moved(drum_mesh(true), |p| p + cell);
            let marked = (240..280).collect();
            (beside(&whole, &bubble), cell, 2.0, Some(marked))
        }
    };
    Planted {
        mesh,
        at,
        within,
        marked,
    }
}

#[test]
fn every_planted_defect_is_found_at_its_place() {
    for rule in DoubtRule::ALL {
        let Planted {
            mesh,
            at,
            within,
            marked,
        } = planted(rule);
        let report = audit(&[&plate()], &mesh, 7);
        let doubt = report.doubts().iter().find(|d| d.rule == rule);
        let doubt = doubt.unwrap_or_else(|| panic!("{rule:?} in {:?}", report.doubts()));
        let first = doubt.places.first().unwrap_or_else(|| panic!("{doubt}"));
        assert!(first.at.distance(at) <= within, "{doubt}");
        assert!(doubt.places.len() <= Place::MOST && doubt.place_count >= doubt.places.len());
        let bits = report.element_doubts.iter().enumerate();
        let found: Vec<usize> = bits
            .filter(|(_, bits)| **bits & rule.bit() != 0)
            .map(|(i, _)| i)
            .collect();
        if let Some(marked) = &marked {
            assert_eq!(found, *marked, "{rule:?}");
        } else {
            assert!(
                !found.is_empty() && found.len() < 120,
                "{rule:?}: {found:?}"
            );
        }
        let named = |e: &ElementId| found.contains(&(e.0 as usize));
        assert!(first.elements.iter().all(named), "{rule:?}");
        assert_eq!(first.elements.is_empty(), found.is_empty(), "{rule:?}");
    }
}

#[test]
fn nothing_is_marked_where_nothing_is_doubted() {
    let report = audit(&[&plate()], &plate_mesh(20, 12), 7);
    assert_eq!(report.element_doubts, vec![0; 240]);
    assert_eq!(report.betti, Some([1, 0, 0]));
}

#[test]
fn a_bare_wall_is_told_by_its_faces() {
    let mesh = planted(DoubtRule::Cover).mesh;
    let report = audit(&[&plate()], &mesh, 7);
    let doubt = report.doubts().iter().find(|d| d.rule == DoubtRule::Cover);
    let doubt = doubt.unwrap();
    assert_eq!(doubt.place_count, 1);
    assert_eq!(doubt.places[0].faces, [1, 2]);
    assert!(doubt.places[0].at.x > 50.0 && (doubt.places[0].at.z - 1.5).abs() < 1e-9);
}

#[test]
fn a_solid_without_mesh_and_a_void_left_open_are_told_by_their_faces() {
    let far = placed(plate(), |p| p + DVec3::Z * 50.0);
    let far = Brep {
        solid_tag: 2,
        ..far
    };
    let report = audit(&[&plate(), &far], &plate_mesh(20, 12), 7);
    let doubt = report.doubts().iter().find(|d| d.rule == DoubtRule::Pieces);
    let place = &doubt.unwrap().places[0];
    assert_eq!(place.at, DVec3::new(50.0, 30.0, 51.5));
    assert_eq!(place.faces, [1, 2, 3, 4, 5, 6]);

    // The walls of a hollow cube with one side left open, which a hole elsewhere would hide from the Euler characteristic.
    let open = moved(drum_mesh(false), |p| p * 10.0 + DVec3::splat(10.0));
    let report = audit(&[&hollow_brep()], &open, 7);
    let doubt = report.doubts().iter().find(|d| d.rule == DoubtRule::Voids);
    let place = &doubt.unwrap().places[0];
    assert_eq!(
        (place.at, &place.faces[..2]),
        (DVec3::splat(10.0), &[7, 8][..])
    );
    assert!(place.elements.is_empty());
}

#[test]
fn a_tapered_sheet_may_end_a_little_short_of_the_material_and_no_more() {
    // A thin end of a wall is no measure of how near a rim must be: what lies ahead is, in thicknesses of the walls.
    let off = |margin: f64| {
        let scale = DVec3::new(1.0 - margin / 50.0, 1.0 - margin / 30.0, 1.0);
        let shift = DVec3::new(margin, margin, 0.0);
        let mut mesh = moved(plate_mesh(20, 12), |p| p * scale + shift);
        for e in mesh.elements.iter_mut() {
            e.thickness = [0.5; 4];
        }
        audit(&[&plate()], &mesh, 7).free_off
    };
    assert!(off(2.0) < 1e-12, "{}", off(2.0));
    assert!(off(4.0) > 0.99, "{}", off(4.0));
}
