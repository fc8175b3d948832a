//! Where a sub-step ends early.

use crate::predict::forward::{Forward, SHORTEST};

impl Forward<'_> {
    /// In how many s, of less than `length`, the pusher's velocity jumps; none if it does not.
    pub(crate) fn kink_within(&self, length: f64) -> Option<f64> {
        let seen = self.time - self.measurement.latency;
        Some(self.step.track.kink_after(seen)? - seen).filter(|kink| *kink < length)
    }

    /// At most `length`, in s, up to where the pusher turns towards the contact or back from it.
    pub(crate) fn until_turn(&self, length: f64) -> f64 {
        let normal_w = self.pose_wo.rotate(&self.now.contact.normal);
        let leaves = |after: f64| normal_w.dot(&self.pusher(self.time + after).1) <= 0.0;
        let (is_leaving, mut low, mut high) = (leaves(0.0), 0.0, length);
        if is_leaving == leaves(length) {
            return length;
        }
        while high - low > SHORTEST * length {
            let middle = 0.5 * (low + high);
            if leaves(middle) == is_leaving { low = middle } else { high = middle }
        }
        high
    }
}
