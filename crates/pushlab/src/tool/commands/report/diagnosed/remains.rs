//! What of the rig the error comes from that the claimed effects leave.

use ::report::Section;
use diagnosis::{Gain, OriginShare, Remains};

use super::dash;

/// A section with what free components of every origin predict of what is left.
pub(super) fn told(remains: &Remains, section: Section) -> Section {
    let Remains { gain, share, smooth, origins } = remains;
    if !gain.is_sure() && !smooth.is_sure() {
        return section.text(
            "Nor is anything left that held-out pushes would be predicted better by, were support, contact, table \
             and the rest of the rig free to take any form.",
        );
    }
    let row = |one: &OriginShare| {
        let percent = |share: Option<f64>| {
            let sure = share.filter(|_| one.gain.is_sure());
            sure.map_or_else(dash, |share| format!("{:.0} %", 100.0 * share))
        };
        let at = one.at.clone().unwrap_or_else(dash);
        let name = one.origin.name().to_owned();
        vec![name, nats(one.gain), percent(one.alone), percent(one.last_in), at]
    };
    section
        .text(&format!(
            "Where the rest comes from, looked at all at once: each origin is free to take any form, fitted to \
             four fifths of the pushes, and predicts the last fifth. Together they take off {:.0} % of the squared error that is left, in \
             units of the noise; any smooth function of place, direction and speed gains {}. Where “alone” \
             is large and “by nothing else” small, another origin could be it as well.",
            100.0 * share,
            nats(*smooth)
        ))
        .table(
            &["origin", "gain", "alone", "by nothing else", "most of it"],
            origins.iter().map(row).collect(),
        )
}

/// A gain, if it is sure.
fn nats(gain: Gain) -> String {
    match gain.is_sure() {
        true => format!("{:.0} ± {:.0} nats", gain.mean, gain.se),
        false => "nothing sure".to_owned(),
    }
}
