use super::*;
use crate::model::complex::{MidNode, MidTriangle, Support};
use crate::model::ids::WallId;

/// Wall 0 is the plane z = 0, wall 1 a plane with this normal; both end at |x| = 100 and are one thick.
struct Walls(DVec3);
const PLANES: Walls = Walls(DVec3::Y);
impl Placer for Walls {
    fn place(&self, start: DVec3, _: &[Support]) -> DVec3 {
        start
    }
    fn normal(&self, _: DVec3, wall: WallId) -> Option<DVec3> {
        Some(if wall == WallId(0) { DVec3::Z } else { self.0 })
    }
    fn thickness(&self, _: DVec3, _: WallId) -> Option<f64> {
        Some(1.0)
    }
    fn beyond(&self, point: DVec3, _: WallId) -> f64 {
        (point.x.abs() - 100.0).max(0.0)
    }
    fn curvature_radius(&self, _: DVec3, _: WallId) -> f64 {
        f64::INFINITY
    }
}

/// A row of `count` squares along x between two lines of nodes.
fn strip(complex: &mut MidComplex, wall: u32, low: &[NodeId], high: &[NodeId]) {
    for i in 0..low.len() - 1 {
        let (a, b, c, d) = (low[i], low[i + 1], high[i + 1], high[i]);
        for nodes in [[a, b, c], [a, c, d]] {
            complex.triangles.push(MidTriangle {
                nodes,
                wall: WallId(wall),
            });
        }
    }
}

fn line(complex: &mut MidComplex, y: f64, z: f64) -> Vec<NodeId> {
    (0..5)
        .map(|i| {
            complex.nodes.push(MidNode {
                point: DVec3::new(f64::from(i), y, z),
                supports: Default::default(),
            })
        })
        .collect()
}

/// A plate of wall 0 with a line in its middle, and that line.
fn plate() -> (MidComplex, Vec<NodeId>) {
    let mut complex = MidComplex::default();
    let lines = [-30.0, 0.0, 30.0].map(|y| line(&mut complex, y, 0.0));
    strip(&mut complex, 0, &lines[0], &lines[1]);
    strip(&mut complex, 0, &lines[1], &lines[2]);
    let [_, middle, _] = lines;
    (complex, middle)
}

fn with_supports(mut complex: MidComplex) -> MidComplex {
    complex.support_by_walls();
    complex
}

#[test]
fn a_fin_that_doubles_its_plate_goes_and_the_plate_is_as_before() {
    let (bare, middle) = plate();
    let mut complex = bare.clone();
    let edge = line(&mut complex, 0.5, 0.02);
    strip(&mut complex, 0, &middle, &edge);
    let euler = complex.euler();
    let (pruned, stats) = prune(with_supports(complex), &PLANES);
    assert_eq!((stats.sheets, stats.triangles), (1, 8));
    assert_eq!(pruned, with_supports(bare));
    assert_eq!(pruned.euler(), euler);
}

#[test]
fn a_rib_that_stands_for_its_own_wall_stays() {
    let (mut complex, middle) = plate();
    let top = line(&mut complex, 0.0, 1.5);
    strip(&mut complex, 1, &middle, &top);
    let complex = with_supports(complex);
    let (pruned, stats) = prune(complex.clone(), &PLANES);
    assert_eq!(stats, PruneStats::default());
    assert_eq!(pruned, complex);
}

#[test]
fn a_sheet_that_hangs_off_its_wall_at_a_right_angle_goes() {
    let (mut complex, middle) = plate();
    let down = line(&mut complex, 0.0, -0.6);
    strip(&mut complex, 0, &middle, &down);
    let (pruned, stats) = prune(with_supports(complex), &PLANES);
    assert_eq!(stats.sheets, 1);
    assert_eq!(pruned.triangles.len(), 16);
}

#[test]
fn a_strip_between_two_junctions_cannot_go() {
    let mut complex = MidComplex::default();
    let lines = [-30.0, 0.0, 0.5, 30.0].map(|y| line(&mut complex, y, 0.0));
    for k in 0..3 {
        strip(&mut complex, 0, &lines[k], &lines[k + 1]);
    }
    // A second strip over the middle one: a flat tube, whose hole must stay.
    let (low, high) = (lines[1].clone(), lines[2].clone());
    let ridge = line(&mut complex, 0.25, 0.01);
    strip(&mut complex, 0, &low, &ridge);
    strip(&mut complex, 0, &ridge, &high);
    let complex = with_supports(complex);
    let (pruned, stats) = prune(complex.clone(), &PLANES);
    assert_eq!(stats, PruneStats::default());
    assert_eq!(pruned.euler(), complex.euler());
}

#[test]
fn a_third_sheet_where_a_wall_meets_itself_goes_however_far_apart() {
    let (bare, middle) = plate();
    let mut complex = bare.clone();
    let edge = line(&mut complex, 9.0, 0.9);
    strip(&mut complex, 0, &middle, &edge);
    let (pruned, stats) = prune(with_supports(complex.clone()), &PLANES);
    assert_eq!((stats.sheets, stats.triangles), (1, 8));
    assert_eq!(pruned, with_supports(bare));
    // The foot of another wall is no surplus.
    for t in complex.triangles.as_mut_slice().iter_mut().skip(16) {
        t.wall = WallId(1);
    }
    let complex = with_supports(complex);
    let (kept, _) = prune(
        complex.clone(),
        &Walls(DVec3::new(0.0, -0.1, 1.0).normalize()),
    );
    assert_eq!(kept, complex);
}

#[test]
fn a_fin_without_area_goes_whatever_wall_it_is_of() {
    let (bare, middle) = plate();
    let mut complex = bare.clone();
    let edge = line(&mut complex, 0.0, 0.0);
    strip(&mut complex, 1, &middle, &edge);
    let (pruned, stats) = prune(with_supports(complex), &PLANES);
    assert_eq!((stats.sheets, stats.triangles), (1, 8));
    assert_eq!(pruned, with_supports(bare));
}
