//! The motion of a pusher along an edge as a differential equation, one push at a time.

use nalgebra::Vector2;

use crate::numerics::runge_kutta::{Step, step};

/// How the pusher moves; the state is the contact's place s along t, in m, and the turn φ, in rad.
#[derive(Clone, Copy)]
pub(super) struct EdgeContactOde {
    pub(super) contact: EdgeContact,
    /// Inward normal of the edge, frame B.
    pub(super) normal_b: Vector2<f64>,
    /// Where the pusher's center starts, in m, axes of the edge.
    pub(super) start: Vector2<f64>,
    /// The first place s, in m; the object has not turned.
    pub(super) first: f64,
    /// How far it pushes, in m.
    pub(super) length: f64,
}

/// A pusher that moves straight while it touches an edge, in axes along the edge's inward normal n and
/// its left t, from the center of friction.
#[derive(Clone, Copy)]
pub(super) struct EdgeContact {
    /// Place of the edge's line along n, in m.
    pub(super) x: f64,
    /// Its ends along t, in m.
    pub(super) ends: [f64; 2],
    /// Of c = Mmax/Fmax, in m².
    pub(super) length_squared: f64,
    pub(super) friction: f64,
    /// The pusher's motion at the start, a unit vector.
    pub(super) direction: Vector2<f64>,
    /// Where its center is along n while it touches, in m.
    pub(super) center_x: f64,
}

/// What the contact does.
#[derive(Clone, Copy)]
pub(super) struct ContactState {
    /// To which side the pusher slides: 1 left, −1 right, 0 if it sticks.
    pub(super) side: f64,
    /// Of place and turn, at unit speed of the pusher.
    pub(super) slope: Vector2<f64>,
    /// By how much the force that would stick is beyond the left and the right edge of the friction
    /// cone.
    beyond: [f64; 2],
}

/// The pusher left the edge.
struct Left;

/// Error of a step, in m.
pub(super) const TOLERANCE: f64 = 1e-8;
/// Longest travel of the pusher in a step, in m.
pub(super) const MAX_TRAVEL: f64 = 5e-3;
/// Travel within which a change between sticking and sliding is located, in m.
const SWITCH: f64 = 1e-8;
/// Most steps, and most places at which a change is looked for.
pub(super) const MOST_STEPS: usize = 64;

impl EdgeContact {
    /// The pusher's velocity along n and t after a turn, of which sine and cosine are given.
    #[inline(always)]
    pub(super) fn velocity(&self, (sin, cos): (f64, f64)) -> [f64; 2] {
        let (x, y) = (self.direction.x, self.direction.y);
        [cos * x + sin * y, cos * y - sin * x]
    }

    /// Whether a place is on the edge.
    #[inline(always)]
    pub(super) fn has(&self, s: f64) -> bool {
        s > self.ends[0] && s < self.ends[1]
    }

    /// What the contact does at the place s on the edge, where the pusher has the velocity v.
    ///
    /// Nothing but arithmetic, so that the compiler can take several contacts at once.
    #[inline(always)]
    pub(super) fn state(&self, s: f64, [v_n, v_t]: [f64; 2]) -> ContactState {
        let (c2, friction, x) = (self.length_squared, self.friction, self.x);
        let size = 1.0 / (c2 + x * x + s * s);
        let f_n = ((c2 + x * x) * v_n + x * s * v_t) * size;
        let f_t = ((c2 + s * s) * v_t + x * s * v_n) * size;
        let beyond = [f_t - friction * f_n, -f_t - friction * f_n];
        let (side, f_t, turn) = if f_t.abs() <= friction * f_n {
            (0.0, f_t, (x * v_t - s * v_n) * size)
        } else {
            let (side, slope) = if f_t > 0.0 { (1.0, friction) } else { (-1.0, -friction) };
            let f_n = c2 * v_n / (c2 + s * s - slope * x * s);
            (side, slope * f_n, (slope * x - s) * f_n / c2)
        };
        let slope = Vector2::new(v_t - f_t - turn * self.center_x, turn);
        ContactState { side, slope, beyond }
    }
}

impl EdgeContactOde {
    /// The state at its end; none if the pusher leaves the edge.
    pub(super) fn integrate(&self) -> Option<Vector2<f64>> {
        let mut state = Vector2::new(self.first, 0.0);
        let (mut left, mut longest) = (self.length, MAX_TRAVEL);
        for _ in 0..MOST_STEPS {
            let here = self.contact_state(&state)?;
            let mut h = left.min(longest);
            let Step { mut end, error } = self.step(h, &state, &here)?;
            let arm = Vector2::new(self.contact.center_x, end.x).norm();
            if error.x.abs() + arm * error.y.abs() > TOLERANCE {
                longest = 0.5 * h;
                continue;
            }
            let there = self.contact_state(&end)?;
            if there.side != here.side {
                (h, end) = self.switch(h, &state, &here, &there)?;
            }
            if h >= left {
                return Some(end);
            }
            (state, left) = (end, left - h);
        }
        None
    }

    #[inline]
    fn step(&self, h: f64, state: &Vector2<f64>, here: &ContactState) -> Option<Step<2>> {
        let slope = |_: f64, state: &Vector2<f64>| {
            self.contact_state(state).map(|contact| contact.slope).ok_or(Left)
        };
        step(0.0, state, &here.slope, h, slope).ok()
    }

    /// The travel and the state just after a change between sticking and sliding, by secants from both
    /// sides; none for a change from side to side at once.
    fn switch(
        &self,
        h: f64,
        state: &Vector2<f64>,
        here: &ContactState,
        there: &ContactState,
    ) -> Option<(f64, Vector2<f64>)> {
        if here.side * there.side != 0.0 {
            return None;
        }
        let side = usize::from(here.side + there.side < 0.0);
        let (mut low, mut high) = ((0.0, here.beyond[side]), (h, there.beyond[side]));
        let mut end = self.step(h, state, here)?.end;
        for k in 0..MOST_STEPS {
            if high.0 - low.0 <= SWITCH {
                return Some((high.0, end));
            }
            let root = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
            // A little after and a little before in turn, to have it between them.
            let off = if k.is_multiple_of(2) { 0.4 * SWITCH } else { -0.4 * SWITCH };
            let at = (root + off).clamp(low.0 + 0.1 * SWITCH, high.0 - 0.1 * SWITCH);
            let tried = self.step(at, state, here)?.end;
            let contact = self.contact_state(&tried)?;
            if contact.side == here.side {
                low = (at, contact.beyond[side]);
            } else {
                (high, end) = ((at, contact.beyond[side]), tried);
            }
        }
        None
    }

    /// What the contact does; none where the pusher is beside the edge or does not press.
    #[inline]
    fn contact_state(&self, state: &Vector2<f64>) -> Option<ContactState> {
        if !self.contact.has(state.x) {
            return None;
        }
        let velocity = self.contact.velocity(sin_cos(state.y));
        if velocity[0] <= 0.0 {
            return None;
        }
        Some(self.contact.state(state.x, velocity))
    }
}

/// Sine and cosine, to rounding by their series for the small turns of a step.
#[inline]
pub(super) fn sin_cos(angle: f64) -> (f64, f64) {
    if angle.abs() > SMALL_TURN {
        return angle.sin_cos();
    }
    small_sin_cos(angle)
}

/// Up to this the series are as good as the functions, in rad.
pub(super) const SMALL_TURN: f64 = 0.3;

/// Sine and cosine of a small turn.
#[inline(always)]
pub(super) fn small_sin_cos(angle: f64) -> (f64, f64) {
    let x = angle * angle;
    let term = |k: f64, rest: f64| 1.0 - x * (1.0 / ((k - 1.0) * k)) * rest;
    let sin = term(3.0, term(5.0, term(7.0, term(9.0, term(11.0, 1.0)))));
    let cos = term(2.0, term(4.0, term(6.0, term(8.0, term(10.0, term(12.0, 1.0))))));
    (angle * sin, cos)
}

#[cfg(test)]
mod tests {
    use super::sin_cos;

    #[test]
    fn the_series_are_the_functions() {
        for k in -300..=300 {
            let angle = 1e-3 * f64::from(k);
            let (sin, cos) = sin_cos(angle);
            assert!((sin - angle.sin()).abs() < 1e-16 && (cos - angle.cos()).abs() < 2e-16);
        }
    }
}
