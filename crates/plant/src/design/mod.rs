//! A layout or a list goes in, the pushes of a set come out, planned on the nominal outline.

pub(crate) mod layout;
pub(crate) mod planned_push;
pub(crate) mod push_list;
