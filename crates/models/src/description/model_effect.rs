//! An effect that a model carries, with what is known of its parameters.

use std::collections::BTreeMap;

use effects::{Setting, Spread};

use crate::Estimate;

/// An effect by its id, with an estimate of each parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelEffect {
    /// Id in the catalogue, or of an effect of one's own.
    pub id: String,
    /// Every parameter by its name, in its SI unit.
    pub parameters: BTreeMap<String, Estimate>,
    /// Of those that differ from push to push of a session.
    pub per_push: BTreeMap<String, Spread>,
    /// Of those that differ from session to session, beside that.
    pub per_session: BTreeMap<String, Spread>,
    /// Of those that differ from place to place of the table, faster than a step is long.
    pub per_place: BTreeMap<String, Spread>,
}

impl ModelEffect {
    /// An effect whose parameters are the same in all pushes and places.
    pub fn new(id: &str, parameters: BTreeMap<String, Estimate>) -> Self {
        let [per_push, per_session, per_place] = Default::default();
        Self { id: id.to_owned(), parameters, per_push, per_session, per_place }
    }

    /// The values alone, as a push of an unknown session has them: what differs from session to session does so
    /// from push to push.
    pub fn setting(&self) -> Setting {
        let values = self.parameters.iter().map(|(name, known)| (name.clone(), known.value));
        let mut per_push = self.per_push.clone();
        for (name, spread) in &self.per_session {
            let both = per_push.get(name).map_or(*spread, |of_push| of_push.and(*spread));
            per_push.insert(name.clone(), both);
        }
        Setting {
            id: self.id.clone(),
            parameters: values.collect(),
            per_push,
            per_place: self.per_place.clone(),
        }
    }
}

impl From<Setting> for ModelEffect {
    /// Values taken as exact, without a source.
    fn from(Setting { id, parameters, per_push, per_place }: Setting) -> Self {
        let exact = |(name, value)| (name, Estimate::exact(value, ""));
        let parameters = parameters.into_iter().map(exact).collect();
        Self { per_push, per_place, ..Self::new(&id, parameters) }
    }
}
