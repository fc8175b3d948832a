//! A model fitted to the part of a recording set that fits may see.

mod options;
mod result;
mod spread;

use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};
use diagnosis::{
    Fit, FitSettings, NoiseModel, NotTestable, Observations, fit_with_noise, lacking, split,
};
use effects::{EffectInfo, by_id};
use models::{MadeFor, ModelFile, Split};
use output::OutputFile;

pub(crate) use self::options::FitOptions;
pub(crate) use self::result::Fitted;
use crate::tool::destination::{Force, Inputs};
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::step_source::{Reading, StepSource};
use crate::tool::terminal::Terminal;
use crate::tool::whole_pushes::calibration_of_fitted;

/// Recordings with their split.
pub(crate) struct Fitting {
    set: String,
    split: Split,
    train: Observations,
    /// Whether the model was fitted to these recordings before.
    is_known: bool,
    options: FitOptions,
    /// What the model is then made for.
    made_for: MadeFor,
}

impl Fitting {
    /// Reads a set or a table and splits it: as the model says where it was fitted to this set before, else
    /// by the seed.
    ///
    /// # Errors
    /// If it cannot be read, contradicts the mechanics, or has too few pushes.
    pub(crate) fn read(
        (source, options): (&StepSource, &FitOptions),
        model: &ModelFile,
        seed: u64,
        origin: &mut Origin,
        terminal: &Terminal,
    ) -> Result<Self> {
        let steps = source.read(Reading::Steady, terminal)?;
        origin.inputs.extend(steps.inputs);
        let (made_for, all) = (steps.rig.made_for(), steps.observations);
        let known = model.split.clone().filter(|split| all.are_of(split));
        let is_known = known.is_some();
        let split = match known {
            Some(known) => known,
            None => split(&all, seed)?,
        };
        let train = all.part(&split.fit)?;
        let (set, options) = (source.set.display().to_string(), options.clone());
        Ok(Self { set, split, train, is_known, options, made_for })
    }

    /// Values at which an effect changes nothing of a model on this set.
    ///
    /// # Errors
    /// If the model cannot predict these pushes.
    pub(crate) fn off(&self, model: &ModelFile, about: &EffectInfo) -> Result<Vec<f64>> {
        Ok(self.train.off(&model.description, about)?)
    }

    /// The fit of effects on the part for fits, with the noise that this part shows.
    ///
    /// # Errors
    /// What the fit says.
    pub(crate) fn fit(&self, model: &ModelFile, free: &[&str]) -> Result<Fit> {
        self.fit_with(model, free, &self.settings())
    }

    /// Refuses an effect that no fit to this set can tell of, whatever its size.
    ///
    /// # Errors
    /// If what it depends on was not measured, as a diagnosis says it.
    pub(crate) fn testable(&self, about: &EffectInfo) -> Result<()> {
        if let Some(NotTestable { because, measure, .. }) = lacking(&self.train, about) {
            let id = about.id;
            bail!("{id} is not testable with these pushes, because {because}; measure {measure}");
        }
        Ok(())
    }

    fn settings(&self) -> FitSettings {
        FitSettings {
            priors: !self.is_known,
            points: self.options.support_points(),
            ..FitSettings::default()
        }
    }

    fn fit_with(&self, model: &ModelFile, free: &[&str], settings: &FitSettings) -> Result<Fit> {
        for effect in free {
            self.testable(by_id(effect)?.info())?;
        }
        let description = &model.description;
        let noise = NoiseModel::learn(description, &settings.own, &self.train)?;
        Ok(fit_with_noise(&self.train, description, free, &noise, settings)?)
    }

    /// The same for a model of which only the values count.
    ///
    /// # Errors
    /// What the fit says.
    pub(crate) fn fit_values(&self, model: &ModelFile, free: &[&str]) -> Result<Fit> {
        let values = FitSettings { resemblances: false, ..self.settings() };
        self.fit_with(model, free, &values)
    }

    /// Writes the fitted model, as sure of whole pushes as those of its set let it be.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(crate) fn write(
        self,
        fit: Fit,
        name: String,
        (source, to): (&StepSource, OutputFile),
        terminal: &Terminal,
    ) -> Result<Fitted> {
        let writes_nuisances = self.options.writes_nuisances();
        let description = if writes_nuisances { &fit.with_nuisances } else { &fit.description };
        let description = description.clone();
        let n_kept = self.split.confirm.len();
        let (split, made_for) = (Some(self.split), Some(self.made_for));
        let mut model = ModelFile { split, made_for, ..ModelFile::new(name, description) };
        model.calibration = calibration_of_fitted((source, None), &model, terminal);
        let path = to.path().to_owned();
        let calibration = model.calibration.clone();
        model.write_to(to)?;
        Ok(Fitted::new(fit, (&self.set, &path), (n_kept, writes_nuisances), calibration))
    }
}

/// Reads a model file for a command that writes another one.
///
/// # Errors
/// If it cannot be read, or the other one cannot be written or is one of the inputs.
pub(crate) fn model_for(
    path: &PathBuf,
    (output, force): (&Path, &Force),
    inputs: Inputs,
    origin: &mut Origin,
) -> Result<(ModelFile, OutputFile)> {
    readable(path)?;
    let destination = force.file(output, &inputs.with([path]))?;
    origin.inputs.push(Input::file(path)?);
    let model = ModelFile::read(path)?;
    let has_mechanics = matches!(model.description.base, models::Base::Analytical(_));
    ensure!(has_mechanics, "{} is not analytical: it has nothing to fit or add to", path.display());
    Ok((model, destination))
}
