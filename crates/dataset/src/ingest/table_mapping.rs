//! Step tables of others, read through a mapping of their columns to ours.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use nalgebra::Vector2;
use planar::{Pose, perpendicular};
use serde::Deserialize;
use serde_spanned::Spanned;

use crate::error::DatasetError;
use crate::ingest::TOOL;
use crate::input::limits::{Limit, ReadLimits};
use crate::input::map::{FileBytes, read_text};
use crate::manifest::object::{ObjectChoice, ObjectSpec, ObjectTable};
use crate::manifest::object_support::ObjectSupport;
use crate::manifest::preset::Preset;
use crate::manifest::text::Source;
use crate::manifest::{PusherSpec, PusherTable, SupportSpec, SupportTable};
use crate::recording::settings::ColumnMap;
use crate::table::column::{Access, Column, column_place, columns};
use crate::table::step::StepRow;
use crate::table::{Provenance, Table};

const SCHEMA: &str = "pushlab.table-mapping/1";
/// What a row cannot do without.
const NEEDED: [&str; 8] =
    ["edge", "p", "beta_rad", "dt_s", "speed_m_s", "dx_m", "dy_m", "dtheta_rad"];

/// How the columns of a foreign table become ours.
///
/// In TOML: `schema`, `name`, `[object]`, `[pusher]`, `[support]` as in a manifest, `[constants]`
/// for columns that are the same in every row, and `[columns]` with
/// `ours = { column = "theirs", scale = 1.0, offset = 0.0 }`.
#[derive(Clone)]
pub struct TableMapping {
    /// Title of the table.
    pub name: String,
    /// The pushed object.
    pub object: ObjectSpec,
    /// What it rests on.
    pub object_support: ObjectSupport,
    /// The pusher.
    pub pusher: PusherSpec,
    /// The table that it is pushed on.
    pub support: SupportSpec,
    constants: Vec<(&'static Column, f64)>,
    columns: Vec<(&'static Column, ColumnMap)>,
}

impl TableMapping {
    /// Reads and checks a mapping.
    ///
    /// # Errors
    /// `Io`, `NotAFile`, `OverLimit`, `Parse` and `Manifest` as for a manifest.
    pub fn read(path: &Path) -> Result<Self, DatasetError> {
        let text = read_text(path)?;
        Self::parse(&text, path)
    }

    /// The mapping of the MIT square's step table.
    ///
    /// # Errors
    /// None for the text that is built in, which a test reads.
    pub fn mit_table() -> Result<Self, DatasetError> {
        Self::parse(Preset::MitTable.text(), Path::new("preset mit-table"))
    }

    /// Checks the text of a mapping; `path` is for messages alone.
    ///
    /// # Errors
    /// `Parse` and `Manifest` as for a manifest.
    pub fn parse(text: &str, path: &Path) -> Result<Self, DatasetError> {
        let source = Source::new(text, path);
        let table: MappingTable = source.parse_filled()?;
        if table.schema.get_ref() != SCHEMA {
            let (span, value) = (table.schema.span(), table.schema.get_ref());
            return Err(source.refuse(span, "schema", value, "", SCHEMA));
        }
        let chosen = table.object.check(&source)?;
        let object_support = ObjectSupport::of(&table.object, &chosen, &source)?;
        let ObjectChoice::Fixed(object) = chosen else {
            let what = "a table has one shape; name it in [object]".to_owned();
            return Err(DatasetError::Parse { path: path.into(), line: 1, what });
        };
        let own = |name: &str| {
            columns().iter().find(|column| column.name == name && column.is_number()).ok_or_else(
                || DatasetError::ColumnMissing {
                    path: path.into(),
                    column: name.to_owned(),
                    found: numbers(),
                },
            )
        };
        let mapping = Self {
            name: table.name,
            object: *object,
            object_support,
            pusher: table.pusher.check(&source)?,
            support: table.support.check(&source)?,
            constants: table
                .constants
                .iter()
                .map(|(name, value)| Ok((own(name)?, *value)))
                .collect::<Result<_, DatasetError>>()?,
            columns: table
                .columns
                .into_iter()
                .map(|(name, map)| Ok((own(&name)?, map)))
                .collect::<Result<_, DatasetError>>()?,
        };
        match NEEDED.into_iter().find(|name| !mapping.gives(name)) {
            Some(missing) => Err(DatasetError::ColumnMissing {
                path: path.into(),
                column: missing.to_owned(),
                found: "the keys of [constants] and [columns]".to_owned(),
            }),
            None => Ok(mapping),
        }
    }

    /// Whether it gives a number of our table, by the column's name.
    #[must_use]
    pub fn gives(&self, column: &str) -> bool {
        let constants = self.constants.iter().map(|(known, _)| known.name);
        constants.chain(self.columns.iter().map(|(known, _)| known.name)).any(|name| name == column)
    }

    /// Reads a foreign CSV table into ours.
    ///
    /// What the columns leave open follows from them: the pusher moves straight at constant speed
    /// from its contact, and the object starts at the world's origin unless its pose is given.
    ///
    /// # Errors
    /// `Io`, `ColumnMissing`, `Parse` with the line for a value that is no finite number or out of
    /// range, `TableTooShort` for fewer than two rows.
    pub fn read_table(&self, path: &Path) -> Result<Table, DatasetError> {
        let limits = ReadLimits::default();
        let file = FileBytes::open(path, &limits)?;
        let bytes = file.bytes();
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
        let reading = Reading { mapping: self, path: path.into() };
        let header = reader.headers().map_err(|error| reading.fail(1, error))?.clone();
        let n_columns = header.len() as u64;
        limits.check(path, Limit::Columns, || "columns of the table".into(), n_columns)?;
        let places = reading.places(&header)?;
        let mut rows = Vec::new();
        let mut names = StepRow {
            recording: Arc::from(self.name.as_str()),
            shape: Arc::from(self.object.name.as_str()),
            ..StepRow::default()
        };
        for record in reader.records() {
            let line = |position: Option<&csv::Position>| position.map_or(0, csv::Position::line);
            let record = record.map_err(|error| reading.fail(line(error.position()), &error))?;
            let n_rows = rows.len() as u64 + 1;
            limits.check(path, Limit::Samples, || "rows of the table".into(), n_rows)?;
            names.push = rows.len() as u32;
            rows.push(reading.row(&record, line(record.position()), &places, names.clone())?);
        }
        if rows.len() < 2 {
            return Err(DatasetError::TableTooShort { path: path.into(), rows: rows.len() });
        }
        let mut provenance = Provenance::default();
        provenance.push("tool", TOOL);
        provenance.push("set", &self.name);
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        provenance.push("source", &format!("sha256 {} {name}", file.sha256()));
        Ok(Table { rows, provenance })
    }
}

/// One pass over a foreign table.
struct Reading<'a> {
    mapping: &'a TableMapping,
    path: PathBuf,
}

impl Reading<'_> {
    fn fail(&self, line: u64, error: impl ToString) -> DatasetError {
        DatasetError::Parse { path: self.path.clone(), line, what: error.to_string() }
    }

    fn places(&self, header: &csv::StringRecord) -> Result<Vec<usize>, DatasetError> {
        let place =
            |(_, map): &(&Column, ColumnMap)| column_place(&self.path, &map.column, header.iter());
        self.mapping.columns.iter().map(place).collect()
    }

    fn row(
        &self,
        record: &csv::StringRecord,
        line: u64,
        places: &[usize],
        mut row: StepRow,
    ) -> Result<StepRow, DatasetError> {
        let mut set = |column: &Column, value: f64| {
            column.set_number(&mut row, value).map_err(|expected| {
                self.fail(line, format!("{} is {value}, expected {expected}", column.name))
            })
        };
        for (column, value) in &self.mapping.constants {
            set(column, *value)?;
        }
        for ((column, map), &place) in self.mapping.columns.iter().zip(places) {
            let text = record.get(place).unwrap_or_default();
            let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
            let number = number.ok_or_else(|| {
                self.fail(line, format!("{} is `{text}`, expected a finite number", map.column))
            })?;
            set(column, map.scale * number + map.offset)?;
        }
        let n_edges = self.mapping.object.shape.n_edges();
        if row.edge as usize >= n_edges {
            let what = format!("edge is {}, expected 0 to {}", row.edge, n_edges - 1);
            return Err(self.fail(line, what));
        }
        if row.speed <= 0.0 {
            let what = format!("speed_m_s is {}, expected above 0 m/s", row.speed);
            return Err(self.fail(line, what));
        }
        self.complete(&mut row);
        Ok(row)
    }

    /// Fills in the motion of pusher and object that edge, p, β, speed and time imply.
    fn complete(&self, row: &mut StepRow) {
        let shape = &self.mapping.object.shape;
        let (edge, pose) = (row.edge as usize, row.object_pose);
        let normal = pose.rotate(&shape.inward_normal_at(edge, row.p));
        let contact = pose.transform_point(&shape.point_at(edge, row.p));
        let along = Pose::new(0.0, 0.0, row.beta).rotate(&normal);
        row.contact_point = contact;
        row.contact_normal = normal;
        row.pusher_velocity = row.speed * along;
        row.pusher_start = contact - self.mapping.pusher.radius * normal;
        row.pusher_end = row.pusher_start + row.dt * row.pusher_velocity;
        let moved: Vector2<f64> = row.dx * along + row.dy * perpendicular(&along);
        let end = Pose::new(
            pose.position.x + moved.x,
            pose.position.y + moved.y,
            pose.angle + row.dtheta,
        );
        let pusher_b = end.inverse_transform_point(&row.pusher_end);
        row.gap_end = shape.contact(&pusher_b, self.mapping.pusher.radius).gap;
    }
}

impl Column {
    fn is_number(&self) -> bool {
        !matches!(self.access, Access::Text(..))
    }
}

fn numbers() -> String {
    let names = columns().iter().filter(|column| column.is_number()).map(|column| column.name);
    names.collect::<Vec<_>>().join(", ")
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MappingTable {
    schema: Spanned<String>,
    name: String,
    object: ObjectTable,
    pusher: PusherTable,
    support: SupportTable,
    #[serde(default)]
    constants: BTreeMap<String, f64>,
    columns: BTreeMap<String, ColumnMap>,
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use planar::cross;

    use super::TableMapping;
    use crate::table::Table;

    const HEADER: &str = "c,phi_rad,dx_c_m,dy_c_m_sign_flipped,dtheta_rad\n";

    fn read(rows: &str) -> Result<Table, String> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("table.csv");
        std::fs::write(&path, rows).unwrap();
        let table = TableMapping::mit_table().unwrap().read_table(&path);
        table.map_err(|e| e.to_string().replace(dir.path().to_str().unwrap(), "SET"))
    }

    /// A push near the face's upper end, straight in: its force turns the object clockwise.
    /// A push through the middle towards +y: the object lags behind to the pusher's right.
    #[test]
    fn the_mit_table_turns_and_shifts_the_right_way() {
        let text = format!("{HEADER}0.2,0.0,0.003,0.0,-0.03\n0.5,0.5,0.003,0.001,0.0\n");
        let table = read(&text).unwrap();
        let [high, oblique] = &table.rows[..] else { panic!("two rows") };
        assert_eq!((high.edge, high.p, high.dt, high.speed), (1, 0.2, 0.2, 0.02));
        assert!((high.contact_point.x + 0.045).abs() < 1e-15);
        assert!((high.contact_point.y - 0.09 * 0.3).abs() < 1e-15);
        assert!((high.contact_normal.x - 1.0).abs() < 1e-15);
        assert!(cross(&high.contact_point, &high.contact_normal) * high.dtheta > 0.0);
        assert!((oblique.pusher_velocity.y - 0.02 * 0.5f64.sin()).abs() < 1e-15);
        assert_eq!(oblique.dy, -0.001);
    }

    /// The pose that a row reports must leave the pusher on the outline, which only the right
    /// reading of face, frame and signs does: a pure turn about the contact point shows it.
    #[test]
    fn a_turn_about_the_contact_keeps_the_pusher_at_the_outline() {
        let (c, turn) = (0.3, 0.02f64);
        let (x, y) = (-0.045, 0.09 * (0.5 - c));
        let way = 0.2 * 0.02;
        let radius = 0.00475;
        // The contact normal turns by `turn` while the pusher moves by `way` along +x.
        let dx = way + radius * (turn.cos() - 1.0) + x - (turn.cos() * x - turn.sin() * y);
        let dy = radius * turn.sin() + y - (turn.sin() * x + turn.cos() * y);
        let row = format!("{c},0.0,{dx},{},{turn}\n", -dy);
        let table = read(&format!("{HEADER}{row}{row}")).unwrap();
        assert!(table.rows[0].gap_end.abs() < 1e-12, "{}", table.rows[0].gap_end);
    }

    #[test]
    fn bad_tables_are_named() {
        let good = "0.2,0.0,0.003,0.0,-0.03\n";
        assert_eq!(
            read(&HEADER.replace("dtheta_rad", "dtheta_deg")).unwrap_err(),
            "SET/table.csv: no column `dtheta_rad`; the table has: c, phi_rad, dx_c_m, \
             dy_c_m_sign_flipped, dtheta_deg"
        );
        assert_eq!(
            read(&format!("{HEADER}{good}0.2,inf,0.003,0.0,-0.03\n")).unwrap_err(),
            "SET/table.csv:3: phi_rad is `inf`, expected a finite number"
        );
        assert_eq!(
            read(&format!("{HEADER}1.2,0.0,0.003,0.0,-0.03\n{good}")).unwrap_err(),
            "SET/table.csv:2: p is 1.2, expected 0 to 1"
        );
        assert!(read(&format!("{HEADER}{good}")).unwrap_err().contains("has 1 row(s)"));
    }

    #[test]
    fn bad_mappings_are_named() {
        let error = |from: &str, to: &str| {
            let text = crate::manifest::preset::Preset::MitTable.text();
            assert!(text.contains(from));
            let error = TableMapping::parse(&text.replacen(from, to, 1), Path::new("map.toml"));
            error.err().unwrap().to_string()
        };
        assert!(error("mapping/1", "mapping/9").starts_with("map.toml:5: schema = pushlab.table"));
        assert!(error("beta_rad =", "beta =").starts_with("map.toml: no column `beta`; the table"));
        assert!(error("edge = 1\n", "").contains("no column `edge`"));
        assert!(error("\"rect1\"", "\"rect9\"").contains("object.shape = rect9 is not allowed"));
    }
}
