//! What pytest says at its end, as programs of Rust's tests say it.

use std::fmt;

/// Numbers of tests.
#[derive(Default)]
pub(crate) struct Outcome {
    passed: usize,
    failed: usize,
    ignored: usize,
    is_success: bool,
}

impl Outcome {
    /// From the last line, such as `1 failed, 57 passed, 2 skipped in 9.12s`.
    pub(crate) fn of(text: &str, is_success: bool) -> Self {
        let mut outcome = Self { is_success, ..Self::default() };
        let last = text.lines().rev().find(|line| line.contains(" in ")).unwrap_or_default();
        let words: Vec<_> = last.split([' ', ',']).filter(|word| !word.is_empty()).collect();
        for pair in words.windows(2) {
            let Ok(count) = pair[0].parse::<usize>() else { continue };
            match pair[1] {
                "passed" | "xfailed" => outcome.passed += count,
                "failed" | "error" | "errors" | "xpassed" => outcome.failed += count,
                "skipped" | "deselected" => outcome.ignored += count,
                _ => {}
            }
        }
        outcome
    }

    /// Whether something ran, and all of it is as it should be.
    pub(crate) fn is_good(&self) -> bool {
        self.is_success && self.failed == 0 && self.passed > 0
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { passed, failed, ignored, .. } = self;
        let word = if self.is_good() { "ok" } else { "FAILED" };
        write!(
            f,
            "test result: {word}. {passed} passed; {failed} failed; {ignored} ignored; 0 measured"
        )
    }
}
