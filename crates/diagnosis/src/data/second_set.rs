//! A second set that confirms what is fitted to all of the first.

use models::Split;

use crate::{DiagnosisError, Observations};

impl Observations {
    /// The split in which all of these pushes are fitted to, and those of another set confirm.
    ///
    /// # Errors
    /// `OtherKind` if that set has other channels, another object, pusher or table, or is this one.
    pub fn confirmed_by(&self, other: &Self) -> Result<Split, DiagnosisError> {
        let differs = |what| Err(DiagnosisError::OtherKind { what });
        let [mine, theirs] = [self, other].map(|set| &set.steps[0].input);
        let shapes = [mine, theirs].map(|input| input.object.shape());
        if self.set == other.set {
            return differs("it is the same set");
        }
        if self.channels() != other.channels() {
            return differs("it has other channels");
        }
        if shapes[0] != shapes[1] {
            return differs("its object has another outline");
        }
        if mine.pusher_radius != theirs.pusher_radius {
            return differs("its pusher has another radius");
        }
        if self.support != other.support {
            return differs("its table has another friction or gravity");
        }
        let names = |set: &Self| set.pushes.iter().map(ToString::to_string).collect();
        Ok(Split {
            set: self.set.clone(),
            seed: 0,
            cluster: self.cluster,
            fit: names(self),
            confirm: names(other),
            confirm_set: Some(other.set.clone()),
        })
    }

    /// Whether a split keeps these recordings, all of them, to confirm what is fitted to others.
    pub fn confirm(&self, split: &Split) -> bool {
        split.confirm_set.as_ref() == Some(&self.set)
    }
}
