//! How late messages reach the log after their own stamps.

use crate::remark::{Remark, RemarkKind, StreamRole};

/// A message is late that takes longer by this than the promptest of its stream, in ns.
///
/// The promptest stands for zero because sender and log may have clocks of their own.
const LATE: i64 = 50_000_000;

/// Delays of one stream's messages, from stamp to log, in ns.
#[derive(Default)]
pub(crate) struct Lateness {
    delays: Vec<i64>,
}

impl Lateness {
    /// Notes a message by its stamp and the time at which it was logged.
    pub(crate) fn note(&mut self, stamp: i64, log_time: i64) {
        self.delays.push(log_time.saturating_sub(stamp));
    }

    /// What to say of the stream, if messages are late.
    pub(crate) fn remark(&self, stream: StreamRole) -> Option<Remark> {
        let promptest = *self.delays.iter().min()?;
        let late = |delay: i64| delay.saturating_sub(promptest);
        let n_late = self.delays.iter().filter(|delay| late(**delay) > LATE).count();
        let latest = self.delays.iter().map(|delay| late(*delay)).max()?;
        (n_late > 0).then(|| Remark {
            kind: RemarkKind::Late,
            stream: Some(stream),
            count: n_late as u64,
            text: format!(
                "{n_late} of {} messages of the {stream} stream reach the log more than {} ms \
                 later than the promptest, at most {:.0} ms; their own stamps are used",
                self.delays.len(),
                LATE / 1_000_000,
                latest as f64 * 1e-6
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Lateness;
    use crate::remark::StreamRole;

    #[test]
    fn late_messages_are_counted_whatever_the_clocks_differ_by() {
        for offset in [0, 5_000_000_000, -5_000_000_000] {
            let mut lateness = Lateness::default();
            for (i, delay) in [3, 4, 53, 54, 873].into_iter().enumerate() {
                let stamp = 1_000_000_000 * i as i64;
                lateness.note(stamp, stamp + delay * 1_000_000 + offset);
            }
            let remark = lateness.remark(StreamRole::Object).unwrap();
            assert_eq!(remark.count, 2);
            assert!(
                remark.text.contains("2 of 5 messages of the object stream"),
                "{}",
                remark.text
            );
            assert!(remark.text.contains("at most 870 ms"), "{}", remark.text);
        }
    }

    #[test]
    fn prompt_messages_are_not_worth_a_remark() {
        let mut lateness = Lateness::default();
        assert_eq!(lateness.remark(StreamRole::Robot), None);
        lateness.note(0, 10_000_000);
        lateness.note(5, 60_000_005);
        assert_eq!(lateness.remark(StreamRole::Robot), None);
    }
}
