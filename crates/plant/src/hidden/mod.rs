//! Hidden effects by name, as a user asks for them.

mod additional;
mod catalogue;
mod effect_kind;
mod quantity;
mod spec;
mod surprise;

pub use effect_kind::{EffectKind, Parameter};
pub use quantity::Quantity;
pub use spec::{Hidden, HiddenEffect};

/// Every effect that can be hidden: first those of the catalogue of missing effects, then those
/// that no catalogue has.
#[must_use]
pub fn effect_kinds() -> Vec<&'static EffectKind> {
    catalogue::KINDS.iter().chain(additional::KINDS).collect()
}

pub(crate) fn effect_kind(id: &str) -> Option<&'static EffectKind> {
    effect_kinds().into_iter().find(|kind| kind.id == id)
}
