//! The same pushes by the diagnosis alone: what it claims, and where it says that the object rests.

use std::f64::consts::PI;

use anyhow::{Context, Result};
use diagnosis::{DiagnoseSettings, Diagnosis, Observations, diagnose};
use effects::{Effect, PressureRadius, SupportPoints};
use models::Description;

use super::super::page::claimed;
use super::super::plain_fit::feet;
use super::Known;

/// What is claimed of a set.
pub(super) struct Diagnosed {
    found: Diagnosis,
    /// Places and shares of points; none where no points are claimed.
    pub(super) feet: Vec<[f64; 3]>,
    /// Mean distance of the pressure from the center of friction, in m; none where nothing of the support is claimed.
    distance: Option<f64>,
}

impl Diagnosed {
    /// # Errors
    /// A diagnosis that fails.
    pub(super) fn of(all: &Observations, nominal: &Description) -> Result<Self> {
        let found = diagnose(all, nominal, &DiagnoseSettings::default())?;
        let claimed = |id: &str| found.description.effects.iter().find(|effect| effect.id == id);
        let feet = match claimed(SupportPoints.info().id) {
            Some(_) => feet(&found.description).context("points that cannot be read")?,
            None => Vec::new(),
        };
        let about = PressureRadius.info();
        let radius = claimed(about.id).map(|effect| effect.setting().values(about)).transpose()?;
        let ratio = radius.map(|own| own[0]);
        let uniform = all.steps().first().map(|step| step.input.object.mean_distance());
        let distance = if feet.is_empty() {
            ratio.zip(uniform).map(|(ratio, uniform)| ratio * uniform)
        } else {
            let [x, y] = center(&feet);
            Some(feet.iter().map(|foot| foot[2] * (foot[0] - x).hypot(foot[1] - y)).sum())
        };
        Ok(Self { found: found.diagnosis, feet, distance })
    }

    /// How many of the coordinates of true feet the intervals of the nearest points hold, and of how many.
    fn held(&self, truth: &[[f64; 3]]) -> Option<(usize, usize)> {
        let points = self.found.effects.iter().find(|one| one.id == SupportPoints.info().id)?;
        let points: Vec<_> = points.parameters.chunks_exact(3).collect();
        let at = |k: usize, axis: usize| points[k][axis].estimate.unwrap_or(f64::INFINITY);
        let mut n_held = 0;
        for foot in truth {
            let away = |k: &usize| (at(*k, 0) - foot[0]).hypot(at(*k, 1) - foot[1]);
            let nearest = (0..self.feet.len()).min_by(|a, b| away(a).total_cmp(&away(b)))?;
            let holds = |axis: &usize| {
                let one = &points[nearest][*axis];
                let ends = one.low95.zip(one.high95);
                ends.is_some_and(|(low, high)| (low..=high).contains(&foot[*axis]))
            };
            n_held += (0..2).filter(holds).count();
        }
        Some((n_held, 2 * truth.len()))
    }

    fn row(&self, Known { name, truth, feet, .. }: &Known) -> String {
        let [before, after, floor] =
            [&self.found.error.before_si, &self.found.error.after_si, &self.found.error.floor_si];
        let told = |of: fn(&diagnosis::MotionError) -> Option<f64>, unit: f64| {
            let number = |value: f64| format!("{:.2}", unit * value);
            let [before, after, floor] =
                [before, after, floor].map(|one| of(one).map_or("–".to_owned(), number));
            format!("{before} → {after} ({floor})")
        };
        let place = match self.feet.is_empty() {
            true => "–".to_owned(),
            false => {
                let [x, y] = center(&self.feet);
                format!("({:.1}, {:.1})", 1e3 * x, 1e3 * y)
            }
        };
        let distance = self.distance.map_or("–".to_owned(), |c| format!("{:.1}", 1e3 * c));
        let held = self.held(feet).filter(|(_, of)| *of > 0);
        let held = held.map_or("–".to_owned(), |(n, of)| format!("{n} of {of}"));
        let [x, y, c] = truth.map(|length| 1e3 * length);
        format!(
            "| {name} | {} | {} | {} | {place} for ({x:.1}, {y:.1}) | {distance} for {c:.1} | {held} |\n",
            claimed(&self.found),
            told(|error| error.dx_m, 1e3),
            told(|error| error.dtheta_rad, 180.0 / PI),
        )
    }
}

/// Of friction, in m.
pub(super) fn center(feet: &[[f64; 3]]) -> [f64; 2] {
    let whole: f64 = feet.iter().map(|foot| foot[2]).sum();
    [0, 1].map(|axis| feet.iter().map(|foot| foot[2] * foot[axis]).sum::<f64>() / whole)
}

/// What the diagnosis alone says of each set.
pub(super) fn text(known: &[Known]) -> String {
    known.iter().fold(HEAD.to_owned(), |page, one| page + &one.diagnosed.row(one))
}

const HEAD: &str = "
By the diagnosis alone, from the same nominal models: what `pushlab diagnose` claims of each set (**bold** is
identified; of the rest the error falls, though the cause may be another), the errors of held-out pushes before → after
and the floor, and, where the support is claimed, the center of friction and c in mm, and how many coordinates of the
true feet the 95 % intervals of the points hold.

| set | claimed | dx, mm | dθ, ° | center | c | feet held |
|---|---|---|---|---|---|---|
";
