//! Sets modulo two: which curves get one edge more or less, so that every sheet is even.

use std::collections::BTreeMap;

/// Those that are there an odd number of times, sorted.
pub(super) fn odd_ones(mut all: Vec<u32>) -> Vec<u32> {
    all.sort_unstable();
    (all.chunk_by(|a, b| a == b))
        .filter(|run| run.len() % 2 == 1)
        .map(|run| run[0])
        .collect()
}

/// Columns that add up to the target modulo two, or to as much of it as can be had; earlier columns are preferred.
pub(super) fn chosen(columns: &[Vec<u32>], mut target: Vec<u32>) -> Vec<usize> {
    // Each vector of the basis by its lowest row, with the columns that it is made of.
    let mut basis: BTreeMap<u32, (Vec<u32>, Vec<u32>)> = BTreeMap::new();
    for (i, column) in columns.iter().enumerate() {
        let (mut vector, mut made_of) = (column.clone(), vec![i as u32]);
        while let Some(&low) = vector.first() {
            match basis.get(&low) {
                Some((v, m)) => {
                    vector = sum(&vector, v);
                    made_of = sum(&made_of, m);
                }
                None => {
                    basis.insert(low, (vector, made_of));
                    break;
                }
            }
        }
    }
    let mut made_of = Vec::new();
    let mut left: Vec<u32> = Vec::new();
    while let Some(&low) = target.first() {
        match basis.get(&low) {
            Some((v, m)) => {
                target = sum(&target, v);
                made_of = sum(&made_of, m);
            }
            None => left.push(target.remove(0)),
        }
    }
    made_of.into_iter().map(|i| i as usize).collect()
}

/// The sum of two sorted sets modulo two.
fn sum(a: &[u32], b: &[u32]) -> Vec<u32> {
    odd_ones([a, b].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_add_up_to_the_target_where_they_can() {
        // Two sheets, both odd: a shared curve mends both at once.
        assert_eq!(chosen(&[vec![0, 1], vec![0]], vec![0, 1]), [0]);
        // Only the first is odd, and its own curve comes later.
        assert_eq!(chosen(&[vec![0, 1], vec![0]], vec![0]), [1]);
        assert_eq!(chosen(&[vec![0, 1], vec![0]], vec![1]), [0, 1]);
        // Nothing reaches sheet 2; the rest is mended.
        assert_eq!(chosen(&[vec![0]], vec![0, 2]), [0]);
    }
}
