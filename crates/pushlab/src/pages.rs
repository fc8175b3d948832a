//! Pages of the workspace whose examples are tests.

#[doc = include_str!("../../../README.md")]
struct Readme;

#[doc = include_str!("../../../docs/tutorial-compare.md")]
struct TutorialCompare;

#[doc = include_str!("../../../docs/tutorial-recordings.md")]
struct TutorialRecordings;
