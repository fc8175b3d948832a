//! The catalogue: one file an effect, and one line in the list.

use std::sync::{Arc, LazyLock};

use crate::{Effect, EffectError};

/// Declares the modules, hands on their effects, and lists them in `ALL`, those that a diagnosis tests
/// for first.
macro_rules! catalogue {
    (
        tested { $($file:ident::$Effect:ident,)+ }
        fitted { $($other_file:ident::$Other:ident,)+ }
    ) => {
        $(
            mod $file;
            pub use $file::$Effect;
        )+
        $(
            mod $other_file;
            pub use $other_file::$Other;
        )+

        static ALL: LazyLock<Vec<Arc<dyn Effect>>> = LazyLock::new(|| {
            vec![$(Arc::new($Effect) as Arc<dyn Effect>,)+ $(Arc::new($Other),)+]
        });

        /// How many a diagnosis tests for.
        const N_TESTED: usize = [$(stringify!($Effect)),+].len();
    };
}

// In the order in which they act.
catalogue! {
    tested {
        support_friction::SupportFriction,
        pressure_radius::PressureRadius,
        limit_surface_shape::LimitSurfaceShape,
        friction_center_offset::FrictionCenterOffset,
        table_anisotropy::TableAnisotropy,
        body_anisotropy::BodyAnisotropy,
        friction_gradient::FrictionGradient,
        table_tilt::TableTilt,
        rate_dependent_friction::RateDependentFriction,
        support_stiction::SupportStiction,
        friction_drift::FrictionDrift,
        pusher_friction::PusherFriction,
        pusher_friction_asymmetry::PusherFrictionAsymmetry,
        pusher_stiction::PusherStiction,
        pusher_radius::PusherRadius,
        contact_bias::ContactBias,
        edge_rounding::EdgeRounding,
        pusher_compliance::PusherCompliance,
        inertia::Inertia,
        pose_offset::PoseOffset,
        yaw_offset::YawOffset,
        robot_offset::RobotOffset,
        stream_latency::StreamLatency,
        force_bias::ForceBias,
        push_height::PushHeight,
    }
    fitted {
        support_points::SupportPoints,
        pressure_map::PressureMap,
        vertex_contact::VertexContact,
        approach_gap::ApproachGap,
        friction_field::FrictionField,
    }
}

/// Every effect of the catalogue, in the order in which they act.
pub fn all() -> &'static [Arc<dyn Effect>] {
    &ALL
}

/// The effects of the catalogue that a diagnosis tests for; the others are added by hand or fitted.
pub fn tested() -> &'static [Arc<dyn Effect>] {
    &ALL[..N_TESTED]
}

/// The effect with an id.
///
/// # Errors
/// `UnknownEffect`, with the ids that there are.
pub fn by_id(id: &str) -> Result<&'static Arc<dyn Effect>, EffectError> {
    by_id_with(id, &[])
}

/// The effect with an id, of `own` or else of the catalogue.
///
/// # Errors
/// `UnknownEffect`, with the ids that there are.
pub fn by_id_with<'a>(
    id: &str,
    own: &'a [Arc<dyn Effect>],
) -> Result<&'a Arc<dyn Effect>, EffectError> {
    let known = || own.iter().chain(all());
    known().find(|effect| effect.info().id == id).ok_or_else(|| EffectError::UnknownEffect {
        id: id.to_owned(),
        known: known().map(|effect| effect.info().id).collect::<Vec<_>>().join(", "),
    })
}
