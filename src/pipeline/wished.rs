//! Whether a part has the sheets and faces that the user gave sizes of their own.

use crate::import::Piece;
use crate::options::{MeshOptions, OptionFault};
use std::collections::BTreeSet;

/// Whether all faces are there that sizes are wished for.
pub(super) fn faces_are_there(pieces: &[Piece], options: &MeshOptions) -> Result<(), OptionFault> {
    let faces: BTreeSet<i32> = (pieces.iter())
        .flat_map(|piece| piece.brep.faces.iter().map(|f| f.tag))
        .collect();
    let wished = (options.sizes.iter()).flat_map(|w| w.faces.iter().map(move |f| (w, *f)));
    for (wish, face) in wished {
        if !faces.contains(&face) {
            return Err(OptionFault::NoFace {
                origin: wish.origin.clone(),
                face,
                faces: faces.into_iter().collect(),
            });
        }
    }
    Ok(())
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
