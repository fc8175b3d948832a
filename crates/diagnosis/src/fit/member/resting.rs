//! What a member says of where the object rests.

use std::sync::Arc;

use effects::{Object, Parameter, Role, SupportSummary};
use nalgebra::Vector2;

use super::{Member, Part};

impl Member {
    /// The same from other values, about an object. Of parts of the weight the largest is held, for they
    /// count in proportion, and so is all of a point that bears nothing. The others are under the object; by
    /// statics, they balance it.
    pub(in crate::fit) fn starting_from(
        mut self,
        mut values: Vec<f64>,
        object: &Arc<Object>,
        by_statics: bool,
    ) -> Self {
        self.object = Some(object.clone());
        self.is_by_statics = by_statics;
        let parts = self.parts();
        let largest = parts.clone().max_by(|a, b| values[*a].total_cmp(&values[*b]));
        for part in parts {
            if Some(part) == largest || values[part] == 0.0 {
                self.prior_sd[part] = 0.0;
            }
            let is_point = self.parameters()[part].role == Role::Part;
            if is_point && values[part] == 0.0 {
                self.prior_sd[part - 2..part].fill(0.0);
                values[part - 2..part].fill(0.0);
            }
        }
        self.start = values;
        self
    }

    /// Which numbers are parts of the weight.
    pub(super) fn parts(&self) -> impl Iterator<Item = usize> + Clone + use<> {
        let parameters = self.parameters();
        (0..parameters.len()).filter(|k| is_part(&parameters[*k]))
    }

    /// Whether it says how the weight is spread, of which single numbers mean little.
    pub(in crate::fit) fn is_mixture(&self) -> bool {
        self.parts().next().is_some()
    }

    /// Center of friction and mean distance of the pressure from it, in m, of a place of its numbers; none
    /// of an effect that does not say where the object rests.
    pub(in crate::fit) fn support(&self, x: &[f64]) -> Option<[f64; 3]> {
        let object = self.object.as_ref().filter(|_| self.is_mixture())?;
        let mut spots = Vec::new();
        self.effect.spots(&self.values(x), object, &mut spots);
        let SupportSummary { center_of_friction_o, mean_distance } = object.support_summary(&spots);
        Some([center_of_friction_o.x, center_of_friction_o.y, mean_distance])
    }

    /// Whether it is one that is written.
    pub(in crate::fit) fn is_moved_mixture(&self) -> bool {
        self.part != Part::Nuisance && self.is_mixture()
    }

    /// The strains of a center of friction that is not below the center of mass; none where the weight may
    /// be shared as it likes.
    pub(super) fn unbalanced(&self, values: &[f64]) -> Vec<f64> {
        let object = self.object.as_ref().filter(|_| self.is_by_statics && self.is_mixture());
        object.map_or_else(Vec::new, |object| {
            let mut spots = Vec::new();
            self.effect.spots(values, object, &mut spots);
            let center = object.support_summary(&spots).center_of_friction_o;
            ((center - object.center_of_mass()) / BALANCED).as_slice().to_vec()
        })
    }

    /// Adds the strains of places outside of the outline.
    pub(super) fn add_strains_outside(&self, values: &[f64], residuals: &mut [f64]) {
        let Some(object) = &self.object else { return };
        for (k, parameter) in self.parameters().iter().enumerate() {
            if matches!(parameter.role, Role::X(_)) {
                let outside = outside(object, &Vector2::new(values[k], values[k + 1]));
                residuals[k] += outside.x / OUTSIDE;
                residuals[k + 1] += outside.y / OUTSIDE;
            }
        }
    }
}

/// How far a place is outside of an outline, in m.
fn outside(object: &Object, place: &Vector2<f64>) -> Vector2<f64> {
    match object.shape().contains(place) {
        true => Vector2::zeros(),
        false => place - object.shape().contact(place, 0.0).point,
    }
}

/// Tolerance of outlines, in m.
const OUTSIDE: f64 = 2e-4;
/// Tolerance of the center of mass, in m: small enough that no number of pushes moves it.
const BALANCED: f64 = 2e-5;

pub(super) fn is_part(parameter: &Parameter) -> bool {
    matches!(parameter.role, Role::Part | Role::Cell)
}
