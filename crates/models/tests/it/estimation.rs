//! A particle filter on recorded pushes: poor motion capture, or force alone, with a fitted model.

use dataset::{Flags, IngestSettings, Manifest, RecordingSet, Table, ingest};
use filter::{PlanarSummary, Weights};
use models::{
    Analytical, ForceSeen, PoseSeen, RecordedPush, RollOut, RollOutSettings, StepCorrelation,
    StepErrors, StepSelection,
};
use nalgebra::Vector2;
use planar::{Pose, wrap_angle};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Motion capture a hundred times as noisy as that of the recordings, in m and rad.
const SD: [f64; 2] = [2e-3, 0.04];
/// It reports after every third step, and then fails one time in three.
const EVERY: usize = 3;

struct Rig {
    table: Table,
    manifest: Manifest,
    test: Vec<RecordedPush>,
    model: Analytical,
    settings: RollOutSettings,
}

fn rig() -> Rig {
    let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pushes");
    let set = RecordingSet::open(fixtures.as_ref()).unwrap();
    let (table, _) = ingest(&set, &IngestSettings::default()).unwrap();
    let manifest = set.manifest().clone();
    let selection = StepSelection::default();
    let mut pushes = selection.pushes(&table, &manifest.object, manifest.pusher.radius).unwrap();
    let mut test = pushes.split_off(40);
    test.truncate(12);
    let steps: Vec<_> = pushes[..20].iter().flat_map(|push| push.steps.clone()).collect();
    let model = Analytical::nominal(manifest.pusher.friction).unwrap().fit(&steps).unwrap().model;
    let correlation = StepCorrelation::measure(&model, &pushes[20..]).unwrap();
    let settings = RollOutSettings {
        n_particles: 200,
        // Recorded steps, of 4 mm give or take the robot's, are not divided.
        step: 0.01,
        gap: correlation.gap,
        errors: StepErrors::Held(correlation),
        touching: true,
        ..RollOutSettings::default()
    };
    Rig { table, manifest, test, model, settings }
}

/// Squares of the errors of place and angle.
#[derive(Default)]
struct Squares {
    place: f64,
    angle: f64,
    n: usize,
}

impl Squares {
    fn add(&mut self, [x, y, angle]: [f64; 3], truth: &Pose) {
        self.place += (Vector2::new(x, y) - truth.position).norm_squared();
        self.angle += wrap_angle(angle - truth.angle).powi(2);
        self.n += 1;
    }

    /// Root mean squares, in m and rad.
    fn rms(&self) -> [f64; 2] {
        [self.place, self.angle].map(|sum| (sum / self.n as f64).sqrt())
    }
}

#[test]
fn a_filter_beats_rare_and_noisy_motion_capture_and_the_blind_model() {
    let Rig { test, model, settings, .. } = rig();
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let (mut raw, mut blind, mut filtered) =
        (Squares::default(), Squares::default(), Squares::default());
    for push in &test {
        let roll_out = RollOut { model: &model, pushed: &push.pushed, settings: &settings };
        let mut filter = roll_out.start(&push.poses_wb[0], &push.path).unwrap();
        let mut without = filter.clone();
        let start = push.poses_wb[0];
        let mut last_seen = [start.position.x, start.position.y, start.angle];
        for (k, step) in push.path.steps(settings.step).unwrap().iter().enumerate() {
            filter.predict(&roll_out.motion(step).unwrap()).unwrap();
            without.predict(&roll_out.motion(step).unwrap()).unwrap();
            let truth = &push.poses_wb[k + 1];
            let noise: [f64; 3] = std::array::from_fn(|_| random.sample(StandardNormal));
            let fails = random.random::<f64>() < 1.0 / 3.0;
            if (k + 1).is_multiple_of(EVERY) && !fails {
                let seen = [
                    truth.position.x + SD[0] * noise[0],
                    truth.position.y + SD[0] * noise[1],
                    truth.angle + SD[1] * noise[2],
                ];
                last_seen = seen;
                let pose_wb = Pose::new(seen[0], seen[1], seen[2]);
                filter.update(&PoseSeen { pose_wb, sd: SD }).unwrap();
            }
            let mean = |filter: &filter::ParticleFilter<'_, _>| -> [f64; 3] {
                PlanarSummary::of(filter.particles(), filter.weights()).unwrap().mean.into()
            };
            raw.add(last_seen, truth);
            blind.add(mean(&without), truth);
            filtered.add(mean(&filter), truth);
        }
    }
    let [raw, blind, filtered] = [raw.rms(), blind.rms(), filtered.rms()];
    println!("raw {raw:?} blind {blind:?} filtered {filtered:?}");
    assert!(filtered[0] < 0.3 * raw[0] && filtered[1] < 0.5 * raw[1], "{filtered:?} {raw:?}");
    assert!(filtered[0] < blind[0] && filtered[1] < blind[1], "{filtered:?} {blind:?}");
}

#[test]
fn force_alone_finds_back_an_object_that_was_laid_down_turned() {
    /// How far it is turned, in rad.
    const TURNED: f64 = 0.1;
    let Rig { table, manifest, test, model, settings } = rig();
    let settings = RollOutSettings { start_sd: [1e-3, TURNED], ..settings };
    let (mut with, mut without) = (Squares::default(), Squares::default());
    for (number, push) in test.iter().enumerate() {
        let (recording, _) = push.name.split_once('#').unwrap();
        let rows = table.rows.iter().filter(|row| *row.recording == *recording);
        let forces: Vec<_> = rows
            .filter(|row| !row.flags.contains(Flags::UNTARED))
            .filter_map(|row| Some((row, row.force?.mean)))
            .map(|(row, force)| {
                let normal = row.contact_normal;
                force.normal * normal + force.tangential * planar::perpendicular(&normal)
            })
            .collect();
        let mut thought_wb = push.poses_wb[0];
        thought_wb.angle += if number.is_multiple_of(2) { TURNED } else { -TURNED };
        let roll_out = RollOut { model: &model, pushed: &push.pushed, settings: &settings };
        let mut filter = roll_out.start(&thought_wb, &push.path).unwrap();
        let mut blind = filter.clone();
        for (step, force_w) in push.path.steps(settings.step).unwrap().iter().zip(forces) {
            let seen = ForceSeen {
                pushed: &push.pushed,
                center_w: step.start_w,
                force_w,
                friction: manifest.pusher.friction,
                angle_sd: 0.03,
                threshold: 0.3,
            };
            filter.update(&seen).unwrap();
            filter.predict(&roll_out.motion(step).unwrap()).unwrap();
            blind.predict(&roll_out.motion(step).unwrap()).unwrap();
        }
        let truth = &push.poses_wb[push.poses_wb.len() - 1];
        let mean = |particles: &[models::PushParticle], weights: &Weights| -> [f64; 3] {
            PlanarSummary::of(particles, weights).unwrap().mean.into()
        };
        with.add(mean(filter.particles(), filter.weights()), truth);
        without.add(mean(blind.particles(), blind.weights()), truth);
    }
    let [with, without] = [with.rms()[1], without.rms()[1]];
    println!("error of the angle {without} without force, {with} with");
    assert!(with < 0.8 * without, "{with} {without}");
}

#[test]
fn a_pose_is_most_likely_where_it_was_seen_and_a_force_within_its_cone() {
    use filter::MeasurementModel;
    let Rig { test, model, settings, .. } = rig();
    let push = &test[0];
    let roll_out = RollOut { model: &model, pushed: &push.pushed, settings: &settings };
    let filter = roll_out.start(&push.poses_wb[0], &push.path).unwrap();
    let particle = &filter.particles()[0];
    let seen = |pose_wb: Pose| PoseSeen { pose_wb, sd: SD }.log_likelihood(particle);
    let mut turned = particle.pose_wb;
    turned.angle += 2.0 * std::f64::consts::PI;
    assert_eq!(seen(particle.pose_wb), 0.0);
    assert!(seen(turned).abs() < 1e-12, "angles have no seam");
    turned.angle += SD[1];
    assert!((seen(turned) + 0.5).abs() < 1e-9);
    let center_w = push.path.start_w();
    let center_b = particle.pose_wb.inverse_transform_point(&center_w);
    let contact = push.pushed.shape.contact(&center_b, push.pushed.pusher_radius);
    let felt = |angle: f64, size: f64| {
        let force_w =
            particle.pose_wb.rotate(&(Pose::new(0.0, 0.0, angle).rotate(&contact.normal)));
        let pushed = &push.pushed;
        let force_w = size * force_w;
        let (friction, angle_sd, threshold) = (0.25, 0.1, 0.3);
        let seen = ForceSeen { pushed, center_w, force_w, friction, angle_sd, threshold };
        seen.log_likelihood(particle)
    };
    assert_eq!([felt(0.2, 1.0), felt(-0.2, 1.0)], [0.0, 0.0]);
    assert!((felt(0.25_f64.atan() + 0.1, 1.0) + 0.5).abs() < 1e-9);
    assert!(felt(0.0, 0.1) < -5.0, "the particle touches, the sensor feels nothing");
}
