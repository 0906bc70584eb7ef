//! Welding, closing, faces and sizes on shapes with closed-form truth.

use std::f64::consts::TAU;

use glam::DVec3;
use proptest::prelude::*;

use super::reader_tests::tetrahedron;
use super::segment::segment;
use super::shells::{ShellFault, solids};
use super::soup::Soup;
use super::weld::weld;
use super::{shells, sized};

/// A box between two corners, turned outwards.
fn cuboid(low: DVec3, high: DVec3) -> Soup {
    let points = (0..8)
        .map(|i| {
            DVec3::new(
                [low.x, high.x][i & 1],
                [low.y, high.y][i >> 1 & 1],
                [low.z, high.z][i >> 2],
            )
        })
        .collect();
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    Soup {
        points,
        triangles: quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
    }
}

fn plate() -> Soup {
    cuboid(DVec3::ZERO, DVec3::new(40.0, 30.0, 2.0))
}

fn together(a: &Soup, b: &Soup) -> Soup {
    let shift = a.points.len() as u32;
    Soup {
        points: [a.points.clone(), b.points.clone()].concat(),
        triangles: a
            .triangles
            .iter()
            .copied()
            .chain(b.triangles.iter().map(|t| t.map(|v| v + shift)))
            .collect(),
    }
}

fn turned(mut soup: Soup) -> Soup {
    for t in &mut soup.triangles {
        t.swap(0, 1);
    }
    soup
}

fn volume(soup: &Soup) -> f64 {
    (0..soup.triangles.len())
        .map(|t| {
            let [a, b, c] = soup.corners(t);
            a.dot(b.cross(c)) / 6.0
        })
        .sum()
}

/// A tube along z: `n` chords a circle, in two triangles a strip.
fn tube(n: u32, outer: f64, inner: f64, height: f64) -> Soup {
    let ring = |r: f64, z: f64| {
        (0..n).map(move |i| {
            let a = TAU * f64::from(i) / f64::from(n);
            DVec3::new(r * a.cos(), r * a.sin(), z)
        })
    };
    let points = ring(outer, 0.0)
        .chain(ring(outer, height))
        .chain(ring(inner, 0.0))
        .chain(ring(inner, height))
        .collect();
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        let mut quad = |a: u32, b: u32, c: u32, d: u32| triangles.extend([[a, b, c], [a, c, d]]);
        quad(i, j, n + j, n + i);
        quad(2 * n + j, 2 * n + i, 3 * n + i, 3 * n + j);
        quad(n + i, n + j, 3 * n + j, 3 * n + i);
        quad(j, i, 2 * n + i, 2 * n + j);
    }
    Soup { points, triangles }
}

/// Every corner on its own, as STL has it, off by `noise`.
fn exploded(soup: &Soup, noise: f64) -> Soup {
    let mut random = crate::geom::random::Pcg::new(5);
    let points: Vec<DVec3> = (0..soup.triangles.len())
        .flat_map(|t| soup.corners(t))
        .map(|p| p + noise * DVec3::new(random.unit(), random.unit(), random.unit()))
        .collect();
    let triangles = (0..points.len() as u32 / 3)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    Soup { points, triangles }
}

#[test]
fn corners_are_welded_to_rounding_and_no_further() {
    for noise in [0.0, 1e-6, 1e-4] {
        let (welded, dropped) = weld(&exploded(&plate(), noise));
        assert_eq!(welded.points.len(), 8, "noise {noise}");
        assert_eq!((dropped.degenerate, dropped.double), (0, 0));
    }
    // A tenth of a millimetre on a part of 50 mm is a feature, not noise.
    let (welded, _) = weld(&exploded(&plate(), 0.1));
    assert!(welded.points.len() > 8);
}

#[test]
fn degenerate_and_double_facets_go() {
    let mut soup = plate();
    soup.triangles.push([0, 0, 1]);
    soup.triangles.push(soup.triangles[3]);
    // A leaf without thickness: one triangle and its reverse.
    soup.points.extend([DVec3::new(9.0, 9.0, 9.0)]);
    soup.triangles.extend([[0, 1, 8], [1, 0, 8]]);
    let (welded, dropped) = weld(&soup);
    assert_eq!((dropped.degenerate, dropped.double), (1, 1));
    let (found, mended) = solids(welded).unwrap();
    assert_eq!(found[0].facets.triangles.len(), 12);
    assert_eq!((found.len(), mended.crumbs), (1, 1));
}

#[test]
fn a_plate_with_turned_facets_is_turned_outwards() {
    let mut soup = turned(plate());
    for t in [2, 5, 7] {
        soup.triangles[t].swap(0, 1);
    }
    let (found, mended) = solids(soup).unwrap();
    assert_eq!(found.len(), 1);
    assert!((volume(&found[0].facets) - 2400.0).abs() < 1e-9);
    assert!(mended.turned > 0);
}

#[test]
fn a_shell_in_a_shell_is_a_void_and_one_in_that_a_solid() {
    let box_of = |half: f64| cuboid(DVec3::splat(-half), DVec3::splat(half));
    // The inner ones are turned the wrong way on purpose.
    let nested = together(&together(&box_of(3.0), &box_of(2.0)), &turned(box_of(1.0)));
    let (found, _) = solids(nested).unwrap();
    let volumes: Vec<f64> = found.iter().map(|s| volume(&s.facets)).collect();
    assert_eq!(found.len(), 2);
    assert!((volumes[0] - (216.0 - 64.0)).abs() < 1e-9, "{volumes:?}");
    assert!((volumes[1] - 8.0).abs() < 1e-9, "{volumes:?}");
}

#[test]
fn boxes_that_share_an_edge_are_two_solids() {
    let a = cuboid(DVec3::ZERO, DVec3::ONE);
    let b = cuboid(DVec3::new(1.0, 1.0, 0.0), DVec3::new(2.0, 2.0, 1.0));
    let (welded, _) = weld(&together(&a, &b));
    assert_eq!(welded.points.len(), 14);
    let (found, mended) = solids(welded).unwrap();
    assert_eq!((found.len(), mended.forked), (2, 1));
}

#[test]
fn bodies_that_touch_are_two_solids_however_their_facets_meet() {
    let a = cuboid(DVec3::ZERO, DVec3::splat(2.0));
    // On the whole face, with the same triangles turned over; on it with the other diagonal; on a part of the face; with a gap of rounding.
    let b = cuboid(DVec3::new(2.0, 0.0, 0.0), DVec3::new(5.0, 2.0, 2.0));
    let mirrored = Soup {
        points: a
            .points
            .iter()
            .map(|p| DVec3::new(4.0 - p.x, p.y, p.z))
            .collect(),
        triangles: turned(a.clone()).triangles,
    };
    let part = cuboid(DVec3::new(2.0, 0.5, 0.0), DVec3::new(3.0, 1.5, 1.0));
    let mut near = b.clone();
    for p in &mut near.points {
        p.x += 1e-7;
    }
    for (name, other) in [
        ("whole", b),
        ("mirrored", mirrored),
        ("part", part),
        ("near", near),
    ] {
        let (found, _) = solids(weld(&together(&a, &other)).0).unwrap();
        assert_eq!(found.len(), 2, "{name}");
        assert!(found.iter().all(|s| s.cut.is_none()), "{name}");
        let sum: f64 = found.iter().map(|s| volume(&s.facets)).sum();
        let truth = 8.0 + volume(&other);
        assert!((sum - truth).abs() < 1e-5, "{name}: {sum} {truth}");
    }
}

#[test]
fn a_slit_without_width_inside_the_material_goes() {
    // A box whose corner at the origin a cut of no width enters.
    let mut soup = cuboid(DVec3::ZERO, DVec3::splat(2.0));
    let n = soup.points.len() as u32;
    soup.points.push(DVec3::splat(0.7));
    let [a, b] = [soup.triangles[0][0], soup.triangles[0][1]];
    soup.triangles.extend([[a, b, n], [b, a, n]]);
    let (found, _) = solids(weld(&soup).0).unwrap();
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].facets.triangles.len(), 12);
    assert!((volume(&found[0].facets) - 8.0).abs() < 1e-9);
}

#[test]
fn a_narrow_facet_that_turns_to_and_fro_is_no_face() {
    // A plate of 40 x 30 x 2; on its top a triangle 1 mm wide at the rim is tilted by five degrees, one way on one side, the other way on the other.
    let mut points = plate().points;
    let tilt = f64::tan(TAU * 5.0 / 360.0);
    points.extend([
        DVec3::new(10.0, 30.0, 2.0),
        DVec3::new(11.0, 30.0, 2.0 + tilt),
        DVec3::new(10.5, 10.0, 2.0),
    ]);
    let mut triangles = plate().triangles;
    // The top and the side that has the rim.
    triangles.retain(|t| !t.iter().all(|v| v & 4 == 4) && !t.iter().all(|v| v & 2 == 2));
    triangles.extend([
        [10, 4, 5],
        [10, 5, 7],
        [10, 7, 9],
        [10, 9, 8],
        [10, 8, 6],
        [10, 6, 4],
    ]);
    triangles.extend([[3, 2, 6], [3, 6, 8], [3, 8, 9], [3, 9, 7]]);
    let mut soup = Soup { points, triangles };
    assert_eq!(super::weld::open_sides(&soup), 0);
    assert_eq!(segment(&soup, 2.0).regions, 6);
    // Ten times as wide as that, and tilted on one side only, it is a bevel and stays.
    soup.points[8].x = 20.0;
    soup.points[9] = DVec3::new(30.0, 30.0, 2.0 + 10.0 * tilt);
    assert!(segment(&soup, 2.0).regions > 6);
}

#[test]
fn a_small_hole_is_closed_and_a_large_one_refused() {
    let mut small = tube(96, 20.0, 18.0, 30.0);
    // A triangle of the tube's end, 1.3 by 2 mm.
    let lost = [4];
    small.triangles = small
        .triangles
        .iter()
        .enumerate()
        .filter(|(i, _)| !lost.contains(i))
        .map(|(_, t)| *t)
        .collect();
    let (found, mended) = solids(small).unwrap();
    assert_eq!((found.len(), mended.holes), (1, 1));
    let truth = volume(&tube(96, 20.0, 18.0, 30.0));
    assert!((volume(&found[0].facets) - truth).abs() < 1e-9 * truth);

    let mut large = plate();
    large.triangles.truncate(10);
    let Err(ShellFault::Open { count, length, .. }) = solids(large) else {
        panic!("a plate without an end was taken for a solid");
    };
    assert_eq!(count, 1);
    assert!((length - 64.0).abs() < 1e-9);
}

#[test]
fn bodies_that_cut_each_other_are_one_solid_and_said_so() {
    let other = cuboid(DVec3::new(10.0, 10.0, 1.0), DVec3::new(20.0, 20.0, 9.0));
    let (found, _) = solids(together(&plate(), &other)).unwrap();
    assert_eq!(found.len(), 1);
    assert!(matches!(found[0].cut, Some(ShellFault::Overlap { .. })));
    let apart = cuboid(DVec3::new(10.0, 10.0, 3.0), DVec3::new(20.0, 20.0, 9.0));
    let (found, _) = solids(together(&plate(), &apart)).unwrap();
    assert_eq!(found.len(), 2);
    assert!(found.iter().all(|s| s.cut.is_none()));
}

#[test]
fn bodies_that_cut_without_a_corner_inside_are_found_and_a_shell_that_cuts_itself() {
    // A bar through the plate: every corner of either lies outside the other.
    let bar = cuboid(DVec3::new(10.0, 10.0, -9.0), DVec3::new(14.0, 14.0, 9.0));
    let (found, _) = solids(together(&plate(), &bar)).unwrap();
    assert_eq!(found.len(), 1);
    assert!(matches!(found[0].cut, Some(ShellFault::Overlap { .. })));
    let mut own = plate();
    own.points[0] = DVec3::new(3.0, 2.0, 10.0);
    assert!(matches!(solids(own), Err(ShellFault::SelfCut { .. })));
}

#[test]
fn a_moebius_strip_and_a_bare_surface_are_no_solids() {
    // Five triangles in a ring with a twist, the smallest Moebius strip.
    let points = (0..5)
        .map(|i| {
            DVec3::new(
                (1.3 * f64::from(i)).cos(),
                (1.3 * f64::from(i)).sin(),
                0.2 * f64::from(i),
            )
        })
        .collect();
    let triangles = (0..5).map(|i| [i, (i + 1) % 5, (i + 2) % 5]).collect();
    assert!(solids(Soup { points, triangles }).is_err());
    let flat = Soup {
        points: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        triangles: vec![[0, 1, 2], [0, 2, 1]],
    };
    assert_eq!(solids(flat).unwrap_err(), ShellFault::NoVolume);
}

#[test]
fn coarse_cylinders_are_one_face_and_plates_six() {
    assert_eq!(segment(&plate(), 1.8).regions, 6);
    // Chords of 7.5, 15 and 30 degrees.
    for n in [48, 24, 12] {
        assert_eq!(segment(&tube(n, 20.0, 18.0, 30.0), 1.8).regions, 4, "{n}");
    }
    // A prism is no cylinder.
    assert_eq!(segment(&tube(6, 20.0, 18.0, 30.0), 1.8).regions, 14);
    assert_eq!(segment(&tetrahedron(), 0.1).regions, 4);
}

#[test]
fn a_bend_of_chords_has_its_flat_flanges_beside_it() {
    // An outline of two flanges of 20 and a quarter turn in `n` chords, 2 mm thick, drawn out by 15.
    for n in [3u32, 4, 6, 12] {
        let arc = |r: f64| {
            (0..=n).map(move |i| {
                let a = TAU / 4.0 * f64::from(i) / f64::from(n);
                DVec3::new(r * a.sin(), -r * a.cos(), 0.0)
            })
        };
        let outer: Vec<DVec3> = [DVec3::new(-20.0, -6.0, 0.0)]
            .into_iter()
            .chain(arc(6.0))
            .chain([DVec3::new(6.0, 20.0, 0.0)])
            .collect();
        let inner: Vec<DVec3> = [DVec3::new(-20.0, -4.0, 0.0)]
            .into_iter()
            .chain(arc(4.0))
            .chain([DVec3::new(4.0, 20.0, 0.0)])
            .collect();
        let m = outer.len() as u32;
        let lift = DVec3::Z * 15.0;
        let points: Vec<DVec3> = outer
            .iter()
            .chain(&inner)
            .copied()
            .chain(outer.iter().chain(&inner).map(|p| *p + lift))
            .collect();
        let mut triangles = Vec::new();
        let mut quad = |a: u32, b: u32, c: u32, d: u32| triangles.extend([[a, b, c], [a, c, d]]);
        for i in 0..m - 1 {
            quad(i, i + 1, 2 * m + i + 1, 2 * m + i);
            quad(m + i + 1, m + i, 3 * m + i, 3 * m + i + 1);
            quad(i + 1, i, m + i, m + i + 1);
            quad(2 * m + i, 2 * m + i + 1, 3 * m + i + 1, 3 * m + i);
        }
        quad(m, 0, 2 * m, 3 * m);
        quad(m - 1, 2 * m - 1, 4 * m - 1, 3 * m - 1);
        let bend = Soup { points, triangles };
        assert!(volume(&bend) > 0.0);
        // Two flanges and a bend on either side, two outlines, two ends.
        assert_eq!(segment(&bend, 2.0).regions, 10, "{n} chords");
    }
}

#[test]
fn facets_of_any_shape_come_to_the_wanted_size() {
    let (coarse, size) = sized(&tube(48, 20.0, 18.0, 200.0), 1.0, true);
    let longest = |s: &Soup| {
        (0..s.triangles.len())
            .flat_map(|t| {
                let [a, b, c] = s.corners(t);
                [a.distance(b), b.distance(c), c.distance(a)]
            })
            .fold(0.0, f64::max)
    };
    assert!(longest(&coarse.soup) < 1.5 * size);
    assert_eq!(coarse.soup.triangles.len(), coarse.region.len());
    let found = volume(&coarse.soup);
    let truth = volume(&tube(48, 20.0, 18.0, 200.0));
    // Between the chords and the circles: 48 chords have 0.3 % less.
    assert!(
        found - truth > -1e-3 * truth && found - truth < 3e-3 * truth,
        "{found} {truth}"
    );
    let euler = |s: &Soup| {
        let mut sides: Vec<[u32; 2]> = s
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(|[p, q]| [p.min(q), p.max(q)]))
            .collect();
        sides.sort_unstable();
        sides.dedup();
        s.points.len() as i64 - sides.len() as i64 + s.triangles.len() as i64
    };
    assert_eq!(euler(&coarse.soup), 0);
    assert_eq!(sized(&tube(48, 20.0, 18.0, 200.0), 1.0, true).0, coarse);
}

#[test]
fn needless_facets_go() {
    // A plate cut into 20,000 triangles.
    let n = 50;
    let mut soup = plate();
    let halves = |s: &Soup| {
        let mut out = Soup::default();
        for t in 0..s.triangles.len() {
            let [a, b, c] = s.corners(t);
            let (ab, bc, ca) = (a.midpoint(b), b.midpoint(c), c.midpoint(a));
            for tri in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
                let first = out.points.len() as u32;
                out.points.extend(tri);
                out.triangles.push([first, first + 1, first + 2]);
            }
        }
        out
    };
    while soup.triangles.len() < 20_000 {
        soup = weld(&halves(&soup)).0;
    }
    let (found, _) = shells::solids(soup).unwrap();
    let (small, _) = sized(&found[0].facets, 1.0, true);
    assert!(
        small.soup.triangles.len() < 20 * n,
        "{}",
        small.soup.triangles.len()
    );
    assert!((volume(&small.soup) - 2400.0).abs() < 1e-6);
}

proptest! {
    #[test]
    fn hostile_little_meshes_give_closed_solids_or_a_reason(
        corners in proptest::collection::vec((0u8..4, 0u8..4, 0u8..3), 4..14),
        triangles in proptest::collection::vec((0u32..14, 0u32..14, 0u32..14), 0..30),
        whole in any::<bool>(),
    ) {
        let points: Vec<DVec3> = corners
            .iter()
            .map(|&(x, y, z)| DVec3::new(x.into(), y.into(), z.into()))
            .collect();
        let n = points.len() as u32;
        let random = triangles.iter().map(|&(a, b, c)| [a % n, b % n, c % n]);
        let mut soup = Soup { points, triangles: random.collect() };
        if whole {
            // Something closed that the rest touches, cuts or lies in.
            soup = together(&soup, &cuboid(DVec3::ONE, DVec3::new(3.0, 2.0, 2.0)));
        }
        if let Ok((found, _)) = solids(weld(&soup).0) {
            for solid in &found {
                prop_assert_eq!(super::weld::open_sides(&solid.facets), 0);
                prop_assert!(volume(&solid.facets) > 0.0 || solid.cut.is_some());
            }
            for solid in found.iter().filter(|s| s.cut.is_none()) {
                let (surface, size) = sized(&solid.facets, 1.0, true);
                prop_assert!(size > 0.0 && surface.soup.points.iter().all(|p| p.is_finite()));
            }
        }
    }
}
