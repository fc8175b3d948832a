//! A model with what was fitted in its place.

use effects::Setting;
use models::{Analytical, Base, CharacteristicLength, Description, ModelEffect};

use super::member::Part;
use super::space::Space;
use crate::DiagnosisError;

/// A model with the effects of a place, with nuisances or without.
pub(super) fn described(
    space: &Space<'_>,
    model: &Description,
    x: &[f64],
    has_nuisances: bool,
) -> Result<Description, DiagnosisError> {
    let mut model = model.clone();
    for (member, own) in space.shares(x) {
        if has_nuisances || member.part != Part::Nuisance {
            let setting = Setting::new(member.effect.info(), &member.values(own));
            put(&mut model, ModelEffect::from(setting))?;
        }
    }
    Ok(model)
}

/// Puts an effect in the place of the one with its id, of the base's own number, or at the end.
pub(super) fn put(model: &mut Description, effect: ModelEffect) -> Result<(), DiagnosisError> {
    if let Some(known) = model.effects.iter_mut().find(|known| known.id == effect.id) {
        known.parameters = effect.parameters;
        return Ok(());
    }
    if let Base::Analytical(base) = &model.base {
        let (friction, length) = match effect.id.as_str() {
            "pusher-friction" => {
                (effect.parameters.values().next().cloned(), base.length().clone())
            }
            "pressure-radius" => (None, CharacteristicLength::UniformPressure),
            _ => (None, base.length().clone()),
        };
        let is_base = friction.is_some();
        let friction = friction.unwrap_or_else(|| base.pusher_friction().clone());
        let changed = Analytical::new(friction, length, *base.scatter())?;
        model.base = Base::Analytical(changed.with_surface(base.surface())?);
        if is_base {
            return Ok(());
        }
    }
    model.effects.push(effect);
    Ok(())
}
