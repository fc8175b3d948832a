//! What figures and pages obey, from outside the crate.

mod figure;
mod live_page;
mod marks;
mod page;
