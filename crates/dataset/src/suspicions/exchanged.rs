//! Whether the streams of pusher and object are exchanged.

use super::mistake::View;
use super::places::{NEAR, NEARER, SHARE, distance, evidence};
use super::scene::Scene;
use super::{Check, Explanation, Find, Suspicion};
use crate::curves::sample::quantile;

pub(super) const CHECK: Check = Check {
    id: "exchanged",
    looks_at: "the same distance with the two streams of poses exchanged",
    names: "topics, files or data sets of robot and object that are taken for each other",
    find: Find::Places(find),
};

fn find(scene: &Scene<'_>) -> Option<Explanation> {
    let recorded = View::recorded();
    let distance = distance(scene, &recorded)?;
    let gaps = scene.recordings.iter().flat_map(|one| {
        let gap = |moment| recorded.seen(moment, &one.object.shape, scene.radius()).contact.gap;
        one.exchanged.iter().map(move |moment| gap(moment).abs())
    });
    let at = quantile(gaps.collect(), SHARE)?;
    let near = NEAR * scene.size();
    if distance <= near || at > near || at > NEARER * distance {
        return None;
    }
    let suspicion = Suspicion {
        what: "the streams of pusher and object are exchanged".into(),
        evidence: evidence(distance, at),
        fix: "exchange streams.robot.topic and streams.object.topic (for CSV robot.csv and \
              object.csv)"
            .into(),
        is_certain: true,
    };
    Some(Explanation { distance: at, suspicion: Some(suspicion), view: None })
}
