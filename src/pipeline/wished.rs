//! Whether a part has the sheets, faces and edges that the user names.

use crate::import::Piece;
use crate::model::keep::KeepEdge;
use crate::options::{MeshOptions, OptionFault};
use crate::stage::keep::Unkept;
use std::collections::{BTreeMap, BTreeSet};

/// Whether all faces are there that sizes are wished for or edges of which are to be kept.
pub(super) fn faces_are_there(pieces: &[Piece], options: &MeshOptions) -> Result<(), OptionFault> {
    let faces: BTreeSet<i32> = (pieces.iter())
        .flat_map(|piece| piece.brep.faces.iter().map(|f| f.tag))
        .collect();
    let sized =
        (options.sizes.iter()).flat_map(|w| w.faces.iter().map(move |f| (w.origin.clone(), *f)));
    let kept = (options.keep.iter())
        .flat_map(|wish| wish.faces.map(|f| (format!("--keep-edge {wish}"), f)));
    for (origin, face) in sized.chain(kept) {
        if !faces.contains(&face) {
            return Err(OptionFault::NoFace {
                origin,
                face,
                faces: faces.into_iter().collect(),
            });
        }
    }
    Ok(())
}

/// Whether the faces whose edges are to be kept have such edges.
pub(super) fn edges_are_there(pieces: &[Piece], options: &MeshOptions) -> Result<(), OptionFault> {
    // The faces across the edges of each face.
    let mut across: BTreeMap<i32, BTreeSet<i32>> = BTreeMap::new();
    for brep in pieces.iter().map(|piece| &piece.brep) {
        for curve in &brep.curves {
            if let &[a, b] = curve.faces.as_slice() {
                let [a, b] = [a, b].map(|f| brep.faces[f].tag);
                across.entry(a).or_default().insert(b);
                across.entry(b).or_default().insert(a);
            }
        }
    }
    for wish in &options.keep {
        let [a, b] = wish.faces;
        let near = across.get(&a).cloned().unwrap_or_default();
        if !near.contains(&b) {
            return Err(OptionFault::NoEdge {
                wish: *wish,
                near: near.into_iter().collect(),
            });
        }
    }
    Ok(())
}

/// What the user is told of an edge that cannot be kept.
pub(super) fn unkept((wish, why): (KeepEdge, Unkept)) -> OptionFault {
    match why {
        Unkept::Outer => OptionFault::OuterEdge(wish),
        Unkept::PartsNothing(at) => OptionFault::PartsNothing {
            wish,
            at: at.to_array(),
        },
    }
}

/// Whether all sheets are there that sizes are wished for, where there are `sheets` of them.
pub(super) fn sheets_are_there(sheets: usize, options: &MeshOptions) -> Result<(), OptionFault> {
    let wished = (options.sizes.iter()).flat_map(|w| w.sheets.iter().map(move |s| (w, *s)));
    for (wish, sheet) in wished {
        if sheet as usize > sheets {
            return Err(OptionFault::NoSheet {
                origin: wish.origin.clone(),
                sheet,
                sheets,
            });
        }
    }
    Ok(())
}
