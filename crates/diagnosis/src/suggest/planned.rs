//! Pushes that were not done yet, as observations would have them.

use models::{ChannelObservation, Cluster, Excluded};

use super::SuggestedPush;
use super::route::{Route, RouteStep};
use crate::data::observations::Place;
use crate::{Observations, PushName};
use dataset::{Flags, quantile};

/// Candidates as observations, with the numbers that are expected.
pub(super) struct Planned(pub(super) Observations);

impl Planned {
    /// With the channels and the poses' errors of the observations so far.
    pub(super) fn new(observations: &Observations, routes: &[Route]) -> Self {
        let is_observed: [bool; 7] = std::array::from_fn(|number| {
            observations.steps.iter().any(|step| step.observed[number].is_some())
        });
        let sd = |end: usize, kind: usize| {
            let sd = observations.places.iter().map(|place| place.pose_sd[end][kind]);
            quantile(sd.collect(), 0.5).unwrap_or_default()
        };
        let pose_sd = [0, 1].map(|end| [sd(end, 0), sd(end, 1)]);
        let is_of_ends = observations.places[0].is_whole;
        let (mut steps, mut places, mut push_of) = (Vec::new(), Vec::new(), Vec::new());
        for (push, Route { push: SuggestedPush { edge, speed, .. }, steps: own }) in
            routes.iter().enumerate()
        {
            for (index, RouteStep { input, place: [p, beta], predicted }) in own.iter().enumerate()
            {
                let observed = |k: usize| is_observed[k].then_some(predicted[k]);
                let observed = std::array::from_fn(observed);
                steps.push(ChannelObservation { input: input.clone(), observed });
                let (step, edge) = (index as u32, *edge as u32);
                places.push(Place {
                    flags: Flags::default(),
                    step,
                    edge,
                    p: *p,
                    beta: *beta,
                    speed: *speed,
                    pose_sd,
                    is_whole: is_of_ends,
                });
                push_of.push(push);
            }
        }
        let name = |k: usize| PushName { recording: format!("candidate-{k}"), push: 0 };
        Self(Observations {
            cluster_of: push_of.clone(),
            cluster: Cluster::Push,
            steps,
            places,
            push_of,
            pushes: (0..routes.len()).map(name).collect(),
            support: observations.support,
            set: String::new(),
            name: String::new(),
            unknown: observations.unknown.clone(),
            excluded: Excluded::default(),
            runs: None,
        })
    }
}
