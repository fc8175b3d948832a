//! Figure M.9: repeats of one push through a vertex, which turn the object either way.

use std::f64::consts::{FRAC_PI_4, PI};
use std::path::PathBuf;

use anyhow::Result;
use models::{
    GpPushModel, Noise, ProcessKind, PushModel, PushParticle, RecordedPush, RollOut,
    RollOutSettings, SlipMixture, SlipPrediction, StepCorrelation, StepErrors, StepInput, Training,
    learn_options,
};
use nalgebra::Vector3;
use planar::wrap_angle;
use plant::{Design, GenerateSettings, Layout, Nominal, PlannedPush, Scatter, generate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use report::{Axis, Color, Figure, Histogram, LegendPlace, Line, Panel};
use serde_json::{Value, json};

use super::ends::{LEVELS, recorded_settings};
use super::neighbors::Neighbors;
use super::pushes::steps_of;
use crate::figures::inputs::{Inputs, SEED};
use crate::figures::sketch::Sketch;
use fixtures::made_once::{key, made_once};
use fixtures::quiet_rig;
use fixtures::workspace_root;

const N_REPEATS: usize = 240;
/// Scatter of where the object is laid down, along each axis in m, and of its turn in rad.
const LAID_SD: [f64; 2] = [5e-4, 0.01];
/// Of a tip thin enough to push through the vertex in both ways, in m.
const TIP_RADIUS: f64 = 5e-4;
const MOST_LEARNT: usize = 300;
/// With care, and quickly.
const N_PARTICLES: [usize; 2] = [1000, 250];
/// The neighbor whose distance tells the density, and how many particles are held against an end.
const NEIGHBOR: usize = 20;
const N_COMPARED: usize = 500;
const N_LEVELS: usize = 51;
const N_BINS: usize = 60;
/// Turns that are drawn, in °.
const WIDEST: f64 = 30.0;

/// A model's scores on the repeats that it has not seen.
struct Scores {
    name: &'static str,
    color: Color,
    /// Mean negative log density of a step, in nats of m, m and rad.
    step_nlpd: f64,
    ends: Vec<End>,
}

/// A measured end among the particles.
struct End {
    /// Level of the region of highest density on whose border the measured end is.
    level: f64,
    nlpd: f64,
    /// Turns of the particles over the push, in °.
    turns: Vec<f64>,
}

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let n_particles = N_PARTICLES[usize::from(inputs.quick())];
    let all = Inputs::open(&repeats()?, false)?.whole_pushes()?;
    let (learn, rest) = all.split_at(all.len() / 3);
    let (measure, test) = rest.split_at(rest.len() / 2);
    let steps = steps_of(&learn.iter().collect::<Vec<_>>());
    let steps = &steps[..steps.len().min(MOST_LEARNT)];
    let mut options = learn_options();
    options.n_starts = 1;
    let training = Training { process: ProcessKind::Gp, ..options.into() };
    let plain = GpPushModel::train(steps, &training)?.0;
    let mixture = SlipMixture::train(steps, &training)?;
    let one = |inputs: &[StepInput]| {
        let said = plain.predict(inputs, Noise::Included)?;
        Ok(said.into_iter().map(SlipPrediction::from).collect())
    };
    let many = |inputs: &[StepInput]| Ok(mixture.ways(inputs, Noise::Included)?);
    let scores = [
        Scores::of(("gp", Color::BLUE), &plain, one, measure, test, n_particles)?,
        Scores::of(("mixture", Color::VERMILION), &mixture, many, measure, test, n_particles)?,
    ];
    let turned: Vec<f64> = test.iter().map(turn).collect();
    let figure = Figure::new(1, 2)
        .panel_size(420.0, 320.0)
        .with(turns(&turned, &scores))
        .with(curves(&scores));
    let told: Vec<String> = scores.iter().map(Scores::in_words).collect();
    let chance = LEVELS
        .map(|level| format!("{:.0}", 100.0 * (level * (1.0 - level) / test.len() as f64).sqrt()));
    let caption = format!(
        "A push through a vertex towards the center, repeated {} times in simulation with scatter of friction, \
         pressure and of where the object lies: it turns either way. Left: by how much, measured in {} \
         repeats that no model has seen, and in {n_particles} particles of each by a Gaussian process and \
         by a mixture of sticking and slipping, learnt from {} others. Right: the share of the ends within \
         regions of highest density, which may fall apart; densities are by the distance to the {NEIGHBOR}th \
         neighbor, for both alike. Negative log density of a step and of an end in nats, and ends within \
         50, 90 and 95 % regions in percent (±{} are chance): {}.",
        all.len(),
        test.len(),
        learn.len(),
        chance.join(", "),
        told.join("; ")
    );
    let alt = "Histograms of the turn with two humps, and two coverage curves.";
    let numbers: Vec<Value> = scores.iter().map(Scores::numbers).collect();
    let data = json!({ "models": numbers, "measured_turns_deg": turned });
    Ok(Sketch::new(figure, data, &caption, alt))
}

/// The recording set of the repeats, simulated once.
fn repeats() -> Result<PathBuf> {
    let rig = quiet_rig();
    let push = |_| PlannedPush {
        edge: 0,
        p: 0.0,
        // The edge goes on at −90° from its inward normal.
        angle: -FRAC_PI_4,
        speed: 0.02,
        travel: 0.04,
        place: [0.0; 3],
        session: 0,
        repeat: "vertex".to_owned(),
    };
    let [laid_sd, turned_sd] = LAID_SD;
    let nominal = Nominal { pusher_radius: TIP_RADIUS, ..rig.nominal };
    let mut truth = rig.truth.clone();
    truth.tip.radius = TIP_RADIUS;
    let settings = GenerateSettings {
        nominal,
        truth,
        name: "repeats of a push through a vertex, simulated".into(),
        design: Design {
            layout: Layout::List((0..N_REPEATS).map(push).collect()),
            n_pushes: 0,
            rests: [0.2, 0.4],
            ..Design::default()
        },
        scatter: Scatter { placing_sd: laid_sd, turning_sd: turned_sd, ..rig.scatter },
        ..rig
    };
    let folder = workspace_root().join("target").join("vertex-repeats");
    made_once(&folder, &key(std::slice::from_ref(&settings))?, |folder| {
        generate(&settings, &folder.join("set"))?;
        Ok(())
    })?;
    Ok(folder.join("set"))
}

/// By how much the object turned in a push, in °.
fn turn(push: &RecordedPush) -> f64 {
    let last = push.poses_wb.len() - 1;
    wrap_angle(push.poses_wb[last].angle - push.poses_wb[0].angle).to_degrees()
}

impl Scores {
    fn of(
        (name, color): (&'static str, Color),
        model: &dyn PushModel,
        predict: impl Fn(&[StepInput]) -> Result<Vec<SlipPrediction>>,
        measure: &[RecordedPush],
        test: &[RecordedPush],
        n_particles: usize,
    ) -> Result<Self> {
        let correlation = StepCorrelation::measure(model, measure)?;
        let settings = RollOutSettings {
            n_particles,
            seed: SEED,
            errors: StepErrors::Held(correlation.clone()),
            ..recorded_settings(correlation.gap)
        };
        let units = spread(test);
        let ends = test.par_iter().map(|push| End::of(model, push, &settings, &units));
        let steps = steps_of(&test.iter().collect::<Vec<_>>());
        let inputs: Vec<StepInput> = steps.iter().map(|step| step.input.clone()).collect();
        let said = predict(&inputs)?;
        let logs = said.iter().zip(&steps).map(|(said, step)| said.log_density(&step.outputs));
        let step_nlpd = -logs.sum::<f64>() / steps.len() as f64;
        Ok(Self { name, color, step_nlpd, ends: ends.collect::<Result<_>>()? })
    }

    fn end_nlpd(&self) -> f64 {
        self.ends.iter().map(|end| end.nlpd).sum::<f64>() / self.ends.len() as f64
    }

    fn coverage(&self, level: f64) -> f64 {
        let within = self.ends.iter().filter(|end| end.level <= level).count();
        within as f64 / self.ends.len() as f64
    }

    fn in_words(&self) -> String {
        let shares = LEVELS.map(|level| format!("{:.0}", 100.0 * self.coverage(level)));
        let (step, end) = (self.step_nlpd, self.end_nlpd());
        format!("{} {step:.2} and {end:.2}, {}", self.name, shares.join(", "))
    }

    fn numbers(&self) -> Value {
        json!({
            "model": self.name,
            "step_nlpd": self.step_nlpd,
            "end_nlpd": self.end_nlpd(),
            "coverage": LEVELS.map(|level| json!({ "level": level, "share": self.coverage(level) })),
            "levels": self.ends.iter().map(|end| end.level).collect::<Vec<_>>(),
        })
    }
}

/// Standard deviations of where the pushes end, about where they begin: the units of distances.
fn spread(pushes: &[RecordedPush]) -> Vector3<f64> {
    let off = |push: &RecordedPush| {
        let (first, last) = (push.poses_wb[0], push.poses_wb[push.poses_wb.len() - 1]);
        let way = last.position - first.position;
        Vector3::new(way.x, way.y, wrap_angle(last.angle - first.angle))
    };
    let n = pushes.len() as f64;
    let mean = pushes.iter().map(off).sum::<Vector3<f64>>() / n;
    let square = |push| (off(push) - mean).map(|x| x * x);
    (pushes.iter().map(square).sum::<Vector3<f64>>() / n).map(f64::sqrt)
}

impl End {
    fn of(
        model: &dyn PushModel,
        push: &RecordedPush,
        settings: &RollOutSettings,
        units: &Vector3<f64>,
    ) -> Result<Self> {
        let settings = RollOutSettings { start_sd: push.pose_sd[0], ..settings.clone() };
        let roll_out = RollOut { model, pushed: &push.pushed, settings: &settings };
        let mut particles: Vec<PushParticle> = Vec::new();
        roll_out.run(&push.poses_wb[0], &push.path, |_, now| particles = now.to_vec())?;
        let (first, end) = (push.poses_wb[0], push.poses_wb[push.poses_wb.len() - 1]);
        let [place_sd, angle_sd] = push.pose_sd[1];
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let mut noise = |sd: f64| sd * random.sample::<f64, _>(StandardNormal);
        let scaled = |pose: &planar::Pose| -> [f64; 3] {
            let turn = wrap_angle(pose.angle - first.angle);
            Vector3::new(pose.position.x, pose.position.y, turn).component_div(units).into()
        };
        // As they would be measured.
        let measured = particles.iter().map(|particle| {
            let mut pose = particle.pose_wb;
            pose.position.x += noise(place_sd);
            pose.position.y += noise(place_sd);
            pose.angle += noise(angle_sd);
            scaled(&pose)
        });
        let places: Vec<[f64; 3]> = measured.collect();
        let tree = Neighbors::of(places.clone());
        let reach = tree.distance(scaled(&end), NEIGHBOR);
        let every = places.len().div_ceil(N_COMPARED);
        let compared: Vec<_> = places.iter().step_by(every).collect();
        // A particle is its own first neighbor.
        let is_denser = |place: &&&[f64; 3]| tree.distance(***place, NEIGHBOR + 1) < reach;
        let level = compared.iter().filter(is_denser).count() as f64 / compared.len() as f64;
        let volume = 4.0 / 3.0 * PI * reach.powi(3) * units.product();
        let nlpd = (places.len() as f64 * volume / NEIGHBOR as f64).ln();
        let turns = particles
            .iter()
            .step_by(every)
            .map(|particle| wrap_angle(particle.pose_wb.angle - first.angle).to_degrees());
        Ok(Self { level, nlpd, turns: turns.collect() })
    }
}

fn turns(measured: &[f64], scores: &[Scores]) -> Panel {
    let panel = Panel::new(Axis::new("turn over the push / °"), "density")
        .title("the object turns either way")
        .legend(LegendPlace::Below)
        .with(Histogram::new(measured, N_BINS).range(-WIDEST, WIDEST).label("measured"));
    scores.iter().fold(panel, |panel, model| {
        let turns: Vec<f64> = model.ends.iter().flat_map(|end| end.turns.iter().copied()).collect();
        let (edges, densities) = Histogram::new(&turns, N_BINS).range(-WIDEST, WIDEST).densities();
        let middles: Vec<f64> = edges.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        panel.with(Line::new(&middles, &densities).color(model.color).label(model.name))
    })
}

fn curves(scores: &[Scores]) -> Panel {
    let grid: Vec<f64> = (0..N_LEVELS).map(|k| k as f64 / (N_LEVELS - 1) as f64).collect();
    let panel = Panel::new(
        Axis::new("level of the region").range(0.0, 1.0),
        Axis::new("share of the ends within").range(0.0, 1.0),
    )
    .title("regions of highest density")
    .legend(LegendPlace::Below)
    .with(Line::new(&[0.0, 1.0], &[0.0, 1.0]).color(Color::GRAY).width(1.0));
    scores.iter().fold(panel, |panel, model| {
        let shares: Vec<f64> = grid.iter().map(|level| model.coverage(*level)).collect();
        panel.with(Line::new(&grid, &shares).color(model.color).label(model.name))
    })
}

#[cfg(test)]
mod tests {
    use super::draw;
    use crate::figures::inputs::Inputs;

    #[test]
    fn where_repeats_go_either_way_a_mixture_is_surer_of_steps_and_of_ends() {
        let sketch = draw(&Inputs::fixtures(true).unwrap()).unwrap();
        let report::Data::Json(data) = &sketch.data else { panic!("numbers are in JSON") };
        let turns = data["measured_turns_deg"].as_array().unwrap();
        let share = |is_so: &dyn Fn(f64) -> bool| {
            let n = turns.iter().filter(|turn| is_so(turn.as_f64().unwrap())).count();
            n as f64 / turns.len() as f64
        };
        assert!(share(&|turn| turn > 10.0) > 0.2 && share(&|turn| turn < -10.0) > 0.2);
        let number = |model: usize, key: &str| data["models"][model][key].as_f64().unwrap();
        for key in ["step_nlpd", "end_nlpd"] {
            assert!(number(1, key) < number(0, key) - 1.0, "{key}");
        }
        let within = data["models"][1]["coverage"][2]["share"].as_f64().unwrap();
        assert!(within > 0.85, "{within}");
    }
}
