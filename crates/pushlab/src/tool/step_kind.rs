//! What the steps are of which errors are told.

use std::fmt;

use dataset::StepLength;
use diagnosis::steady_ingest;
use serde::{Serialize, Serializer};

use crate::tool::step_size::StepSize;

/// How a step was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum StepKind {
    /// Of recordings, where noise is known: what tests and fits take.
    Steady,
    /// Of recordings, all in contact, of a length that was asked for.
    Length(StepSize),
    /// From one pose at rest to the next.
    WholePush,
    /// As a table has it.
    OfTable,
}

impl fmt::Display for StepKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let length = |step: StepLength| match step {
            StepLength::Time(time) => format!("{} ms", 1e3 * time),
            StepLength::Distance(way) => format!("{} mm", 1e3 * way),
        };
        match self {
            Self::Steady => {
                write!(f, "{} of smoothed motion, away from vertices", length(steady_ingest().step))
            }
            Self::Length(StepSize(step)) => write!(f, "{}, all in contact", length(*step)),
            Self::WholePush => write!(f, "a whole push"),
            Self::OfTable => write!(f, "as in the table"),
        }
    }
}

impl Serialize for StepKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::StepKind;

    #[test]
    fn steps_are_told_in_units_that_people_use() {
        let told = |kind: StepKind| kind.to_string();
        assert_eq!(told(StepKind::Steady), "5 mm of smoothed motion, away from vertices");
        let asked = |text: &str| StepKind::Length(text.parse().unwrap());
        assert_eq!(told(asked("0.2s")), "200 ms, all in contact");
        assert_eq!(told(asked("0.4cm")), "4 mm, all in contact");
    }
}
