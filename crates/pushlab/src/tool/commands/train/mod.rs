//! `pushlab train`: a model learnt from a part of the pushes, alone or beside physics.

mod kind;
mod scores;
mod text;

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Result, bail, ensure};
use dataset::IngestSettings;
use diagnosis::{Observations, split};
use models::{
    Calibration, Description, GpPushModel, Hybrid, MadeFor, ModelFile, ProcessReport, PushModel,
    Setup, Split, StepFeatures, StepObservation, Training, Unexplained, learn_options,
};
use serde::Serialize;

use self::kind::{Chosen, Extra, Kind, Residual, Typed};
use self::scores::{Score, scores};
use crate::tool::command_line::seed_parser;
use crate::tool::destination::Force;
use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::some_of::some_of;
use crate::tool::step_size::StepSize;
use crate::tool::step_source::{Reading, StepSource, Steps};
use crate::tool::terminal::Terminal;
use crate::tool::whole_pushes::calibration_of_fitted;
use crate::tool::wrong_usage::WrongUsage;

/// Train a model on a part of the pushes, alone or on what physics leaves over
///
/// A quarter of the pushes is held out first, as by the other commands, and tells how good the model
/// is. A hybrid fits the physics of a model file with its effects, and learns what is left so that it
/// says nothing that the fitted physics could say: its file tells which share is unexplained.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(flatten)]
    source: StepSource,
    /// What to train
    #[arg(long)]
    kind: Kind,
    /// Of a hybrid: what learns the rest; else gp
    #[arg(long, value_name = "KIND")]
    residual_kind: Option<Residual>,
    /// Of a hybrid: the model file whose physics come first; else model.toml
    #[arg(long, value_name = "FILE", value_parser = file_ending::model)]
    model: Option<PathBuf>,
    /// Inputs beside p and beta: the pusher's speed, the edge by its normal; or, in place of p, the
    /// contact as shapes have it in common
    #[arg(long, value_name = "INPUTS", value_delimiter = ',')]
    with: Vec<Extra>,
    /// Most steps to learn from, a random part; else 1000 of gp, 300 of vhgp, and all of the others
    #[arg(short = 'n', long, value_name = "N", value_parser = clap::value_parser!(u32).range(20..))]
    rows: Option<u32>,
    /// Length of a step of recordings: a time or a way, as of `compare`; else 200ms
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    step: Option<StepSize>,
    /// Seed of the held-out pushes, and of all else that is drawn
    #[arg(long, value_name = "SEED", default_value_t = 7, value_parser = seed_parser())]
    seed: u64,
    /// Where to write the model; its weights are written beside it
    #[arg(short, long, value_name = "FILE", value_parser = file_ending::model)]
    output: PathBuf,
    #[command(flatten)]
    force: Force,
}

const EXAMPLES: &str = "\
Examples:
  pushlab train pushes --kind gp -o gp.toml
  pushlab train pushes --kind hybrid --residual-kind rff --model better.toml -o hybrid.toml
  pushlab train pushes --kind spgp --with speed,edge -o spgp.toml
  pushlab train shapes --kind gp --with contact -o shapes.toml
  pushlab train table.csv --preset mit-table --kind gp -n 500 -o gp.toml
then:
  pushlab compare pushes --model hybrid.toml --against better.toml";

/// A trained model, and how well it predicts pushes that it has not seen.
#[derive(Serialize)]
struct Trained {
    /// The model file.
    model: PathBuf,
    #[serde(flatten)]
    chosen: Chosen,
    inputs: Vec<&'static str>,
    /// Pushes and steps of the part to learn from, and the steps that were learnt from.
    n_pushes: usize,
    n_steps: usize,
    n_learnt: usize,
    /// Parameters of the physics that the steps do not determine.
    kept: Vec<String>,
    /// Hyperparameters at the end of what they may be, of each output.
    at_bound: Vec<Vec<String>>,
    /// Shares of what was learnt in what a hybrid says.
    unexplained: Option<Unexplained>,
    unseen: Unseen,
    /// How sure the model may be of whole pushes; none where those that it has not seen do not tell.
    calibration: Option<Calibration>,
}

/// The held-out pushes.
#[derive(Serialize)]
struct Unseen {
    n_pushes: usize,
    n_steps: usize,
    scores: Vec<Score>,
    unexplained: Option<Unexplained>,
}

/// Fewer steps say nothing about a function of two inputs.
const FEWEST: usize = 20;

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let chosen = Chosen::new(args.kind, args.residual_kind)?;
    let mut origin = args.origin();
    let base = args.base(&mut origin)?;
    let model = base.is_some().then(|| args.model_file());
    let destination = args.force.file(&args.output, &args.source.inputs().with(&model))?;
    let parts = Parts::read(args, base.as_ref(), &mut origin, terminal)?;
    let started = Instant::now();
    let trained = args.train(chosen, base.as_ref(), &parts)?;
    terminal.note(format_args!("trained in {:.1} s", started.elapsed().as_secs_f64()));
    let description = trained.model.describe()?;
    let name = match &base {
        Some(base) => format!("{}, and {} beside it", base.name, chosen.process.id()),
        None => format!("{} trained on {}", chosen.process.id(), args.source.set.display()),
    };
    let [_, test] = &parts.observations;
    let steps = test.motion_steps()?;
    let is_hybrid = args.kind == Kind::Hybrid;
    let inputs: Vec<_> = steps.iter().map(|step| step.input.clone()).collect();
    let unexplained = is_hybrid.then(|| trained.model.unexplained(&inputs)).transpose()?;
    let mut result = Trained {
        model: args.output.clone(),
        chosen,
        inputs: args.features().names(),
        n_pushes: parts.observations[0].pushes().len(),
        n_steps: trained.n_steps,
        n_learnt: trained.n_learnt,
        kept: trained.kept,
        at_bound: trained.reports.into_iter().map(|report| report.at_bound).collect(),
        unexplained: unexplained_of(&description),
        unseen: Unseen {
            n_pushes: test.pushes().len(),
            n_steps: steps.len(),
            scores: scores(trained.model.as_ref(), &steps, is_hybrid)?,
            unexplained,
        },
        calibration: None,
    };
    let (split, made_for) = (Some(parts.split), Some(parts.made_for));
    let mut file = ModelFile { split, made_for, ..ModelFile::new(name, description) };
    file.calibration = calibration_of_fitted((&args.source, args.step), &file, terminal);
    result.calibration.clone_from(&file.calibration);
    file.write_to(destination)?;
    terminal.finish(&origin, &result, &result)
}

/// What a hybrid's weights say about its training steps.
fn unexplained_of(description: &Description) -> Option<Unexplained> {
    Some(description.weights.as_ref()?.orthogonal_discrepancy.as_ref()?.unexplained)
}

/// The steps to learn from, and those held out.
struct Parts {
    split: Split,
    observations: [Observations; 2],
    made_for: MadeFor,
}

impl Parts {
    /// Splits as the base model says where it was fitted to this set, else by the seed; the choice
    /// is that of `fit` and `diagnose`, which read recordings in another way.
    fn read(
        args: &Args,
        base: Option<&ModelFile>,
        origin: &mut Origin,
        terminal: &Terminal,
    ) -> Result<Self> {
        let steady = args.source.read(Reading::Steady, terminal)?;
        let known = base.and_then(|base| base.split.clone());
        let known = known.filter(|known| steady.observations.are_of(known));
        let split = match known {
            Some(known) => known,
            None => split(&steady.observations, args.seed)?,
        };
        if steady.n_pushes.is_none() && args.step.is_some() {
            bail!(WrongUsage("--step is for recordings; the steps of a table are made"));
        }
        // A learnt model is asked near vertices, too, where it is compared with no step.
        let usual = StepSize(IngestSettings::default().step);
        let reading = Reading::Plain(args.step.unwrap_or(usual));
        let to_learn = match steady.n_pushes {
            Some(_) => Some(args.source.read(reading, &terminal.silent())?.observations),
            None => None,
        };
        let Steps { rig, observations, inputs, .. } = steady;
        origin.inputs.extend(inputs);
        let to_learn = to_learn.as_ref().unwrap_or(&observations);
        let unseen = if args.step.is_some() { to_learn } else { &observations };
        let observations = [to_learn.part(&split.fit)?, unseen.part(&split.confirm)?];
        Ok(Self { split, observations, made_for: rig.made_for() })
    }
}

/// A model fresh from training.
struct Fresh {
    model: Box<dyn PushModel>,
    reports: [ProcessReport; 3],
    kept: Vec<String>,
    n_steps: usize,
    n_learnt: usize,
}

impl Args {
    /// The model that a hybrid is beside.
    fn model_file(&self) -> PathBuf {
        self.model.clone().unwrap_or_else(|| "model.toml".into())
    }

    /// The model whose physics a hybrid begins with.
    fn base(&self, origin: &mut Origin) -> Result<Option<ModelFile>> {
        if self.kind != Kind::Hybrid {
            if self.model.is_some() {
                bail!(WrongUsage("--model is for --kind hybrid; the other kinds know no physics"));
            }
            return Ok(None);
        }
        let path = self.model_file();
        readable(&path)?;
        origin.inputs.push(Input::file(&path)?);
        Ok(Some(ModelFile::read(&path)?))
    }

    fn train(&self, chosen: Chosen, base: Option<&ModelFile>, parts: &Parts) -> Result<Fresh> {
        let observations = &parts.observations[0];
        let all = observations.motion_steps()?;
        let (n_steps, n_pushes) = (all.len(), observations.pushes().len());
        ensure!(
            n_steps >= FEWEST,
            "training needs at least {FEWEST} steps, and the {n_pushes} pushes to learn from have \
             {n_steps}; record more pushes, or take shorter steps"
        );
        let most = self.rows.map_or(chosen.most_rows(), |rows| rows as usize);
        let steps: Vec<StepObservation> = some_of(&all, most, self.seed);
        let training = self.training(chosen);
        let n_learnt = steps.len();
        let (model, reports, kept): (Box<dyn PushModel>, _, _) = match base {
            Some(base) => {
                let setup = Setup { support: observations.support(), own: Vec::new() };
                let (model, report) =
                    Hybrid::train(&base.description, Some(setup), &steps, &training)?;
                (Box::new(model), report.processes, report.kept)
            }
            None => {
                let (model, reports) = GpPushModel::train(&steps, &training)?;
                (Box::new(model), reports, Vec::new())
            }
        };
        Ok(Fresh { model, reports, kept, n_steps, n_learnt })
    }

    fn training(&self, chosen: Chosen) -> Training {
        let mut options = learn_options();
        options.seed = self.seed;
        Training { process: chosen.process, features: self.features(), ..options.into() }
    }

    fn features(&self) -> StepFeatures {
        let has = |extra| self.with.contains(&extra);
        StepFeatures {
            contact: has(Extra::Contact),
            speed: has(Extra::Speed),
            normal: has(Extra::Edge),
        }
    }

    fn origin(&self) -> Origin {
        let with: Vec<_> = self.with.iter().map(|extra| extra.name()).collect();
        Origin::new("train")
            .path(&self.source.set)
            .option("kind", [self.kind.name()])
            .option("residual-kind", self.residual_kind.map(|kind| kind.name()))
            .paths("model", &self.model)
            .option("with", (!with.is_empty()).then(|| with.join(",")))
            .option("rows", self.rows)
            .option("step", self.step)
            .option("seed", [self.seed])
            .words(self.source.words())
    }
}
