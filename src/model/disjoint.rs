//! Disjoint sets of the numbers below a count: which things hang together.

/// Disjoint sets; the lowest member stands for its set, so that results do not depend on the order of joining.
///
/// Reference: R. E. Tarjan, J. van Leeuwen, Worst-case analysis of set union algorithms, JACM 31 (1984), doi:10.1145/62.2160 (path halving).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Disjoint {
    root: Vec<u32>,
}

impl Disjoint {
    /// Every number a set of its own.
    pub fn new(count: usize) -> Self {
        Self {
            root: (0..count as u32).collect(),
        }
    }

    /// The lowest member of the set of `x`.
    pub fn find(&mut self, mut x: u32) -> u32 {
        while self.root[x as usize] != x {
            self.root[x as usize] = self.root[self.root[x as usize] as usize];
            x = self.root[x as usize];
        }
        x
    }

    /// Makes one set of those of `a` and `b`.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.root[a.max(b) as usize] = a.min(b);
    }

    /// Number of sets.
    pub fn sets(&self) -> usize {
        (0..self.root.len())
            .filter(|&i| self.root[i] == i as u32)
            .count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_member_stands_for_a_set_whatever_the_order() {
        let links = [(4, 2), (5, 4), (1, 0)];
        for turn in 0..links.len() {
            let mut sets = Disjoint::new(6);
            for k in 0..links.len() {
                let (a, b) = links[(k + turn) % links.len()];
                sets.join(a, b);
            }
            let found: Vec<u32> = (0..6).map(|x| sets.find(x)).collect();
            assert_eq!(found, [0, 0, 2, 3, 2, 2]);
            assert_eq!(sets.sets(), 3);
        }
    }
}
