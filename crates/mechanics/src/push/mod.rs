//! A limit surface and a contact's velocity go in, the object's velocity and the contact's force
//! come out.

pub(crate) mod contact;
pub(crate) mod friction_cone;
pub(crate) mod general;
pub(crate) mod joint;
pub(crate) mod motion_cone;
pub(crate) mod quadric;
pub(crate) mod rotation;
pub(crate) mod slider;
