use super::*;
use crate::stage::test_shapes as shapes;
use glam::DVec3;

fn sound(patches: &[Patch], complex: &MidComplex) {
    let mut all: Vec<u32> = Vec::new();
    for p in patches {
        assert_eq!(p.check(), vec![]);
        all.extend(p.source.iter().map(|t| t.0));
    }
    all.sort_unstable();
    assert_eq!(all, (0..complex.triangles.len() as u32).collect::<Vec<_>>());
}

/// Cuts until every piece is a disc with at most `holes` holes.
fn cut_to_discs(patch: Patch, holes: usize) -> Vec<Patch> {
    if patch.is_planar_graph() && patch.loops.len() <= holes + 1 {
        return vec![patch];
    }
    cut(&patch, &[])
        .into_iter()
        .flat_map(|p| cut_to_discs(p, holes))
        .collect()
}

#[test]
fn a_plate_with_three_holes_is_one_patch_with_four_loops() {
    let c = shapes::plate_with_holes(4.0);
    let p = patches(&c);
    sound(p.as_slice(), &c);
    assert_eq!(p.len(), 1);
    assert_eq!((p[PatchId(0)].loops.len(), p[PatchId(0)].euler()), (4, -2));
    assert!(p[PatchId(0)].is_planar_graph());
    assert!(p[PatchId(0)].kept_edges.is_empty() && p[PatchId(0)].kept_corners.is_empty());
}

#[test]
fn a_rib_across_a_plate_makes_three_patches() {
    let c = shapes::rib_on_plate(1.0);
    let p = patches(&c);
    sound(p.as_slice(), &c);
    assert_eq!(p.len(), 3);
    assert!(p.iter().all(|p| p.loops.len() == 1 && p.euler() == 1));
}

#[test]
fn a_rib_that_ends_inside_leaves_the_plate_whole_with_kept_edges() {
    let c = shapes::rib_on_plate(0.5);
    let p = patches(&c);
    sound(p.as_slice(), &c);
    assert_eq!(p.len(), 2);
    let plate = &p[PatchId(0)];
    assert_eq!((plate.loops.len(), plate.kept_edges.len()), (1, 10));
    // The first of the eleven nodes of the rib's foot lies on the rim.
    assert_eq!(plate.kept_corners.len(), 10);
}

#[test]
fn a_sharp_fold_inside_a_wall_is_kept() {
    let mut b = shapes::Build::default();
    b.sheet(0, 4, 4, |u, v| DVec3::new(u, v, 0.0));
    b.sheet(0, 4, 4, |u, v| DVec3::new(0.0, v, u));
    let p = patches(&b.complex);
    sound(p.as_slice(), &b.complex);
    assert_eq!(p.len(), 1);
    assert_eq!(p[PatchId(0)].kept_edges.len(), 4);
}

#[test]
fn closed_and_tube_like_patches_are_cut_into_discs() {
    for (complex, loops) in [
        (shapes::sphere(8, false), 0),
        (shapes::torus(40, 16), 0),
        (shapes::tube(24, 40, 120.0), 2),
    ] {
        let p = patches(&complex);
        assert_eq!((p.len(), p[PatchId(0)].loops.len()), (1, loops));
        let pieces = cut_to_discs(p[PatchId(0)].clone(), 0);
        sound(&pieces, &complex);
        assert!(pieces.len() <= 8, "{} pieces", pieces.len());
    }
    let tube = &patches(&shapes::tube(24, 40, 120.0))[PatchId(0)];
    assert_eq!(cut_to_discs(tube.clone(), 0).len(), 2);
}

#[test]
fn a_second_cut_avoids_the_first() {
    let c = shapes::tube(24, 40, 120.0);
    let tube = &patches(&c)[PatchId(0)];
    let on_cut = |pieces: &[Patch]| {
        let mut all: Vec<NodeId> = Vec::new();
        for p in pieces {
            let mut own: Vec<NodeId> = p.boundary().map(|e| p.nodes[e[0] as usize]).collect();
            own.retain(|n| (1.0..119.0).contains(&c.nodes[*n].point.z));
            all.extend(own);
        }
        all.sort_unstable();
        all.dedup();
        all
    };
    let first = on_cut(&cut(tube, &[]));
    let second = on_cut(&cut(tube, &first));
    assert!(first.len() > 60 && second.len() > 60);
    assert!(second.iter().all(|n| first.binary_search(n).is_err()));
}

#[test]
fn a_strip_with_half_a_twist_is_opened() {
    let c = shapes::moebius();
    let p = patches(&c);
    sound(p.as_slice(), &c);
    assert_eq!(p.len(), 1);
    assert!(p[PatchId(0)].is_planar_graph());
}

#[test]
fn triangles_turned_at_random_come_out_one_way_round() {
    let mut c = shapes::half_cylinder(12, 10);
    for (i, t) in c.triangles.iter_mut().enumerate() {
        if i * i % 7 == 2 {
            t.nodes.swap(0, 1);
        }
    }
    sound(patches(&c).as_slice(), &c);
}

#[test]
fn two_triangles_and_one_can_be_cut() {
    let c = shapes::sheet(1, 1, |u, v| DVec3::new(u, v, 0.0));
    let p = patches(&c);
    let halves = cut(&p[PatchId(0)], &[]);
    assert_eq!(halves.len(), 2);
    assert_eq!(cut(&halves[0], &[]).len(), 1);
}
