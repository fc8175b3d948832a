//! A texture as heights at places.

use nalgebra::{Matrix2, Vector2};
use std::f64::consts::TAU;

use crate::dynamics::state::rotation;
use crate::random::{Purpose, Random};
use crate::truth::Texture;

/// Cells of a lattice along each axis; beyond, it is repeated, each one at another angle.
const N_CELLS: usize = 64;
/// Variance of what is read between lattice points over that at them, ∫(w² + (1 − w)²) squared.
const SMOOTHED: f64 = 0.783_549_783_549_783_5;

/// The part of a texture that a stream of random numbers is for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part {
    TableHeight = 0,
    TableFriction = 1,
    Underside = 2,
    Side = 3,
}

/// A smooth random field over a plane, a sum of lattices of numbers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Relief {
    octaves: Vec<Octave>,
}

#[derive(Clone, Debug)]
struct Octave {
    /// To cells, with the lattice's own turn and origin.
    to_cells: Matrix2<f64>,
    origin: Vector2<f64>,
    values: Vec<f64>,
}

impl Relief {
    pub(crate) fn new(texture: &Texture, seed: u64, part: Part) -> Self {
        if texture.sd == 0.0 {
            return Self::default();
        }
        let mut sizes = Vec::new();
        let (mut wavelength, mut share) = (texture.longest, 1.0);
        while sizes.is_empty() || wavelength > 0.99 * texture.shortest {
            sizes.push((wavelength, share));
            wavelength *= 0.5;
            share *= texture.persistence;
        }
        let squares: f64 = sizes.iter().map(|(_, share)| share * share).sum();
        let unit = texture.sd / (SMOOTHED * squares.sqrt());
        let octave = |(number, (wavelength, share)): (usize, &(f64, f64))| {
            let number = 64 * part as u64 + number as u64;
            let mut random = Random::new(seed, Purpose::Texture, number);
            let turn = rotation(random.uniform(0.0, TAU));
            let mut corner = || random.uniform(0.0, N_CELLS as f64);
            let origin = Vector2::new(corner(), corner());
            let values = (0..N_CELLS * N_CELLS).map(|_| random.normal(share * unit)).collect();
            // A hill and a hollow make a wave.
            Octave { to_cells: turn * (2.0 / wavelength), origin, values }
        };
        Self { octaves: sizes.iter().enumerate().map(octave).collect() }
    }

    /// Whether it is flat everywhere.
    pub(crate) fn is_flat(&self) -> bool {
        self.octaves.is_empty()
    }

    /// Its value at a place, in m.
    pub(crate) fn at(&self, place: &Vector2<f64>) -> f64 {
        self.octaves.iter().map(|octave| octave.at(place)).sum()
    }
}

impl Octave {
    fn at(&self, place: &Vector2<f64>) -> f64 {
        let cell = self.to_cells * place + self.origin;
        let corner = cell.map(f64::floor);
        let (i, j) = (index(corner.x), index(corner.y));
        let weight = (cell - corner).map(|u| u * u * u * (10.0 + u * (6.0 * u - 15.0)));
        let row = |j: usize| {
            let row = &self.values[N_CELLS * j..N_CELLS * (j + 1)];
            row[i] + weight.x * (row[(i + 1) % N_CELLS] - row[i])
        };
        let (low, high) = (row(j), row((j + 1) % N_CELLS));
        low + weight.y * (high - low)
    }
}

/// Place of a whole number in a lattice that is repeated.
fn index(whole: f64) -> usize {
    (whole as i64).rem_euclid(N_CELLS as i64) as usize
}

#[cfg(test)]
mod tests {
    use super::{Part, Relief};
    use crate::truth::Texture;
    use nalgebra::Vector2;

    const TEXTURE: Texture = Texture { sd: 2e-5, longest: 0.1, shortest: 0.005, persistence: 0.6 };

    fn at(relief: &Relief, k: usize, step: f64) -> f64 {
        relief.at(&Vector2::new(step * (k % 300) as f64, -step * (k / 300) as f64))
    }

    #[test]
    fn heights_scatter_as_stated_and_change_smoothly() {
        let relief = Relief::new(&TEXTURE, 7, Part::TableHeight);
        let heights: Vec<_> = (0..90_000).map(|k| at(&relief, k, 0.02)).collect();
        let sd = (heights.iter().map(|h| h * h).sum::<f64>() / 9e4).sqrt();
        assert!((sd / 2e-5 - 1.0).abs() < 0.1, "{sd}");
        // 10 µm further on, heights have changed by less than a hundredth of their scatter.
        for k in 0..2000 {
            let here = Vector2::new(1.7e-3 * k as f64, 0.3);
            let beyond = here + Vector2::new(6e-6, 8e-6);
            assert!((relief.at(&here) - relief.at(&beyond)).abs() < 2e-7);
        }
    }

    #[test]
    fn a_seed_gives_one_landscape_and_parts_differ() {
        let heights = |seed, part| at(&Relief::new(&TEXTURE, seed, part), 50, 0.01);
        assert_eq!(heights(7, Part::TableHeight), heights(7, Part::TableHeight));
        assert_ne!(heights(7, Part::TableHeight), heights(8, Part::TableHeight));
        assert_ne!(heights(7, Part::TableHeight), heights(7, Part::Underside));
        let flat = Relief::new(&Texture { sd: 0.0, ..TEXTURE }, 7, Part::TableHeight);
        assert!(flat.is_flat() && flat.at(&Vector2::new(0.1, 0.2)) == 0.0);
    }

    #[test]
    fn the_largest_hills_are_as_long_as_stated() {
        let one = Texture { longest: 0.1, shortest: 0.1, ..TEXTURE };
        let relief = Relief::new(&one, 7, Part::TableHeight);
        let product = |way: f64| {
            let pairs = (0..40_000).map(|k| {
                let here = Vector2::new(0.037 * (k % 200) as f64, 0.041 * (k / 200) as f64);
                relief.at(&here) * relief.at(&(here + Vector2::new(way, 0.0)))
            });
            pairs.sum::<f64>() / 4e4
        };
        // A lattice point further, half of a wave, nothing is left in common.
        assert!(product(0.1) / product(0.0) < 0.1, "{}", product(0.1) / product(0.0));
        assert!(product(0.01) / product(0.0) > 0.9);
    }
}
