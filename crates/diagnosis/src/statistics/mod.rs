//! Numbers and their clusters go in, quantiles, variances and probabilities come out; no pushes.

pub(crate) mod blocks;
pub(crate) mod box_search;
pub(crate) mod gain;
pub(crate) mod map_test;
pub(crate) mod mixture;
pub(crate) mod quantile;
pub(crate) mod score;
pub(crate) mod sign_flips;
pub(crate) mod signed_ranks;
pub(crate) mod variances;
