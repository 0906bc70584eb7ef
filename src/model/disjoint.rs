//! Disjoint sets of the numbers below a count: which things hang together, and which way round.

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

/// Disjoint sets of things with two sides, each of which lies in its set one way round or the other, such as pairs of faces that make up walls.
///
/// Every side carries members (faces); a join that would put one member on both sides of a set is refused, and so is one of sets that are to be kept apart. The lowest number stands for its set and lies in it
/// unturned, so that the sides do not depend on the order of joins that all succeed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SidedDisjoint<T> {
    root: Vec<u32>,
    /// For each number whether it lies the other way round than its root.
    turned: Vec<bool>,
    /// Members of both sides, ascending; kept at the number that stands for the set.
    sides: Vec<[Vec<T>; 2]>,
    /// Numbers whose sets the set may not be joined with; kept there too.
    apart: Vec<Vec<u32>>,
}

impl<T: Copy + Ord> SidedDisjoint<T> {
    /// Every number a set of its own, with these members on its two sides.
    pub fn new(sides: impl IntoIterator<Item = [Vec<T>; 2]>) -> Self {
        let sides: Vec<[Vec<T>; 2]> = sides.into_iter().map(|both| both.map(ascending)).collect();
        Self {
            root: (0..sides.len() as u32).collect(),
            turned: vec![false; sides.len()],
            apart: vec![Vec::new(); sides.len()],
            sides,
        }
    }

    /// Refuses every join from now on that would make one set of those of `a` and `b`.
    pub fn keep_apart(&mut self, a: u32, b: u32) {
        let [a, b] = [a, b].map(|x| self.find(x).0);
        self.apart[a as usize].push(b);
        self.apart[b as usize].push(a);
    }

    /// The lowest number of the set of `x`, and whether `x` lies the other way round than it.
    pub fn find(&mut self, mut x: u32) -> (u32, bool) {
        let mut turned = false;
        while self.root[x as usize] != x {
            let above = self.root[x as usize] as usize;
            // A number that stands for its set is never turned, so this holds at the top too.
            self.turned[x as usize] ^= self.turned[above];
            self.root[x as usize] = self.root[above];
            turned ^= self.turned[x as usize];
            x = self.root[x as usize];
        }
        (x, turned)
    }

    /// Makes one set of those of `a` and `b`, `b` the other way round than `a` if `turned`. `false` if that would put a member on both sides, if they are to be kept
    /// apart, or if they are one set in which they lie differently: then nothing changes.
    pub fn join(&mut self, a: u32, b: u32, turned: bool) -> bool {
        let ((a, s), (b, t)) = (self.find(a), self.find(b));
        let turn = turned ^ s ^ t;
        if a == b {
            return !turn;
        }
        let [keep, gone] = [a.min(b), a.max(b)].map(|x| x as usize);
        // The side of `keep` on which side `k` of `gone` comes to lie.
        let onto = |k: usize| usize::from((k == 1) ^ turn);
        let on_both_sides = (0..2).any(|k| {
            let across = &self.sides[keep][1 - onto(k)];
            self.sides[gone][k]
                .iter()
                .any(|member| across.binary_search(member).is_ok())
        });
        let foes = std::mem::take(&mut self.apart[gone]);
        if on_both_sides || foes.iter().any(|&x| self.find(x).0 == keep as u32) {
            self.apart[gone] = foes;
            return false;
        }
        self.apart[keep].extend(foes);
        self.root[gone] = keep as u32;
        self.turned[gone] = turn;
        for (k, mut members) in std::mem::take(&mut self.sides[gone])
            .into_iter()
            .enumerate()
        {
            let side = &mut self.sides[keep][onto(k)];
            members.append(side);
            *side = ascending(members);
        }
        true
    }

    /// Members of both sides of the set of `x`, ascending, as its lowest number lies.
    pub fn sides(&mut self, x: u32) -> &[Vec<T>; 2] {
        let root = self.find(x).0;
        &self.sides[root as usize]
    }
}

fn ascending<T: Ord>(mut members: Vec<T>) -> Vec<T> {
    members.sort_unstable();
    members.dedup();
    members
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

    /// Four things with one member on either side: 0 between 1 and 2, and so on.
    fn four() -> SidedDisjoint<u32> {
        SidedDisjoint::new([[1, 2], [3, 2], [3, 4], [6, 5]].map(|both| both.map(|m| vec![m])))
    }

    #[test]
    fn turns_add_up_along_a_chain_whatever_the_order() {
        let links = [(0, 1, false), (2, 1, false), (3, 2, true)];
        for turn in 0..links.len() {
            let mut sets = four();
            for k in 0..links.len() {
                let (a, b, turned) = links[(k + turn) % links.len()];
                assert!(sets.join(a, b, turned));
            }
            let found: Vec<_> = (0..4).map(|x| sets.find(x)).collect();
            assert_eq!(found, [(0, false), (0, false), (0, false), (0, true)]);
            assert_eq!(*sets.sides(3), [vec![1, 3, 5], vec![2, 4, 6]]);
        }
    }

    #[test]
    fn long_chains_keep_their_turns_while_paths_are_halved() {
        let mut sets = SidedDisjoint::<u32>::new((0..64).map(|_| [vec![], vec![]]));
        for x in (1..64).rev() {
            assert!(sets.join(x, x - 1, x % 3 == 0));
        }
        let mut turned = false;
        for x in 0..64 {
            turned ^= x % 3 == 0 && x > 0;
            assert_eq!(sets.find(x), (0, turned), "{x}");
            assert_eq!(sets.find(x), (0, turned), "{x}, again");
        }
    }

    #[test]
    fn a_member_never_comes_to_lie_on_both_sides() {
        let mut sets = four();
        // The other way round, 2 would be on both sides of 0 and 1.
        assert!(!sets.join(0, 1, true));
        assert_eq!(sets, four());
        assert!(sets.join(0, 1, false));
        // Already one set: true only for the way they lie.
        assert!(sets.join(1, 0, false));
        assert!(!sets.join(1, 0, true));
        // 3 is on the first side of 0 and 1 by now.
        assert!(!sets.join(2, 0, true));
        assert_eq!(sets.find(2), (2, false));
    }

    #[test]
    fn what_is_kept_apart_is_not_joined_by_others_either() {
        // 0 - 1 - 2 - 3 in a row: whichever joint comes last is refused.
        let links = [(0, 1), (1, 2), (2, 3)];
        for last in 0..3 {
            let mut sets = SidedDisjoint::new((0..4).map(|i| [vec![i], vec![10 + i]]));
            sets.keep_apart(3, 0);
            for (k, &(a, b)) in links.iter().enumerate().filter(|l| l.0 != last) {
                assert!(sets.join(a, b, k == 1));
            }
            let (a, b) = links[last];
            let before = sets.clone();
            assert!(!sets.join(a, b, false));
            assert_eq!(
                (0..4).map(|x| sets.find(x)).collect::<Vec<_>>(),
                (0..4).map(|x| before.clone().find(x)).collect::<Vec<_>>()
            );
            assert_ne!(sets.find(0).0, sets.find(3).0);
        }
    }
}
