//! The pages of docs/ about effects, so that their code is tested.

#[doc = include_str!("../../../docs/write-your-own-effect.md")]
struct WriteYourOwnEffect;
