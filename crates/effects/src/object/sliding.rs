//! Points of the support that slide over the table, and what effects change of their friction.

use nalgebra::Vector2;

/// One point of the support that slides over the table.
#[derive(Clone, Copy, Debug)]
pub struct Sliding {
    /// Where, in m, frame W.
    pub place_w: Vector2<f64>,
    /// How fast, in m/s, axes of W.
    pub velocity_w: Vector2<f64>,
}

/// Some points of the support that slide over the table, an entry of each list for every one.
#[derive(Clone, Debug)]
pub struct SlidingPoints {
    n: usize,
    places_w: [[f64; Self::MOST]; 2],
    velocities_w: [[f64; Self::MOST]; 2],
    squares: [f64; Self::MOST],
}

/// What effects change of the friction of [`SlidingPoints`], an entry each.
#[derive(Clone, Debug)]
pub struct LocalFriction {
    /// Relative surplus of friction.
    pub surplus: [f64; SlidingPoints::MOST],
    /// Its growth with the logarithm of the point's speed.
    pub growth: [f64; SlidingPoints::MOST],
}

impl SlidingPoints {
    /// So many at a time, at most.
    pub const MOST: usize = 64;

    /// Points at x and y of some axes, in m, with their velocities, in m/s, seen in W: turned by (cos, sin),
    /// about `center_w`. No more than [`MOST`](Self::MOST) are taken.
    pub(crate) fn seen(
        (places, velocities): ([&[f64]; 2], [&[f64]; 2]),
        [cos, sin]: [f64; 2],
        center_w: &Vector2<f64>,
    ) -> Self {
        let n = places[0].len().min(Self::MOST);
        let none = [0.0; Self::MOST];
        let mut seen = Self { n, places_w: [none; 2], velocities_w: [none; 2], squares: none };
        for k in 0..n {
            let (x, y) = (places[0][k], places[1][k]);
            seen.places_w[0][k] = center_w.x + (cos * x - sin * y);
            seen.places_w[1][k] = center_w.y + (sin * x + cos * y);
            let (x, y) = (velocities[0][k], velocities[1][k]);
            seen.velocities_w[0][k] = cos * x - sin * y;
            seen.velocities_w[1][k] = sin * x + cos * y;
            seen.squares[k] = x * x + y * y;
        }
        seen
    }

    /// The points one after the other.
    pub fn iter(&self) -> impl Iterator<Item = Sliding> + '_ {
        let of = |lists: &[[f64; Self::MOST]; 2], k: usize| Vector2::new(lists[0][k], lists[1][k]);
        (0..self.n).map(move |k| Sliding {
            place_w: of(&self.places_w, k),
            velocity_w: of(&self.velocities_w, k),
        })
    }

    /// The squares of their speeds, in m²/s².
    pub fn squared_speeds(&self) -> &[f64] {
        &self.squares[..self.n]
    }
}

impl Default for LocalFriction {
    fn default() -> Self {
        Self { surplus: [0.0; SlidingPoints::MOST], growth: [0.0; SlidingPoints::MOST] }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::{LocalFriction, SlidingPoints};
    use crate::{Stage, all};

    #[test]
    fn all_points_at_once_have_what_each_has_by_itself() {
        let list = |of: fn(f64) -> f64| (0..21).map(|k| of(f64::from(k))).collect::<Vec<f64>>();
        let places = [list(|k| 0.04 * (1.7 * k).sin()), list(|k| 0.04 * (2.3 * k).cos())];
        let velocities = [list(|k| 0.03 * (0.9 * k).cos()), list(|k| 0.02 * k.sin())];
        let [x, y] = [&places, &velocities].map(|lists| [&lists[0][..], &lists[1][..]]);
        let (sin, cos) = 0.4_f64.sin_cos();
        let points = SlidingPoints::seen((x, y), [cos, sin], &Vector2::new(0.1, -0.2));
        assert_eq!(points.iter().count(), 21);
        let local = all().iter().filter(|effect| effect.info().stages.contains(&Stage::Local));
        let mut n = 0;
        for effect in local {
            let about = effect.info();
            let typical: Vec<f64> = about.parameters.iter().map(|one| one.typical).collect();
            let mut found = LocalFriction::default();
            effect.add_local_friction(&typical, &points, &mut found);
            for (k, sliding) in points.iter().enumerate() {
                let surplus = effect.local_friction(&typical, &sliding);
                let growth = effect.local_growth(&typical, &sliding, surplus);
                let off = (found.surplus[k] - surplus).abs().max((found.growth[k] - growth).abs());
                assert!(off < 1e-14, "{} {off}", about.id);
            }
            n += usize::from(found.surplus.iter().any(|surplus| *surplus != 0.0));
        }
        assert!(n >= 3, "{n}");
    }
}
