//! Which way the contact goes, as a function of where and how it is pushed.

/// Shares of classes over (p, β), read from a table.
#[derive(Clone, Debug)]
pub(crate) struct SlipGate {
    first: [f64; 2],
    spacing: [f64; 2],
    n_along: [usize; 2],
    n_classes: usize,
    /// Of each class at each node, p running slowest, the class fastest.
    shares: Vec<f64>,
}

/// Widths that are tried: of p, and of β in rad.
const WIDTHS: [f64; 4] = [0.02, 0.05, 0.1, 0.2];
/// Nodes a width.
const NODES: f64 = 6.0;
/// Farther from all training steps, in widths, there are the overall shares.
const REACH: f64 = 4.0;

impl SlipGate {
    /// Of (p, β) and the class of each training step, with the widths of the largest leave-one-out log
    /// probability. O(N²).
    pub(crate) fn learn(known: Vec<([f64; 2], usize)>, n_classes: usize) -> Self {
        Self::table(&Near::learn(known, n_classes))
    }

    fn table(near: &Near) -> Self {
        let axis = |axis: usize| {
            let values = || near.known.iter().map(|(place, _)| place[axis]);
            let reach = REACH * near.widths[axis];
            let low = values().fold(f64::INFINITY, f64::min) - reach;
            let high = values().fold(f64::NEG_INFINITY, f64::max) + reach;
            let spacing = near.widths[axis] / NODES;
            (low, spacing, ((high - low) / spacing).ceil() as usize + 1)
        };
        let [(p, dp, n_p), (beta, dbeta, n_beta)] = [axis(0), axis(1)];
        let n_classes = near.overall.len();
        let mut shares = near.overall.repeat(n_p * n_beta);
        for (place, class) in &near.known {
            let along = |axis: usize, first: f64, spacing: f64, n: usize| -> Vec<f64> {
                let off = |k: usize| (first + k as f64 * spacing - place[axis]) / near.widths[axis];
                (0..n).map(|k| (-0.5 * off(k) * off(k)).exp()).collect()
            };
            let (of_p, of_beta) = (along(0, p, dp, n_p), along(1, beta, dbeta, n_beta));
            let rows = shares.chunks_mut(n_beta * n_classes).zip(of_p);
            // A Gaussian that far is nothing beside one step's worth.
            for (row, of_p) in rows.filter(|(_, of_p)| *of_p > 1e-9) {
                let nodes = row.chunks_mut(n_classes).zip(&of_beta);
                nodes.for_each(|(node, of_beta)| node[*class] += of_p * of_beta);
            }
        }
        for node in shares.chunks_mut(n_classes) {
            let total: f64 = node.iter().sum();
            node.iter_mut().for_each(|share| *share /= total);
        }
        let (first, spacing, n_along) = ([p, beta], [dp, dbeta], [n_p, n_beta]);
        Self { first, spacing, n_along, n_classes, shares }
    }

    /// The share of each class at a place: they are not negative and sum to 1.
    pub(crate) fn shares(&self, place: [f64; 2]) -> Vec<f64> {
        let [(i, right), (j, above)] = [0, 1].map(|axis| {
            let last = (self.n_along[axis] - 1) as f64;
            let at = ((place[axis] - self.first[axis]) / self.spacing[axis]).clamp(0.0, last);
            let node = at.min(last - 1.0).floor();
            (node as usize, at - node)
        });
        let node = |i: usize, j: usize| {
            let start = (i * self.n_along[1] + j) * self.n_classes;
            &self.shares[start..start + self.n_classes]
        };
        let corners = [
            ((1.0 - right) * (1.0 - above), node(i, j)),
            ((1.0 - right) * above, node(i, j + 1)),
            (right * (1.0 - above), node(i + 1, j)),
            (right * above, node(i + 1, j + 1)),
        ];
        let share = |class: usize| corners.iter().map(|(part, node)| part * node[class]).sum();
        (0..self.n_classes).map(share).collect()
    }
}

/// Shares of classes among the training steps near a place: O(N) to ask.
#[derive(Clone, Debug)]
struct Near {
    /// (p, β) of each training step, and the index of its way.
    known: Vec<([f64; 2], usize)>,
    overall: Vec<f64>,
    widths: [f64; 2],
}

impl Near {
    /// With the widths of the largest leave-one-out log probability. O(N²).
    fn learn(known: Vec<([f64; 2], usize)>, n_classes: usize) -> Self {
        let n = known.len() as f64;
        let share = |class: usize| known.iter().filter(|(_, own)| *own == class).count() as f64 / n;
        let overall = (0..n_classes).map(share).collect();
        let mut gate = Self { known, overall, widths: [WIDTHS[0]; 2] };
        let pairs = WIDTHS.iter().flat_map(|p| WIDTHS.iter().map(move |beta| [*p, 2.0 * beta]));
        let score = |widths: [f64; 2]| {
            let tried = Self { widths, ..gate.clone() };
            let own = |(k, (place, class)): (usize, &([f64; 2], usize))| {
                tried.shares(*place, Some(k))[*class].ln()
            };
            tried.known.iter().enumerate().map(own).sum::<f64>()
        };
        let best = pairs.map(|widths| (score(widths), widths)).max_by(|a, b| a.0.total_cmp(&b.0));
        gate.widths = best.map_or(gate.widths, |(_, widths)| widths);
        gate
    }

    /// The share of each class at a place, without one of the known.
    fn shares(&self, [p, beta]: [f64; 2], without: Option<usize>) -> Vec<f64> {
        let mut sums = self.overall.clone();
        for (k, ([p_k, beta_k], class)) in self.known.iter().enumerate() {
            let off =
                ((p - p_k) / self.widths[0]).powi(2) + ((beta - beta_k) / self.widths[1]).powi(2);
            if Some(k) != without {
                sums[*class] += (-0.5 * off).exp();
            }
        }
        let total: f64 = sums.iter().sum();
        sums.iter().map(|sum| sum / total).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{Near, SlipGate};

    #[test]
    fn a_table_says_what_the_steps_near_by_do_and_far_away_what_all_do() {
        // Two ways that mix beyond p = 0.8, a third one at large β.
        let known = (0..400).map(|k| {
            let place = [(k as f64 * 0.618).fract(), (k as f64 * 0.414).fract() - 0.5];
            let class = match place {
                [_, beta] if beta > 0.3 => 2,
                [p, _] if p > 0.8 && k % 2 == 0 => 1,
                _ => 0,
            };
            (place, class)
        });
        let near = Near::learn(known.collect(), 3);
        let gate = SlipGate::table(&near);
        for k in 0..2000 {
            let place =
                [(k as f64 * 0.755).fract() * 1.4 - 0.2, (k as f64 * 0.57).fract() * 2.0 - 1.0];
            let (read, asked) = (gate.shares(place), near.shares(place, None));
            assert!((read.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            for (read, asked) in read.iter().zip(&asked) {
                assert!(*read >= 0.0 && (read - asked).abs() < 0.01, "{place:?} {read} {asked}");
            }
        }
        for (share, overall) in gate.shares([9.0, -9.0]).iter().zip(&near.overall) {
            assert!((share - overall).abs() < 0.02, "{share} {overall}");
        }
    }
}
