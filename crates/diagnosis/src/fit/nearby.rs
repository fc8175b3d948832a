//! What is expected of steps where pushes differ, beside a place at which all of it is known.

use effects::{EffectError, PredictedParts, PushPhysics, StepInput};

/// What pushes that differ change of each step, known at a place.
///
/// Most of it hardly changes over a fit: a motion that bends little with a parameter is expected where a typical push
/// moves, and what it bends stays. Only near the edge of sticking and sliding the rest is asked for anew.
#[derive(Clone, Debug)]
pub(super) struct Nearby {
    steps: Vec<OfStep>,
}

#[derive(Clone, Debug)]
struct OfStep {
    /// Parameters that bend its motion, by their order.
    bending: Vec<usize>,
    /// What all others add.
    rest: [f64; 7],
}

/// What a parameter adds that is asked for anew, in standard deviations of the noise.
const BENT: f64 = 0.2;

impl Nearby {
    /// Of steps with all of their parts; `sd` are standard deviations of the noise by step and number.
    pub(super) fn new(steps: &[PredictedParts], sd: &[(usize, usize, f64)]) -> Self {
        let mut allowed = vec![[f64::INFINITY; 7]; steps.len()];
        for (step, number, sd) in sd {
            allowed[*step][*number] = BENT * sd;
        }
        let of = |(parts, allowed): (&PredictedParts, &[f64; 7])| {
            let mut found = OfStep { bending: Vec::new(), rest: [0.0; 7] };
            for (parameter, added) in parts.added.iter().enumerate() {
                let mut pairs = added.iter().zip(allowed);
                if pairs.any(|(added, allowed)| added.abs() > *allowed) {
                    found.bending.push(parameter);
                } else {
                    found.rest.iter_mut().zip(added).for_each(|(rest, added)| *rest += added);
                }
            }
            found
        };
        Self { steps: steps.iter().zip(&allowed).map(of).collect() }
    }

    /// What is expected of a step at another place.
    pub(super) fn predict(
        &self,
        physics: &PushPhysics,
        index: usize,
        step: &StepInput,
    ) -> Result<[f64; 7], EffectError> {
        let OfStep { bending, rest } = &self.steps[index];
        let mut sum = physics.predict_parts(step, |parameter| bending.contains(&parameter))?.sum();
        sum.iter_mut().zip(rest).for_each(|(sum, rest)| *sum += rest);
        Ok(sum)
    }
}

#[cfg(test)]
mod tests {
    use effects::{Spread, by_id};
    use models::{Description, ModelEffect};

    use crate::FitSettings;
    use crate::fit::descent::{Exactness, Start};
    use crate::fit::problem::Problem;
    use crate::fit::robust::Robust;
    use crate::fit::space::Space;
    use crate::synthetic::{pushed_with, white};

    /// A model whose friction with the tip and place of contact differ from push to push.
    fn differing(mut model: Description) -> Description {
        for (id, name, spread) in [
            ("pusher-friction", "friction", Spread::RelativeSd(0.3)),
            ("contact-bias", "shift", Spread::Sd(5e-4)),
        ] {
            let about = by_id(id).unwrap().info();
            let rig = effects::Rig::new(effects::Surface::Ellipsoid, 0.25, 0.3).unwrap();
            let mut effect = ModelEffect::from(effects::Setting::new(about, &about.off(&rig)));
            effect.per_push.insert(name.to_owned(), spread);
            model.effects.push(effect);
        }
        model
    }

    #[test]
    fn a_fit_that_stays_near_ends_as_low_as_one_that_asks_for_all_everywhere() {
        let (observations, model, _) = pushed_with(("table-tilt", &[0.05, 0.0]), 3);
        let (model, whitening) = (differing(model), white(&observations));
        let settings = FitSettings::default();
        let asked = ["table-tilt"];
        let space = || Space::new(&observations, &model, &asked, &settings, None).unwrap();
        let start = space().place(|member| member.start.clone());
        let z = whitening.whiten_residuals(&space().residuals(&start).unwrap());
        let problem = || Problem::new(space(), &whitening, Robust::at(&whitening.rows(), &z));
        let mut near = problem();
        let found = near.settle(start.clone(), None, Exactness::Sum).unwrap();
        let mut everywhere = problem();
        everywhere.robust = near.robust.clone();
        let at = everywhere.stand(start).unwrap();
        let first = at.value;
        let start = Start { at, slopes: None, exactness: Exactness::Sum };
        let lowest = everywhere.descend(start).unwrap().at.value;
        let there = everywhere.stand(found.at.x).unwrap().value;
        assert!(first - lowest > 100.0, "{first} {lowest}");
        assert!((there - lowest).abs() < 1.0, "{there} {lowest}");
        // And says so.
        assert!((found.at.value - there).abs() < 1e-6 * there, "{} {there}", found.at.value);
    }
}
