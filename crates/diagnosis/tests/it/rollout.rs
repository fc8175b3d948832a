//! Whole pushes on the fixture set.

use dataset::{IngestSettings, RecordingSet, StepLength, ingest};
use diagnosis::{Observations, Predictions, Rollout, push_ends, roll_out};
use models::{Analytical, Description, ModelEffect, PushModel};

fn observations(step: StepLength) -> Observations {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pushes");
    let set = RecordingSet::open(folder.as_ref()).unwrap();
    let settings = IngestSettings { step, ..IngestSettings::default() };
    Observations::of(&ingest(&set, &settings).unwrap().0, set.manifest()).unwrap()
}

fn model() -> Description {
    Analytical::nominal(0.25).unwrap().describe().unwrap()
}

fn mean_error(rollouts: &[Rollout]) -> [f64; 2] {
    let n = rollouts.len() as f64;
    let errors: Vec<_> = rollouts.iter().map(Rollout::end_error).collect();
    [
        errors.iter().map(|error| error.0).sum::<f64>() / n,
        errors.iter().map(|error| error.1.abs()).sum::<f64>() / n,
    ]
}

#[test]
fn measured_steps_join_and_the_prediction_begins_with_them() {
    let observations = observations(StepLength::Time(0.2));
    let rollouts = roll_out(&model(), &[], &observations).unwrap();
    assert_eq!(rollouts.len(), 60);
    let n_steps: usize = rollouts.iter().map(|push| push.times.len() - 1).sum();
    assert_eq!(n_steps, observations.n_steps());
    let mut steps = observations.steps().iter();
    for push in &rollouts {
        assert_eq!(push.predicted_wb[0], push.measured_wb[0]);
        for ends in push.measured_wb.windows(2) {
            // Where one step ends the next one begins, to the rounding of the table's numbers.
            let start = steps.next().unwrap().input.pose_wb;
            assert!((ends[0].position - start.position).norm() < 1e-12);
            assert!((ends[0].angle - start.angle).abs() < 1e-12);
        }
        assert!(push.times.windows(2).all(|pair| pair[0] < pair[1]));
    }
}

#[test]
fn the_first_step_of_a_roll_out_is_that_of_the_step_prediction() {
    let observations = observations(StepLength::Time(0.2));
    let rollouts = roll_out(&model(), &[], &observations).unwrap();
    let predictions = Predictions::of(&model(), &[], &observations).unwrap();
    let steps = predictions.steps();
    let mut first = 0;
    for push in &rollouts {
        let turn = push.predicted_wb[1].angle - push.predicted_wb[0].angle;
        // The way in four straight pieces instead of a cubic.
        assert!((turn - steps[first][2].unwrap()).abs() < 1e-3, "{}", push.push);
        first += push.times.len() - 1;
    }
}

#[test]
fn a_roll_out_hardly_depends_on_how_the_push_is_cut_into_steps() {
    let coarse = roll_out(&model(), &[], &observations(StepLength::Time(0.2))).unwrap();
    let fine = roll_out(&model(), &[], &observations(StepLength::Time(0.1))).unwrap();
    let [[a, turn_a], [b, turn_b]] = [mean_error(&coarse), mean_error(&fine)];
    assert!((a - b).abs() < 0.1 * a && (turn_a - turn_b).abs() < 0.1 * turn_a, "{a} {b}");
}

#[test]
fn an_effect_that_is_not_there_makes_the_ends_worse() {
    let observations = observations(StepLength::Time(0.2));
    let mut grain = model();
    let estimate = |value| models::Estimate::exact(value, "");
    let parameters = [("ratio", 1.3), ("direction", 0.6)];
    let parameters = parameters.map(|(name, value)| (name.to_owned(), estimate(value)));
    grain.effects.push(ModelEffect::new("table-anisotropy", parameters.into()));
    let [plain, wrong] =
        [model(), grain].map(|model| mean_error(&roll_out(&model, &[], &observations).unwrap()));
    assert!(wrong[0] > 1.5 * plain[0], "{plain:?} {wrong:?}");
}

/// The fixture set with a pusher stated thinner than it is, and a model that knows by how much.
#[test]
fn a_model_that_knows_the_true_radius_goes_as_if_it_were_stated() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pushes");
    let set = RecordingSet::open(folder.as_ref()).unwrap();
    let (table, _) = ingest(&set, &IngestSettings::default()).unwrap();
    let excess = 1.5e-3;
    let mut thin = set.manifest().clone();
    thin.pusher.radius -= excess;
    let mut knows = model();
    let parameters = [("excess".to_owned(), models::Estimate::exact(excess, ""))].into();
    knows.effects.push(ModelEffect::new("pusher-radius", parameters));
    let stated = Observations::of(&table, set.manifest()).unwrap();
    let unstated = Observations::of(&table, &thin).unwrap();
    let one = roll_out(&model(), &[], &stated).unwrap();
    let other = roll_out(&knows, &[], &unstated).unwrap();
    for (a, b) in one.iter().zip(&other) {
        for (a, b) in a.predicted_wb.iter().zip(&b.predicted_wb) {
            assert!((a.position - b.position).norm() < 1e-9 && (a.angle - b.angle).abs() < 1e-8);
        }
        for (a, b) in a.gaps.iter().zip(&b.gaps) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
    let [one, other] = [one, other].map(|rollouts| push_ends(&rollouts).unwrap());
    assert_eq!((one.n_lost, one.pushes.len()), (other.n_lost, other.pushes.len()));
    assert!(other.n_lost < 5, "{} of {} lose contact", other.n_lost, other.pushes.len());
}
