//! The divergences that were found, as a panel, in words and in numbers.

use report::{Axis, Color, Guide, Panel, Points};
use serde_json::json;

use super::{FITTED, METHODS, SHARES};
use crate::held_out::quantile;

/// Divergences below are drawn here, in nats: the estimate knows no less.
const LEAST_DRAWN: f64 = 1e-3;

/// The divergences of a case.
pub(super) struct Found {
    pub(super) name: &'static str,
    pub(super) n_particles: usize,
    pub(super) pushes: Vec<PushFound>,
    /// Of the exact method and the first push, by [`SHARES`] of the particles.
    pub(super) by_share: [f64; SHARES.len()],
    /// Of draws of a Gaussian from that Gaussian, and between two sets of particles, by [`SHARES`] of as
    /// many: what the estimate makes of nothing.
    pub(super) floor: [[f64; SHARES.len()]; 2],
}

/// Those of a push, in nats.
pub(super) struct PushFound {
    pub(super) changes: bool,
    /// One a method, then of [`FITTED`].
    pub(super) divergences: Vec<f64>,
}

impl Found {
    fn names() -> impl Iterator<Item = &'static str> {
        METHODS.iter().map(|method| method.name).chain(FITTED.map(|(name, _)| name))
    }

    pub(super) fn panel(&self) -> Panel {
        let shorts = METHODS.iter().map(|method| method.short).chain(FITTED.map(|(_, name)| name));
        let names: Vec<(f64, &str)> =
            shorts.enumerate().map(|(index, name)| (index as f64, name)).collect();
        let ends = (-0.5, names.len() as f64 - 0.5);
        let x = Axis::new("method").names(&names).range(ends.0, ends.1);
        let panel = Panel::new(x, Axis::new("divergence / nats").log())
            .with(Guide::horizontal(self.floor[0][SHARES.len() - 1].max(LEAST_DRAWN)));
        [(false, "one way all along"), (true, "sticks and slips")].into_iter().fold(
            panel,
            |panel, (changes, label)| {
                let own = self.pushes.iter().filter(|push| push.changes == changes);
                let points: Vec<[f64; 2]> = own
                    .flat_map(|push| push.divergences.iter().enumerate())
                    .map(|(index, value)| [index as f64, value.max(LEAST_DRAWN)])
                    .collect();
                if points.is_empty() {
                    return panel;
                }
                let points = Points::at(&points).label(label);
                panel.with(match changes {
                    false => points.color(Color::BLUE),
                    true => points.color(Color::VERMILION).hollow(),
                })
            },
        )
    }

    /// The medians over the pushes.
    pub(super) fn in_words(&self) -> String {
        let median = |index: usize| {
            let own = self.pushes.iter().map(|push| push.divergences[index]).collect();
            quantile(own, 0.5)
        };
        let told: Vec<String> = Self::names()
            .enumerate()
            .map(|(index, name)| format!("{name} {:.3}", median(index)))
            .collect();
        let between = self.floor[1][SHARES.len() - 1];
        format!("{} – {} (two sets of particles {between:.3})", self.name, told.join(", "))
    }

    pub(super) fn numbers(&self) -> serde_json::Value {
        let pushes = self.pushes.iter().map(|push| {
            let methods: serde_json::Map<_, _> = Self::names()
                .zip(&push.divergences)
                .map(|(name, value)| (name.to_owned(), json!(value)))
                .collect();
            json!({
                "changes": push.changes,
                "divergence_nats": methods,
            })
        });
        json!({
            "case": self.name,
            "n_particles": self.n_particles,
            "shares": SHARES.map(|share| 1.0 / share as f64),
            "exact_of_the_first_nats": self.by_share,
            "gaussian_from_itself_nats": self.floor[0],
            "between_two_sets_nats": self.floor[1],
            "pushes": pushes.collect::<Vec<_>>(),
        })
    }
}
