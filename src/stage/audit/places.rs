//! Where a doubt arises: single findings gathered into places.

use crate::model::disjoint::Disjoint;
use crate::model::ids::{ElementId, NodeId};
use crate::model::report::Place;
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// Something that findings may share: those that share one hang together.
pub(super) type Key = [i64; 3];

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Finding {
    pub at: DVec3,
    /// How bad it is; 1 where there is no more and less.
    pub value: f64,
    /// Its area, length or number, by which places are ordered.
    pub weight: f64,
    /// Tags of the faces there; 0 for none.
    pub faces: Vec<i32>,
    pub elements: Vec<ElementId>,
    pub keys: Vec<Key>,
}

/// The key of a node.
pub(super) fn node_key(node: NodeId) -> Key {
    [i64::from(node.0), 0, 0]
}

/// Keys of a point such that points nearer than `reach` (along each axis) always share one, and points twice as far away never do. Nothing shares keys
/// with anything where there is no reach.
pub(super) fn near_keys(p: DVec3, reach: f64) -> Vec<Key> {
    let cell = p / reach;
    if !cell.is_finite() {
        return Vec::new();
    }
    // The corners of the cell of a grid that holds the point: cells that touch share corners.
    let [x, y, z] = cell.floor().to_array().map(|c| c as i64);
    (0..8)
        .map(|k| [x + (k & 1), y + (k >> 1 & 1), z + (k >> 2)])
        .collect()
}

/// The findings that hang together, greatest weight first, at most [`Place::MOST`]; and how many there are in all.
pub(super) fn gather(findings: &[Finding]) -> (Vec<Place>, usize) {
    let mut keyed: Vec<(Key, u32)> = findings
        .iter()
        .enumerate()
        .flat_map(|(i, f)| f.keys.iter().map(move |k| (*k, i as u32)))
        .collect();
    keyed.sort_unstable();
    let mut sets = Disjoint::new(findings.len());
    for pair in keyed.windows(2).filter(|w| w[0].0 == w[1].0) {
        sets.join(pair[0].1, pair[1].1);
    }
    let mut members: Vec<(u32, u32)> = (0..findings.len() as u32)
        .map(|i| (sets.find(i), i))
        .collect();
    members.sort_unstable();
    let mut groups: Vec<(f64, &[(u32, u32)])> = members
        .chunk_by(|a, b| a.0 == b.0)
        .map(|group| {
            let weights = group.iter().map(|m| findings[m.1 as usize].weight);
            (weights.sum(), group)
        })
        .collect();
    groups.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1[0].cmp(&b.1[0])));
    let places = groups.iter().take(Place::MOST);
    let places = places.map(|(_, group)| place(findings, group)).collect();
    (places, groups.len())
}

/// One group as a place.
fn place(findings: &[Finding], group: &[(u32, u32)]) -> Place {
    let mut order: Vec<&Finding> = group.iter().map(|m| &findings[m.1 as usize]).collect();
    order.sort_by(|a, b| b.value.total_cmp(&a.value));
    let at = order[0].at;
    let mut faces: BTreeMap<i32, usize> = BTreeMap::new();
    let mut elements: Vec<ElementId> = Vec::new();
    for finding in &order {
        for &tag in finding.faces.iter().filter(|tag| **tag != 0) {
            *faces.entry(tag).or_default() += 1;
        }
        for &element in &finding.elements {
            if elements.len() < Place::MOST && !elements.contains(&element) {
                elements.push(element);
            }
        }
    }
    // Those that most of it lies between.
    let mut faces: Vec<(i32, usize)> = faces.into_iter().collect();
    faces.sort_by_key(|(tag, times)| (Reverse(*times), *tag));
    let mut faces: Vec<i32> = faces.into_iter().take(Place::MOST).map(|f| f.0).collect();
    faces.sort_unstable();
    Place {
        at,
        reach: order.iter().map(|f| f.at.distance(at)).fold(0.0, f64::max),
        worst: order[0].value,
        count: group.len(),
        faces,
        elements,
    }
}

/// The findings of greatest weight: for lists of suspects, where the rest is likely to be sound.
pub(super) fn heaviest(mut findings: Vec<Finding>, most: usize) -> Vec<Finding> {
    findings.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    findings.truncate(most);
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(x: f64, value: f64, element: u32) -> Finding {
        Finding {
            at: DVec3::X * x,
            value,
            weight: 1.0,
            faces: vec![0, element as i32 + 1],
            elements: vec![ElementId(element)],
            keys: near_keys(DVec3::X * x, 1.0),
        }
    }

    #[test]
    fn what_is_near_is_one_place_and_the_largest_comes_first() {
        let mut findings = vec![finding(50.0, 9.0, 7)];
        findings.extend((0..20u32).map(|i| finding(0.9 * f64::from(i), f64::from(i % 7), i)));
        let (places, count) = gather(&findings);
        assert_eq!((places.len(), count), (2, 2));
        assert_eq!((places[0].count, places[0].worst), (20, 6.0));
        assert_eq!(places[0].at, DVec3::X * (0.9 * 6.0));
        assert!((places[0].reach - 0.9 * 13.0).abs() < 1e-9);
        assert_eq!(places[0].elements.len(), Place::MOST);
        assert_eq!(places[0].elements[..3], [6, 13, 5].map(ElementId));
        assert_eq!(places[1].faces, [8]);
    }

    #[test]
    fn only_so_many_places_are_told_and_the_rest_is_counted() {
        let findings: Vec<Finding> = (0..25)
            .map(|i| finding(5.0 * f64::from(i), 1.0, 0))
            .collect();
        let (places, count) = gather(&findings);
        assert_eq!((places.len(), count), (Place::MOST, 25));
        assert!(gather(&[]).0.is_empty());
        assert!(near_keys(DVec3::ONE, 0.0).is_empty());
    }

    #[test]
    fn the_heaviest_are_kept() {
        let mut findings: Vec<Finding> = (0..9).map(|i| finding(0.0, 1.0, i)).collect();
        for (i, f) in findings.iter_mut().enumerate() {
            f.weight = ((i * 4) % 9) as f64;
        }
        let weights: Vec<f64> = heaviest(findings, 3).iter().map(|f| f.weight).collect();
        assert_eq!(weights, [8.0, 7.0, 6.0]);
    }
}
