//! How often an effect is found, by its size.

use std::collections::BTreeMap;

use super::case::Family;
use super::record::Record;
use super::score::Score;
use super::wilson::Share;

/// Shares found, by multiples of the nameable size.
#[derive(Clone, Debug, Default)]
pub(super) struct Power(pub(super) BTreeMap<u64, Share>);

/// Multiples are kept in thousandths, which order and compare exactly.
const THOUSAND: f64 = 1000.0;
const POWER: f64 = 0.9;

impl Power {
    /// Of the trials of one effect, or of all.
    pub(super) fn of(records: &[Record], id: Option<&str>) -> Self {
        let mut power = BTreeMap::new();
        let singles = records.iter().filter(|record| record.family == Family::Single);
        for record in singles.filter(|record| id.is_none_or(|id| record.about == id)) {
            let Some(multiple) = record.multiple else { continue };
            let share = power.entry((multiple * THOUSAND).round() as u64);
            let share: &mut Share = share.or_insert(Share { hits: 0, of: 0 });
            share.hits += usize::from(Score::of(record).is_all_found());
            share.of += 1;
        }
        Self(power)
    }

    pub(super) fn at(&self, multiple: f64) -> Share {
        let known = self.0.get(&((multiple * THOUSAND).round() as u64));
        known.copied().unwrap_or(Share { hits: 0, of: 0 })
    }

    /// The multiple from which nine in ten are found, between measured sizes by the logarithm of
    /// the size; none if the largest finds fewer, the smallest size if it finds more.
    pub(super) fn nine_in_ten(&self) -> Option<f64> {
        let mut points: Vec<(f64, f64)> = Vec::new();
        for (multiple, share) in &self.0 {
            points.push((*multiple as f64 / THOUSAND, share.value()?));
        }
        // Shares that fall with the size are chance: each is at least the one before it.
        let mut least = 0.0_f64;
        for (_, share) in &mut points {
            least = least.max(*share);
            *share = least;
        }
        let above = points.iter().position(|(_, share)| *share >= POWER)?;
        let (size, share) = points[above];
        let Some((smaller, low)) = above.checked_sub(1).map(|k| points[k]) else {
            return Some(size);
        };
        let along = (POWER - low) / (share - low);
        Some((smaller.ln() + along * (size / smaller).ln()).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::{Power, Share};

    fn power(shares: &[(u64, usize)]) -> Option<f64> {
        let shares = shares.iter().map(|(size, hits)| (*size, Share { hits: *hits, of: 10 }));
        Power(shares.collect()).nine_in_ten()
    }

    #[test]
    fn nine_in_ten_lies_between_the_sizes_around_it() {
        assert_eq!(power(&[(1000, 9), (2000, 10)]), Some(1.0));
        let between = power(&[(500, 2), (1000, 8), (2000, 10)]).unwrap();
        assert!((between - 2_f64.sqrt()).abs() < 1e-12);
        assert_eq!(power(&[(1000, 5), (4000, 8)]), None);
        assert_eq!(power(&[]), None);
    }
}
