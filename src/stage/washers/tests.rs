use super::*;
use crate::geom::quality::quad_quality;
use crate::model::complex::MidTriangle;
use crate::model::ids::{ElementId, SheetId, WallId};
use crate::model::shell::{Corners, ShellMesh};
use crate::stage::test_shapes::{Build, Onto, Stay, edge_census, moved, plate_with_holes, tube};
use crate::test_parts::{element, sheet};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Middles and radii of the holes of `plate_with_holes`.
const HOLES: [([f64; 2], f64); 3] = [
    ([25.0, 30.0], 10.0),
    ([60.0, 40.0], 8.0),
    ([75.0, 15.0], 6.0),
];

fn asked(layers: u32, width: Option<f64>) -> WasherRequest {
    WasherRequest {
        layers,
        holes: Some([1.0, 100.0]),
        width,
    }
}

fn planned(complex: &MidComplex, request: &WasherRequest, size: f64) -> Plan {
    plan(complex, request, size, &|_, _| size, &Stay)
}

fn area(complex: &MidComplex) -> f64 {
    let areas = complex.triangles.iter().map(|t| complex.area_vector(t));
    areas.map(DVec3::length).sum()
}

/// Area between regular polygons of `n` corners on circles of these radii.
fn between(n: u32, radii: [f64; 2]) -> f64 {
    let [low, high] = radii.map(|r| f64::from(n) / 2.0 * (TAU / f64::from(n)).sin() * r * r);
    high - low
}

/// The quads that diagonals make of triangles, each from the first end of its diagonal.
fn quads(complex: &MidComplex, diagonals: &[[NodeId; 2]]) -> Vec<[NodeId; 4]> {
    let at: BTreeMap<[NodeId; 2], _> = (complex.edges().into_iter())
        .map(|e| (e.ends, e.triangles))
        .collect();
    let apex = |t: &MidTriangle, [a, c]: [NodeId; 2]| {
        t.nodes.into_iter().find(|n| *n != a && *n != c).unwrap()
    };
    (diagonals.iter())
        .map(|&[a, c]| {
            let both = [0, 1].map(|i| &complex.triangles[at[&[a, c]][i]]);
            // The half that runs from a to c has its corner after c.
            let [first, second] = if both[0].runs([a, c]) {
                both
            } else {
                [both[1], both[0]]
            };
            [a, apex(second, [a, c]), c, apex(first, [a, c])]
        })
        .collect()
}

#[test]
fn holes_are_found_by_their_circles_and_the_border_is_none() {
    let plate = plate_with_holes(1.0);
    let plan = planned(&plate, &asked(1, None), 2.0);
    assert_eq!(plan.left_out, []);
    let washers = plan.washers();
    for ([x, y], radius) in HOLES {
        let own = |w: &&Washer| w.centre.distance(DVec3::new(x, y, 0.0)) < 1e-9;
        let washer = washers.iter().find(own).unwrap();
        assert!((washer.diameter - 2.0 * radius).abs() < 1e-9);
        assert!((washer.axis.z.abs() - 1.0).abs() < 1e-12);
        assert!(washer.around % 4 == 0 && f64::from(washer.around) >= (TAU * radius).round());
    }
    assert_eq!(washers.len(), 3);
    let narrow = WasherRequest {
        holes: Some([12.0, 16.0]),
        ..asked(1, None)
    };
    assert_eq!(planned(&plate, &narrow, 2.0).washers().len(), 2);
    // The ends of a tube are round too.
    let ends = planned(&tube(40, 10, 30.0), &asked(1, None), 2.0);
    assert!(ends.is_empty() && ends.left_out.is_empty());
}

#[test]
fn opened_and_closed_the_plate_is_the_same_but_for_its_rings() {
    let plate = plate_with_holes(1.0);
    for layers in [1, 2, 3] {
        let mut plan = planned(&plate, &asked(layers, None), 1.5);
        let opened = open(&plate, &mut plan, &Stay);
        assert_eq!((opened.check(), opened.euler()), (vec![], plate.euler()));
        assert_eq!((plan.left_out.len(), plan.rings.len()), (0, 3));
        let (closed, diagonals) = close(&opened, &[], &plan, &Stay).unwrap();
        assert_eq!((closed.check(), closed.euler()), (vec![], plate.euler()));
        // Only the free edges have one triangle.
        let rims: u32 = plan.washers().iter().map(|w| w.around).sum();
        assert_eq!(edge_census(&closed), [(1, 320 + rims as usize)].into());
        assert!(closed.nodes.iter().all(|n| pin(&n.supports).is_none()));
        let mut want = 6000.0;
        let mut count = 0;
        for w in plan.washers() {
            want -= between(w.around, [0.0, w.diameter / 2.0]);
            count += w.layers * w.around;
        }
        assert!((area(&closed) - want).abs() < 1e-8);
        assert_eq!(diagonals.len(), count as usize);
        assert!(diagonals.is_sorted() && diagonals.iter().all(|d| d[0] < d[1]));
        // Every quad is an isosceles trapezoid between two circles.
        let worst = plan.washers().iter().map(|w| w.around).min().unwrap();
        let truth = (PI / f64::from(worst)).cos();
        let measured = (quads(&closed, &diagonals).iter())
            .map(|q| quad_quality(q.map(|n| closed.nodes[n].point)).scaled_jacobian)
            .fold(1.0, f64::min);
        assert!((measured - truth).abs() < 1e-9, "{measured} {truth}");
        let stood = standing(&shell(&closed, &diagonals), &plan.washers());
        assert_eq!(stood, [true; 3]);
    }
}

#[test]
fn washers_move_and_grow_with_the_part() {
    let plate = plate_with_holes(1.0);
    let base = planned(&plate, &asked(2, None), 2.0).washers();
    let turned = planned(&moved(&plate), &asked(2, None), 2.0).washers();
    let mut scaled = plate.clone();
    (scaled.nodes.iter_mut()).for_each(|n| n.point *= 50.0);
    let request = WasherRequest {
        holes: Some([50.0, 5000.0]),
        ..asked(2, None)
    };
    let scaled = planned(&scaled, &request, 100.0).washers();
    assert_eq!([turned.len(), scaled.len()], [3; 2]);
    for ((w, t), s) in base.iter().zip(&turned).zip(&scaled) {
        assert_eq!([t.around, s.around], [w.around; 2]);
        assert!((t.width - w.width).abs() < 1e-9 && (s.width - 50.0 * w.width).abs() < 1e-7);
        assert!((s.diameter - 50.0 * w.diameter).abs() < 1e-7);
    }
}

#[test]
fn what_is_in_the_way_makes_a_washer_narrower_or_refuses_the_width() {
    let plate = plate_with_holes(1.0);
    // The hole of radius 6 is 15 from the border, with 40 quads round it.
    let small = |plan: &Plan| plan.washers().into_iter().next();
    let asked = |layers: u32, width: Option<f64>| WasherRequest {
        holes: Some([11.0, 13.0]),
        ..asked(layers, width)
    };
    let size = 6.0;
    let washer = small(&planned(&plate, &asked(1, None), size)).unwrap();
    assert_eq!((washer.around, washer.width), (40, 6.0));
    // Where each hole decides a whole edge of the outer circle is left between, if that leaves room.
    let mut near = plate.clone();
    let below = |p: DVec3| p.y == 0.0 && (40.0..99.0).contains(&p.x);
    for node in near.nodes.iter_mut().filter(|n| below(n.point)) {
        node.point.y = 2.0;
    }
    let washer = small(&planned(&near, &asked(1, None), size)).unwrap();
    assert!((washer.width - (13.0 / (1.0 + TAU / 40.0) - 6.0)).abs() < 1e-9);
    let tight = 15.0 / (1.0 + TAU / 40.0 / 2.0) - 6.0;
    for (width, fits) in [(tight - 1e-6, true), (tight + 1e-6, false)] {
        let plan = planned(&plate, &asked(1, Some(width)), size);
        assert_eq!(small(&plan).is_some(), fits, "{width}");
        let bare = plan.left_out.first();
        assert_eq!(bare.is_none(), fits);
        let Some(NoWasher::Room { room, wanted, end }) = bare.map(|b| b.why) else {
            continue;
        };
        assert!((room - tight).abs() < 1e-9 && wanted == width && end == RoomEnd::Rim);
    }
}

#[test]
fn two_holes_share_what_is_between_them() {
    // Radii 10 and 8, middles 36.4 apart: 18.4 between the rims.
    let plate = plate_with_holes(1.0);
    let apart = DVec2::new(35.0, 10.0).length();
    let request = WasherRequest {
        holes: Some([15.0, 25.0]),
        ..asked(1, Some(9.0))
    };
    let plan = planned(&plate, &request, 5.0);
    let crowded = |h: &BareHole| {
        matches!(
            h.why,
            NoWasher::Room {
                end: RoomEnd::Washer,
                ..
            }
        )
    };
    let rooms: Vec<f64> = (plan.left_out.iter())
        .filter_map(|h| match h.why {
            NoWasher::Room { room, .. } if crowded(h) => Some(room),
            _ => None,
        })
        .collect();
    assert_eq!(rooms.len(), 2);
    assert!(rooms.iter().sum::<f64>() < apart - 18.0);
    assert!(rooms.iter().all(|r| *r > 7.0 && *r < 9.0), "{rooms:?}");
    // Narrow ones do not meet.
    assert_eq!(planned(&plate, &asked(1, Some(4.0)), 5.0).left_out, []);
}

/// A round sheet with a hole of radius 5 in its middle, out to 30, bent by `f`; with a web standing on the line y = 12 if there is to be one.
fn disc(f: impl Fn(f64, f64) -> DVec3 + Copy, web: bool) -> MidComplex {
    let mut b = Build::default();
    let polar = |u: f64, v: f64| {
        let (s, c) = (TAU * u).sin_cos();
        let r = 5.0 + 25.0 * v;
        f(r * c, r * s)
    };
    b.sheet(0, 48, 25, polar);
    if web {
        // Along a spoke: from (0, 12) outwards.
        b.sheet(1, 18, 4, |u, v| {
            polar(0.25, (7.0 + 18.0 * u) / 25.0) + DVec3::Z * (8.0 * v)
        });
    }
    b.complex
}

fn flat(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, 0.0)
}

/// Flat up to x = 11, then round a radius of 4.
fn bend(x: f64, y: f64) -> DVec3 {
    let turn = ((x - 11.0) / 4.0).max(0.0);
    let (s, c) = turn.min(PI / 2.0).sin_cos();
    let on = (turn - PI / 2.0).max(0.0) * 4.0;
    DVec3::new(x.min(11.0) + 4.0 * s, y, 4.0 * (1.0 - c) + on)
}

#[test]
fn webs_and_bends_end_the_room_and_a_rim_seen_from_inside_is_no_hole() {
    let size = 2.0;
    let only = |complex: &MidComplex| {
        let plan = planned(complex, &asked(1, Some(9.0)), size);
        assert!(plan.is_empty());
        let [bare] = plan.left_out.as_slice() else {
            panic!("{:?}", plan.left_out);
        };
        assert!((bare.diameter - 10.0).abs() < 1e-6);
        bare.why
    };
    let room = |why| match why {
        NoWasher::Room { room, end, .. } => (room, end),
        other => panic!("{other}"),
    };
    // Half an edge of the outer circle is shorter than half the size.
    let (to_web, end) = room(only(&disc(flat, true)));
    assert_eq!(end, RoomEnd::Junction);
    assert!(to_web > 5.9 && to_web < 7.0, "{to_web}");
    let (to_bend, end) = room(only(&disc(bend, false)));
    assert_eq!(end, RoomEnd::Bend);
    // The bend begins at 11; its slope passes ten degrees less than one further.
    assert!(to_bend > 4.9 && to_bend < 6.8, "{to_bend}");
    // On the flat disc nothing is in the way, and its outer rim is a circle but no hole.
    let plan = planned(&disc(flat, false), &asked(1, Some(9.0)), size);
    assert_eq!((plan.rings.len(), plan.left_out.len()), (1, 0));
}

#[test]
fn on_a_pipe_the_circles_are_round_as_seen_along_the_hole() {
    let radius = 25.0;
    let wrap = |x: f64, y: f64| {
        // As a drill leaves it: round seen from above.
        DVec3::new(
            x.clamp(-20.0, 20.0),
            y,
            (radius * radius - x.clamp(-20.0, 20.0).powi(2)).sqrt(),
        )
    };
    let onto = Onto(|p: DVec3| {
        let across = DVec3::new(p.x, 0.0, p.z);
        p - across + across.normalize() * radius
    });
    let mut b = Build::default();
    b.sheet(0, 48, 12, |u, v| {
        let (s, c) = (TAU * u).sin_cos();
        let r = 5.0 + 14.0 * v;
        wrap(r * c, r * s)
    });
    let pipe = b.complex;
    let mut plan = plan(&pipe, &asked(2, Some(2.0)), 2.0, &|_, _| 2.0, &onto);
    let opened = open(&pipe, &mut plan, &onto);
    assert_eq!((plan.rings.len(), plan.left_out.len()), (1, 0));
    let (closed, diagonals) = close(&opened, &[], &plan, &onto).unwrap();
    assert_eq!((closed.check(), closed.euler()), (vec![], pipe.euler()));
    let washer = &plan.washers()[0];
    for radius_there in [7.0, 9.0] {
        let on = |n: &&crate::model::complex::MidNode| {
            let p = n.point;
            (p.truncate().length() - radius_there).abs() < 1e-6
                && (DVec2::new(p.x, p.z).length() - radius).abs() < 1e-9
        };
        let count = closed.nodes.iter().filter(on).count();
        assert_eq!(count, washer.around as usize, "{radius_there}");
    }
    assert_eq!(
        standing(&shell(&closed, &diagonals), &plan.washers()),
        [true]
    );
}

#[test]
fn a_circle_that_was_changed_is_found_and_left_out() {
    let plate = plate_with_holes(1.0);
    let mut plan = planned(&plate, &asked(1, None), 2.0);
    let opened = open(&plate, &mut plan, &Stay);
    let pinned = pinned(&opened);
    let mut shifted = opened.clone();
    shifted.nodes[pinned[0].1].point.z += 1e-9;
    assert_eq!(close(&shifted, &[], &plan, &Stay), Err(vec![0]));
    let mut freed = opened.clone();
    let last = pinned[pinned.len() - 1].1;
    freed.nodes[last].supports.clear();
    assert_eq!(close(&freed, &[], &plan, &Stay), Err(vec![2]));
    plan.leave_out(&[2]);
    assert_eq!((plan.rings.len(), plan.left_out.len()), (2, 1));
    assert_eq!(plan.left_out[0].why, NoWasher::Unmeshed);
    assert!(close(&freed, &[], &plan, &Stay).is_ok());
}

/// Triangles as a mesh, those at a diagonal as quads.
fn shell(complex: &MidComplex, diagonals: &[[NodeId; 2]]) -> ShellMesh {
    let mut mesh = ShellMesh::default();
    complex.nodes.iter().for_each(|n| {
        mesh.nodes.push(n.point);
    });
    mesh.sheets.push(sheet());
    for q in quads(complex, diagonals) {
        mesh.elements.push(element(Corners::Quad(q), 0, 1.0));
    }
    let halves = |t: &&MidTriangle| {
        let n = t.nodes;
        let mut sides = [[n[0], n[1]], [n[1], n[2]], [n[2], n[0]]].into_iter();
        !sides.any(|[a, b]| diagonals.binary_search(&[a.min(b), a.max(b)]).is_ok())
    };
    for t in complex.triangles.iter().filter(halves) {
        mesh.elements
            .push(element(Corners::Triangle(t.nodes), 0, 1.0));
    }
    let edges = complex.edges();
    let free = edges.iter().filter(|e| e.triangles.len() == 1);
    mesh.rims = free.map(|e| e.ends).collect();
    mesh
}

#[test]
fn planted_defects_of_a_washer_are_seen() {
    let plate = plate_with_holes(1.0);
    let mut plan = planned(&plate, &asked(2, None), 2.0);
    let opened = open(&plate, &mut plan, &Stay);
    let (closed, diagonals) = close(&opened, &[], &plan, &Stay).unwrap();
    let washers = plan.washers();
    let good = shell(&closed, &diagonals);
    assert_eq!(standing(&good, &washers), [true; 3]);
    // A node of the middle circle of the first, off its circle; off its spoke.
    let w = &washers[0];
    let middle = |n: &NodeId| {
        let away = good.nodes[*n].distance(w.centre);
        (away - w.diameter / 2.0 - w.width).abs() < 1e-9
    };
    let node = good.nodes.ids().find(middle).unwrap();
    let radial = (good.nodes[node] - w.centre).normalize();
    for shift in [radial * 0.1 * w.width, radial.cross(w.axis) * w.width] {
        let mut bad = good.clone();
        bad.nodes[node] += shift;
        assert_eq!(standing(&bad, &washers), [false, true, true]);
    }
    // A quad in two.
    let mut bad = good.clone();
    let own = |e: &ElementId| bad.elements[*e].corners.as_slice().contains(&node);
    let id = bad.elements.ids().find(own).unwrap();
    let Corners::Quad([a, b, c, d]) = bad.elements[id].corners else {
        panic!("no quad")
    };
    bad.elements[id].corners = Corners::Triangle([a, b, c]);
    bad.elements
        .push(element(Corners::Triangle([a, c, d]), 0, 1.0));
    assert_eq!(standing(&bad, &washers), [false, true, true]);
    // More quads than there are, a hole elsewhere.
    let mut other = washers.clone();
    other[1].around += 4;
    other[2].centre.x += 1.0;
    assert_eq!(standing(&good, &other), [true, false, false]);
    assert_eq!(good.elements[ElementId(0)].sheet, SheetId(0));
}

#[test]
fn a_rim_with_a_web_on_it_belongs_to_several_sheets() {
    let mut b = Build::default();
    let polar = |u: f64, v: f64| {
        let (s, c) = (TAU * u).sin_cos();
        let r = 5.0 + 25.0 * v;
        DVec3::new(r * c, r * s, 0.0)
    };
    b.sheet(0, 48, 25, polar);
    b.sheet(1, 25, 4, |u, v| polar(0.25, u) + DVec3::Z * (8.0 * v));
    let complex = b.complex;
    let wall = |t: &MidTriangle| t.wall == WallId(1);
    assert!(complex.triangles.iter().any(wall));
    let plan = planned(&complex, &asked(1, None), 2.0);
    // With the web the rim is no ring of free edges alone; it is one still, and says that it is shared.
    assert!(plan.is_empty());
    assert!(plan.left_out.iter().all(|h| h.why == NoWasher::Shared));
}
