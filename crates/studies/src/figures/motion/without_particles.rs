//! Figure M.8: whole pushes without particles, beside very many of them.

mod found;

use anyhow::{Context, Result};
use filter::{GaussHermite, Gaussian, Mixture, Unscented};
use models::{
    ContactGap, GpPushModel, Matching, ProcessKind, PushModel, PushParticle, RecordedPush, RollOut,
    RollOutSettings, Slip, SlipMixture, StepCorrelation, StepErrors, Training, learn_options,
};
use nalgebra::{DMatrix, DVector, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use report::{Axis, Color, Ellipse, Figure, Panel, Points};

use self::found::{Found, PushFound};
use super::divergence::{Cloud, Density, moments};
use super::ends::recorded_settings;
use super::pushes::{steps_of, turns};
use super::scene::place_of;
use super::trained::{Learnt, learn};
use crate::figures::inputs::{Inputs, SEED};
use crate::figures::sketch::Sketch;

/// Particles that the others are held against.
const MANY: usize = 500_000;
const MANY_QUICK: usize = 10_000;
const FEW: usize = 1000;
/// Pushes that go one way all along, and pushes whose contact changes between sticking and slipping.
const N_OF_EACH: [usize; 2] = [1, 2];
const MOST_LEARNT: usize = 300;
const N_DRAWN: usize = 1500;
/// Half axes of the ellipse that holds 95 % of a Gaussian in the plane, in standard deviations.
const REACH_95: f64 = 2.447_746_830_680_816;
/// Of all particles, the shares by which the estimate's own error is shown.
const SHARES: [usize; 3] = [100, 10, 1];
const MM: f64 = 1e3;

/// A way to do without particles, and the most Gaussians that it keeps.
struct Method {
    name: &'static str,
    /// On an axis.
    short: &'static str,
    color: Color,
    matching: Matching<'static>,
    n_components: usize,
}

const GRID: GaussHermite = GaussHermite { order: 3 };

const METHODS: [Method; 5] = [
    method("unscented", "U", Color::ORANGE, Matching::Points(&Unscented), 1),
    method("Gauss–Hermite", "GH", Color::BLUE, Matching::Points(&GRID), 1),
    method("exact", "E", Color::GREEN, Matching::Exact(&GRID), 1),
    method("4 unscented", "4 U", Color::PURPLE, Matching::Points(&Unscented), 4),
    method("4 exact", "4 E", Color::VERMILION, Matching::Exact(&GRID), 4),
];

const fn method(
    name: &'static str,
    short: &'static str,
    color: Color,
    matching: Matching<'static>,
    n_components: usize,
) -> Method {
    Method { name, short, color, matching, n_components }
}

/// Beside the methods: the Gaussian fitted to all particles, and that of few others.
const FITTED: [(&str, &str); 2] = [("fitted", "fit"), ("1000 particles", "1000")];

/// A model with a way for its errors to go together.
struct Case<'a> {
    name: &'static str,
    model: &'a dyn PushModel,
    errors: StepErrors,
    /// Particles that it is held against.
    n_particles: usize,
}

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let pushes = inputs.whole_pushes()?;
    let setting = inputs.setting()?;
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
    let tested = chosen(&turn.test);
    let mut figure = Figure::new(2, cases.len()).panel_size(320.0, 300.0).one_legend();
    let mut all = Vec::new();
    for case in &cases {
        let (name, n_particles) = (case.name, case.n_particles);
        let mut found = Found {
            name,
            n_particles,
            pushes: Vec::new(),
            by_share: [0.0; SHARES.len()],
            floor: [[0.0; SHARES.len()]; 2],
        };
        for (index, push) in tested.iter().enumerate() {
            let ends = Ends::of(case, push, &correlation)?;
            found.pushes.push(ends.divergences()?);
            if index == 0 {
                figure = figure.with(ends.panel(case.name)?);
                found.by_share = ends.by_share()?;
                found.floor = ends.floor(&Ends::particles(case, push, &correlation, SEED + 2)?)?;
            }
        }
        all.push(found);
    }
    let figure = all.iter().fold(figure, |figure, found| figure.with(found.panel()));
    let place = tested.first().map_or(String::new(), |push| place_of(push));
    let caption = caption(&place, n_particles, n_fewer, &all);
    let alt = "Three clouds of particles with the ellipses of five methods, and how far each is from them.";
    let numbers: Vec<_> = all.iter().map(Found::numbers).collect();
    Ok(Sketch::new(figure, serde_json::Value::Array(numbers), &caption, alt))
}

fn caption(place: &str, n_particles: usize, n_fewer: usize, all: &[Found]) -> String {
    let told: Vec<String> = all.iter().map(Found::in_words).collect();
    format!(
        "Ends of held-out pushes by {n_particles} particles (of the mixture {n_fewer}), and by Gaussians that are \
         carried through the push. Above: 95 % ellipses of the place, of the push from {place}; the Gaussian fitted \
         to the particles is drawn in black. Below: the Kullback–Leibler divergence of each method from the \
         particles, in nats, by the distances of particles to their tenth neighbors, all widened by 10 µm and \
         0.1 mrad: of pushes that stick or slip all along (discs) and of pushes that change (rings); the line \
         is what the estimate makes of as many draws of a Gaussian and that Gaussian. U: \
         unscented; GH: Gauss–Hermite of order 3; E: through the process in closed form; 4: at most four \
         Gaussians; fit: the Gaussian fitted to the particles; 1000: fitted to so many others. Medians over \
         the pushes: {}.",
        told.join("; ")
    )
}

/// Pushes that go one way all along, then pushes that change.
fn chosen<'a>(test: &[&'a RecordedPush]) -> Vec<&'a RecordedPush> {
    let of = |changing: bool, n: usize| {
        test.iter().filter(move |push| changes(push) == changing).take(n).copied()
    };
    let [steady, changing] = N_OF_EACH;
    of(false, steady).chain(of(true, changing)).collect()
}

/// Whether the contact sticks and slips, or slips both ways.
fn changes(push: &RecordedPush) -> bool {
    let ways: Vec<Slip> = push.steps.iter().map(Slip::of).collect();
    ways.iter().any(|way| *way != ways[0])
}

/// The end of one push: by particles, and without.
struct Ends {
    changes: bool,
    particles: Vec<Vector3<f64>>,
    cloud: Cloud,
    /// With the moments of the particles.
    fitted: Gaussian,
    /// One a method.
    matched: Vec<Mixture>,
    /// With the moments of a few other particles.
    of_few: Gaussian,
}

impl Ends {
    fn of(case: &Case<'_>, push: &RecordedPush, correlation: &StepCorrelation) -> Result<Self> {
        let settings = settings(case, push, correlation);
        let roll_out = RollOut { model: case.model, pushed: &push.pushed, settings: &settings };
        let matched = METHODS.iter().map(|method| {
            let Method { matching, n_components, .. } = method;
            let start_wb = &push.poses_wb[0];
            let moments = roll_out.matched(start_wb, &push.path, *matching, *n_components)?;
            moments.into_iter().next_back().context("a push has an end")
        });
        let matched = matched.collect::<Result<_>>()?;
        let particles = Self::particles(case, push, correlation, SEED)?;
        let few = Case { n_particles: FEW, errors: case.errors.clone(), ..*case };
        let of_few = fitted(&Self::particles(&few, push, correlation, SEED + 1)?)?;
        Ok(Self {
            changes: changes(push),
            cloud: Cloud::of(&particles, SEED)?,
            fitted: fitted(&particles)?,
            particles,
            matched,
            of_few,
        })
    }

    /// Where the particles of a seed end.
    fn particles(
        case: &Case<'_>,
        push: &RecordedPush,
        correlation: &StepCorrelation,
        seed: u64,
    ) -> Result<Vec<Vector3<f64>>> {
        let settings = RollOutSettings { seed, ..settings(case, push, correlation) };
        let roll_out = RollOut { model: case.model, pushed: &push.pushed, settings: &settings };
        let start_wb = &push.poses_wb[0];
        let mut filter = roll_out.start(start_wb, &push.path)?;
        for step in push.path.steps(settings.step)? {
            filter.predict(&roll_out.motion(&step)?)?;
        }
        Ok(filter.particles().iter().map(place).collect())
    }

    /// How far the methods are from the particles.
    fn divergences(&self) -> Result<PushFound> {
        let alone = |gaussian: &Gaussian| Mixture::new(vec![(gaussian.clone(), 1.0)]);
        let fits = [alone(&self.fitted)?, alone(&self.of_few)?];
        let densities = self.matched.iter().chain(&fits).map(Density::of);
        let densities = densities.collect::<Result<Vec<_>>>()?;
        let divergences = densities.iter().map(|density| self.cloud.divergence_of(density));
        Ok(PushFound { changes: self.changes, divergences: divergences.collect() })
    }

    /// That of the exact method, by fewer of the particles.
    fn by_share(&self) -> Result<[f64; SHARES.len()]> {
        let exact = METHODS.iter().position(|method| method.name == "exact");
        let exact = Density::of(&self.matched[exact.context("one method is exact")?])?;
        let mut found = [0.0; SHARES.len()];
        for (divergence, share) in found.iter_mut().zip(SHARES) {
            *divergence = self.thinned(share)?.divergence_of(&exact);
        }
        Ok(found)
    }

    /// What the estimates make of draws of the fitted Gaussian, and of others that come from the same.
    fn floor(&self, others: &[Vector3<f64>]) -> Result<[[f64; SHARES.len()]; 2]> {
        // Not the draws by which the cloud is widened.
        let mut random = ChaCha8Rng::seed_from_u64(SEED + 4);
        let draw = |_| Vector3::from_iterator(self.fitted.sample(&mut random).iter().copied());
        let draws: Vec<Vector3<f64>> = (0..others.len()).map(draw).collect();
        let itself = Density::of(&Mixture::new(vec![(self.fitted.clone(), 1.0)])?)?;
        let mut floor = [[0.0; SHARES.len()]; 2];
        for (k, share) in SHARES.into_iter().enumerate() {
            let n = others.len() / share;
            floor[0][k] = Cloud::of(&Cloud::thinned(&draws, n), SEED)?.divergence_of(&itself);
            let own = self.thinned(share)?;
            let others = own.beside(&Cloud::thinned(others, n), SEED + 3);
            floor[1][k] = own.divergence_of_cloud(&others);
        }
        Ok(floor)
    }

    fn thinned(&self, share: usize) -> Result<Cloud> {
        Cloud::of(&Cloud::thinned(&self.particles, self.particles.len() / share), SEED)
    }

    fn panel(&self, name: &str) -> Result<Panel> {
        let drawn: Vec<[f64; 2]> = Cloud::thinned(&self.particles, N_DRAWN)
            .iter()
            .map(|at| [MM * at[0], MM * at[1]])
            .collect();
        let panel = Panel::new(Axis::new("world x / mm"), Axis::new("world y / mm"))
            .title(name)
            .with(Points::at(&drawn).color(Color::GRAY).radius(1.0).label("particles"))
            .with(ellipse(&self.fitted).color(Color::INK));
        METHODS.iter().zip(&self.matched).try_fold(panel, |panel, (method, mixture)| {
            let joined = mixture.moments()?;
            Ok(panel.with(ellipse(&joined).color(method.color).label(method.name)))
        })
    }
}

fn settings(
    case: &Case<'_>,
    push: &RecordedPush,
    correlation: &StepCorrelation,
) -> RollOutSettings {
    RollOutSettings {
        n_particles: case.n_particles,
        seed: SEED,
        errors: case.errors.clone(),
        // Known exactly, places along the normal would have no density.
        gap: ContactGap { sd: correlation.gap.sd.max(1e-5), ..correlation.gap },
        start_sd: push.pose_sd[0],
        ..recorded_settings(ContactGap::default())
    }
}

fn place(particle: &PushParticle) -> Vector3<f64> {
    let pose = particle.pose_wb;
    Vector3::new(pose.position.x, pose.position.y, pose.angle)
}

/// The Gaussian with the moments of equal particles.
fn fitted(particles: &[Vector3<f64>]) -> Result<Gaussian> {
    let (mean, covariance) = moments(particles);
    let mean = DVector::from_iterator(3, mean.iter().copied());
    Ok(Gaussian::new(mean, DMatrix::from_iterator(3, 3, covariance.iter().copied()))?)
}

/// Where 95 % of the places are.
fn ellipse(gaussian: &Gaussian) -> Ellipse {
    let (mean, of) = (gaussian.mean(), |i, j| MM * MM * gaussian.covariance()[(i, j)]);
    let covariance = [of(0, 0), of(0, 1), of(1, 1)];
    Ellipse::of_covariance([MM * mean[0], MM * mean[1]], covariance, REACH_95)
}
