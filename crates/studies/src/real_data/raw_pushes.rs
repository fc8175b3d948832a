//! Published raw pushes: every one accounted for, contact and direction recovered from the poses.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result, bail};
use dataset::{FirstContact, IngestReport, IngestSettings, Preset, RecordingSet, ingest};
use nalgebra::Vector2;
use planar::{Shape, mit_object, wrap_angle};
use serde_json::{Map, Value, json};

use super::Section;
use super::row::{Reference, Row};

/// Required of the medians, in m and rad.
const LARGEST_CONTACT_ERROR: f64 = 0.5e-3;
const LARGEST_DIRECTION_ERROR: f64 = 0.3 * std::f64::consts::PI / 180.0;

/// What the name of a file says of its push: a check, never an input.
struct Told {
    contact_b: Vector2<f64>,
    /// From the inward normal to the pusher's velocity, in rad.
    beta: f64,
}

pub(super) fn run(dir: &Path) -> Result<Section> {
    let set = RecordingSet::open_with_preset(dir, Preset::MitPush)?;
    let (_, report) = ingest(&set, &IngestSettings::default())?;
    let mut contact_errors = Vec::new();
    let mut direction_errors = Vec::new();
    for recording in &report.recordings {
        let told = Told::by(&recording.name)?;
        for first in recording.pushes.iter().filter(|push| push.excluded.is_none()) {
            let Some(first) = first.first_contact else {
                bail!("{}: a used push without first contact", recording.name)
            };
            let (contact, direction) = told.errors(&first);
            contact_errors.push(contact);
            direction_errors.push(direction);
        }
    }
    let contact = Errors::of(contact_errors);
    let direction = Errors::of(direction_errors);
    let json = Map::from_iter([("raw_pushes".to_owned(), entry(&report, &contact, &direction))]);
    Ok(Section { json, rows: rows(&report, &contact, &direction) })
}

/// The spread of differences from what the names tell.
struct Errors {
    median: f64,
    max: f64,
}

impl Told {
    /// Reads `shape=…`, `i=…`, `s=…` and `t=…`.
    fn by(name: &str) -> Result<Self> {
        let parts: BTreeMap<&str, &str> =
            name.split('_').filter_map(|part| part.split_once('=')).collect();
        let part = |key: &str| {
            let value = parts.get(key).with_context(|| format!("{name}: no {key}= in the name"))?;
            Ok::<_, anyhow::Error>(*value)
        };
        let number = |key: &str| {
            let value = part(key)?;
            value.parse::<f64>().with_context(|| format!("{name}: {key}={value} is no number"))
        };
        let Shape::Polygon(outline) = mit_object(part("shape")?)?.shape else {
            bail!("{name}: sides are numbered on polygons alone");
        };
        let (side, s) = (number("i")? as usize, number("s")?);
        let edge = outline.edges().nth(side);
        let (from, to) = edge.with_context(|| format!("{name}: no side {side}"))?;
        Ok(Self { contact_b: from * (1.0 - s) + to * s, beta: number("t")? })
    }

    /// Distance of the contact points in m, and angle between the directions in rad.
    fn errors(&self, first: &FirstContact) -> (f64, f64) {
        let contact = (Vector2::from(first.point_b_m) - self.contact_b).norm();
        (contact, wrap_angle(first.beta_rad - self.beta).abs())
    }
}

impl Errors {
    /// Infinite where there are none, so that no bound holds.
    fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let middle = values.len() / 2;
        let median = match values.len() {
            0 => f64::INFINITY,
            n if n % 2 == 1 => values[middle],
            _ => f64::midpoint(values[middle - 1], values[middle]),
        };
        Self { median, max: values.last().copied().unwrap_or(f64::INFINITY) }
    }
}

fn rows(report: &IngestReport, contact: &Errors, direction: &Errors) -> Vec<Row> {
    let summary = &report.summary;
    let excluded: usize = summary.excluded.values().sum();
    let mut rows = vec![
        Row::new("raw pushes: used", summary.pushes_used as f64, Reference::None),
        Row::new(
            "raw pushes: used or excluded with a reason",
            (summary.pushes_used + excluded) as f64,
            Reference::Exactly(report.recordings.len() as f64),
        ),
        Row::new(
            "raw pushes: contact error in mm, median",
            1e3 * contact.median,
            Reference::AtMost(1e3 * LARGEST_CONTACT_ERROR),
        ),
        Row::new("raw pushes: contact error in mm, largest", 1e3 * contact.max, Reference::None),
        Row::new(
            "raw pushes: direction error in deg, median",
            direction.median.to_degrees(),
            Reference::AtMost(LARGEST_DIRECTION_ERROR.to_degrees()),
        ),
        Row::new(
            "raw pushes: direction error in deg, largest",
            direction.max.to_degrees(),
            Reference::None,
        ),
        Row::new("raw pushes: contact lost", summary.contacts_lost as f64, Reference::None),
        Row::new(
            "raw pushes: zero of the force lost",
            summary.force_left_at_rest as f64,
            Reference::None,
        ),
    ];
    for (name, spread, scale) in [
        ("raw pushes: μ·m·g by the preset in N", summary.nominal_force_n, 1.0),
        ("raw pushes: steady force in N, tared", summary.steady_force_n, 1.0),
        ("raw pushes: steady force in N, 0 at rest", summary.steady_force_untared_n, 1.0),
        ("raw pushes: Vicon noise in µm", summary.resting_position_sd_m, 1e6),
        ("raw pushes: Vicon noise in mdeg", summary.resting_angle_sd_rad, 1e3_f64.to_degrees()),
    ] {
        let median = spread.map(|spread| scale * spread.median);
        rows.extend(median.map(|median| Row::new(name, median, Reference::None)));
    }
    rows
}

fn entry(report: &IngestReport, contact: &Errors, direction: &Errors) -> Value {
    let summary = &report.summary;
    let excluded: usize = summary.excluded.values().sum();
    json!({
        "used": summary.pushes_used,
        "excluded": excluded,
        "reasons": summary.excluded,
        "contact_error_m_median": contact.median,
        "contact_error_m_max": contact.max,
        "direction_error_rad_median": direction.median,
        "direction_error_rad_max": direction.max,
        "steps": summary.rows,
        "contacts_lost": summary.contacts_lost,
        "force_zero_found": summary.tared,
        "force_zero_unknown": summary.untared,
        "force_left_at_rest": summary.force_left_at_rest,
        "nominal_force_n": summary.nominal_force_n,
        "steady_force_n": summary.steady_force_n,
        "steady_force_untared_n": summary.steady_force_untared_n,
        "resting_position_sd_m": summary.resting_position_sd_m,
        "resting_angle_sd_rad": summary.resting_angle_sd_rad,
        "repairs": summary.repairs,
    })
}

#[cfg(test)]
mod tests {
    use dataset::FirstContact;

    use super::{Errors, Told};

    #[test]
    fn a_name_tells_contact_and_direction() {
        let told = Told::by("motion_shape=rect1_a=0_v=100_i=1.000_s=0.200_t=-0.349").unwrap();
        // Side 1 goes from (−, +) down to (−, −).
        assert!((told.contact_b - nalgebra::Vector2::new(-0.045, 0.027)).norm() < 1e-12);
        let first = FirstContact {
            edge: 1,
            p: 0.2,
            point_b_m: [-0.045, 0.028],
            beta_rad: -0.359,
            speed_m_s: 0.1,
        };
        let (contact, direction) = told.errors(&first);
        assert!((contact - 1e-3).abs() < 1e-12 && (direction - 0.01).abs() < 1e-12);
        assert!(Told::by("motion_shape=rect1_i=1.000_s=0.2").is_err());
        assert!(Told::by("motion_shape=rect1_i=9_s=0.2_t=0").is_err());
    }

    #[test]
    fn no_values_satisfy_no_bound() {
        let spread = |values: &[f64]| {
            let errors = Errors::of(values.to_vec());
            (errors.median, errors.max)
        };
        assert_eq!(spread(&[]), (f64::INFINITY, f64::INFINITY));
        assert_eq!(spread(&[3.0, 1.0, 2.0]), (2.0, 3.0));
        assert_eq!(spread(&[1.0, 4.0]), (2.5, 4.0));
    }
}
