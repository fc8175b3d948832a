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

/// Every effect that can be hidden: those that models have a parameter for, those that no catalogue has,
/// and those of the catalogue of which the plant has laws of its own.
#[must_use]
pub fn effect_kinds() -> Vec<&'static EffectKind> {
    surprising().chain(catalogue::OF_THE_TABLE).collect()
}

/// What a surprise may be.
fn surprising() -> impl Iterator<Item = &'static EffectKind> {
    let others = catalogue::OF_SUPPORT_AND_TIP.iter();
    catalogue::KINDS.iter().chain(additional::KINDS).chain(others)
}

pub(crate) fn effect_kind(id: &str) -> Option<&'static EffectKind> {
    effect_kinds().into_iter().find(|kind| kind.id == id)
}
