//! Where an object rests, by the motions of pushes alone: where fits of spots start.

use effects::{Effect, Object, Parameter, Role, Spot};
use models::ChannelObservation;
use nalgebra::{DMatrix, DVector, Matrix2, Vector2, Vector3};
use planar::{Pose, perpendicular};

use crate::Observations;
use crate::statistics::mixture::best_mixture;

/// Observed motions of one object, each with the point at which it was pushed: about that point a
/// pusher has no moment, whether it sticks or slides, so neither has friction.
#[derive(Clone, Debug)]
pub(super) struct PushedMotions {
    motions: Vec<PushedMotion>,
    /// Mean distance of the object's area, in m.
    length: f64,
}

/// In the body's axes, over the step.
#[derive(Clone, Copy, Debug)]
struct PushedMotion {
    /// Where it was pushed, from the body's origin, in m.
    point: Vector2<f64>,
    /// Displacement of the body's origin, in m, and turn, in rad.
    motion: Vector3<f64>,
}

/// Cells of the grid on which points are looked for, along each axis.
const SIDE: usize = 11;
/// Radius of gyration of such a cell's pressure, in the mean distance of the area.
const RADIUS: f64 = 0.03;
/// Rounds of weights.
const ROUNDS: usize = 4;
/// A motion that is missed by more than this many typical errors has less weight.
const HUBER: f64 = 2.0;
/// Step of differences, in the pusher's way.
const STEP: f64 = 1e-4;

impl PushedMotions {
    /// Those of observations; none where the motion is not observed or objects differ.
    pub(super) fn of(observations: &Observations) -> Option<Self> {
        let steps = &observations.steps;
        let object = &steps.first()?.input.object;
        let is_same =
            |step: &ChannelObservation| std::sync::Arc::ptr_eq(&step.input.object, object);
        if !steps.iter().all(is_same) {
            return None;
        }
        let motions: Vec<_> = steps.iter().filter_map(PushedMotion::of).collect();
        let length = object.mean_distance();
        (!motions.is_empty()).then_some(Self { motions, length })
    }

    /// The shares of spots under which friction has the least moments about the contacts.
    fn shares(&self, spots: &[Spot]) -> Vec<f64> {
        let moments = |motion: &Vector3<f64>, point: &Vector2<f64>| {
            let of = |spot: &Spot| moment(spot, motion, point);
            DMatrix::from_iterator(1, spots.len(), spots.iter().map(of))
        };
        let rows: Vec<DMatrix<f64>> =
            self.motions.iter().map(|pushed| moments(&pushed.motion, &pushed.point)).collect();
        let slopes: Vec<DMatrix<f64>> = self
            .motions
            .iter()
            .map(|PushedMotion { point, motion }| {
                // Errors of the turn are those of places over the length.
                let step = STEP * motion.xy().norm().max(self.length * motion.z.abs());
                let mut slopes = DMatrix::zeros(3, spots.len());
                for axis in 0..3 {
                    let mut change = Vector3::zeros();
                    change[axis] = if axis == 2 { step / self.length } else { step };
                    let above = moments(&(motion + change), point);
                    let below = moments(&(motion - change), point);
                    slopes.set_row(axis, &((above - below) / (2.0 * step)).row(0));
                }
                slopes
            })
            .collect();
        let mut shares = DVector::repeat(spots.len(), 1.0 / spots.len() as f64);
        for _ in 0..ROUNDS {
            // Moments in errors of the motion.
            let sizes: Vec<f64> = slopes
                .iter()
                .map(|slopes| (slopes * &shares).norm().max(f64::MIN_POSITIVE))
                .collect();
            let missed: Vec<f64> =
                rows.iter().zip(&sizes).map(|(row, size)| (row * &shares)[0] / size).collect();
            let typical =
                dataset::quantile(missed.iter().map(|missed| missed.abs()).collect(), 0.5);
            let limit = HUBER * typical.unwrap_or_default().max(f64::MIN_POSITIVE) / 0.6745;
            let weight =
                |missed: f64| if missed.abs() <= limit { 1.0 } else { limit / missed.abs() };
            let mut weighted = DMatrix::zeros(rows.len(), spots.len());
            for (k, row) in rows.iter().enumerate() {
                weighted.set_row(k, &(row * (weight(missed[k]).sqrt() / sizes[k])).row(0));
            }
            shares = best_mixture(&weighted.tr_mul(&weighted));
        }
        shares.iter().copied().collect()
    }

    /// Points that bear the object, by their shares: the nearest cells of a grid taken together until
    /// there are `n`.
    fn points(&self, object: &Object, n: usize) -> Vec<Spot> {
        let spots = grid(object);
        let shares = self.shares(&spots);
        let mut points: Vec<Spot> = spots
            .iter()
            .zip(shares)
            .filter(|(_, share)| *share > 0.0)
            .map(|(spot, share)| Spot { share, ..*spot })
            .collect();
        while points.len() > n {
            let pairs = (0..points.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
            let cost = |(a, b): &(usize, usize)| {
                let (a, b) = (&points[*a], &points[*b]);
                let square = (a.place_o - b.place_o).norm_squared();
                a.share * b.share / (a.share + b.share) * square
            };
            let Some((a, b)) = pairs.min_by(|x, y| cost(x).total_cmp(&cost(y))) else { break };
            let (one, other) = (points.swap_remove(a), points[b]);
            let share = one.share + other.share;
            let place_o = (one.share * one.place_o + other.share * other.place_o) / share;
            points[b] = Spot { place_o, share, ..other };
        }
        points.sort_by(|a, b| b.share.total_cmp(&a.share));
        points
    }
}

impl PushedMotion {
    fn of(step: &ChannelObservation) -> Option<Self> {
        let [Some(along), Some(across), Some(turn), ..] = step.observed else { return None };
        let input = &step.input;
        let direction = input.direction_w();
        let moved_w = along * direction + across * perpendicular(&direction);
        let middle = Pose {
            position: input.pose_wb.position + 0.5 * moved_w,
            angle: input.pose_wb.angle + 0.5 * turn,
        };
        let pusher = input.track.at(0.5 * input.track.duration()).0;
        let center = middle.inverse_transform_point(&pusher);
        let contact = input.object.shape().contact(&center, input.pusher_radius);
        // A whole push may begin before the touch; half-way it is under way.
        if !(input.touching || contact.gap.abs() < input.pusher_radius) {
            return None;
        }
        let moved = middle.inverse_rotate(&moved_w);
        let motion = Vector3::new(moved.x, moved.y, turn);
        (motion != Vector3::zeros()).then_some(Self { point: contact.point, motion })
    }
}

/// Moment of a spot's friction about a point, of a weight of 1.
fn moment(spot: &Spot, motion: &Vector3<f64>, point: &Vector2<f64>) -> f64 {
    let spin = spot.radius * std::f64::consts::FRAC_1_SQRT_2;
    let velocity = motion.xy() + motion.z * perpendicular(&spot.place_o);
    let speed = velocity.norm().hypot(spin * motion.z).max(f64::MIN_POSITIVE);
    let arm = spot.place_o - point;
    let of_place = Matrix2::from_columns(&[arm, velocity]).determinant();
    (of_place + spin * spin * motion.z) / speed
}

/// The middles of a grid's cells that are within an object's outline.
fn grid(object: &Object) -> Vec<Spot> {
    let outline = object.shape().outline(360);
    let (mut low, mut high) = (outline[0], outline[0]);
    for place in &outline {
        low = low.inf(place);
        high = high.sup(place);
    }
    let cell = (high - low) / SIDE as f64;
    let place = |k: usize| {
        let share = Vector2::new((k % SIDE) as f64 + 0.5, (k / SIDE) as f64 + 0.5);
        low + cell.component_mul(&share)
    };
    let radius = RADIUS * object.mean_distance();
    let inside = (0..SIDE * SIDE).map(place).filter(|place| object.shape().contains(place));
    inside.map(|place_o| Spot { place_o, share: 0.0, radius }).collect()
}

/// Values from which a fit of an effect that says where an object rests starts, on so many points; none for
/// other effects and where the motion does not tell.
pub(super) fn start(
    effect: &dyn Effect,
    n_points: usize,
    observations: &Observations,
) -> Option<Vec<f64>> {
    let parameters = effect.info().parameters;
    let is = |role: Role| move |parameter: &Parameter| parameter.role == role;
    let has_cells = parameters.iter().any(is(Role::Cell));
    if !has_cells && !parameters.iter().any(is(Role::Part)) {
        return None;
    }
    let motions = PushedMotions::of(observations)?;
    let object = &observations.steps.first()?.input.object;
    let mut values = vec![0.0; parameters.len()];
    if has_cells {
        let cell = |k: usize| {
            let mut one = vec![0.0; parameters.len()];
            one[k] = 1.0;
            let mut spots = Vec::new();
            effect.spots(&one, object, &mut spots);
            spots.first().map(|spot| (k, *spot))
        };
        let (cells, spots): (Vec<_>, Vec<_>) = (0..parameters.len()).filter_map(cell).unzip();
        for (k, share) in cells.into_iter().zip(motions.shares(&spots)) {
            values[k] = share;
        }
    } else {
        let points = motions.points(object, n_points.min(parameters.len() / 3));
        for (values, point) in values.chunks_exact_mut(3).zip(points) {
            values.copy_from_slice(&[point.place_o.x, point.place_o.y, point.share]);
        }
    }
    Some(values)
}

#[cfg(test)]
mod tests {
    use effects::{Effect, PressureMap, SupportPoints};
    use models::Description;
    use nalgebra::Vector2;

    use super::start;
    use crate::synthetic::{pushed_with, white};
    use crate::{Fit, FitSettings, Observations, SupportPointsFit, fit};

    const FEET: [f64; 9] = [0.030, 0.025, 0.30, -0.035, 0.010, 0.45, 0.005, -0.035, 0.25];

    fn on_feet(feet: &[f64; 9]) -> (Observations, Description, Description) {
        let mut values = vec![0.0; SupportPoints.info().parameters.len()];
        values[..feet.len()].copy_from_slice(feet);
        pushed_with((SupportPoints.info().id, &values), 1)
    }

    /// Center and mean distance from it of weighted places.
    fn center_and_distance(points: &[(Vector2<f64>, f64)]) -> (Vector2<f64>, f64) {
        let whole: f64 = points.iter().map(|(_, share)| share).sum();
        let center =
            points.iter().map(|(place, share)| share / whole * place).sum::<Vector2<f64>>();
        let distance =
            |(place, share): &(Vector2<f64>, f64)| share / whole * (place - center).norm();
        (center, points.iter().map(distance).sum())
    }

    fn points(values: &[f64]) -> Vec<(Vector2<f64>, f64)> {
        values.chunks_exact(3).map(|point| (Vector2::new(point[0], point[1]), point[2])).collect()
    }

    #[test]
    fn motions_alone_tell_where_an_object_rests() {
        let (observations, ..) = on_feet(&FEET);
        let (center, distance) = center_and_distance(&points(&FEET));
        let object = observations.steps[0].input.object.clone();
        // Within a quarter of a cell, which is 8 mm for points and 18 mm for the map.
        for (effect, near) in [(&SupportPoints as &dyn Effect, 2e-3), (&PressureMap, 4.5e-3)] {
            let values = start(effect, 4, &observations).unwrap();
            let mut spots = Vec::new();
            effect.spots(&values, &object, &mut spots);
            let spots: Vec<_> = spots.iter().map(|spot| (spot.place_o, spot.share)).collect();
            let found = center_and_distance(&spots);
            assert!((found.0 - center).norm() < near, "{} {center}", found.0);
            assert!((found.1 - distance).abs() < near, "{} {distance}", found.1);
        }
        let other = effects::by_id("table-tilt").unwrap();
        assert_eq!(start(other.as_ref(), 4, &observations), None);
    }

    fn fitted(feet: &[f64; 9], known: SupportPointsFit) -> (Fit, Vec<(Vector2<f64>, f64)>) {
        let (observations, model, _) = on_feet(feet);
        let settings = FitSettings { resemblances: false, points: known, ..FitSettings::default() };
        let whitening = white(&observations);
        let found = fit(&observations, &model, &["support-points"], &whitening, &settings).unwrap();
        let values: Vec<f64> = found.effects[0].parameters.iter().map(|one| one.value).collect();
        (found, points(&values))
    }

    /// Each foot has points near by that bear its share.
    fn check_feet(found: &[(Vector2<f64>, f64)], feet: &[f64; 9]) {
        for (foot, share) in points(feet) {
            let near = found.iter().filter(|(place, _)| (place - foot).norm() < 5e-3);
            let borne: f64 = near.map(|(_, share)| share).sum();
            assert!((borne - share).abs() < 0.05, "{foot} {borne}");
        }
    }

    #[test]
    fn a_fit_finds_the_feet_and_leaves_the_noise() {
        let (found, points_found) = fitted(&FEET, SupportPointsFit::default());
        let (center, distance) = center_and_distance(&points(&FEET));
        let (found_center, found_distance) = center_and_distance(&points_found);
        assert!((found_center - center).norm() < 5e-4, "{found_center} {center}");
        assert!((found_distance / distance - 1.0).abs() < 0.01, "{found_distance} {distance}");
        let [before, after] = found.whitened_rms;
        assert!(before > 1.3 && after < 1.1, "{before} {after}");
        assert!(found.effects[0].p < 1e-3 && found.effects[0].undetermined.is_none());
        check_feet(&points_found, &FEET);
    }

    #[test]
    fn points_by_statics_bear_the_center_of_mass_whatever_the_pushes_say() {
        let known = SupportPointsFit { n: 3, by_statics: true };
        // By hand: w (35, 25) + w (−35, 20) + (1 − 2w) (0, −35) mm is 0 at w = 35/115.
        let (one, other) = (35.0 / 115.0, 45.0 / 115.0);
        let balanced = [0.035, 0.025, one, -0.035, 0.020, one, 0.0, -0.035, other];
        let (found, points) = fitted(&balanced, known);
        assert_eq!(points.iter().filter(|(_, share)| *share > 0.0).count(), 3);
        assert!(center_and_distance(&points).0.norm() < 2e-4);
        assert!(found.whitened_rms[1] < 1.1, "{:?}", found.whitened_rms);
        check_feet(&points, &balanced);
        // Of feet whose center is 6 mm off, it says what is assumed, and misses the pushes.
        let (found, points) = fitted(&FEET, known);
        assert!(center_and_distance(&points).0.norm() < 2e-3);
        assert!(found.whitened_rms[1] > 1.2, "{:?}", found.whitened_rms);
    }
}
