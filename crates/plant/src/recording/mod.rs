//! The motion of pushes goes in, a recording set comes out, with the truth sealed beside it.

pub(crate) mod generate;
pub(crate) mod profile;
pub(crate) mod pushed_object;
pub(crate) mod scatter;
pub(crate) mod sealed_truth;
pub(crate) mod sensors;
pub(crate) mod simulate;
