//! Several pushes beside each other, in the lanes of vector registers.

use nalgebra::Vector2;
use pulp::{Arch, Simd, WithSimd};

use super::ode::{
    ContactState, EdgeContact, EdgeContactOde, MAX_TRAVEL, MOST_STEPS, SMALL_TURN, TOLERANCE,
    small_sin_cos,
};
use crate::numerics::runge_kutta::{ERROR, STAGES};

/// How many run beside each other: the doubles of the widest registers.
pub(super) const LANES: usize = 8;

/// A number of each push.
type Lanes = [f64; LANES];

/// The states at the ends of pushes, as [`EdgeContactOde::integrate`] has them to the bit; none of a
/// lane without push, and none where one of its steps was not taken: where the contact begins to slide
/// or to stick, leaves the edge or the pusher, turns far, or the step is too long for the tolerance.
///
/// Every lane does the same operations, and none is fused, whatever the registers.
pub(super) fn integrate_batch(
    pushes: &[Option<EdgeContactOde>; LANES],
    length_squared: f64,
    friction: f64,
) -> [Option<Vector2<f64>>; LANES] {
    let batch = Arch::new().dispatch(Batch::new(pushes, length_squared, friction));
    let end = |lane: usize| {
        let is_there = batch.left[lane] == 0.0 && pushes[lane].is_some();
        is_there.then(|| Vector2::new(batch.place[lane], batch.turn[lane]))
    };
    std::array::from_fn(end)
}

/// The numbers of [`EdgeContactOde`]s, and how far each is.
#[derive(Clone, Copy)]
struct Batch {
    length_squared: f64,
    friction: f64,
    x: Lanes,
    ends: [Lanes; 2],
    direction: [Lanes; 2],
    center_x: Lanes,
    /// The contact's place, in m.
    place: Lanes,
    /// In rad.
    turn: Lanes,
    /// The travel that is left, in m; NaN of a lane that is given up.
    left: Lanes,
}

/// The slopes of place and turn, and the side to which each contact slides: NaN beyond what lanes can
/// do.
#[derive(Clone, Copy)]
struct ContactStates {
    place: Lanes,
    turn: Lanes,
    side: Lanes,
}

impl Batch {
    /// A lane without push has nothing to do.
    fn new(pushes: &[Option<EdgeContactOde>; LANES], length_squared: f64, friction: f64) -> Self {
        let of = |number: fn(&EdgeContactOde) -> f64| {
            std::array::from_fn(|k| pushes[k].as_ref().map_or(0.0, number))
        };
        Self {
            length_squared,
            friction,
            x: of(|push| push.contact.x),
            ends: [of(|push| push.contact.ends[0]), of(|push| push.contact.ends[1])],
            direction: [of(|push| push.contact.direction.x), of(|push| push.contact.direction.y)],
            center_x: of(|push| push.contact.center_x),
            place: of(|push| push.first),
            turn: [0.0; LANES],
            left: of(|push| push.length),
        }
    }

    #[inline(always)]
    fn contact(&self, k: usize) -> EdgeContact {
        EdgeContact {
            x: self.x[k],
            ends: [self.ends[0][k], self.ends[1][k]],
            length_squared: self.length_squared,
            friction: self.friction,
            direction: Vector2::new(self.direction[0][k], self.direction[1][k]),
            center_x: self.center_x[k],
        }
    }

    #[inline(always)]
    fn contact_states(&self, place: &Lanes, turn: &Lanes) -> ContactStates {
        let zero = [0.0; LANES];
        let mut states = ContactStates { place: zero, turn: zero, side: zero };
        for k in 0..LANES {
            let contact = self.contact(k);
            let velocity = contact.velocity(small_sin_cos(turn[k]));
            let ContactState { slope, side, .. } = contact.state(place[k], velocity);
            (states.place[k], states.turn[k]) = (slope.x, slope.y);
            let is_small = turn[k].abs() <= SMALL_TURN;
            let presses = contact.has(place[k]) && velocity[0] > 0.0;
            states.side[k] = if presses && is_small { side } else { f64::NAN };
        }
        states
    }
}

impl WithSimd for Batch {
    type Output = Self;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) -> Self {
        let mut here = self.contact_states(&self.place, &self.turn);
        for _ in 0..MOST_STEPS {
            here = self.step(&here);
            if !self.left.iter().any(|left| *left > 0.0) {
                break;
            }
        }
        self
    }
}

impl Batch {
    /// One step of every lane that has travel left.
    #[inline(always)]
    fn step(&mut self, here: &ContactStates) -> ContactStates {
        let mut states = [*here; 7];
        let (mut place, mut turn) = (self.place, self.turn);
        let h = self.left.map(|left| if left < MAX_TRAVEL { left } else { MAX_TRAVEL });
        for stage in 1..7 {
            let (mut places, mut turns) = ([0.0; LANES], [0.0; LANES]);
            for (weight, state) in STAGES[stage].iter().zip(&states[..stage]) {
                add(&mut places, *weight, &state.place);
                add(&mut turns, *weight, &state.turn);
            }
            for k in 0..LANES {
                place[k] = self.place[k] + h[k] * places[k];
                turn[k] = self.turn[k] + h[k] * turns[k];
            }
            states[stage] = self.contact_states(&place, &turn);
        }
        let (mut of_place, mut of_turn, mut sides) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for (weight, state) in ERROR.iter().zip(&states) {
            let weights = h.map(|h| h * weight);
            add_each(&mut of_place, &weights, &state.place);
            add_each(&mut of_turn, &weights, &state.turn);
            add(&mut sides, 1.0, &state.side);
        }
        let there = states[6];
        for k in 0..LANES {
            let arm = (self.center_x[k] * self.center_x[k] + place[k] * place[k]).sqrt();
            let is_good = of_place[k].abs() + arm * of_turn[k].abs() <= TOLERANCE;
            // The sum is a number where all stages are.
            let taken = is_good && !sides[k].is_nan() && there.side[k] == here.side[k];
            let left = if taken { self.left[k] - h[k] } else { f64::NAN };
            let moves = self.left[k] > 0.0;
            self.left[k] = if moves { left } else { self.left[k] };
            self.place[k] = place[k];
            self.turn[k] = turn[k];
        }
        there
    }
}

/// sum ← sum + weight·values.
#[inline(always)]
fn add(sum: &mut Lanes, weight: f64, values: &Lanes) {
    add_each(sum, &[weight; LANES], values);
}

/// sum ← sum + weights·values, lane by lane.
#[inline(always)]
fn add_each(sum: &mut Lanes, weights: &Lanes, values: &Lanes) {
    for k in 0..LANES {
        sum[k] += weights[k] * values[k];
    }
}
