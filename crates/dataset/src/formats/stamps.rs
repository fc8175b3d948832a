//! The stamps of a stream as they come: how many, how often, and where the log was stopped.

/// A longer time without a sample is a pause: the log was stopped, in ns.
const PAUSE: i64 = 1_000_000_000;
/// A stream with fewer samples a pause is only slow.
const FEWEST: u64 = 10;

/// What is known of stamps that were seen, in ns.
#[derive(Clone, Copy, Default)]
pub(crate) struct Stamps {
    pub(crate) count: u64,
    /// First, last and most recent one.
    seen: Option<[i64; 3]>,
    n_pauses: u64,
    /// All pauses together, and the longest.
    paused: i64,
    longest: i64,
}

impl Stamps {
    pub(crate) fn add(&mut self, stamp: i64) {
        self.count += 1;
        let [first, last, before] = self.seen.unwrap_or([stamp; 3]);
        self.seen = Some([first.min(stamp), last.max(stamp), stamp]);
        let way = stamp.saturating_sub(before);
        if way > PAUSE {
            self.n_pauses += 1;
            self.paused = self.paused.saturating_add(way);
            self.longest = self.longest.max(way);
        }
    }

    /// How many pauses there are, and the longest in s; none of a stream that is only slow, which cannot tell.
    pub(crate) fn pauses(&self) -> Option<(u64, f64)> {
        let can_tell = FEWEST * (self.n_pauses + 1) <= self.count;
        can_tell.then(|| (self.n_pauses, seconds(self.longest)))
    }

    /// Mean rate apart from the pauses, in Hz; none for fewer than two stamps.
    pub(crate) fn rate_hz(&self) -> Option<f64> {
        let [first, last, _] = self.seen?;
        let (n_pauses, paused) = match self.pauses() {
            Some((n_pauses, _)) => (n_pauses, self.paused),
            None => (0, 0),
        };
        let span = seconds(last.saturating_sub(first).saturating_sub(paused));
        (self.count > 1 && span > 0.0).then(|| (self.count - 1 - n_pauses) as f64 / span)
    }
}

fn seconds(time: i64) -> f64 {
    time as f64 / 1e9
}

#[cfg(test)]
mod tests {
    use super::Stamps;

    fn of(stamps: impl IntoIterator<Item = i64>) -> Stamps {
        let mut seen = Stamps::default();
        stamps.into_iter().for_each(|stamp| seen.add(stamp));
        seen
    }

    #[test]
    fn pauses_are_counted_and_leave_the_rate_as_it_is() {
        let part = |start: i64| (0..50).map(move |k| start + 10_000_000 * k);
        let one = of(part(0));
        let all = of([0, 5_000_000_000, 9_000_000_000].into_iter().flat_map(part));
        assert_eq!((one.pauses(), all.pauses()), (Some((0, 0.0)), Some((2, 4.51))));
        assert!((all.rate_hz().unwrap() - one.rate_hz().unwrap()).abs() < 1e-9);
        let slow = of((0..9).map(|k| 2_000_000_000 * k));
        assert_eq!((slow.pauses(), slow.rate_hz()), (None, Some(0.5)));
        assert_eq!((of([7]).rate_hz(), of([7, 7]).rate_hz(), of([]).count), (None, None, 0));
    }
}
