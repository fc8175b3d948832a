//! What a manifest says of an object's support, as a nominal model.

use dataset::{ObjectChoice, ObjectSupport};
use effects::by_id;

use crate::steps::channel_steps::rigid_object;
use crate::{Analytical, Base, Description, Estimate, ModelEffect, ModelError, SurfaceKind};

impl Description {
    /// The analytical model of an object on what it rests on, with the pusher's friction.
    ///
    /// Points without shares bear what statics say ([`effects::Object::statics`]); `source` says where the values
    /// come from.
    ///
    /// # Errors
    /// `InvalidValue` for a friction that no pusher has; `Effects` for points that cannot bear the object;
    /// `PointsOfNoObject` for points or a map where the set names no object.
    pub fn nominal(
        friction: Estimate,
        object: &ObjectChoice,
        support: &ObjectSupport,
        source: &str,
    ) -> Result<Self, ModelError> {
        let nominal = Analytical::nominal(friction.value)?;
        let nominal = Analytical::new(friction, nominal.length().clone(), *nominal.scatter())?;
        let (surface, effect) = match support {
            ObjectSupport::Ellipsoid => (SurfaceKind::Ellipsoid, None),
            ObjectSupport::Patch => (SurfaceKind::UniformPatch, None),
            ObjectSupport::Points { places, shares } => {
                let shares = match (shares, object) {
                    (Some(shares), _) => shares.clone(),
                    (None, ObjectChoice::Fixed(spec)) => rigid_object(spec)?.statics(places)?,
                    (None, ObjectChoice::ByFileName) => return Err(ModelError::PointsOfNoObject),
                };
                let points = places.iter().zip(shares);
                let values = points.flat_map(|(place, share)| [place.x, place.y, share]);
                (SurfaceKind::UniformPatch, Some(effect("support-points", values, source)?))
            }
            ObjectSupport::Map { shares } => {
                let values = shares.iter().copied();
                (SurfaceKind::UniformPatch, Some(effect("pressure-map", values, source)?))
            }
        };
        let base = Base::Analytical(nominal.with_surface(surface)?);
        Ok(Self { base, effects: effect.into_iter().collect(), weights: None })
    }
}

/// An effect with its first parameters; the others are 0.
fn effect(
    id: &str,
    values: impl Iterator<Item = f64>,
    source: &str,
) -> Result<ModelEffect, ModelError> {
    let values = values.chain(std::iter::repeat(0.0));
    let names = by_id(id)?.info().parameters.iter().map(|parameter| parameter.name.to_owned());
    let known = |value: f64| Estimate::exact(value, if value == 0.0 { "" } else { source });
    let parameters = names.zip(values).map(|(name, value)| (name, known(value))).collect();
    Ok(ModelEffect::new(id, parameters))
}
