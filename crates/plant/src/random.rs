//! Random numbers that are the same on every machine.

use libm::{cos, log, sqrt};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha12Rng;
use std::f64::consts::TAU;

/// A stream of random numbers, given by a seed, a purpose and a number.
///
/// Streams of other purposes or numbers are independent, so that pushes may be made in any order.
pub(crate) struct Random(ChaCha12Rng);

/// What a stream is for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    Design = 1,
    Session = 2,
    Push = 3,
    Sensors = 4,
    Surprise = 5,
    Placing = 6,
    Texture = 7,
    Roughness = 8,
}

impl Random {
    pub(crate) fn new(seed: u64, purpose: Purpose, number: u64) -> Self {
        let mut generator = ChaCha12Rng::seed_from_u64(seed);
        generator.set_stream((purpose as u64) << 48 | number);
        Self(generator)
    }

    /// A number from `low` up to `high`.
    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// One of 0 to n − 1.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        self.0.random_range(0..n as u64) as usize
    }

    /// Whether something of a probability happens.
    pub(crate) fn happens(&mut self, probability: f64) -> bool {
        self.0.random::<f64>() < probability
    }

    /// −1 or 1.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.happens(0.5) { 1.0 } else { -1.0 }
    }

    /// A normal number of mean 0 and a standard deviation, by the method of Box and Muller.
    pub(crate) fn normal(&mut self, sd: f64) -> f64 {
        let (radius, angle) = (1.0 - self.0.random::<f64>(), self.0.random::<f64>());
        sd * sqrt(-2.0 * log(radius)) * cos(TAU * angle)
    }
}

#[cfg(test)]
mod tests {
    use super::{Purpose, Random};

    #[test]
    fn normal_numbers_have_their_moments() {
        let mut random = Random::new(7, Purpose::Push, 3);
        let numbers: Vec<_> = (0..100_000).map(|_| random.normal(2.0)).collect();
        let moment = |k: i32| numbers.iter().map(|x| x.powi(k)).sum::<f64>() / 1e5;
        // Four standard errors of each.
        assert!(moment(1).abs() < 0.026, "{}", moment(1));
        assert!((moment(2) - 4.0).abs() < 0.072, "{}", moment(2));
        assert!((moment(4) - 48.0).abs() < 6.0, "{}", moment(4));
    }

    #[test]
    fn streams_are_repeatable_and_differ() {
        let draw = |purpose, number| Random::new(7, purpose, number).uniform(0.0, 1.0);
        assert_eq!(draw(Purpose::Push, 3), draw(Purpose::Push, 3));
        assert_ne!(draw(Purpose::Push, 3), draw(Purpose::Push, 4));
        assert_ne!(draw(Purpose::Push, 3), draw(Purpose::Design, 3));
    }
}
