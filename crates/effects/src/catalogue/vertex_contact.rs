//! A tip that is caught at a vertex.

use planar::Shape;

use crate::{
    Channel, Confounder, ContactLaw, Effect, EffectInfo, Nuisance, Off, Origin, Parameter, Role,
    Snapshot, Stage,
};

/// Contact at a vertex: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VertexContact;

static INFO: EffectInfo = EffectInfo {
    id: "vertex-contact",
    title: "Tip caught at a vertex",
    physics: "A round tip near the end of an edge meets the vertex, and with it the normals of both \
        edges. A push that would slide from there towards the middle of the edge is held: the vertex \
        is in its way, and holds it however it is pulled at. What counts is where the step begins.",
    equation: "Within the distance of an edge's end, sliding inwards: sticks, whatever the friction.",
    source: "Geometry: at a vertex the contact normal is any between those of its two edges.",
    stages: &[Stage::Contact],
    origin: Origin::Contact,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[Parameter {
        name: "distance",
        unit: "m",
        meaning: "From the edge's end, within which the tip is caught",
        off: Off::At(0.0),
        typical: 2e-3,
        range: (0.0, 0.02),
        role: Role::Threshold,
    }],
    confounders: &[Confounder {
        id: "edge-rounding",
        when: "where few pushes begin near a vertex",
    }],
    nuisance: Nuisance::No,
    shown_by: &["pushes that begin within 2 mm of a vertex, aimed away from it"],
};

impl Effect for VertexContact {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn contact(&self, values: &[f64], moment: &Snapshot<'_>, law: &mut ContactLaw) {
        let step = moment.step;
        let Shape::Polygon(polygon) = step.object.shape() else { return };
        if values[0] == 0.0 {
            return;
        }
        let center_o = moment.pose_wo.inverse_transform_point(&step.track.start());
        let contact = step.object.shape().contact(&center_o, step.pusher_radius);
        let Some((from, to)) = polygon.edges().nth(contact.edge) else { return };
        let length = (to - from).norm();
        // Along the edge is to the right of its inward normal.
        law.caught_right |= contact.p * length < values[0];
        law.caught_left |= (1.0 - contact.p) * length < values[0];
    }
}
