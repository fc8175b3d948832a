//! Nominal numbers that are wrong: a finding, too.

use models::{Analytical, Base, Description, Estimate};

use super::rules::{Objection, Rules};
use super::search::{Accepted, Found, Refused, Search};
use crate::{DiagnosisError, Fit, NuisanceFit, Whitening};

/// The numbers that every fit leaves open, and how exactly a manifest is taken to know them.
const NOMINAL: [(&str, f64); 3] =
    [("support-friction", 0.03), ("pusher-friction", 0.03), ("pressure-radius", 0.01)];

impl Search<'_> {
    /// Adds the nominal numbers that the best model does not leave at their values.
    ///
    /// They are left open in every fit, so no effect is blamed for them; here they are asked for.
    pub(super) fn add_nominal(
        &self,
        found: &mut Found,
        last: &Fit,
        whitening: &Whitening,
    ) -> Result<(), DiagnosisError> {
        let wrong: Vec<&NuisanceFit> =
            last.nuisances.iter().filter(|nuisance| is_wrong(nuisance)).collect();
        let mut claimed = Vec::new();
        for nuisance in wrong {
            let size = self.size(&last.with_nuisances, &reset(&last.with_nuisances, nuisance)?)?;
            match size < Rules::SIZE {
                true => found
                    .refused
                    .push(Refused { id: nuisance.id, objection: Objection::Small { size } }),
                false => claimed.push(nuisance),
            }
        }
        if claimed.is_empty() {
            return Ok(());
        }
        let known = found.accepted.iter().map(|one| one.id);
        let ids: Vec<&str> = known.chain(claimed.iter().map(|nuisance| nuisance.id)).collect();
        let whole = self.fit(&ids, whitening, true)?;
        let reset_all = |model: &Description, from: usize| {
            claimed[from..].iter().try_fold(model.clone(), |model, one| reset(&model, one))
        };
        found.base = reset_all(&found.base, 0)?;
        for accepted in &mut found.accepted {
            accepted.with_nuisances = reset_all(&accepted.with_nuisances, 0)?;
        }
        for (index, nuisance) in claimed.iter().enumerate() {
            let p = whole.effects.iter().find(|effect| effect.id == nuisance.id).map(|one| one.p);
            let Some(accepted) = Accepted::of(&whole, nuisance.id, p.unwrap_or(1.0)) else {
                continue;
            };
            let with_nuisances = reset_all(&whole.with_nuisances, index + 1)?;
            found.accepted.push(Accepted { with_nuisances, ..accepted });
        }
        Ok(())
    }
}

/// Whether a nominal number is off by more than twice its tolerance and twice its error.
fn is_wrong(nuisance: &NuisanceFit) -> bool {
    let known = NOMINAL.iter().find(|(id, _)| *id == nuisance.id);
    let Some((_, tolerance)) = known else { return false };
    let miss = (nuisance.value - nuisance.nominal).abs();
    miss > 2.0 * tolerance * nuisance.nominal.abs() + 2.0 * nuisance.se
}

/// The model with a nuisance at its nominal value.
fn reset(model: &Description, nuisance: &NuisanceFit) -> Result<Description, DiagnosisError> {
    let mut model = model.clone();
    let nominal = Estimate::exact(nuisance.nominal, "nominal");
    let carried = model.effects.iter_mut().find(|effect| effect.id == nuisance.id);
    if let Some(carried) = carried {
        carried.parameters.insert(nuisance.name.to_owned(), nominal);
    } else if let Base::Analytical(base) = &model.base
        && nuisance.id == "pusher-friction"
    {
        let other = Analytical::new(nominal, base.length().clone(), *base.scatter())?;
        model.base = Base::Analytical(other.with_surface(base.surface())?);
    }
    Ok(model)
}
