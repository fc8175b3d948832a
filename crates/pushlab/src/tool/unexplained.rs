//! The share of what was learnt without a reason, in words.

use models::Unexplained;

/// The share of each output and of all, in percent.
pub(crate) fn shares(unexplained: &Unexplained) -> String {
    let Unexplained { dx, dy, dtheta, all } = unexplained;
    let [dx, dy, dtheta, all] = [dx, dy, dtheta, all].map(|share| 100.0 * share);
    format!("dx {dx:.1} %, dy {dy:.1} %, dtheta {dtheta:.1} %, all {all:.1} %")
}
