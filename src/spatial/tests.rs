use super::*;
use crate::geom::random::Pcg;
use glam::Vec3Swizzles;

fn soup(n: usize, seed: u64, size: f64, offset: DVec3) -> (Vec<[DVec3; 3]>, Pcg) {
    let mut rng = Pcg::new(seed);
    let mut point = || DVec3::new(rng.unit(), rng.unit(), rng.unit());
    let t = (0..n)
        .map(|_| {
            let a = point();
            [a, a + (point() - 0.5) * size, a + (point() - 0.5) * size].map(|p| p + offset)
        })
        .collect();
    (t, rng)
}

fn brute_nearest(t: &[[DVec3; 3]], p: DVec3) -> (usize, f64) {
    t.iter()
        .enumerate()
        .map(|(i, t)| (i, nearest_on_triangle(*t, p).distance_squared(p)))
        .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))
        .unwrap()
}

#[test]
fn nearest_and_first_hit_are_those_of_a_search_through_all() {
    for (n, offset) in [
        (1, 0.0),
        (2, 0.0),
        (7, 0.0),
        (3000, 0.0),
        (3000, 1e6),
        (3000, -3e-9),
    ] {
        let (t, mut rng) = soup(n, n as u64, 0.1, DVec3::splat(offset));
        let bvh = TriangleBvh::new(&t);
        for _ in 0..500 {
            let p = DVec3::new(rng.unit(), rng.unit(), rng.unit()) * 2.0 - 0.5 + offset;
            let (i, d2) = brute_nearest(&t, p);
            let near = bvh.nearest(p).unwrap();
            assert_eq!((near.index, near.distance), (i, d2.sqrt()));
            let within = |radius| bvh.any_within(p, radius);
            let reach = near.distance * (1.0 + 1e-9);
            assert!(within(reach).is_some_and(|d| d >= near.distance && d <= reach));
            assert!(near.distance == 0.0 || within(near.distance * (1.0 - 1e-9)).is_none());
            let elsewhere = bvh.nearest(p.yzx()).unwrap().hint;
            assert_eq!(bvh.nearest_from(p, Some(elsewhere)), Some(near));
            let d = DVec3::new(rng.unit(), rng.unit(), rng.unit()) - 0.5;
            let ray = Ray::new(p, d);
            let mut all: Vec<(usize, RayHit)> = t
                .iter()
                .enumerate()
                .filter_map(|(i, t)| ray.meets(*t).filter(|h| h.t >= 0.0).map(|h| (i, h)))
                .collect();
            all.sort_by(|a, b| a.1.t.total_cmp(&b.1.t).then(a.0.cmp(&b.0)));
            let back = bvh.first_hit(p, -d).map_or(f64::INFINITY, |(_, t)| t);
            let ahead = all.first().map_or(f64::INFINITY, |(_, h)| h.t);
            assert_eq!(
                bvh.first_distances(p, d, f64::INFINITY),
                [ahead, back],
                "bit by bit"
            );
            let within = |t: f64| if t <= 0.1 { t } else { f64::INFINITY };
            assert_eq!(bvh.first_distances(p, d, 0.1), [ahead, back].map(within));
            let between = bvh.first_hit_between(p, d, [0.0, 0.1]);
            let first = all.first().copied();
            assert_eq!(between, first.filter(|(_, h)| h.t <= 0.1));
            assert_eq!(bvh.first_hit(p, d), all.first().map(|(i, h)| (*i, h.t)));
            assert_eq!(bvh.all_hits(p, d), all);
        }
    }
}

/// Corners at -1 and 1; outward.
fn cube() -> Vec<[DVec3; 3]> {
    let mut t = Vec::new();
    for k in 0..3 {
        for s in [-1.0, 1.0] {
            let at = |u: f64, v: f64| {
                let mut p = DVec3::splat(s);
                p[(k + 1) % 3] = u * s;
                p[(k + 2) % 3] = v;
                p
            };
            t.push([at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0)]);
            t.push([at(-1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]);
        }
    }
    t
}

#[test]
fn equal_distances_go_to_the_lowest_index() {
    let mut t = vec![cube()[0]; 40];
    t.extend(cube());
    let bvh = TriangleBvh::new(&t);
    assert_eq!(bvh.nearest(DVec3::new(-3.0, -0.5, 0.2)).unwrap().index, {
        brute_nearest(&t, DVec3::new(-3.0, -0.5, 0.2)).0
    });
    assert_eq!(bvh.nearest(t[0][1] * 2.0).unwrap().index, 0);
}

#[test]
fn nearest_within_and_where_hold_back() {
    let bvh = TriangleBvh::new(&cube());
    let p = DVec3::new(3.0, 0.1, 0.2);
    assert!(bvh.nearest_within(p, 1.999).is_none());
    assert_eq!(bvh.nearest_within(p, 2.0).unwrap().distance, 2.0);
    let other = bvh.nearest_where(p, 9.0, |i| i < 2).unwrap();
    assert!(other.index < 2 && (other.distance - 4.0).abs() < 1e-15);
}

#[test]
fn inside_holds_in_spite_of_edges_and_corners_in_the_way() {
    let mut t = cube();
    // A hollow: the same cube at half size, inside out.
    t.extend(cube().iter().map(|t| [t[0], t[2], t[1]].map(|p| p * 0.5)));
    let bvh = TriangleBvh::new(&t);
    for (p, truth) in [
        (DVec3::ZERO, false),
        (DVec3::splat(0.75), true),
        (DVec3::new(0.9, 0.0, 0.0), true),
        (DVec3::new(1.1, 0.0, 0.0), false),
        // Straight behind a corner of the cube.
        (DVec3::splat(-1.0) - PARITY_DIRECTIONS[0], false),
    ] {
        assert_eq!(bvh.inside(p), truth, "{p}");
    }
    let mut rng = Pcg::new(3);
    for _ in 0..2000 {
        let p = (DVec3::new(rng.unit(), rng.unit(), rng.unit()) * 2.0 - 1.0) * 1.3;
        let size = p.abs().max_element();
        assert_eq!(bvh.inside(p), size < 1.0 && size > 0.5, "{p}");
    }
}

#[test]
fn flat_sets_empty_sets_and_broken_triangles() {
    assert!(TriangleBvh::new(&[]).nearest(DVec3::ZERO).is_none());
    assert!(
        TriangleBvh::default()
            .first_hit(DVec3::ZERO, DVec3::X)
            .is_none()
    );
    let mut t = vec![[DVec3::NAN; 3], [DVec3::INFINITY, DVec3::ZERO, DVec3::X]];
    for i in 0..50 {
        let a = DVec3::new(f64::from(i), 0.0, 0.0);
        t.push([a, a + DVec3::X, a + DVec3::Y]);
    }
    let bvh = TriangleBvh::new(&t);
    let near = bvh.nearest(DVec3::new(30.25, 0.25, 7.0)).unwrap();
    assert_eq!((near.index, near.distance), (32, 7.0));
    let hit = bvh.first_hit(DVec3::new(30.25, 0.25, 7.0), DVec3::new(0.0, 0.0, -1.0));
    assert_eq!(hit, Some((32, 7.0)));
    assert!(bvh.nearest(DVec3::NAN).is_none());
    let far = bvh.nearest(DVec3::splat(-1e60)).unwrap();
    assert_eq!((far.index, far.distance), (2, DVec3::splat(1e60).length()));
}
