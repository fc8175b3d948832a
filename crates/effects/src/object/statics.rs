//! How a rigid object's weight is shared by the points that it rests on.

use nalgebra::{DMatrix, DVector, Vector2, Vector3};

use crate::{EffectError, Object};

/// More points make more sets of bearing ones than are tried.
const MOST_POINTS: usize = 12;
/// Relative to the largest singular value, and to the whole weight.
const ROUNDING: f64 = 1e-9;

impl Object {
    /// Shares of the weight on points, in m, frame of the outline: of a rigid object whose center of mass is
    /// known.
    ///
    /// Forces and moments balance: Σ w = 1, Σ w r = center of mass, w ≥ 0. Three points that are in no line
    /// have one answer. Of more the shares of least squares Σ w² are taken: those on equally stiff springs,
    /// of which the ones that would pull are lifted. Real feet, of which three bear most on a hard table, need
    /// not be like them.
    ///
    /// # Errors
    /// `InvalidValue` for a place that is not finite, and for no points or more than twelve;
    /// `NotBetween` where no shares balance the weight.
    pub fn statics(&self, places_o: &[Vector2<f64>]) -> Result<Vec<f64>, EffectError> {
        let n = places_o.len();
        if !(1..=MOST_POINTS).contains(&n) {
            let (name, expected) = ("the number of support points", "from 1 to 12");
            return Err(EffectError::InvalidValue {
                name,
                expected,
                value: n as f64,
                unit: "points",
            });
        }
        if let Some(place) = places_o.iter().find(|place| !(place.x + place.y).is_finite()) {
            let (name, expected, unit) = ("a support point's place", "finite", "m");
            return Err(EffectError::InvalidValue { name, expected, value: place.sum(), unit });
        }
        let center = *self.center_of_mass();
        // Lengths about the center, of order 1.
        let size = places_o.iter().map(|place| (place - center).norm()).fold(0.0, f64::max);
        let rows: Vec<Vector3<f64>> = places_o
            .iter()
            .map(|place| (place - center) / size.max(f64::MIN_POSITIVE))
            .map(|arm| Vector3::new(1.0, arm.x, arm.y))
            .collect();
        let bearing = |set: u32| (0..n).filter(move |k| set & (1 << k) != 0).collect::<Vec<_>>();
        let answers = (1..1_u32 << n).filter_map(|set| balanced(&rows, &bearing(set)));
        let least = answers.min_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
        let found = least.map(|shares| shares.as_slice().to_vec());
        found.ok_or(EffectError::NotBetween { x: center.x, y: center.y })
    }
}

/// The shares of least squares on some of the points, the others bearing nothing; none where one would be
/// negative, or where these cannot bear the weight.
fn balanced(rows: &[Vector3<f64>], bearing: &[usize]) -> Option<DVector<f64>> {
    let matrix = DMatrix::from_fn(3, bearing.len(), |i, k| rows[bearing[k]][i]);
    let whole = DVector::from_column_slice(&[1.0, 0.0, 0.0]);
    let svd = matrix.clone().svd(true, true);
    let least = ROUNDING * svd.singular_values.max();
    let shares = svd.solve(&whole, least).ok()?;
    let is_balanced = (&matrix * &shares - whole).amax() <= ROUNDING;
    if !is_balanced || shares.min() < -ROUNDING {
        return None;
    }
    let mut all = DVector::zeros(rows.len());
    for (k, share) in bearing.iter().zip(&shares) {
        all[*k] = share.max(0.0);
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::Vector2;
    use planar::Shape;

    use crate::{EffectError, Object};

    fn object(center: (f64, f64)) -> Object {
        let square = Arc::new(Shape::square(0.1).unwrap());
        Object::new(square, 1.0, 2e-3, Vector2::new(center.0, center.1)).unwrap()
    }

    fn places(of: &[(f64, f64)]) -> Vec<Vector2<f64>> {
        of.iter().map(|(x, y)| 0.01 * Vector2::new(*x, *y)).collect()
    }

    #[test]
    fn three_feet_share_the_weight_as_by_hand() {
        // Feet at (0, 0), (4, 0), (0, 4) cm, and 1.2 cm, 0.8 cm: 0.5, 0.3, 0.2.
        let shares = object((0.012, 0.008)).statics(&places(&[(0., 0.), (4., 0.), (0., 4.)]));
        for (share, by_hand) in shares.unwrap().iter().zip([0.5, 0.3, 0.2]) {
            assert!((share - by_hand).abs() < 1e-12);
        }
    }

    #[test]
    fn more_feet_are_as_springs_that_only_push() {
        let corners = places(&[(4., 4.), (-4., 4.), (-4., -4.), (4., -4.)]);
        // Springs: a quarter each, and linear in the place.
        let shares = object((0.01, 0.0)).statics(&corners).unwrap();
        for (share, by_hand) in shares.iter().zip([0.3125, 0.1875, 0.1875, 0.3125]) {
            assert!((share - by_hand).abs() < 1e-12, "{shares:?}");
        }
        // Far towards one corner the opposite one would pull; the others bear as three feet do.
        let shares = object((0.03, 0.03)).statics(&corners).unwrap();
        for (share, by_hand) in shares.iter().zip([0.75, 0.125, 0.0, 0.125]) {
            assert!((share - by_hand).abs() < 1e-12, "{shares:?}");
        }
        let center: Vector2<f64> = corners.iter().zip(&shares).map(|(r, w)| *w * r).sum();
        assert!((center - Vector2::new(0.03, 0.03)).norm() < 1e-12);
        // On a line, and on one point.
        let line = places(&[(-4., 0.), (2., 0.), (4., 0.)]);
        let shares = object((0.0, 0.0)).statics(&line).unwrap();
        assert!(shares.iter().all(|share| *share > 0.0), "{shares:?}");
        assert_eq!(object((0.02, 0.0)).statics(&places(&[(2., 0.)])).unwrap(), [1.0]);
    }

    #[test]
    fn a_center_beside_the_feet_is_refused() {
        let feet = places(&[(0., 0.), (4., 0.), (0., 4.)]);
        let error = object((-0.01, 0.0)).statics(&feet).unwrap_err();
        assert_eq!(error, EffectError::NotBetween { x: -0.01, y: 0.0 });
        assert!(error.to_string().contains("center of mass (-0.01, 0) m"), "{error}");
        assert!(object((0.0, 0.0)).statics(&[]).is_err());
        assert!(object((0.0, 0.0)).statics(&places(&[(f64::NAN, 0.0)])).is_err());
    }
}
