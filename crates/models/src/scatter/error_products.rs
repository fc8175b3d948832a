//! What the products of a push's errors say of the parts that they are made of.

use nalgebra::{Matrix3, Vector3};

use crate::scatter::push_errors::PushErrors;

/// Sums over the pairs of a push's whitened errors, lag by lag.
#[derive(Clone, Debug)]
pub(crate) struct ErrorProducts {
    /// Of errors 0, 1, 2, … steps apart.
    of_lags: Vec<Lag>,
    /// Mean way of the pusher in a step, in m.
    way: f64,
}

#[derive(Clone, Copy, Debug)]
struct Lag {
    /// Sum of the products, of Δx, Δy and Δθ.
    products: Vector3<f64>,
    /// What a unit of variance of each output (column) adds to the products of each (row): A ∘ A'
    /// summed, with A and A' of the two steps; as many as there are pairs, where all directions are free.
    responses: Matrix3<f64>,
}

/// Parts of the errors' variance, of Δx, Δy and Δθ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shares {
    pub(crate) held: Vector3<f64>,
    pub(crate) own: Vector3<f64>,
    pub(crate) measured: Vector3<f64>,
    /// Over which what is held falls to 1/e, in m.
    pub(crate) length: f64,
}

/// Lengths that are tried: from a step, below which all is each step's own, to so many times the longest
/// push, where what is held stays the same.
const LONGEST: f64 = 100.0;
const N_LENGTHS: usize = 161;

/// A least-squares problem of three parts for each of the three outputs: its blocks of rows and columns
/// are of the parts, in each of them those of the outputs.
struct Normal {
    matrix: [[Matrix3<f64>; 3]; 3],
    right: [Vector3<f64>; 3],
}

/// Sweeps over the outputs.
const N_SWEEPS: usize = 60;

impl ErrorProducts {
    pub(crate) fn of(push: &PushErrors) -> Self {
        let PushErrors { errors, free, drawn, way } = push;
        let products = |lag: usize| -> Vector3<f64> {
            errors.iter().zip(&errors[lag..]).map(|(a, b)| a.component_mul(b)).sum()
        };
        let of_lag = |lag: usize| Lag {
            products: products(lag) + drawn.products(lag),
            responses: free.iter().zip(&free[lag..]).map(|(a, b)| a.component_mul(b)).sum(),
        };
        Self { of_lags: (0..errors.len()).map(of_lag).collect(), way: *way }
    }
}

impl Shares {
    /// The parts, none negative, and the length, of least squares over all pairs of a push's errors:
    /// E z_k z_lᵀ = A_k (held · exp(−way from k to l / length) + own [k = l] + measured (2 [k = l] −
    /// [|k − l| = 1])) A_l.
    ///
    /// # Source
    /// Searle, Casella & McCulloch (1992), Variance Components, chapter 4 (estimators by mean
    /// products), here of a part that decays and of differences, too.
    pub(crate) fn of(pushes: &[ErrorProducts]) -> Self {
        let ways = pushes.iter().map(|push| push.way);
        let shortest = ways.fold(f64::INFINITY, f64::min);
        let whole = pushes.iter().map(|push| push.way * push.of_lags.len() as f64);
        let longest = LONGEST * whole.fold(0.0, f64::max);
        let tried = (0..N_LENGTHS).map(|k| {
            let length = shortest * (longest / shortest).powf(k as f64 / (N_LENGTHS - 1) as f64);
            let (parts, gained) = Normal::of(pushes, length).solved();
            (gained, length, parts)
        });
        let best = tried.max_by(|a, b| a.0.total_cmp(&b.0));
        let (_, length, parts) = best.unwrap_or((0.0, longest, [Vector3::zeros(); 3]));
        let [held, own, measured] = parts;
        Self { held, own, measured, length }
    }
}

impl Normal {
    fn of(pushes: &[ErrorProducts], length: f64) -> Self {
        let (mut matrix, mut right) = ([[Matrix3::zeros(); 3]; 3], [Vector3::zeros(); 3]);
        for push in pushes {
            let kept = (-push.way / length).exp();
            let mut held = 1.0;
            for (lag, Lag { products, responses }) in push.of_lags.iter().enumerate() {
                let parts = match lag {
                    0 => [held, 1.0, 2.0],
                    1 => [held, 0.0, -1.0],
                    _ => [held, 0.0, 0.0],
                };
                for (row, one) in parts.iter().enumerate() {
                    right[row] += *one * products;
                    for (column, other) in parts.iter().enumerate() {
                        matrix[row][column] += one * other * responses;
                    }
                }
                held *= kept;
            }
        }
        Self { matrix, right }
    }

    /// The parts, none negative, and by how much they lower the sum of squares: output by output, each
    /// exactly, until they agree.
    fn solved(&self) -> ([Vector3<f64>; 3], f64) {
        let mut parts = [Vector3::<f64>::zeros(); 3];
        for _ in 0..N_SWEEPS {
            for output in 0..3 {
                parts.iter_mut().for_each(|part| part[output] = 0.0);
                let others = self.times(&parts);
                let right = Vector3::from_fn(|k, _| self.right[k][output] - others[k][output]);
                let matrix = Matrix3::from_fn(|i, j| self.matrix[i][j][(output, output)]);
                let best = best_of_subsets(&matrix, &right);
                (0..3).for_each(|part| parts[part][output] = best[part]);
            }
        }
        let times = self.times(&parts);
        let gained = (0..3).map(|k| parts[k].dot(&(2.0 * self.right[k] - times[k]))).sum();
        (parts, gained)
    }

    fn times(&self, parts: &[Vector3<f64>; 3]) -> [Vector3<f64>; 3] {
        self.matrix.map(|row| row.iter().zip(parts).map(|(block, part)| block * part).sum())
    }
}

/// The best of the solutions in which a subset of the coefficients is not 0 and none negative.
fn best_of_subsets(matrix: &Matrix3<f64>, right: &Vector3<f64>) -> Vector3<f64> {
    let solved = |subset: u8| {
        let is_in = |k: usize| subset & (1 << k) != 0;
        let matrix = Matrix3::from_fn(|i, j| match (is_in(i) && is_in(j), i == j) {
            (true, _) => matrix[(i, j)],
            (false, is_diagonal) => f64::from(u8::from(is_diagonal)),
        });
        let right = Vector3::from_fn(|k, _| if is_in(k) { right[k] } else { 0.0 });
        let solution = matrix.cholesky()?.solve(&right);
        (solution.min() >= 0.0).then(|| (solution, solution.dot(&right)))
    };
    let all = (1..8).filter_map(solved).max_by(|a, b| a.1.total_cmp(&b.1));
    all.map_or(Vector3::zeros(), |(solution, _)| solution)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};
    use proptest::prelude::{ProptestConfig, Strategy, any, proptest};

    use super::{ErrorProducts, Lag, Normal, Shares};

    fn projection(turn: f64) -> Matrix3<f64> {
        let held = Vector3::new(turn.cos(), 0.3, turn.sin()).normalize();
        Matrix3::identity() - held * held.transpose()
    }

    /// Products as they are expected, exactly, of a push in which what contact holds turns or nothing is
    /// held.
    fn expected((way, n, held): (f64, usize, bool), truth: &Shares) -> ErrorProducts {
        let free = |k: usize| if held { projection(0.05 * k as f64) } else { Matrix3::identity() };
        let of_lag = |lag: usize| {
            let mut part = (-(lag as f64) * way / truth.length).exp() * truth.held;
            part += match lag {
                0 => truth.own + 2.0 * truth.measured,
                1 => -truth.measured,
                _ => Vector3::zeros(),
            };
            let part = Matrix3::from_diagonal(&part);
            Lag {
                products: (0..n - lag).map(|k| (free(k) * part * free(k + lag)).diagonal()).sum(),
                responses: (0..n - lag).map(|k| free(k).component_mul(&free(k + lag))).sum(),
            }
        };
        ErrorProducts { of_lags: (0..n).map(of_lag).collect(), way }
    }

    #[test]
    fn exact_products_of_pushes_with_steps_of_several_lengths_give_their_parts_back() {
        let truth = Shares {
            held: Vector3::new(0.5, 0.0, 2.0),
            own: Vector3::new(0.1, 1.0, 0.0),
            measured: Vector3::new(0.0, 0.2, 0.3),
            length: 0.01,
        };
        let pushes = [(0.004, 12, true), (0.002, 9, true), (0.003, 20, false)];
        let products: Vec<_> = pushes.iter().map(|push| expected(*push, &truth)).collect();
        // The length is as fine as those that are tried.
        let found = Shares::of(&products);
        assert!((found.length / truth.length).ln().abs() < 0.05, "{found:?}");
        let (parts, _) = Normal::of(&products, truth.length).solved();
        for (part, truth) in parts.iter().zip([truth.held, truth.own, truth.measured]) {
            assert!((part - truth).amax() < 1e-9, "{parts:?}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        #[test]
        fn no_part_is_negative_and_none_could_be_better(
            sums in proptest::array::uniform12(any::<u8>().prop_map(|x| f64::from(x) - 128.0)),
        ) {
            let lag = |(lag, sums): (usize, &[f64])| Lag {
                products: Vector3::from_column_slice(sums),
                responses: (0..4 - lag).map(|k| {
                    projection(0.3 * k as f64).component_mul(&projection(0.3 * (k + lag) as f64))
                }).sum(),
            };
            let of_lags = sums.chunks(3).enumerate().map(lag).collect();
            let normal = Normal::of(&[ErrorProducts { of_lags, way: 1.0 }], 2.0);
            let (parts, _) = normal.solved();
            // Karush, Kuhn and Tucker: no slope along a part, or an upward one where it is 0.
            let times = normal.times(&parts);
            for (k, part) in parts.iter().enumerate() {
                for (part, slope) in part.iter().zip((times[k] - normal.right[k]).iter()) {
                    assert!(*part >= 0.0 && *slope > -1e-6, "{part} {slope}");
                    assert!((part * slope).abs() < 1e-4, "{part} {slope}");
                }
            }
        }
    }
}
