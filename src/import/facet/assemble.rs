//! From filled facets to a mesh with entities: the faces are the regions, the curves the chains of sides between two of them.

use std::collections::HashMap;

use glam::DVec3;

use super::remesh::Remeshed;
use super::segment::{NONE, neighbours};
use crate::geom::six_node::QuadraticTriangle;
use crate::import::msh::{ElementBlock, ElementKind, Msh, MshEntity};
use crate::import::skin::{Skin, SkinCurve};
use crate::model::brep::Face;
use crate::model::disjoint::Disjoint;

/// The surface with its faces and curves, numbered after `faces` and `curves`.
pub(super) fn skin(surface: &Remeshed, solid: i32, faces: &mut i32, curves: &mut i32) -> Skin {
    let regions = surface.region.iter().max().map_or(0, |r| *r as usize + 1);
    let mut skin = Skin {
        solid_tag: solid,
        facets: vec![Vec::new(); regions],
        faces: vec![Face::default(); regions],
        curves: Vec::new(),
    };
    for face in &mut skin.faces {
        *faces += 1;
        face.tag = *faces;
    }
    for (t, &mids) in surface.mids.iter().enumerate() {
        skin.facets[surface.region[t] as usize].push(QuadraticTriangle {
            corners: surface.soup.corners(t),
            mids,
        });
    }
    for curve in border_curves(surface) {
        *curves += 1;
        skin.curves.push(SkinCurve {
            tag: *curves,
            faces: curve.regions.to_vec(),
            segments: curve
                .segments
                .iter()
                .map(|s| s.map(|v| surface.soup.points[v as usize]))
                .collect(),
        });
    }
    skin
}

/// The mesh of one solid with number `solid`; numbers of faces and curves begin after `faces` and `curves`. `None` where the filling lacks a point of the
/// surface.
pub(super) fn assemble(
    surface: &Remeshed,
    filling: &Msh,
    solid: i32,
    faces: &mut i32,
    curves: &mut i32,
) -> Option<Msh> {
    // Only looked up, never walked.
    let mut known: HashMap<[u64; 3], u32> = HashMap::with_capacity(filling.nodes.len());
    let key = |p: &DVec3| (*p + DVec3::ZERO).to_array().map(f64::to_bits);
    for (i, p) in (0u32..).zip(&filling.nodes) {
        known.entry(key(p)).or_insert(i);
    }
    let number: Vec<u32> = surface
        .soup
        .points
        .iter()
        .map(|p| known.get(&key(p)).copied())
        .collect::<Option<_>>()?;
    let mut nodes = filling.nodes.clone();
    let regions = surface.region.iter().max().map_or(0, |r| r + 1);
    let first_face = *faces + 1;
    *faces += regions as i32;

    let mut blocks: Vec<Vec<u32>> = vec![Vec::new(); regions as usize];
    for (t, tri) in surface.soup.triangles.iter().enumerate() {
        let block = &mut blocks[surface.region[t] as usize];
        block.extend(tri.map(|v| number[v as usize]));
        for m in surface.mids[t] {
            block.push(nodes.len() as u32);
            nodes.push(m);
        }
    }
    let mut elements: Vec<ElementBlock> = Vec::new();
    let mut boundary: Vec<Vec<i32>> = vec![Vec::new(); regions as usize];
    let mut curve_entities = Vec::new();
    for curve in border_curves(surface) {
        *curves += 1;
        for r in curve.regions {
            boundary[r as usize].push(*curves);
        }
        curve_entities.push(MshEntity {
            tag: *curves,
            ..MshEntity::default()
        });
        elements.push(ElementBlock {
            dimension: 1,
            entity: *curves,
            kind: ElementKind::Line2,
            nodes: curve
                .segments
                .iter()
                .flatten()
                .map(|&v| number[v as usize])
                .collect(),
        });
    }
    for (r, block) in blocks.into_iter().enumerate() {
        elements.push(ElementBlock {
            dimension: 2,
            entity: first_face + r as i32,
            kind: ElementKind::Triangle6,
            nodes: block,
        });
    }
    elements.extend(
        filling
            .elements
            .iter()
            .filter(|b| b.dimension == 3)
            .map(|b| ElementBlock {
                entity: solid,
                ..b.clone()
            }),
    );
    let tags: Vec<i32> = (first_face..=*faces).collect();
    let surfaces = tags
        .iter()
        .zip(boundary)
        .map(|(&tag, boundary)| MshEntity {
            tag,
            boundary,
            ..MshEntity::default()
        })
        .collect();
    let volume = MshEntity {
        tag: solid,
        boundary: tags,
        ..MshEntity::default()
    };
    Some(Msh {
        entities: [Vec::new(), curve_entities, surfaces, vec![volume]],
        nodes,
        elements,
        ..Msh::default()
    })
}

pub(super) struct BorderCurve {
    pub(super) regions: [u32; 2],
    pub(super) segments: Vec<[u32; 2]>,
}

/// Sides between two regions, joined over the vertices where exactly two of one pair of regions meet.
pub(super) fn border_curves(surface: &Remeshed) -> Vec<BorderCurve> {
    let triangles = &surface.soup.triangles;
    let beyond = neighbours(triangles);
    let mut sides: Vec<([u32; 2], [u32; 2])> = Vec::new();
    for (t, tri) in triangles.iter().enumerate() {
        for k in 0..3 {
            let mate = beyond[t][k];
            if mate == NONE {
                continue;
            }
            let (r, s) = (surface.region[t], surface.region[mate as usize]);
            if r < s {
                sides.push(([r, s], [tri[k], tri[(k + 1) % 3]]));
            }
        }
    }
    sides.sort_unstable();
    let mut ends: Vec<(u32, u32)> = (0u32..)
        .zip(&sides)
        .flat_map(|(i, s)| s.1.map(|v| (v, i)))
        .collect();
    ends.sort_unstable();
    let mut sets = Disjoint::new(sides.len());
    for run in ends.chunk_by(|a, b| a.0 == b.0) {
        if let &[(_, i), (_, j)] = run
            && sides[i as usize].0 == sides[j as usize].0
        {
            sets.join(i, j);
        }
    }
    let mut curves: Vec<BorderCurve> = Vec::new();
    let mut of_root = vec![NONE; sides.len()];
    for (i, &(regions, segment)) in (0u32..).zip(&sides) {
        let root = sets.find(i) as usize;
        if of_root[root] == NONE {
            of_root[root] = curves.len() as u32;
            curves.push(BorderCurve {
                regions,
                segments: Vec::new(),
            });
        }
        curves[of_root[root] as usize].segments.push(segment);
    }
    curves
}
