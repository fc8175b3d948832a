//! Two numbers over time, in the order of their stamps.

use nalgebra::Vector2;

use crate::curves::sample::quantile;

/// Samples of a stream: positions in m, or forces in N, as recorded.
#[derive(Clone, Debug, Default)]
pub(super) struct Track {
    /// Times, in s as recorded, never falling.
    pub(super) t: Vec<f64>,
    values: Vec<Vector2<f64>>,
    /// Sums of the values up to each.
    sums: Vec<Vector2<f64>>,
}

impl Track {
    /// The finite samples, sorted.
    pub(super) fn new(t: &[f64], x: &[f64], y: &[f64]) -> Self {
        let samples = t.iter().zip(x.iter().zip(y)).map(|(t, (x, y))| (*t, Vector2::new(*x, *y)));
        let is_finite = |(t, value): &(f64, Vector2<f64>)| {
            t.is_finite() && value.iter().all(|value| value.is_finite())
        };
        let mut samples: Vec<_> = samples.filter(is_finite).collect();
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut sum = Vector2::zeros();
        let sums = samples.iter().map(|(_, value)| {
            sum += value;
            sum
        });
        let sums = sums.collect();
        let (t, values) = samples.into_iter().unzip();
        Self { t, values, sums }
    }

    /// First and last stamp, in s; none without samples.
    pub(super) fn span(&self) -> Option<[f64; 2]> {
        Some([*self.t.first()?, *self.t.last()?])
    }

    /// The value on a line between the neighbours of a time; none outside of them.
    pub(super) fn at(&self, t: f64) -> Option<Vector2<f64>> {
        let after = self.t.partition_point(|known| *known <= t);
        let before = after.checked_sub(1)?;
        let (a, b) = (self.t[before], *self.t.get(after)?);
        let share = (t - a) / (b - a);
        Some(self.values[before].lerp(&self.values[after], share))
    }

    /// Number and sum of the samples in [from, to].
    pub(super) fn sum(&self, [from, to]: [f64; 2]) -> (usize, Vector2<f64>) {
        let first = self.t.partition_point(|t| *t < from);
        let last = self.t.partition_point(|t| *t <= to).max(first);
        let before = |n: usize| n.checked_sub(1).map_or_else(Vector2::zeros, |i| self.sums[i]);
        (last - first, before(last) - before(first))
    }

    /// Mean of the samples in intervals; none without samples.
    pub(super) fn mean(&self, intervals: impl Iterator<Item = [f64; 2]>) -> Option<Vector2<f64>> {
        let add = |(n, sum): (usize, Vector2<f64>), interval| {
            let (more, of_it) = self.sum(interval);
            (n + more, sum + of_it)
        };
        let (n, sum) = intervals.fold((0, Vector2::zeros()), add);
        (n > 0).then(|| sum / n as f64)
    }

    /// The time at which the last motion ends: that is slower than a share of the fast ones' before.
    pub(super) fn stop(&self) -> Option<f64> {
        const MOVING: f64 = 0.3;
        let stride = self.t.len().div_ceil(400).max(1);
        let marks: Vec<usize> = (0..self.t.len()).step_by(stride).collect();
        let way = |pair: &[usize]| (self.values[pair[1]] - self.values[pair[0]]).norm();
        let ways: Vec<f64> = marks.windows(2).map(way).collect();
        let long = quantile(ways.clone(), 0.9)?;
        let last = ways.iter().rposition(|way| *way > MOVING * long && *way > 0.0)?;
        Some(self.t[marks[last + 1]])
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::Track;

    #[test]
    fn samples_are_sorted_and_looked_up() {
        let track = Track::new(&[2.0, 0.0, 1.0, f64::NAN], &[4.0, 0.0, 2.0, 1.0], &[0.0; 4]);
        assert_eq!(track.span(), Some([0.0, 2.0]));
        assert_eq!(track.at(0.5), Some(Vector2::new(1.0, 0.0)));
        assert_eq!((track.at(-0.1), track.at(2.1)), (None, None));
        assert_eq!(track.mean([[0.5, 2.0]].into_iter()), Some(Vector2::new(3.0, 0.0)));
        assert_eq!(track.mean([[0.1, 0.2]].into_iter()), None);
        assert_eq!(track.stop(), Some(2.0));
        assert_eq!(Track::default().mean([[0.0, 1.0]].into_iter()), None);
    }
}
