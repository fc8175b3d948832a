//! Numbers in, numbers out: roots, quadrature and a step of a differential equation; no mechanics.

pub(crate) mod quadrature;
pub(crate) mod root;
pub(crate) mod runge_kutta;
