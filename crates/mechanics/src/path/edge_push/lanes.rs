//! Ways of several pushes beside each other, in the lanes of vector registers.

use nalgebra::Vector2;
use pulp::{Arch, Simd, WithSimd};

use super::way::{EdgeContactOde, MAX_TRAVEL, MOST_STEPS, SMALL_TURN, TOLERANCE, small_sin_cos};
use crate::numerics::runge_kutta::{ERROR, STAGES};

/// How many run beside each other: the doubles of the widest registers.
pub(super) const LANES: usize = 8;

/// A number of each push.
type Lanes = [f64; LANES];

/// The states at the ends of ways, as [`EdgeContactOde::along`] has them to the bit; none of a lane without way,
/// and none where one of its steps was not taken: where the contact begins to slide or to stick, leaves
/// the edge or the pusher, turns far, or the step is too long for the tolerance.
///
/// Every lane does the same operations, and none is fused, whatever the registers.
pub(super) fn integrate_batch(
    ways: &[Option<EdgeContactOde>; LANES],
    length_squared: f64,
    friction: f64,
) -> [Option<Vector2<f64>>; LANES] {
    let mut together = Batch::idle(length_squared, friction);
    for (lane, way) in ways.iter().enumerate() {
        if let Some(way) = way {
            together.set(lane, way);
        }
    }
    let together = Arch::new().dispatch(together);
    let end = |lane: usize| {
        let is_there = together.left[lane] == 0.0 && ways[lane].is_some();
        is_there.then(|| Vector2::new(together.place[lane], together.turn[lane]))
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
    /// What is left of the way, in m; NaN of a lane that is given up.
    left: Lanes,
}

/// What the contacts do: the slopes of place and turn, and which way each slides: 0 where it sticks,
/// 1 to the left, −1 to the right, NaN beyond what lanes can do.
#[derive(Clone, Copy)]
struct Looks {
    place: Lanes,
    turn: Lanes,
    slides: Lanes,
}

impl Batch {
    /// Lanes that have nothing to do.
    fn idle(length_squared: f64, friction: f64) -> Self {
        let (zero, one) = ([0.0; LANES], [1.0; LANES]);
        let (ends, direction) = ([[-1.0; LANES], one], [one, zero]);
        let (x, center_x) = ([-1.0; LANES], [-1.0; LANES]);
        let (place, turn, left) = (zero, zero, zero);
        Self { length_squared, friction, x, ends, direction, center_x, place, turn, left }
    }

    fn set(&mut self, lane: usize, way: &EdgeContactOde) {
        self.x[lane] = way.edge.x;
        self.ends[0][lane] = way.edge.ends[0];
        self.ends[1][lane] = way.edge.ends[1];
        self.direction[0][lane] = way.direction.x;
        self.direction[1][lane] = way.direction.y;
        self.center_x[lane] = way.center_x;
        self.place[lane] = way.first;
        self.left[lane] = way.length;
    }

    /// As [`EdgeContactOde`] looks at one.
    #[inline(always)]
    fn look(&self, place: &Lanes, turn: &Lanes) -> Looks {
        let (c2, friction) = (self.length_squared, self.friction);
        let mut looks = Looks { place: [0.0; LANES], turn: [0.0; LANES], slides: [0.0; LANES] };
        for k in 0..LANES {
            let (s, x, center_x) = (place[k], self.x[k], self.center_x[k]);
            let (sin, cos) = small_sin_cos(turn[k]);
            let v_n = cos * self.direction[0][k] + sin * self.direction[1][k];
            let v_t = cos * self.direction[1][k] - sin * self.direction[0][k];
            let size = 1.0 / (c2 + x * x + s * s);
            let f_n = ((c2 + x * x) * v_n + x * s * v_t) * size;
            let f_t = ((c2 + s * s) * v_t + x * s * v_n) * size;
            let turns = (x * v_t - s * v_n) * size;
            let side = if f_t > 0.0 { 1.0 } else { -1.0 };
            let slope = side * friction;
            let f_n_sliding = c2 * v_n / (c2 + s * s - slope * x * s);
            let turns_sliding = (slope * x - s) * f_n_sliding / c2;
            let sticks = f_t.abs() <= friction * f_n;
            let f_t = if sticks { f_t } else { slope * f_n_sliding };
            let turns = if sticks { turns } else { turns_sliding };
            let is_within = s > self.ends[0][k]
                && s < self.ends[1][k]
                && v_n > 0.0
                && turn[k].abs() <= SMALL_TURN;
            looks.place[k] = v_t - f_t - turns * center_x;
            looks.turn[k] = turns;
            let slides = if sticks { 0.0 } else { side };
            looks.slides[k] = if is_within { slides } else { f64::NAN };
        }
        looks
    }
}

impl WithSimd for Batch {
    type Output = Self;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) -> Self {
        let mut here = self.look(&self.place, &self.turn);
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
    /// One step of every lane that has way left.
    #[inline(always)]
    fn step(&mut self, here: &Looks) -> Looks {
        let mut looks = [*here; 7];
        let (mut place, mut turn) = (self.place, self.turn);
        let h = self.left.map(|left| if left < MAX_TRAVEL { left } else { MAX_TRAVEL });
        for stage in 1..7 {
            let (mut places, mut turns) = ([0.0; LANES], [0.0; LANES]);
            for (weight, look) in STAGES[stage].iter().zip(&looks[..stage]) {
                add(&mut places, *weight, &look.place);
                add(&mut turns, *weight, &look.turn);
            }
            for k in 0..LANES {
                place[k] = self.place[k] + h[k] * places[k];
                turn[k] = self.turn[k] + h[k] * turns[k];
            }
            looks[stage] = self.look(&place, &turn);
        }
        let (mut of_place, mut of_turn, mut slides) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for (weight, look) in ERROR.iter().zip(&looks) {
            let weights = h.map(|h| h * weight);
            add_each(&mut of_place, &weights, &look.place);
            add_each(&mut of_turn, &weights, &look.turn);
            add(&mut slides, 1.0, &look.slides);
        }
        let there = looks[6];
        for k in 0..LANES {
            let arm = (self.center_x[k] * self.center_x[k] + place[k] * place[k]).sqrt();
            let is_good = of_place[k].abs() + arm * of_turn[k].abs() <= TOLERANCE;
            // The sum is a number where all stages are.
            let taken = is_good && !slides[k].is_nan() && there.slides[k] == here.slides[k];
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
