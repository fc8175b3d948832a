//! The pages of docs/ about recordings, so that their code is tested.

#[doc = include_str!("../../../docs/write-your-own-log-format.md")]
struct WriteYourOwnLogFormat;
