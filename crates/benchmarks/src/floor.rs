//! What the arithmetic of a task costs at the rate of the matrix product.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

/// A product of two square matrices with a given number of operations, half of them multiplications.
pub(super) struct Floor {
    left: Mat<f64>,
    right: Mat<f64>,
    product: Mat<f64>,
    parallelism: Par,
}

impl Floor {
    /// 2 S³ operations, as near as an integer S comes.
    pub(super) fn new(operations: f64, threads: usize) -> Self {
        let size = (0.5 * operations).cbrt().round() as usize;
        let value = |i: usize, j: usize| 1.0 / (1.0 + (i + 2 * j) as f64);
        let (left, right) = (Mat::from_fn(size, size, value), Mat::from_fn(size, size, value));
        let parallelism = if threads == 1 { Par::Seq } else { Par::rayon(threads) };
        Self { left, right, product: Mat::zeros(size, size), parallelism }
    }

    /// Multiplies so many times; returns one entry, so that the work is not left out.
    pub(super) fn multiply(&mut self, times: usize) -> f64 {
        for _ in 0..times {
            let Self { left, right, product, parallelism } = self;
            matmul(product.as_mut(), Accum::Replace, &*left, &*right, 1.0, *parallelism);
        }
        self.product[(0, 0)]
    }
}

#[cfg(test)]
mod tests {
    use super::Floor;

    #[test]
    fn the_floor_multiplies() {
        let mut floor = Floor::new(16.0, 1);
        let expected = 1.0 + 1.0 / 3.0 * 0.5;
        assert!((floor.multiply(2) - expected).abs() < 1e-15);
    }
}
