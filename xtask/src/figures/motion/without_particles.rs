//! Figure M.8: whole pushes without particles, beside very many of them.

use anyhow::{Context, Result};
use filter::{GaussHermite, Gaussian, Mixture, Rule, Unscented};
use models::{
    ContactGap, GpPushModel, ProcessKind, PushModel, PushParticle, RecordedPush, RollOut,
    RollOutSettings, SlipMixture, StepCorrelation, StepErrors, Training, learn_options,
};
use nalgebra::{DMatrix, DVector};
use report::{Axis, Color, Ellipse, Figure, LegendPlace, Panel, Points};
use serde_json::json;

use super::ends::recorded_settings;
use super::pushes::{pushes, steps_of, turns};
use super::scene::place_of;
use super::trained::{Learnt, Setting, learn};
use crate::figures::inputs::{Inputs, SEED};
use crate::figures::sketch::Sketch;
use crate::held_out::quantile;

/// Particles that the others are held against.
const MANY: usize = 1_000_000;
const MANY_QUICK: usize = 40_000;
const FEW: usize = 1000;
const N_PUSHES: usize = 6;
const MOST_LEARNT: usize = 300;
/// Particles at which densities are compared, and drawn.
const N_READ: usize = 20_000;
const N_DRAWN: usize = 1500;
/// Half axes of the ellipse that holds 95 % of a Gaussian in the plane, in standard deviations.
const REACH_95: f64 = 2.447_746_830_680_816;
/// Standard deviations by which all densities are widened, in m, m and rad: less than any sensor's.
const WIDER_SD: [f64; 3] = [1e-5, 1e-5, 1e-4];
const MM: f64 = 1e3;

/// A way to do without particles: its name, its rule and the most Gaussians that it keeps.
struct Method {
    name: &'static str,
    color: Color,
    rule: &'static dyn Rule,
    n_components: usize,
}

const METHODS: [Method; 3] = [
    Method { name: "unscented", color: Color::ORANGE, rule: &Unscented, n_components: 1 },
    Method {
        name: "Gauss–Hermite",
        color: Color::BLUE,
        rule: &GaussHermite { order: 3 },
        n_components: 1,
    },
    Method { name: "8 Gaussians", color: Color::VERMILION, rule: &Unscented, n_components: 8 },
];

/// A model with a way for its errors to go together.
struct Case<'a> {
    name: &'static str,
    model: &'a dyn PushModel,
    errors: StepErrors,
    /// Particles that it is held against.
    n_particles: usize,
}

/// The divergences of a case, one list a method and one number a push; the last is of few particles.
struct Found {
    name: &'static str,
    divergences: Vec<Vec<f64>>,
}

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let pushes = pushes(inputs)?;
    let setting = Setting { friction: inputs.pusher()?.friction, support: inputs.support()? };
    let turns = turns(&pushes);
    let turn = turns.first().context("pushes take turns")?;
    let Learnt { correlation, .. } =
        learn(&setting, turn, &["gp"])?.pop().context("a process was trained")?;
    let steps = steps_of(&turn.learn);
    let steps = &steps[..MOST_LEARNT.min(steps.len())];
    let mut options = learn_options();
    options.n_starts = 1;
    let training = Training { process: ProcessKind::Gp, ..options.into() };
    let process = GpPushModel::train(steps, &training)?.0.tabulated()?.0;
    let mixture = SlipMixture::train(steps, &training)?.tabulated()?;
    let held = StepErrors::Held(correlation.clone());
    let n_particles = if inputs.quick() { MANY_QUICK } else { MANY };
    let independent = StepErrors::Independent;
    let gp = |name, errors| Case { name, model: &process as &dyn PushModel, errors, n_particles };
    // The mixture's probabilities are sums over all its training steps.
    let n_fewer = n_particles / 10;
    let cases = [
        gp("gp", independent.clone()),
        gp("gp, errors held", held),
        Case { name: "mixture", model: &mixture, errors: independent, n_particles: n_fewer },
    ];
    let tested: Vec<&RecordedPush> = turn.test.iter().take(N_PUSHES).copied().collect();
    let mut figure = Figure::new(1, cases.len()).panel_size(320.0, 300.0);
    let mut all = Vec::new();
    for case in &cases {
        let mut divergences = vec![Vec::new(); METHODS.len() + 1];
        for (index, push) in tested.iter().enumerate() {
            let ends = Ends::of(case, push, &correlation)?;
            divergences.iter_mut().zip(ends.divergences()?).for_each(|(all, own)| all.push(own));
            if index == 0 {
                figure = figure.with(ends.panel(case.name)?);
            }
        }
        all.push(Found { name: case.name, divergences });
    }
    let told: Vec<String> = all.iter().map(Found::in_words).collect();
    let caption = format!(
        "Ends of held-out pushes by {n_particles} particles (of a mixture {n_fewer}), and by Gaussians that are carried through the \
         push (95 % ellipses of the place, of the push from {}; the Gaussian fitted to the particles is drawn in black). By \
         how many nats a particle is less likely than under that fitted Gaussian (for one Gaussian its \
         Kullback–Leibler divergence; below 0 the mixture is nearer than any Gaussian), median and \
         worst of {} pushes, all widened by 10 µm and 0.1 mrad: {}.",
        tested.first().map_or(String::new(), |push| place_of(push)),
        tested.len(),
        told.join("; ")
    );
    let alt = "Three clouds of particles with the ellipses of three methods.";
    let numbers: Vec<_> = all.iter().map(Found::numbers).collect();
    Ok(Sketch::new(figure, serde_json::Value::Array(numbers), &caption, alt))
}

/// The end of one push: by particles, and without.
struct Ends {
    particles: Vec<DVector<f64>>,
    /// With the moments of the particles.
    fitted: Gaussian,
    /// One a method.
    matched: Vec<Mixture>,
    /// With the moments of a few other particles.
    of_few: Gaussian,
}

impl Ends {
    fn of(case: &Case<'_>, push: &RecordedPush, correlation: &StepCorrelation) -> Result<Self> {
        let settings = RollOutSettings {
            n_particles: case.n_particles,
            seed: SEED,
            errors: case.errors.clone(),
            // Known exactly, places along the normal would have no density.
            gap: ContactGap { sd: correlation.gap.sd.max(1e-5), ..correlation.gap },
            start_sd: push.pose_sd[0],
            ..recorded_settings(ContactGap::default())
        };
        let start_wb = &push.poses_wb[0];
        let rolled = |settings: &RollOutSettings| -> Result<(Vec<DVector<f64>>, Gaussian)> {
            let roll_out = RollOut { model: case.model, pushed: &push.pushed, settings };
            let mut last = Vec::new();
            let n_steps = push.path.steps(settings.step)?.len();
            let mut seen = 0;
            let watch = |_: &_, now: &[PushParticle]| {
                if seen == n_steps {
                    last = now.iter().map(place).collect();
                }
                seen += 1;
            };
            roll_out.run(start_wb, &push.path, watch)?;
            let fitted = fitted(&last)?;
            Ok((last, fitted))
        };
        let (particles, all) = rolled(&settings)?;
        let few = RollOutSettings { n_particles: FEW, seed: SEED + 1, ..settings.clone() };
        let roll_out = RollOut { model: case.model, pushed: &push.pushed, settings: &settings };
        let matched = METHODS.iter().map(|method| {
            let moments =
                roll_out.matched(start_wb, &push.path, method.rule, method.n_components)?;
            moments.into_iter().next_back().context("a push has an end")
        });
        let matched = matched.collect::<Result<_>>()?;
        Ok(Self { particles, fitted: all, matched, of_few: rolled(&few)?.1 })
    }

    /// Of every method, then of few particles: mean log density of the particles under the Gaussian
    /// fitted to them, less that under the other.
    fn divergences(&self) -> Result<Vec<f64>> {
        let every = self.particles.len().div_ceil(N_READ);
        let mean = |density: &dyn Fn(&DVector<f64>) -> Result<f64>| -> Result<f64> {
            let read = self.particles.iter().step_by(every);
            let logs = read.map(density).collect::<Result<Vec<_>>>()?;
            Ok(logs.iter().sum::<f64>() / logs.len() as f64)
        };
        let of_one = |gaussian: &Gaussian| {
            let wide = widened(gaussian)?;
            mean(&|at| Ok(wide.log_density(at)?))
        };
        let of_mixture = |mixture: &Mixture| {
            let parts = mixture.components().iter();
            let wide = parts.map(|(part, weight)| Ok((widened(part)?, *weight)));
            let wide = Mixture::new(wide.collect::<Result<_>>()?)?;
            mean(&|at| Ok(wide.log_density(at)?))
        };
        let best = of_one(&self.fitted)?;
        let of_few = std::iter::once_with(|| of_one(&self.of_few));
        let all = self.matched.iter().map(of_mixture).chain(of_few);
        all.map(|log| Ok(best - log?)).collect()
    }

    fn panel(&self, name: &str) -> Result<Panel> {
        let every = self.particles.len().div_ceil(N_DRAWN);
        let drawn: Vec<[f64; 2]> =
            self.particles.iter().step_by(every).map(|at| [MM * at[0], MM * at[1]]).collect();
        let panel = Panel::new(Axis::new("world x / mm"), Axis::new("world y / mm"))
            .equal_aspect()
            .title(name)
            .legend(LegendPlace::Below)
            .with(Points::at(&drawn).color(Color::GRAY).radius(1.0).label("particles"))
            .with(ellipse(&self.fitted).color(Color::INK));
        METHODS.iter().zip(&self.matched).try_fold(panel, |panel, (method, mixture)| {
            let joined = mixture.moments()?;
            Ok(panel.with(ellipse(&joined).color(method.color).label(method.name)))
        })
    }
}

fn place(particle: &PushParticle) -> DVector<f64> {
    let pose = particle.pose_wb;
    DVector::from_vec(vec![pose.position.x, pose.position.y, pose.angle])
}

/// The Gaussian with the moments of equal particles.
fn fitted(particles: &[DVector<f64>]) -> Result<Gaussian> {
    let n = particles.len() as f64;
    let first = particles.first().context("there are particles")?;
    let mean = particles.iter().fold(DVector::zeros(first.len()), |sum, at| sum + at) / n;
    let mut covariance = DMatrix::zeros(first.len(), first.len());
    for at in particles {
        let off = at - &mean;
        covariance.ger(1.0 / n, &off, &off, 1.0);
    }
    Ok(Gaussian::new(mean, covariance)?)
}

/// A little wider: a part of a mixture that came from a single point of a rule has no density along
/// the normal of its contact.
fn widened(gaussian: &Gaussian) -> Result<Gaussian> {
    let variances = WIDER_SD.map(|sd| sd * sd);
    let wider = DMatrix::from_diagonal(&DVector::from_row_slice(&variances));
    Ok(Gaussian::new(gaussian.mean().clone(), gaussian.covariance() + wider)?)
}

/// Where 95 % of the places are.
fn ellipse(gaussian: &Gaussian) -> Ellipse {
    let (mean, of) = (gaussian.mean(), |i, j| MM * MM * gaussian.covariance()[(i, j)]);
    let covariance = [of(0, 0), of(0, 1), of(1, 1)];
    Ellipse::of_covariance([MM * mean[0], MM * mean[1]], covariance, REACH_95)
}

impl Found {
    fn names() -> impl Iterator<Item = String> {
        let methods = METHODS.iter().map(|method| method.name.to_owned());
        methods.chain(std::iter::once(format!("{FEW} particles")))
    }

    fn in_words(&self) -> String {
        let told: Vec<String> = Self::names()
            .zip(&self.divergences)
            .map(|(name, all)| {
                let worst = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                format!("{name} {:.3} ({worst:.3})", quantile(all.clone(), 0.5))
            })
            .collect();
        format!("{} — {}", self.name, told.join(", "))
    }

    fn numbers(&self) -> serde_json::Value {
        let methods: Vec<_> = Self::names()
            .zip(&self.divergences)
            .map(|(name, all)| json!({ "method": name, "divergence_nats": all }))
            .collect();
        json!({ "case": self.name, "methods": methods })
    }
}
