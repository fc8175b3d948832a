//! Whole pushes, of which the ends alone are known, as steps.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result};
use dataset::{EndPoint, Flags, Provenance, StepRow, Table, TableMapping, read_endpoints};
use nalgebra::{UnitVector2, Vector2};
use planar::{Contact, Pose, Shape, cross, perpendicular, wrap_angle};

/// A push whose pusher ends further from the outline has slid off the object, in m.
const LOST: f64 = 2e-3;
/// How closely the touch is found, in m.
const TOUCH: f64 = 1e-6;

/// The pushes of one object, a row each from the touch to the end.
pub(super) struct Pushes {
    pub(super) shape: String,
    pub(super) mapping: TableMapping,
    /// Those that end in contact.
    pub(super) kept: Table,
    /// Those whose pusher has slid off before the end.
    pub(super) lost: Table,
    /// How many never meet the outline.
    pub(super) n_missed: usize,
}

/// Every object's pushes in a file of end points, in order of their names.
///
/// # Errors
/// A file that cannot be read, by its path.
pub(super) fn pushes(path: &Path) -> Result<Vec<Pushes>> {
    let mut by_shape: BTreeMap<String, Vec<EndPoint>> = BTreeMap::new();
    for push in read_endpoints(path)? {
        by_shape.entry(push.shape.clone()).or_default().push(push);
    }
    by_shape.into_iter().map(|(shape, ends)| Pushes::of(shape, &ends, path)).collect()
}

/// The poses are not among the columns of this mapping, so that the motion alone is compared: the
/// gap at the end follows from it, and the one at the start is 0, because the step begins there.
fn mapping(shape: &str) -> Result<TableMapping> {
    let text = format!(
        r#"schema = "pushlab.table-mapping/1"
name = "ends of pushes of {shape} on plywood"
object.shape = "{shape}"
pusher = {{ radius_m = 0.00475, friction = 0.25 }}
support = {{ friction = 0.25, gravity_m_s2 = 9.81 }}

[columns]
edge = "edge"
p = "p"
beta_rad = "beta_rad"
dt_s = "dt_s"
speed_m_s = "speed_m_s"
dx_m = "dx_m"
dy_m = "dy_m"
dtheta_rad = "dtheta_rad"
"#
    );
    Ok(TableMapping::parse(&text, Path::new(shape))?)
}

impl Pushes {
    fn of(shape: String, ends: &[EndPoint], path: &Path) -> Result<Self> {
        let mapping = mapping(&shape).with_context(|| format!("{}: {shape}", path.display()))?;
        let mut provenance = Provenance::default();
        provenance.push("set", &mapping.name);
        provenance.push("source", &mapping.name);
        let table = || Table { rows: Vec::new(), provenance: provenance.clone() };
        let mut found =
            Self { kept: table(), lost: table(), n_missed: 0, shape, mapping: mapping.clone() };
        for push in ends {
            match row(push, &mapping) {
                Some(row) if row.gap_end > LOST => found.lost.rows.push(row),
                Some(row) => found.kept.rows.push(row),
                None => found.n_missed += 1,
            }
        }
        Ok(found)
    }
}

/// A push from the touch on, before which the object rests; none if there is no touch.
fn row(push: &EndPoint, mapping: &TableMapping) -> Option<StepRow> {
    let (shape, radius) = (&mapping.object.shape, mapping.pusher.radius);
    let EndPoint { object_start, object_end, tip_end, .. } = push;
    let along = UnitVector2::try_new(tip_end - push.tip_start, 0.0)?;
    let start = touch(shape, radius, push, &along)?;
    let (way, speed) = ((tip_end - start).norm(), push.speed);
    let contact = at(shape, radius, object_start, &start);
    let normal = object_start.rotate(&contact.normal);
    let moved = object_end.position - object_start.position;
    let beta = cross(&normal, &along).atan2(normal.dot(&along));
    let mut flags = Flags::default();
    if beta.abs() > std::f64::consts::FRAC_PI_2 {
        flags |= Flags::MOVING_AWAY;
    }
    Some(StepRow {
        recording: Arc::from(push.shape.as_str()),
        shape: Arc::from(push.shape.as_str()),
        push: push.push,
        dt: way / speed,
        edge: contact.edge as u32,
        p: contact.p,
        beta,
        speed,
        object_pose: *object_start,
        pusher_start: start,
        pusher_end: *tip_end,
        pusher_velocity: speed * *along,
        contact_point: object_start.transform_point(&contact.point),
        contact_normal: normal,
        dx: along.dot(&moved),
        dy: perpendicular(&along).dot(&moved),
        dtheta: wrap_angle(object_end.angle - object_start.angle),
        gap_start: contact.gap,
        gap_end: at(shape, radius, object_end, tip_end).gap,
        flags,
        ..StepRow::default()
    })
}

fn at(shape: &Shape, radius: f64, pose: &Pose, center_w: &Vector2<f64>) -> Contact {
    shape.contact(&pose.inverse_transform_point(center_w), radius)
}

/// Where the pusher meets the resting object.
///
/// No point of the outline is nearer than the gap, so that a way as long as the gap meets none.
fn touch(
    shape: &Shape,
    radius: f64,
    push: &EndPoint,
    along: &Vector2<f64>,
) -> Option<Vector2<f64>> {
    let whole = (push.tip_end - push.tip_start).norm();
    let mut way = 0.0;
    while way < whole {
        let center = push.tip_start + way * along;
        let gap = at(shape, radius, &push.object_start, &center).gap;
        if gap <= TOUCH {
            return Some(center);
        }
        way += gap;
    }
    None
}

#[cfg(test)]
mod tests {
    use dataset::EndPoint;
    use nalgebra::Vector2;
    use planar::Pose;

    use super::{mapping, row};

    fn push(from: [f64; 2], to: [f64; 2], object_end: Pose) -> EndPoint {
        EndPoint {
            surface: "plywood".into(),
            shape: "rect1".into(),
            speed: 0.01,
            push: 3,
            object_start: Pose::new(0.0, 0.0, 0.0),
            object_end,
            tip_start: Vector2::from(from),
            tip_end: Vector2::from(to),
        }
    }

    #[test]
    fn a_push_begins_at_the_touch_and_keeps_its_end() {
        let mapping = mapping("rect1").unwrap();
        // The face is at −45 mm, the pusher's radius 4.75 mm: the touch is at −49.75 mm.
        let straight = push([-0.055, 0.0], [-0.03, 0.0], Pose::new(0.01975, 0.0, 0.0));
        let row = row(&straight, &mapping).unwrap();
        assert!((row.pusher_start.x + 0.04975).abs() < 2e-6, "{}", row.pusher_start.x);
        assert!((row.pusher_end.x + 0.03).abs() < 1e-15);
        assert!((row.dt - 0.01975 / 0.01).abs() < 1e-3 && (row.p - 0.5).abs() < 1e-9);
        assert!(row.gap_end.abs() < 1e-12 && row.beta.abs() < 1e-12);
        assert_eq!((row.edge, row.push), (1, 3));
    }

    #[test]
    fn a_way_beside_the_object_is_no_push() {
        let beside = push([-0.055, 0.06], [0.05, 0.06], Pose::new(0.0, 0.0, 0.0));
        assert!(row(&beside, &mapping("rect1").unwrap()).is_none());
        assert!(mapping("rect9").is_err());
    }
}
