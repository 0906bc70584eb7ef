//! Role: what every face is to the walls, and for which wall faces it stands.

use crate::model::decomposition::{FaceRoles, Labels};
use crate::model::ids::{FaceId, IndexVec};
use crate::model::walls::{Aag, Arc, Pairing, Role};

/// Fillets lie beside fillets: labels travel this many faces far from a wall. A blend between three walls has its neighbours at two.
const ROUNDS: usize = 3;
/// Faces that meet at a sharper inner corner than this butt against each other; a chamfer turns from both of its neighbours by 45 degrees.
const BUTTS_RAD: f64 = std::f64::consts::FRAC_PI_3;

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
            let opposed = |labels: &Labels| {
                labels
                    .iter()
                    .any(|&a| labels.iter().any(|&b| pairing.opposing(a, b)))
            };
            let mut around = carried(aag, &before, f, |_| true);
            let mut is_lateral = opposed(&around);
            if is_lateral {
                // A rib that butts against the face does not end at it; both its sides meet it in a corner.
                let flush = carried(aag, &before, f, |a| a.turn_rad > -BUTTS_RAD);
                if !flush.is_empty() && !opposed(&flush) {
                    (around, is_lateral) = (flush, false);
                }
            }
            if around.is_empty() {
                continue;
            }
            role[f] = if is_lateral {
                Role::Lateral
            } else {
                Role::Blend
            };
            if !is_lateral {
                carries[f] = around;
            }
        }
    }
    FaceRoles { role, carries }
}

/// The labels that the neighbours over the wanted arcs stand for, sorted.
fn carried(
    aag: &Aag,
    carries: &IndexVec<FaceId, Labels>,
    f: FaceId,
    wanted: impl Fn(&Arc) -> bool,
) -> Labels {
    let mut labels: Labels = aag
        .arcs_of(f)
        .filter(|a| wanted(a))
        .flat_map(|a| carries[Aag::across(a, f)].iter().copied())
        .collect();
    labels.sort_unstable();
    labels.dedup();
    labels
}

#[cfg(test)]
mod tests;
