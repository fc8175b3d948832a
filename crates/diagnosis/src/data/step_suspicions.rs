//! Motions of steps whose signs or units the mechanics contradict.

use dataset::Suspicion;

use crate::data::nominal_motion::{Beside, NominalMotion};
use crate::{DiagnosisError, Observations};

/// Steps that are looked at, evenly over all.
const MOST_STEPS: usize = 400;
/// Fewer say nothing.
const FEWEST_STEPS: usize = 10;
/// A mistake shows in more than this share of the motion that the mechanics predict.
const SHARE: f64 = 0.85;
/// Of the predicted motion at least this share has to go to either side.
const FEWEST_OF_A_SIDE: f64 = 0.1;
/// Motions within this factor of the predicted ones, or of a unit's multiple of them, are like them.
const ALIKE: f64 = 3.0;
/// What lengths are multiplied by in other units, with the unit's name.
const LENGTHS: [(f64, &str); 4] = [
    (1e3, "in mm, not m"),
    (1e2, "in cm, not m"),
    (1e-3, "1000 times too small"),
    (1e-2, "100 times too small"),
];
const DEGREES: f64 = 57.295_779_513_082_32;

/// What of the motions of a table's steps contradicts the mechanics of a nominal push.
///
/// Observed motions are set beside those that an ellipsoid of uniform pressure predicts, with
/// `pusher_friction`: no effect turns most of them around or makes them dozens of times larger, a
/// wrong sign or unit does. What rests on a few steps alone is no suspicion.
///
/// # Errors
/// `Model` for a friction, of pusher or table, that no model can have.
pub fn step_suspicions(
    observations: &Observations,
    pusher_friction: f64,
) -> Result<Vec<Suspicion>, DiagnosisError> {
    let beside = ObservedPredicted::of(observations, pusher_friction)?;
    if beside.0.len() < FEWEST_STEPS {
        return Ok(Vec::new());
    }
    let swapped = beside.swapped();
    if beside.is_scaled(0, 1.0).is_none() && swapped.is_scaled(0, 1.0).is_some() {
        return Ok(vec![found(
            "dx_m and dy_m are swapped",
            "the motion along the pusher's is in dy_m".into(),
            "correct dx_m and dy_m under [columns] of its mapping",
        )]);
    }
    let mut all = beside.units();
    all.extend(beside.signs());
    Ok(all)
}

fn found(what: impl Into<String>, evidence: String, fix: &str) -> Suspicion {
    Suspicion { what: what.into(), evidence, fix: fix.to_owned(), is_certain: true }
}

/// Steps that are looked at.
struct ObservedPredicted(Vec<Beside>);

impl ObservedPredicted {
    fn of(observations: &Observations, pusher_friction: f64) -> Result<Self, DiagnosisError> {
        let model = NominalMotion::new(pusher_friction, observations.support)?;
        let stride = observations.steps.len().div_ceil(MOST_STEPS).max(1);
        let mut beside = Vec::new();
        for step in observations.steps.iter().step_by(stride) {
            beside.extend(model.beside(step)?);
        }
        Ok(Self(beside))
    }

    fn swapped(&self) -> Self {
        Self(self.0.iter().map(|[x, y, theta]| [(y.0, x.1), (x.0, y.1), *theta]).collect())
    }

    /// The share of a predicted output, by its size, for which an observation is so; to the left and
    /// to the right the smaller one, for an effect shifts motions one way.
    fn share(&self, output: usize, is_so: impl Fn(f64) -> bool) -> f64 {
        let (mut so, mut all) = ([0.0; 2], [0.0; 2]);
        for (observed, predicted) in self.0.iter().map(|step| step[output]) {
            let side = usize::from(output != 0 && predicted < 0.0);
            all[side] += predicted.abs();
            if is_so(observed / predicted) {
                so[side] += predicted.abs();
            }
        }
        let share = |side: usize| {
            let is_seen = all[side] > FEWEST_OF_A_SIDE * (all[0] + all[1]);
            if is_seen { so[side] / all[side] } else { 0.0 }
        };
        if output == 0 { share(0) } else { share(0).min(share(1)) }
    }

    /// The share that is about so many times what is predicted, if that is nearly all.
    fn is_scaled(&self, output: usize, factor: f64) -> Option<f64> {
        let range = factor / ALIKE..factor * ALIKE;
        let share = self.share(output, |ratio| range.contains(&ratio.abs()));
        (share > SHARE).then_some(share)
    }

    fn is_turned(&self, output: usize) -> Option<f64> {
        let share = self.share(output, |ratio| ratio < 0.0);
        (share > SHARE).then_some(share)
    }

    fn units(&self) -> Vec<Suspicion> {
        let evidence = |name: &str, factor: f64, share: f64| {
            format!(
                "{name} is about {factor:.3} times what the pusher's way makes of it, in {:.0} % \
                 of the motion",
                100.0 * share
            )
        };
        let mut all = Vec::new();
        for (factor, unit) in LENGTHS {
            let [x, y, theta] = [0, 1, 2].map(|output| self.is_scaled(output, factor));
            all.extend(match (x, theta) {
                (Some(share), Some(_)) => Some(found(
                    "the pusher's way is in another unit than the object's motion",
                    evidence("dx_m, and dtheta_rad as well,", factor, share),
                    "correct the scale of speed_m_s or of dt_s under [columns] of its mapping",
                )),
                (Some(share), None) => Some(found(
                    format!("dx_m and dy_m are {unit}"),
                    evidence("dx_m", factor, share),
                    &format!(
                        "set dx_m and dy_m with scale = {} under [columns] of its mapping",
                        1.0 / factor
                    ),
                )),
                (None, _) => y.map(|share| {
                    found(
                        format!("dy_m is {unit}"),
                        evidence("dy_m", factor, share),
                        &format!(
                            "set dy_m with scale = {} under [columns] of its mapping",
                            1.0 / factor
                        ),
                    )
                }),
            });
        }
        for (factor, how) in
            [(DEGREES, "in degrees, not rad"), (1.0 / DEGREES, "57 times too small")]
        {
            all.extend(self.is_scaled(2, factor).map(|share| {
                found(
                    format!("dtheta_rad is {how}"),
                    evidence("dtheta_rad", factor, share),
                    &format!(
                        "set dtheta_rad with scale = {:.9} under [columns] of its mapping",
                        1.0 / factor
                    ),
                )
            }));
        }
        all
    }

    fn signs(&self) -> Option<Suspicion> {
        let [x, y, theta] = [0, 1, 2].map(|output| self.is_turned(output));
        let (what, names, fix) = match (x, y, theta) {
            (Some(_), ..) => (
                "the object moves against the pusher",
                "dx_m",
                "set dx_m with the other sign of scale under [columns] of its mapping",
            ),
            (None, Some(_), Some(_)) => (
                "the motions are mirrored",
                "dy_m and dtheta_rad",
                "set dy_m and dtheta_rad, or beta_rad and p, the other way round under [columns] of its mapping",
            ),
            (None, Some(_), None) => (
                "dy_m or beta_rad has the wrong sign",
                "dy_m",
                "set one of them with scale = -1 under [columns] of its mapping: dy_m counts to the left of the \
                 pusher's velocity, beta_rad counter-clockwise from the inward normal",
            ),
            (None, None, Some(_)) => (
                "dtheta_rad has the wrong sign, or p counts from the other end of the edge",
                "dtheta_rad",
                "set dtheta_rad with scale = -1, or p with scale = -1 and offset = 1, under [columns] \
                 of its mapping",
            ),
            (None, None, None) => return None,
        };
        let share = [x, y, theta].into_iter().flatten().fold(1.0, f64::min);
        let evidence = format!(
            "{names} is opposite to what the mechanics say in {:.0} % of the motion",
            100.0 * share
        );
        Some(found(what, evidence, fix))
    }
}

#[cfg(test)]
mod tests {
    use super::ObservedPredicted;

    /// Steps whose observations are `change` of the predictions.
    fn steps(change: impl Fn([f64; 3]) -> [f64; 3]) -> ObservedPredicted {
        let step = |k: usize| {
            let (p, beta) = (0.1 * (k % 11) as f64 - 0.5, 0.15 * (k % 7) as f64 - 0.45);
            let predicted = [0.0035 - 0.002 * p * p, -0.0012 * beta, -0.04 * p];
            let observed = change(predicted);
            [0, 1, 2].map(|k| (observed[k], predicted[k]))
        };
        ObservedPredicted((0..77).map(step).collect())
    }

    fn told(beside: &ObservedPredicted) -> Vec<String> {
        let all = beside.units().into_iter().chain(beside.signs());
        all.map(|suspicion| suspicion.what).collect()
    }

    type Change = fn([f64; 3]) -> [f64; 3];

    #[test]
    fn one_wrong_sign_or_unit_is_one_suspicion() {
        let changes: [(Change, &str); 8] = [
            (|[x, y, t]| [x, y, -t], "dtheta_rad has the wrong sign"),
            (|[x, y, t]| [x, -y, t], "dy_m or beta_rad"),
            (|[x, y, t]| [x, -y, -t], "mirrored"),
            (|[x, y, t]| [-x, -y, t], "against the pusher"),
            (|[x, y, t]| [1e3 * x, 1e3 * y, t], "dx_m and dy_m are in mm"),
            (|[x, y, t]| [1e-3 * x, 1e-3 * y, 1e-3 * t], "the pusher's way is in another unit"),
            (|[x, y, t]| [x, y, 57.3 * t], "dtheta_rad is in degrees"),
            (|[x, y, t]| [x, 100.0 * y, t], "dy_m is in cm"),
        ];
        for (change, what) in changes {
            let told = told(&steps(change));
            assert!(told.len() == 1 && told[0].contains(what), "{told:?} is not {what}");
        }
    }

    #[test]
    fn what_effects_do_is_no_suspicion() {
        let changes: [Change; 5] = [
            |motion| motion,
            |[x, y, t]| [0.6 * x, 2.5 * y, 0.4 * t],
            |[x, y, t]| [x, y + 0.0008, t + 0.01],
            |[x, _, _]| [x, 0.0, 0.0],
            |[x, y, t]| [x, y - 0.002, t - 0.05],
        ];
        for change in changes {
            assert_eq!(told(&steps(change)), Vec::<String>::new());
        }
    }
}
