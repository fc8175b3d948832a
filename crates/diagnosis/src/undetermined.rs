//! Why data do not determine an effect.

use std::fmt;

use effects::Channel;
use serde::Serialize;

/// Why data do not determine an effect, and what would.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "reason", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Undetermined {
    /// No channel that these data have shows it.
    NoChannel {
        /// What would show it.
        shown_in: Vec<Channel>,
    },
    /// A typical size of it, and the size that was found, change what these pushes show by less than their noise.
    Invisible,
    /// A parameter's interval does not close within its range.
    Open {
        /// Its name.
        parameter: &'static str,
    },
    /// Another effect changes the same.
    LooksLike {
        /// Its id.
        other: &'static str,
        /// Of their signatures.
        correlation: f64,
        /// When the two look alike; empty where not known.
        when: &'static str,
    },
    /// The pushes do not tell it from nothing.
    NotDistinct {
        /// Probability of an estimate as far from "off".
        p: f64,
    },
}

impl fmt::Display for Undetermined {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoChannel { shown_in } => {
                let names = shown_in.iter().map(|channel| match channel {
                    Channel::Motion => "the motion",
                    Channel::Force => "the contact force",
                    Channel::Gap => "the contact gap",
                });
                let names = names.collect::<Vec<_>>().join(" and ");
                write!(f, "it shows in {names} alone, which these data lack; record it too")
            }
            Self::Invisible => f.write_str(
                "a typical size of it changes what these pushes show by less than their noise; \
                 record pushes that it acts on (`pushlab effects explain` tells how it acts)",
            ),
            Self::Open { parameter } => write!(
                f,
                "the pushes allow every {parameter} up to an end of its range; record more, or \
                 pushes that differ more"
            ),
            Self::LooksLike { other, correlation, when } => {
                write!(
                    f,
                    "{other} changes the same in these pushes (correlation {correlation:.3})"
                )?;
                match when.is_empty() {
                    true => f.write_str("; leave one of the two out, or record other pushes"),
                    false => write!(f, ", as it does {when}; record other pushes"),
                }
            }
            Self::NotDistinct { p } => {
                write!(f, "the pushes do not tell it from nothing (p {p:.2})")
            }
        }
    }
}
