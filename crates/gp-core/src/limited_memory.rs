//! The inverse Hessian from the last few steps, for functions of many variables.

use std::collections::VecDeque;

use crate::vector::{add_multiple, dot};

/// The last steps s with their changes of gradient t; H follows from them by the BFGS formula from a
/// multiple of the identity. 16 bytes a variable and step.
///
/// # Source
/// Nocedal & Wright, Numerical Optimization (2006), algorithm 7.4 (L-BFGS).
#[derive(Default)]
pub(crate) struct LimitedMemory {
    pairs: VecDeque<Pair>,
}

struct Pair {
    step: Vec<f64>,
    change: Vec<f64>,
    /// sᵀt, positive.
    along: f64,
}

/// Steps that are remembered.
const N_PAIRS: usize = 20;

impl LimitedMemory {
    pub(crate) fn is_fresh(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Takes in a step along which the gradient changed, with sᵀt = `along` positive.
    pub(crate) fn update(&mut self, step: Vec<f64>, change: Vec<f64>, along: f64) {
        if self.pairs.len() == N_PAIRS {
            self.pairs.pop_front();
        }
        self.pairs.push_back(Pair { step, change, along });
    }

    /// −H g.
    pub(crate) fn direction(&self, gradient: &[f64]) -> Vec<f64> {
        let mut direction: Vec<f64> = gradient.iter().map(|slope| -slope).collect();
        let mut shares = Vec::with_capacity(self.pairs.len());
        for Pair { step, change, along } in self.pairs.iter().rev() {
            let share = dot(step, &direction) / along;
            add_multiple(&mut direction, -share, change);
            shares.push(share);
        }
        if let Some(Pair { change, along, .. }) = self.pairs.back() {
            let scale = along / dot(change, change);
            direction.iter_mut().for_each(|entry| *entry *= scale);
        }
        for (Pair { step, change, along }, share) in self.pairs.iter().zip(shares.iter().rev()) {
            let back = dot(change, &direction) / along;
            add_multiple(&mut direction, share - back, step);
        }
        direction
    }
}
