//! Rows of a log that cannot be used, counted with what is wrong of the first.

/// Rows of one stream excluded, by their reasons.
#[derive(Default)]
pub(super) struct RowLosses {
    pub(super) not_finite: Losses,
    pub(super) too_large: Losses,
    pub(super) not_unit: Losses,
}

/// Rows excluded for one reason.
#[derive(Default)]
pub(super) struct Losses {
    pub(super) count: u64,
    pub(super) place: u64,
    pub(super) example: f64,
}

impl Losses {
    pub(super) fn add(&mut self, place: u64, example: f64) {
        if self.count == 0 {
            (self.place, self.example) = (place, example);
        }
        self.count += 1;
    }
}
