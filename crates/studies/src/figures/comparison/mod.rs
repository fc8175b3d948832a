//! Ours: how wrong a model is beside how wrong it may be.

pub(crate) mod where_it_fails;
