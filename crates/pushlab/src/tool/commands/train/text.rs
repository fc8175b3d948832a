//! A training in words.

use std::fmt;

use super::{Score, Trained};
use crate::tool::terminal::{TITLE, WARNING};
use crate::tool::unexplained::shares;
use crate::tool::whole_pushes::Told;

impl fmt::Display for Trained {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { n_pushes, n_steps, n_learnt, unseen, .. } = self;
        writeln!(f, "{TITLE}wrote {}{TITLE:#}", self.model.display())?;
        let process = self.chosen.process.id();
        let inputs = self.inputs.join(", ");
        match n_learnt == n_steps {
            true => write!(f, "  {process} of {inputs}, learnt from {n_steps} steps")?,
            false => {
                write!(f, "  {process} of {inputs}, learnt from {n_learnt} of {n_steps} steps")?;
            }
        }
        writeln!(f, " of {n_pushes} pushes")?;
        if n_learnt < n_steps {
            writeln!(f, "  these {n_learnt} are a random part; -n takes more")?;
        }
        if !self.kept.is_empty() {
            writeln!(f, "  kept, for these pushes do not tell it: {}", self.kept.join(", "))?;
        }
        for (score, names) in unseen.scores.iter().zip(&self.at_bound) {
            if !names.is_empty() {
                let names = names.join(", ");
                writeln!(f, "  {WARNING}note:{WARNING:#} {}: {names} ended at a wall", score.name)?;
            }
        }
        let (pushes, steps) = (unseen.n_pushes, unseen.n_steps);
        writeln!(f, "{TITLE}on {steps} steps of {pushes} pushes that it has not seen{TITLE:#}")?;
        unseen.scores.iter().try_for_each(|score| write_score(f, score))?;
        let mean = |of: &dyn Fn(&Score) -> Option<f64>| {
            let values: Option<Vec<f64>> = unseen.scores.iter().map(of).collect();
            values.map(|values| values.iter().sum::<f64>() / values.len() as f64)
        };
        if let Some(nmse) = mean(&|score| Some(score.nmse)) {
            write!(f, "  mean    NMSE {nmse:.4}")?;
        }
        match mean(&|score| score.nmse_of_physics) {
            Some(nmse) => writeln!(f, ", of the physics alone {nmse:.4}")?,
            None => writeln!(f)?,
        }
        if let Some(calibration) = &self.calibration {
            writeln!(f, "of whole pushes: {}", Told(calibration))?;
        }
        if let Some(learnt) = &self.unexplained {
            let title = "share of what it says that no physics explains";
            writeln!(f, "{TITLE}{title}{TITLE:#}")?;
            writeln!(f, "  where it learnt: {}", shares(learnt))?;
            if let Some(unseen) = &unseen.unexplained {
                writeln!(f, "  where it has not: {}", shares(unseen))?;
            }
        }
        Ok(())
    }
}

fn write_score(f: &mut fmt::Formatter<'_>, score: &Score) -> fmt::Result {
    write!(f, "  {:7} NMSE {:.4}", score.name, score.nmse)?;
    if let Some(nmse) = score.nmse_of_physics {
        write!(f, ", of the physics alone {nmse:.4}")?;
    }
    write!(f, "  NLPD {:.2}", score.nlpd)?;
    for covered in &score.coverage {
        write!(f, "  {:.0} %: {:.0} %", 100.0 * covered.level, 100.0 * covered.share)?;
    }
    writeln!(f)
}
