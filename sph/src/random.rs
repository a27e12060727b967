//! Numbers that look random and are the same in every run and version.

/// The generator SplitMix64 (Steele, Lea & Flood 2014); its state is the seed.
#[derive(Clone, Debug)]
pub struct SplitMix64(pub u64);

impl SplitMix64 {
    /// What the state grows by.
    pub const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

    /// 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(Self::STEP);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }

    /// A number from −1 to 1, uniform, by the upper 53 bits.
    pub fn symmetric(&mut self) -> f64 {
        // Exact: 53 bits fit the mantissa.
        let fraction = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        2.0 * fraction - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_published_generator() {
        let mut numbers = SplitMix64(1_234_567);
        let expected = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        assert_eq!([(); 3].map(|()| numbers.bits()), expected);
        assert!((0..1000).all(|_| (-1.0..1.0).contains(&numbers.symmetric())));
    }
}
