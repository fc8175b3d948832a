//! When a gap closes.

use crate::EffectError;

/// Gap at which pusher and object touch, in m.
pub(crate) const TOUCH: f64 = 1e-10;
/// Places at which a touch is looked for: a corner takes the most.
const MOST_TRIES: usize = 60;

/// When a gap closes that is positive, or not, at first and negative after `length` seconds.
///
/// # Source
/// Dowell & Jarratt (1971), A modified regula falsi method for computing the root of an equation, BIT
/// 11(2).
pub(crate) fn touch_time(
    (start_gap, end_gap): (f64, f64),
    length: f64,
    gap_after: impl Fn(f64) -> Result<f64, EffectError>,
) -> Result<f64, EffectError> {
    if start_gap <= 0.0 {
        return Ok(0.0);
    }
    let ((mut low, mut above), (mut high, mut below)) = ((0.0, start_gap), (length, end_gap));
    let mut was_high = None;
    for _ in 0..MOST_TRIES {
        let middle = (low * below - high * above) / (below - above);
        let gap = gap_after(middle)?;
        let is_high = gap <= 0.0;
        // An end that stays weighs half as much.
        let halved = if was_high == Some(is_high) { 0.5 } else { 1.0 };
        if is_high {
            (high, below, above) = (middle, gap, halved * above);
        } else {
            (low, above, below) = (middle, gap, halved * below);
        }
        if gap.abs() <= TOUCH || high - low <= 1e-12 * length {
            return Ok(middle);
        }
        was_high = Some(is_high);
    }
    Ok(high)
}

#[cfg(test)]
mod tests {
    use super::{TOUCH, touch_time};
    use crate::EffectError;

    #[test]
    fn a_touch_is_where_the_gap_closes() {
        let gaps: [fn(f64) -> f64; 4] = [
            |time| 1e-3 - 0.02 * time,
            |time| 1e-3 - 0.4 * time * time,
            |time| 1e-3 * (-60.0 * time).exp() - 5e-5,
            |time| 1e-3 - 1e3 * (time - 0.01).max(0.0).powi(3),
        ];
        for gap in gaps {
            let (start, end) = (gap(0.0), gap(0.1));
            assert!(start > 0.0 && end < 0.0);
            let time = touch_time((start, end), 0.1, |time| Ok(gap(time))).unwrap();
            assert!(gap(time).abs() <= TOUCH, "{time}: {}", gap(time));
        }
    }

    #[test]
    fn who_touches_already_waits_for_nothing() {
        let never = |_: f64| -> Result<f64, EffectError> { unreachable!("no search is needed") };
        assert_eq!(touch_time((0.0, -1e-3), 0.1, never).unwrap(), 0.0);
        assert_eq!(touch_time((-1e-6, -1e-3), 0.1, never).unwrap(), 0.0);
    }

    #[test]
    fn a_gap_that_jumps_is_found_within_the_bracket() {
        let jump = |time: f64| Ok(if time < 0.0371 { 1e-3 } else { -1e-3 });
        let time = touch_time((1e-3, -1e-3), 0.1, jump).unwrap();
        assert!((time - 0.0371).abs() < 1e-9, "{time}");
    }
}
