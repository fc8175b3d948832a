//! The push in closed form, for every limit surface that is an ellipsoid.

use crate::{ContactMode, MechanicsError, Push, PushMotion};
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2};
use planar::Twist;

/// The push on the limit surface level² = wᵀ `A` w, w = (Fx, Fy, M), `A` positive definite.
///
/// With J the Jacobian of the contact point, a contact force f moves that point with G f, where
/// G = J A Jᵀ, up to a common factor. Sticking thus needs f = G⁻¹ v; if that leaves the friction
/// cone, the force is on the cone's edge and G f matches the normal velocity only.
///
/// A pusher at (x, y) that sticks to an upright, centered ellipsoid thus causes
/// vx = ((c² + x²) vpx + x y vpy)/(c² + x² + y²), vy = (x y vpx + (c² + y²) vpy)/(c² + x² + y²) and
/// ω = (x vy − y vx)/c²; the denominators of the thesis' eq. 2.19 have `r_y` for y.
///
/// # Errors
/// A push with a component that is not finite or a negative friction; a motion beyond all numbers.
#[allow(non_snake_case, reason = "the symbols of the derivation")]
pub(crate) fn quadric_push(A: &Matrix3<f64>, push: &Push) -> Result<PushMotion, MechanicsError> {
    push.validate()?;
    let scale = push.speed_scale();
    let push = &push.slowed_by(scale);
    let approach = push.approach_speed();
    if approach <= 0.0 {
        return push.separated().sped_up_by(scale);
    }
    let p = &push.p_sc;
    let J = Matrix2x3::new(1.0, 0.0, -p.y, 0.0, 1.0, p.x);
    let AJt = A * J.transpose();
    let G = J * AJt;
    let sticking = solve(&G, &push.v_wp_s);
    let (normal_part, tangent_part) =
        (push.normal_s.dot(&sticking), push.tangent_s().dot(&sticking));
    let (mode, f) = if tangent_part.abs() <= push.friction * normal_part {
        (ContactMode::Sticking, sticking)
    } else {
        let mode =
            if tangent_part > 0.0 { ContactMode::SlidingLeft } else { ContactMode::SlidingRight };
        let edge = push.edge_of(mode);
        (mode, edge * (approach / push.normal_s.dot(&(G * edge))))
    };
    let level = f.dot(&(G * f)).sqrt();
    push.motion(mode, Twist::from_vector(&(AJt * f)), f / level).sped_up_by(scale)
}

/// G⁻¹ v for a positive definite G.
fn solve(g: &Matrix2<f64>, v: &Vector2<f64>) -> Vector2<f64> {
    let determinant = g.m11 * g.m22 - g.m12 * g.m21;
    Vector2::new(g.m22 * v.x - g.m12 * v.y, g.m11 * v.y - g.m21 * v.x) / determinant
}
