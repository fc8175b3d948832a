//! Points that fill a cube more evenly than chance.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Roberts' additive recurrence in [0, 1)ⁿ, shifted at random by a seed.
///
/// frac(shift_j + index·g^−j) with g the positive root of gⁿ⁺¹ = g + 1.
///
/// # Source
/// Roberts, The unreasonable effectiveness of quasirandom sequences (2018); Cranley & Patterson (1976)
/// for the shift.
#[derive(Clone, Debug)]
pub struct LowDiscrepancy {
    generator: f64,
    shifts: Vec<f64>,
}

impl LowDiscrepancy {
    /// The points of `n` coordinates with the shift of a seed.
    pub fn new(n: usize, seed: u64) -> Self {
        let generator = (0..64).fold(2.0_f64, |g, _| (1.0 + g).powf(1.0 / (n as f64 + 1.0)));
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        Self { generator, shifts: (0..n).map(|_| rng.random()).collect() }
    }

    /// The point with a number.
    pub fn point(&self, index: usize) -> Vec<f64> {
        let coordinate =
            |(j, shift): (i32, &f64)| (shift + index as f64 * self.generator.powi(-j)).fract();
        (1..).zip(&self.shifts).map(coordinate).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::LowDiscrepancy;

    #[test]
    fn points_fill_the_plane_more_evenly_than_chance() {
        let (mut cells, points) = ([0; 16], LowDiscrepancy::new(2, 5));
        for index in 1..=64 {
            let point = points.point(index);
            cells[(point[0] * 4.0) as usize * 4 + (point[1] * 4.0) as usize] += 1;
        }
        assert!(cells.iter().all(|&count| (2..=6).contains(&count)), "{cells:?}");
    }

    #[test]
    fn the_seed_moves_the_points() {
        let point = |seed: u64| LowDiscrepancy::new(3, seed).point(1);
        assert_ne!(point(1), point(2));
        assert_eq!(point(1), point(1));
    }
}
