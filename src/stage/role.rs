//! Role: what every face is to the walls, and for which wall faces it stands.

use crate::model::decomposition::{FaceRoles, Labels};
use crate::model::ids::{FaceId, IndexVec};
use crate::model::walls::{Aag, Pairing, Role};

/// Fillets lie beside fillets: labels travel this many faces far from a wall. A blend between three walls has its neighbours at two.
const ROUNDS: usize = 3;

/// Roles from adjacency and pairs.
///
/// A wall side stands for itself, and so does the riser of a step, which is part of one. A face between walls of one side (fillet, chamfer, boss wall) stands for all of them. A face between opposing
/// walls is lateral and stands for none: there the mid-surface ends. Cost: linear in the arcs.
pub fn roles(aag: &Aag, pairing: &Pairing) -> FaceRoles {
    let faces = aag.area.len();
    let mut carries: IndexVec<FaceId, Labels> = pairing
        .side
        .enumerated()
        .map(|(f, side)| {
            if side.is_some() {
                Labels::from_slice(&[f])
            } else {
                Labels::new()
            }
        })
        .collect();
    let mut role: IndexVec<FaceId, Role> = pairing
        .side
        .iter()
        .map(|s| {
            if s.is_some() {
                Role::WallSide
            } else {
                Role::Lump
            }
        })
        .collect();
    for _ in 0..ROUNDS {
        let before = carries.clone();
        for f in (0..faces as u32).map(FaceId) {
            if !before[f].is_empty() {
                continue;
            }
            let mut around: Labels = aag
                .arcs_of(f)
                .flat_map(|arc| before[Aag::across(arc, f)].iter().copied())
                .collect();
            around.sort_unstable();
            around.dedup();
            if around.is_empty() {
                continue;
            }
            let opposed = around
                .iter()
                .any(|&a| around.iter().any(|&b| pairing.opposing(a, b)));
            role[f] = if opposed { Role::Lateral } else { Role::Blend };
            if !opposed {
                carries[f] = around;
            }
        }
    }
    FaceRoles { role, carries }
}

#[cfg(test)]
mod tests;
