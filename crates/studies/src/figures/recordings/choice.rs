//! A push that shows what a figure is about.

use dataset::{FirstContact, IngestReport, Phase, PushReport, RecordingReport, StepRow, Table};

/// Differences in p and β that count as equally far.
const P_SCALE: f64 = 0.1;
const BETA_SCALE: f64 = 0.35;

/// One push of the set, with where it first touches.
#[derive(Clone, Copy)]
pub(super) struct Choice<'a> {
    pub(super) recording: &'a RecordingReport,
    pub(super) push: &'a PushReport,
    pub(super) first: FirstContact,
}

impl<'a> Choice<'a> {
    /// All pushes with rows, in the order of the report.
    pub(super) fn all(report: &'a IngestReport) -> impl Iterator<Item = Self> {
        report.recordings.iter().flat_map(|recording| {
            let used = recording.pushes.iter().filter(|push| push.excluded.is_none());
            used.filter_map(move |push| Some(Self { recording, push, first: push.first_contact? }))
        })
    }

    /// All pushes, the first of them that which touches nearest to `p` in the direction `beta`.
    pub(super) fn nearest_first(report: &'a IngestReport, (p, beta): (f64, f64)) -> Vec<Self> {
        let distance = |choice: &Self| {
            let first = &choice.first;
            ((first.p - p) / P_SCALE).hypot((first.beta_rad - beta) / BETA_SCALE)
        };
        let mut all: Vec<_> = Self::all(report).collect();
        all.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        all
    }

    /// Of the pushes that fit, the nearest to `p` and `beta`.
    pub(super) fn nearest(
        report: &'a IngestReport,
        wanted: (f64, f64),
        fits: impl Fn(&Self) -> bool,
    ) -> Option<Self> {
        Self::nearest_first(report, wanted).into_iter().find(fits)
    }

    /// Its rows in contact.
    pub(super) fn rows(&self, table: &'a Table) -> Vec<&'a StepRow> {
        let own = |row: &&StepRow| {
            *row.recording == *self.recording.name
                && row.push == self.push.push
                && row.phase == Phase::Contact
        };
        table.rows.iter().filter(own).collect()
    }

    /// End of the contact in motion, on the recording's clock in s.
    pub(super) fn contact_end(&self) -> f64 {
        self.push.contact_end_s.min(self.push.rest_s)
    }

    /// The time that belongs to this push: after the last one's rest and before the next contact.
    pub(super) fn window(&self) -> (f64, f64) {
        let others = &self.recording.pushes;
        let start = self.push.contact_start_s;
        let before = others.iter().map(|push| push.rest_s).filter(|rest| *rest < start);
        let after = others.iter().map(|push| push.contact_start_s).filter(|next| *next > start);
        (before.fold(f64::NEG_INFINITY, f64::max), after.fold(f64::INFINITY, f64::min))
    }

    /// Where it touches, in words.
    pub(super) fn place(&self) -> String {
        place(self.first.p, self.first.beta_rad)
    }
}

/// p and β in words.
pub(super) fn place(p: f64, beta: f64) -> String {
    let degrees = beta.to_degrees().round() + 0.0;
    format!("p = {p:.2}, β = {degrees}°").replace('-', "\u{2212}")
}
