//! The table's columns: one list with name, unit, meaning and access, for every file format.

use std::{path::Path, sync::Arc};

use nalgebra::Vector2;

use crate::error::DatasetError;
use crate::table::Table;
use crate::table::named_column::Cells;
use crate::table::step::{ContactForce, StepForce, StepRow};

/// One column of the table.
pub struct Column {
    /// Header.
    pub name: &'static str,
    /// Unit; `1` for numbers without one, empty for text.
    pub unit: &'static str,
    /// What it holds.
    pub meaning: &'static str,
    pub(crate) access: Access,
}

impl Column {
    /// The number that a row has in it, in its unit; none for text and where none was measured.
    #[must_use]
    pub fn number(&self, row: &StepRow) -> Option<f64> {
        match self.access {
            Access::Text(..) => None,
            Access::Integer(get, _) => Some(f64::from(get(row))),
            Access::Real(get, _) => Some(get(row)),
            Access::OptionalReal(get, _) => get(row),
        }
    }

    /// The values of some rows.
    #[must_use]
    pub fn cells(&self, rows: &[StepRow]) -> Cells {
        match self.access {
            Access::Text(get, _) => {
                Cells::Text(rows.iter().map(|row| get(row).unwrap_or_default()).collect())
            }
            Access::Integer(get, _) => Cells::Integer(rows.iter().map(get).collect()),
            Access::Real(get, _) => Cells::Real(rows.iter().map(|row| Some(get(row))).collect()),
            Access::OptionalReal(get, _) => Cells::Real(rows.iter().map(get).collect()),
        }
    }
}

impl Table {
    /// The columns that a file of this table has.
    pub fn columns(&self) -> impl Iterator<Item = &'static Column> {
        written_columns(self.rows.first().is_some_and(StepRow::is_whole_push))
    }
}

/// Outlines have fewer edges; more would be counted one by one.
pub(crate) const MOST_EDGES: usize = 10_000;
/// No quantity of a push is larger in its SI unit, a time since 1970 among them.
const LARGEST: f64 = 1e12;
/// A path that nearly stops may be as curved, in 1/m.
const LARGEST_CURVATURE: f64 = 1e24;

impl Column {
    /// Smallest and largest number that a table may have in it, in its unit.
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        // A unit vector's components may be rounded.
        const UNIT: f64 = 1.0 + 1e-6;
        match self.name {
            "p" => (0.0, 1.0),
            "dt_s" => (1e-9, 1e6),
            "edge" => (0.0, (MOST_EDGES - 1) as f64),
            "normal_x" | "normal_y" => (-UNIT, UNIT),
            "path_curvature_1_m" => (-LARGEST_CURVATURE, LARGEST_CURVATURE),
            "speed_m_s"
            | "start_position_sd_m"
            | "start_angle_sd_rad"
            | "end_position_sd_m"
            | "end_angle_sd_rad" => (0.0, LARGEST),
            _ if matches!(self.access, Access::Integer(..)) => (0.0, f64::from(u32::MAX)),
            _ => (-LARGEST, LARGEST),
        }
    }

    /// What the column expects, for messages.
    fn expected(&self) -> String {
        let (low, high) = self.range();
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        let kind = if matches!(self.access, Access::Integer(..)) { "a whole number, " } else { "" };
        let number = |value: f64| match value.abs() {
            size if size == 0.0 || (1e-3..1e6).contains(&size) => value.to_string(),
            _ => format!("{value:e}"),
        };
        format!("{kind}{} to {}{unit}", number(low), number(high))
    }

    /// Puts a number into a row.
    ///
    /// # Errors
    /// What the column expects, with its unit, if it is not that.
    pub(crate) fn set_number(&self, row: &mut StepRow, value: f64) -> Result<(), String> {
        let (low, high) = self.range();
        if !(low..=high).contains(&value) {
            return Err(self.expected());
        }
        match self.access {
            Access::Real(_, set) | Access::OptionalReal(_, set) => set(row, value),
            Access::Integer(_, set) if value.fract() == 0.0 => set(row, value as u32),
            Access::Integer(..) => return Err(self.expected()),
            Access::Text(..) => return Err("text".to_owned()),
        }
        Ok(())
    }

    /// Puts a number as text into a row.
    ///
    /// # Errors
    /// As [`Column::set_number`].
    pub(crate) fn set_text(&self, row: &mut StepRow, text: &str) -> Result<(), String> {
        match self.access {
            Access::Text(_, set) => set(row, text),
            Access::OptionalReal(..) if text.is_empty() => Ok(()),
            // A sign or a fraction that is 0 is no part of a whole number's text.
            Access::Integer(..) => match text.parse::<u32>() {
                Ok(value) => self.set_number(row, value.into()),
                Err(_) => Err(self.expected()),
            },
            Access::Real(..) | Access::OptionalReal(..) => match text.parse::<f64>() {
                Ok(value) => self.set_number(row, value),
                Err(_) => Err(self.expected()),
            },
        }
    }
}

/// Where a table has each of our columns; that of ways may be missing.
///
/// # Errors
/// `ColumnMissing` with those that are there; `ColumnTwice` for one that is there more than once.
pub(crate) fn column_places<'a>(
    path: &Path,
    found: impl Iterator<Item = &'a str> + Clone,
) -> Result<Vec<(&'static Column, usize)>, DatasetError> {
    let has_way = found.clone().any(|name| name == WAY);
    let place =
        |column: &'static Column| Ok((column, column_place(path, column.name, found.clone())?));
    written_columns(has_way).map(place).collect()
}

/// The columns of a file with whole pushes, or without.
pub(crate) fn written_columns(has_way: bool) -> impl Iterator<Item = &'static Column> {
    columns().iter().filter(move |column| has_way || column.name != WAY)
}

/// Where a table has one column.
///
/// # Errors
/// As [`column_places`].
pub(crate) fn column_place<'a>(
    path: &Path,
    name: &str,
    found: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, DatasetError> {
    let mut places = found.clone().enumerate().filter(|(_, other)| *other == name);
    let (path, column) = (path.to_path_buf(), name.to_owned());
    match (places.next(), places.next()) {
        (Some((place, _)), None) => Ok(place),
        (Some((first, _)), Some((second, _))) => {
            Err(DatasetError::ColumnTwice { path, column, places: [first + 1, second + 1] })
        }
        (None, _) => {
            let found = found.collect::<Vec<_>>().join(", ");
            Err(DatasetError::ColumnMissing { path, column, found })
        }
    }
}

/// How a column's values are taken out of a row and put back.
pub(crate) enum Access {
    Text(fn(&StepRow) -> Option<String>, fn(&mut StepRow, &str) -> Result<(), String>),
    Integer(fn(&StepRow) -> u32, fn(&mut StepRow, u32)),
    Real(fn(&StepRow) -> f64, fn(&mut StepRow, f64)),
    /// A number that may be missing in a row.
    OptionalReal(fn(&StepRow) -> Option<f64>, fn(&mut StepRow, f64)),
}

/// The column of pushers' ways, which tables of whole pushes have alone.
const WAY: &str = "pusher_way";

/// Every column, in the order in which files have them; `pusher_way` is in tables of whole pushes alone.
#[must_use]
pub fn columns() -> &'static [Column] {
    &COLUMNS
}

macro_rules! real {
    ($name:literal, $unit:literal, $meaning:literal, $($field:ident).+) => {
        Column {
            name: $name,
            unit: $unit,
            meaning: $meaning,
            access: Access::Real(|row| row.$($field).+, |row, value| row.$($field).+ = value),
        }
    };
}

macro_rules! integer {
    ($name:literal, $meaning:literal, $field:ident) => {
        Column {
            name: $name,
            unit: "1",
            meaning: $meaning,
            access: Access::Integer(|row| row.$field, |row, value| row.$field = value),
        }
    };
}

macro_rules! text {
    ($name:literal, $meaning:literal, $get:expr, $set:expr) => {
        Column { name: $name, unit: "", meaning: $meaning, access: Access::Text($get, $set) }
    };
}

macro_rules! force {
    ($name:literal, $meaning:literal, $moment:ident, $direction:ident) => {
        Column {
            name: $name,
            unit: "N",
            meaning: $meaning,
            access: Access::OptionalReal(
                |row| row.force.map(|force| force.$moment.$direction),
                |row, value| {
                    row.force.get_or_insert(NO_FORCE).$moment.$direction = value;
                },
            ),
        }
    };
}

const NONE: ContactForce = ContactForce { normal: 0.0, tangential: 0.0 };
const NO_FORCE: StepForce = StepForce { mean: NONE, start: NONE, end: NONE };

static COLUMNS: [Column; 51] = [
    text!(
        "recording",
        "name of the recording",
        |row| Some(row.recording.to_string()),
        |row, text| {
            row.recording = Arc::from(text);
            Ok(())
        }
    ),
    text!(
        "session",
        "measuring session, empty if unknown",
        |row| row.session.as_deref().map(String::from),
        |row, text| {
            row.session = if text.is_empty() { None } else { Some(Arc::from(text)) };
            Ok(())
        }
    ),
    integer!("push", "number of the push within the recording, from 0", push),
    integer!("step", "number of the step within the push, from 0", step),
    text!("phase", "contact or after", |row| Some(row.phase.to_string()), |row, text| {
        row.phase = text.parse()?;
        Ok(())
    }),
    real!("t_s", "s", "start of the step on the log's clock", t),
    real!("dt_s", "s", "length of the step", dt),
    integer!("n_samples", "object samples within the step", n_samples),
    text!("shape", "name of the object's shape", |row| Some(row.shape.to_string()), |row, text| {
        row.shape = Arc::from(text);
        Ok(())
    }),
    integer!("edge", "edge touched at the start, vertex i to i + 1, from 0", edge),
    real!("p", "1", "position along the edge, 0 to 1", p),
    real!("beta_rad", "rad", "from the edge's inward normal to the pusher's velocity", beta),
    real!("speed_m_s", "m/s", "magnitude of the pusher's mean velocity", speed),
    real!("object_x_m", "m", "object at the start, world", object_pose.position.x),
    real!("object_y_m", "m", "object at the start, world", object_pose.position.y),
    real!("object_theta_rad", "rad", "object at the start, world", object_pose.angle),
    real!("object_vx_m_s", "m/s", "object's velocity at the start, world", object_twist.linear.x),
    real!("object_vy_m_s", "m/s", "object's velocity at the start, world", object_twist.linear.y),
    real!("object_omega_rad_s", "rad/s", "object's yaw rate at the start", object_twist.angular),
    real!("pusher_x0_m", "m", "pusher at the start, world", pusher_start.x),
    real!("pusher_y0_m", "m", "pusher at the start, world", pusher_start.y),
    real!("pusher_x1_m", "m", "pusher at the end, world", pusher_end.x),
    real!("pusher_y1_m", "m", "pusher at the end, world", pusher_end.y),
    real!("pusher_vx_m_s", "m/s", "pusher's mean velocity, world", pusher_velocity.x),
    real!("pusher_vy_m_s", "m/s", "pusher's mean velocity, world", pusher_velocity.y),
    real!("pusher_ax_m_s2", "m/s²", "pusher's mean acceleration, world", pusher_acceleration.x),
    real!("pusher_ay_m_s2", "m/s²", "pusher's mean acceleration, world", pusher_acceleration.y),
    real!("path_curvature_1_m", "1/m", "curvature of the pusher's path, left +", path_curvature),
    real!("contact_x_m", "m", "contact point at the start, world", contact_point.x),
    real!("contact_y_m", "m", "contact point at the start, world", contact_point.y),
    real!("normal_x", "1", "contact normal into the object at the start, world", contact_normal.x),
    real!("normal_y", "1", "contact normal into the object at the start, world", contact_normal.y),
    real!("dx_m", "m", "displacement along the pusher's mean velocity", dx),
    real!("dy_m", "m", "displacement along the left normal of that velocity", dy),
    real!("dtheta_rad", "rad", "turn of the object", dtheta),
    force!("force_normal_n", "mean force on the object, inward", mean, normal),
    force!("force_tangential_n", "mean force on the object, inward turned +90°", mean, tangential),
    force!("force_normal_start_n", "the same at the start", start, normal),
    force!("force_tangential_start_n", "the same at the start", start, tangential),
    force!("force_normal_end_n", "the same at the end", end, normal),
    force!("force_tangential_end_n", "the same at the end", end, tangential),
    real!("gap_start_m", "m", "pusher's surface to the outline at the start", gap_start),
    real!("gap_end_m", "m", "pusher's surface to the outline at the end", gap_end),
    real!("slip_m", "m", "way of the contact point along the outline, larger p +", slip),
    real!("since_contact_s", "s", "time since the first contact", since_contact),
    real!("start_position_sd_m", "m", "sd of the start position, per axis", start_position_sd),
    real!("start_angle_sd_rad", "rad", "sd of the start yaw", start_angle_sd),
    real!("end_position_sd_m", "m", "sd of the end position, per axis", end_position_sd),
    real!("end_angle_sd_rad", "rad", "sd of the end yaw", end_angle_sd),
    text!("flags", "names joined by |", |row| Some(row.flags.to_string()), |row, text| {
        row.flags = text.parse()?;
        Ok(())
    }),
    text!(
        "pusher_way",
        "in whole pushes, where a straight way at constant speed is not enough: `t x y` of the \
         pusher between start and end, s from the start and m, world, joined by `;`",
        |row| Some(way_text(&row.pusher_way)),
        |row, text| {
            row.pusher_way = way(text).ok_or("`t x y` joined by `;`, in s and m, t increasing")?;
            Ok(())
        }
    ),
];

fn way_text(way: &[(f64, Vector2<f64>)]) -> String {
    let points = way.iter().map(|(t, point)| format!("{t} {} {}", point.x, point.y));
    points.collect::<Vec<_>>().join(";")
}

/// The points of a text; none if it is not of finite numbers, with times that increase from 0.
fn way(text: &str) -> Option<Vec<(f64, Vector2<f64>)>> {
    let point = |text: &str| {
        let numbers: Option<Vec<f64>> = text.split(' ').map(|word| word.parse().ok()).collect();
        let [t, x, y] = numbers?[..] else { return None };
        (t + x + y).is_finite().then(|| (t, Vector2::new(x, y)))
    };
    let points = text.split(';').filter(|point| !point.is_empty()).map(point);
    let points: Vec<_> = points.collect::<Option<_>>()?;
    let times = std::iter::once(0.0).chain(points.iter().map(|(t, _)| *t));
    times.is_sorted_by(|earlier, later| earlier < later).then_some(points)
}
