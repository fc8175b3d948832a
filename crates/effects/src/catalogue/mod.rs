//! The catalogue: one file an effect, one line in [`all`].

mod body_anisotropy;
mod contact_bias;
mod edge_rounding;
mod force_bias;
mod friction_center_offset;
mod friction_drift;
mod friction_gradient;
mod inertia;
mod limit_surface_shape;
mod pose_offset;
mod pressure_radius;
mod pusher_compliance;
mod pusher_friction;
mod pusher_friction_asymmetry;
mod pusher_radius;
mod pusher_stiction;
mod rate_dependent_friction;
mod stream_latency;
mod support_friction;
mod support_stiction;
mod table_anisotropy;
mod table_tilt;
mod yaw_offset;

pub use body_anisotropy::BodyAnisotropy;
pub use contact_bias::ContactBias;
pub use edge_rounding::EdgeRounding;
pub use force_bias::ForceBias;
pub use friction_center_offset::FrictionCenterOffset;
pub use friction_drift::FrictionDrift;
pub use friction_gradient::FrictionGradient;
pub use inertia::Inertia;
pub use limit_surface_shape::LimitSurfaceShape;
pub use pose_offset::PoseOffset;
pub use pressure_radius::PressureRadius;
pub use pusher_compliance::PusherCompliance;
pub use pusher_friction::PusherFriction;
pub use pusher_friction_asymmetry::PusherFrictionAsymmetry;
pub use pusher_radius::PusherRadius;
pub use pusher_stiction::PusherStiction;
pub use rate_dependent_friction::RateDependentFriction;
pub use stream_latency::StreamLatency;
pub use support_friction::SupportFriction;
pub use support_stiction::SupportStiction;
pub use table_anisotropy::TableAnisotropy;
pub use table_tilt::TableTilt;
pub use yaw_offset::YawOffset;

use crate::{Effect, EffectError};

/// Every effect of the catalogue, in the order in which they act.
pub fn all() -> &'static [&'static dyn Effect] {
    ALL
}

/// The effect with an id.
///
/// # Errors
/// `UnknownEffect`, with the ids that there are.
pub fn by_id(id: &str) -> Result<&'static dyn Effect, EffectError> {
    let found = ALL.iter().find(|effect| effect.info().id == id);
    found.copied().ok_or_else(|| EffectError::UnknownEffect {
        id: id.to_owned(),
        known: ALL.iter().map(|effect| effect.info().id).collect::<Vec<_>>().join(", "),
    })
}

static ALL: &[&dyn Effect] = &[
    &SupportFriction,
    &PressureRadius,
    &LimitSurfaceShape,
    &FrictionCenterOffset,
    &TableAnisotropy,
    &BodyAnisotropy,
    &FrictionGradient,
    &TableTilt,
    &RateDependentFriction,
    &SupportStiction,
    &FrictionDrift,
    &PusherFriction,
    &PusherFrictionAsymmetry,
    &PusherStiction,
    &PusherRadius,
    &ContactBias,
    &EdgeRounding,
    &PusherCompliance,
    &Inertia,
    &PoseOffset,
    &YawOffset,
    &StreamLatency,
    &ForceBias,
];
