//! The friction in force at one moment.

use std::sync::Arc;

use nalgebra::{Vector2, Vector3};
use planar::perpendicular;

use crate::EffectError;
use crate::effect::Stage;
use crate::object::points::Point;
use crate::object::pressure::Pressure;
use crate::object::spots::Spots;
use crate::predict::area_friction::{AreaFriction, Local};
use crate::predict::friction::{Friction, SpotFriction, motion_at};
use crate::predict::instant::{ForceBalance, Memory};

impl<'a> ForceBalance<'a> {
    /// The friction of single points, if any has a surplus in a motion at S.
    pub(crate) fn local(&self, motion: &Vector3<f64>) -> Option<Local<'a>> {
        if !self.physics.acts_at(Stage::Local) {
            return None;
        }
        let local = self.local_about(&self.center);
        let of_area = self.step.object.points().iter().map(|Point { place, .. }| place);
        let of_spots = self.spots.into_iter().flat_map(Spots::places);
        let mut places = of_area.chain(of_spots);
        let is_there = places.any(|place| {
            local.surplus(place, &(motion.xy() + motion.z * perpendicular(place))) != 0.0
        });
        is_there.then_some(local)
    }

    fn local_about(&self, center: &Vector2<f64>) -> Local<'a> {
        let center_w = self.pose_wo.position + self.turn_wo * center;
        Local { physics: self.physics, center_w, turn_wo: self.turn_wo }
    }

    pub(crate) fn friction(
        &self,
        local: Option<Local<'a>>,
        memory: &mut Memory,
    ) -> Result<Friction<'_>, EffectError> {
        let given = self.physics.rig().given();
        let has_points = self.support.shape != 0.0 || local.is_some();
        let pressure = if has_points { self.pressure(memory)? } else { None };
        let (object, support) = (&self.step.object, &self.support);
        let of_support = (support, self.turning());
        let Some(spots) = self.spots else {
            let area = AreaFriction::new(object, of_support, given, pressure, local)?;
            return Ok(Friction { area, spots: None });
        };
        // The area keeps its own center, about which its load is known.
        let center = object.centroid() + support.center_o;
        let of_area = local.map(|_| self.local_about(&center));
        let area = AreaFriction::new(object, of_support, given, pressure, of_area)?;
        let spots = SpotFriction {
            share: spots.share,
            points: spots.leaning(&support.center_o),
            length: support.length_ratio * spots.mean_distance,
            stretch: support.length_ratio,
            tensor: support.tensor_o.exp(1.0),
            local,
            to_area: motion_at(&(center - self.center)),
        };
        Ok(Friction { area, spots: Some(spots) })
    }

    /// The load that leans, worked out anew only if its center moved; none for uniform pressure.
    fn pressure(&self, memory: &mut Memory) -> Result<Option<Arc<Pressure>>, EffectError> {
        let center = &self.support.center_o;
        if *center == Vector2::zeros() {
            return Ok(None);
        }
        let object = &self.step.object;
        memory.pressure = Some(match memory.pressure.take() {
            Some(known) if known.is(center) => known,
            Some(near) => Arc::new(near.moved(object, center)?),
            None => object.pressure(center)?,
        });
        Ok(memory.pressure.clone())
    }
}
