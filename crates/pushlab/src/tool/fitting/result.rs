//! What a fit found, for programs and for people.

use std::fmt;
use std::path::{Path, PathBuf};

use diagnosis::{
    EffectFit, FieldRegion, Fit, FrictionFieldFit, Interval, NuisanceFit, ParameterFit, SpreadFit,
};
use effects::Spread;
use models::{Calibration, Cluster};
use serde::Serialize;

use crate::tool::people::{behind_number, digits_of_error, four_digits};
use crate::tool::terminal::TITLE;
use crate::tool::whole_pushes::Told;

/// A fit and the file that it was written to.
#[derive(Serialize)]
pub(crate) struct Fitted {
    /// The model file.
    model: PathBuf,
    set: String,
    n_pushes: usize,
    n_steps: usize,
    /// Held-out pushes.
    n_kept: usize,
    cluster: Cluster,
    n_clusters: usize,
    /// Without what was fitted, and with it.
    whitened_rms: [f64; 2],
    effects: Vec<EffectFit>,
    #[serde(skip_serializing_if = "Option::is_none")]
    field: Option<FrictionFieldFit>,
    nuisances: Vec<NuisanceFit>,
    /// Whether the model file has the nuisances.
    writes_nuisances: bool,
    coordinates: Vec<String>,
    covariance: Vec<Vec<f64>>,
    iterations: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    per_push: Option<PerPush>,
    /// How sure the model may be of whole pushes; none where these do not tell.
    calibration: Option<Calibration>,
}

/// By how much an effect differs from push to push, and from place to place.
#[derive(Serialize)]
struct PerPush {
    parameters: Vec<&'static str>,
    #[serde(flatten)]
    spread: Spread,
    #[serde(skip_serializing_if = "Option::is_none")]
    per_session: Option<Spread>,
    per_place: Spread,
    /// Of the log density of a cluster, in nats.
    gain: f64,
    gain_se: f64,
}

impl Fitted {
    /// The same, with what was found of the differences from push to push.
    pub(crate) fn with_spread(self, found: &SpreadFit) -> Self {
        let [gain, gain_se] = found.gain;
        let SpreadFit { per_push: spread, per_session, per_place, .. } = *found;
        let parameters = found.parameters.clone();
        let per_push = PerPush { parameters, spread, per_session, per_place, gain, gain_se };
        Self { per_push: Some(per_push), ..self }
    }

    pub(super) fn new(
        fit: Fit,
        (set, model): (&str, &Path),
        (n_kept, writes_nuisances): (usize, bool),
        calibration: Option<Calibration>,
    ) -> Self {
        let Fit { n_pushes, n_steps, cluster, n_clusters, whitened_rms, iterations, .. } = fit;
        let rows = fit.covariance.row_iter().map(|row| row.iter().copied().collect());
        Self {
            model: model.into(),
            set: set.to_owned(),
            n_pushes,
            n_steps,
            n_kept,
            cluster,
            n_clusters,
            whitened_rms,
            covariance: rows.collect(),
            effects: fit.effects,
            field: fit.field,
            nuisances: fit.nuisances,
            writes_nuisances,
            coordinates: fit.coordinates,
            iterations,
            per_push: None,
            calibration,
        }
    }
}

impl fmt::Display for Fitted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { n_pushes, n_steps, n_kept, set, .. } = self;
        writeln!(f, "{TITLE}wrote {}{TITLE:#}", self.model.display())?;
        write!(f, "  fit to {n_pushes} pushes ({n_steps} steps) of {set}; ")?;
        writeln!(f, "{n_kept} others are kept to confirm it")?;
        for EffectFit { id, parameters, follows, resemblances, .. } in &self.effects {
            writeln!(f, "{TITLE}{id}{TITLE:#}")?;
            let mut told = parameters.iter().filter(|parameter| !is_nothing(parameter));
            told.try_for_each(|parameter| write_parameter(f, parameter))?;
            follows.iter().try_for_each(|parameter| write_parameter(f, parameter))?;
            let nearest =
                resemblances.iter().max_by(|a, b| a.correlation.total_cmp(&b.correlation));
            if let Some(alike) = nearest {
                writeln!(f, "  most like it: {} (correlation {:.2})", alike.id, alike.correlation)?;
            }
        }
        let regions = self.field.iter().flat_map(|field| &field.regions);
        regions.into_iter().try_for_each(|region| write_region(f, region))?;
        if let Some(of_pushes) = &self.per_push {
            let PerPush { parameters, spread, per_session, per_place, gain, gain_se } = of_pushes;
            let size = |spread: &Spread| match spread {
                Spread::Sd(sd) => format!("by {sd:.2e} (standard deviation)"),
                Spread::RelativeSd(sd) => format!("by a factor of e^{sd:.2} (standard deviation)"),
            };
            let names = parameters.join(" and ");
            writeln!(f, "  {names} from push to push {}", size(spread))?;
            if let Some(spread) = per_session {
                writeln!(f, "  {names} from session to session {}", size(spread))?;
            }
            writeln!(f, "  {names} from place to place, faster than a step, {}", size(per_place))?;
            writeln!(f, "  log density gained: {gain:.3} ± {gain_se:.3} nats a cluster")?;
        }
        let [before, after] = self.whitened_rms;
        writeln!(f, "error over noise on these pushes: {before:.2} before, {after:.2} after")?;
        if let Some(calibration) = &self.calibration {
            writeln!(f, "of whole pushes: {}", Told(calibration))?;
        }
        let is_written = if self.writes_nuisances { "written, too" } else { "not written" };
        writeln!(f, "{TITLE}left open beside it{TITLE:#}, {is_written}")?;
        self.nuisances.iter().try_for_each(|nuisance| write_nuisance(f, nuisance))
    }
}

/// Whether it is of a point or a cell that bears nothing, which no fit has moved.
fn is_nothing(parameter: &ParameterFit) -> bool {
    parameter.value == 0.0 && parameter.se == 0.0 && parameter.off == Some(0.0)
}

fn write_region(f: &mut fmt::Formatter<'_>, region: &FieldRegion) -> fmt::Result {
    let FieldRegion { n_pushes, area, range: [low, high], se, prior_sd } = region;
    let went = match n_pushes {
        0 => "no push",
        1 => "one push",
        _ => "several pushes",
    };
    let [area, low, high, se, prior_sd] =
        [area, low, high, se, prior_sd].map(|share| 100.0 * share);
    writeln!(
        f,
        "  where {went} went, {area:.0} % of its rectangle: {low:+.0} to {high:+.0} % of friction, \
         ± {se:.1} % (± {prior_sd:.0} % beforehand)"
    )
}

fn write_nuisance(f: &mut fmt::Formatter<'_>, nuisance: &NuisanceFit) -> fmt::Result {
    let NuisanceFit { id, name, unit, nominal, value, se, .. } = nuisance;
    let unit = behind_number(unit);
    match *nominal == 0.0 {
        true => writeln!(f, "  {id} {name}: {value:.1e} ± {se:.0e}{unit}"),
        false => {
            let nominal = four_digits(*nominal);
            writeln!(f, "  {id} {name}: {value:.3} ± {se:.3}{unit}, nominal {nominal}")
        }
    }
}

fn write_parameter(f: &mut fmt::Formatter<'_>, parameter: &ParameterFit) -> fmt::Result {
    let ParameterFit { name, unit, off, value, se, interval } = parameter;
    if *se == 0.0 && off.is_none() {
        return writeln!(f, "  {name}: {}{}, not moved", four_digits(*value), behind_number(unit));
    }
    let (digits, unit) = (digits_of_error(*se), behind_number(unit));
    write!(f, "  {name}: {value:.digits$} ± {se:.digits$}{unit}")?;
    match interval {
        Some(Interval { low95, high95 }) => {
            writeln!(f, "  (95 %: {low95:.digits$} to {high95:.digits$})")
        }
        None => writeln!(f),
    }
}
