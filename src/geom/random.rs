//! A small seeded generator of pseudo-random numbers, so that samples are the same on every machine and in every run.
//!
//! PCG-XSH-RR with 64 bits of state (O'Neill, "PCG: a family of simple fast space-efficient statistically good algorithms for
//! random number generation", Harvey Mudd College HMC-CS-2014-0905, 2014). Not for cryptography.

/// The generator.
#[derive(Clone, Debug)]
pub struct Pcg {
    state: u64,
}

impl Pcg {
    const MULTIPLIER: u64 = 6_364_136_223_846_793_005;
    const INCREMENT: u64 = 1_442_695_040_888_963_407;

    /// A generator; equal seeds give equal numbers.
    pub fn new(seed: u64) -> Self {
        let mut new = Self {
            state: seed.wrapping_add(Self::INCREMENT),
        };
        new.bits();
        new
    }

    /// 32 random bits.
    #[inline]
    pub fn bits(&mut self) -> u32 {
        let old = self.state;
        self.state = old
            .wrapping_mul(Self::MULTIPLIER)
            .wrapping_add(Self::INCREMENT);
        let mixed = (((old >> 18) ^ old) >> 27) as u32;
        mixed.rotate_right((old >> 59) as u32)
    }

    /// A number in `[0, 1)`, in steps of 2^-53.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        let (high, low) = (u64::from(self.bits()) >> 5, u64::from(self.bits()) >> 6);
        ((high << 26) | low) as f64 / (1u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_even_and_repeat_only_with_the_seed() {
        let mut rng = Pcg::new(5);
        let mut bins = [0; 10];
        for _ in 0..10_000 {
            let x = rng.unit();
            assert!((0.0..1.0).contains(&x));
            bins[(x * 10.0) as usize] += 1;
        }
        assert!(bins.iter().all(|&n| (850..1150).contains(&n)), "{bins:?}");
        assert_eq!(Pcg::new(5).bits(), Pcg::new(5).bits());
        assert_ne!(Pcg::new(5).bits(), Pcg::new(6).bits());
    }
}
