//! What the recordings of a set add up to.

use std::collections::BTreeMap;

use crate::ingest::force_zero::ForceZero;
use crate::ingest::push::Exclusion;
use crate::ingest::report::{IngestReport, RecordingReport, Spread, Summary};
use crate::remark::StreamRole;
use crate::table::step::StepRow;

/// The summary so far, with the values whose medians it states.
#[derive(Default)]
pub(crate) struct Collected {
    summary: Summary,
    steady_force: Vec<f64>,
    steady_force_untared: Vec<f64>,
    nominal_force: Vec<f64>,
    rates: BTreeMap<StreamRole, Vec<f64>>,
    resting_position: Vec<f64>,
    resting_angle: Vec<f64>,
}

impl Collected {
    pub(crate) fn add(&mut self, rows: &[StepRow], recording: &RecordingReport) {
        let summary = &mut self.summary;
        summary.rows += rows.len();
        for row in rows {
            summary.coverage.add(row);
        }
        let count = |counts: &mut BTreeMap<String, usize>, key: &str| {
            *counts.entry(key.to_owned()).or_default() += 1;
        };
        let excluded = recording.pushes.iter().filter_map(|push| push.excluded.as_ref());
        for reason in recording.excluded.iter().chain(excluded) {
            match reason {
                // Told at once for all of them.
                Exclusion::OtherShape { pushes, .. } => {
                    *summary.excluded.entry(reason.name().to_owned()).or_default() += pushes;
                }
                _ => count(&mut summary.excluded, reason.name()),
            }
        }
        for stream in &recording.streams {
            self.rates.entry(stream.stream).or_default().extend(stream.rate_hz);
            let repairs = summary.repairs.entry(stream.stream).or_default();
            for (kind, n) in &stream.repairs {
                *repairs.entry(*kind).or_default() += n;
            }
            if stream.stream == StreamRole::Object {
                summary.max_tilt_rad = summary.max_tilt_rad.max(stream.max_tilt_rad);
            }
        }
        match &recording.force_zero {
            ForceZero::NoForce => {}
            ForceZero::Tared { .. } => summary.tared += 1,
            ForceZero::Untared { reason } => count(&mut summary.untared, reason.name()),
        }
        let nominal_force = recording.nominal_force_n;
        self.nominal_force.extend(nominal_force);
        for push in &recording.pushes {
            summary.contacts_lost += usize::from(push.contact_lost);
            summary.pushes_used += usize::from(push.excluded.is_none());
            summary.steps_lost_in_gaps += push.steps_lost_in_gaps;
            let left =
                push.resting_force_n.zip(nominal_force).map(|(left, nominal)| left / nominal);
            summary.force_left_at_rest += usize::from(left.is_some_and(|left| left > 0.5));
            self.steady_force.extend(push.steady_force_n);
            if push.steady_force_n.is_none() && left.is_some_and(|left| left < 0.1) {
                self.steady_force_untared.extend(push.recorded_force_n);
            }
        }
        if let Some(noise) = recording.resting_noise {
            self.resting_position.push(noise.position_sd_m);
            self.resting_angle.push(noise.angle_sd_rad);
        }
    }

    /// Puts the summary into a report that has all recordings.
    pub(crate) fn finish(self, report: &mut IngestReport) {
        report.summary = self.summary;
        let summary = &mut report.summary;
        summary.nominal_force_n = Spread::of(&self.nominal_force);
        summary.steady_force_n = Spread::of(&self.steady_force);
        summary.steady_force_untared_n = Spread::of(&self.steady_force_untared);
        summary.resting_position_sd_m = Spread::of(&self.resting_position);
        summary.resting_angle_sd_rad = Spread::of(&self.resting_angle);
        let rates = self.rates.iter().filter_map(|(role, rates)| Some((*role, Spread::of(rates)?)));
        summary.rates_hz = rates.collect();
        for stream in report.recordings.iter_mut().flat_map(|recording| &mut recording.streams) {
            let [first, last] = stream.span_s;
            let rate = summary.rates_hz.get(&stream.stream).map_or(0.0, |rate| rate.high);
            stream.samples_due = Some(1 + ((last - first) * rate).round() as usize);
        }
    }
}
