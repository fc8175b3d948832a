//! What the figures are drawn from: the fixtures, or data of the user's.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use anyhow::{Context, Result, anyhow, ensure};
use dataset::{
    DatasetError, IngestReport, IngestSettings, ObjectChoice, ObjectSpec, Preset, PusherSpec,
    Recording, RecordingSet, StepLength, SupportSpec, Table, TableMapping, ingest,
};
use diagnosis::{Observations, steady_ingest};
use models::{RecordedPush, StepSelection};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

use super::lacking::Lacking;
use super::missing::{Study, hidden_effects};
use super::motion::{Scene, Setting};
pub(crate) use super::seed::SEED;
use fixtures::workspace_root;

/// The recording set for a first look.
const FIXTURES: &str = "fixtures/pushes";

/// Fewer pushes cannot be split.
const FEWEST_PUSHES: usize = 16;
/// Pushes with fewer steps have no way to go.
const FEWEST_STEPS: usize = 3;

/// The pusher's way in a step, in m: 0.2 s at 20 mm/s. Steps of one length can be compared at all
/// speeds at which a push is quasi-static.
pub(crate) const STEP_WAY: f64 = 0.004;

/// One set of data, shared by all figures; what takes time is done once, when first asked for.
pub(crate) struct Inputs {
    name: String,
    source: Source,
    quick: bool,
    /// The same pushes at other speeds, each as it would be for itself.
    faster: Vec<Inputs>,
    is_users: bool,
    ingested: Once<(Table, IngestReport)>,
    study: Once<Study>,
    scene: Once<Scene>,
}

/// What takes time: made when first asked for.
struct Once<T>(OnceLock<Result<T>>);

enum Source {
    Recordings(Box<RecordingSet>),
    Table { table: Table, mapping: Option<Box<TableMapping>> },
}

impl Inputs {
    /// Opens the 60 pushes of the fixtures.
    ///
    /// # Errors
    /// Fixtures that cannot be read.
    pub(crate) fn fixtures(quick: bool) -> Result<Self> {
        Ok(Self { is_users: false, ..Self::open(&workspace_root().join(FIXTURES), quick)? })
    }

    /// Opens recording sets of the same pushes, one for each speed, the slowest first.
    ///
    /// # Errors
    /// No set at all, or one that cannot be read.
    pub(crate) fn at_speeds(sets: &[PathBuf]) -> Result<Self> {
        let mut speeds =
            sets.iter().map(|set| Self::open(set, false)).collect::<Result<Vec<_>>>()?;
        ensure!(!speeds.is_empty(), "no recording set at any speed");
        let slowest = speeds.remove(0);
        Ok(Self { faster: speeds, is_users: false, ..slowest })
    }

    /// Opens a recording set, or a table of steps (a file, or a folder with one).
    ///
    /// # Errors
    /// A path that is neither, or a table that cannot be read.
    pub(crate) fn open(path: &Path, quick: bool) -> Result<Self> {
        let (name, source) = open_source(path)?;
        let (ingested, study, scene) = (Once::new(), Once::new(), Once::new());
        Ok(Self { name, source, quick, faster: Vec::new(), is_users: true, ingested, study, scene })
    }

    /// Whether the user has named the data.
    pub(crate) fn is_users(&self) -> bool {
        self.is_users
    }

    /// The diagnosis of the user's data, or of a simulated set that hides effects.
    ///
    /// # Errors
    /// [`Lacking`] if no effect is named there; what the diagnosis says.
    pub(crate) fn study(&self) -> Result<&Study> {
        self.study.get(|| {
            let study = if self.is_users() {
                Study::of(self.steady_observations()?, self.pusher()?.friction)
            } else {
                let set = Self::open(&hidden_effects(self.quick())?, self.quick())?;
                Study::of(set.steady_observations()?, set.pusher()?.friction)
            };
            study?.ok_or_else(|| self.lacking("effects that a diagnosis names"))
        })
    }

    /// One turn of the pushes with the models that are trained on it.
    ///
    /// # Errors
    /// As [`Inputs::whole_pushes`], and what a fit says.
    pub(crate) fn scene(&self) -> Result<&Scene> {
        self.scene.get(|| Scene::of(&self.whole_pushes()?, &self.setting()?))
    }

    /// What training needs to be told.
    ///
    /// # Errors
    /// As [`Inputs::pusher`] and [`Inputs::support`].
    pub(crate) fn setting(&self) -> Result<Setting> {
        let (friction, support) = (self.pusher()?.friction, self.support()?);
        Ok(Setting { friction, support, quick: self.quick })
    }

    /// The same pushes at higher speeds, in their order; none for data of one speed.
    pub(crate) fn faster(&self) -> &[Self] {
        &self.faster
    }

    /// Title of the data.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Whether fewer repetitions than a careful figure needs will do.
    pub(crate) fn quick(&self) -> bool {
        self.quick
    }

    /// The recordings.
    ///
    /// # Errors
    /// [`Lacking`] if the data are a table of steps.
    pub(crate) fn recordings(&self) -> Result<&RecordingSet> {
        match &self.source {
            Source::Recordings(set) => Ok(set),
            Source::Table { .. } => Err(self.lacking("recordings")),
        }
    }

    /// Reads one recording, by its name in the table.
    ///
    /// # Errors
    /// [`Lacking`] if the data are a table of steps; a recording that cannot be read.
    pub(crate) fn recording(&self, name: &str) -> Result<Recording> {
        let set = self.recordings()?;
        let report = self.ingest_report()?;
        let found = report.recordings.iter().find(|recording| recording.name == name);
        let path = &found.with_context(|| format!("there is no recording {name}"))?.path;
        Ok(set.read(path)?)
    }

    /// The steps, [`STEP_WAY`] each where they are made from recordings.
    ///
    /// # Errors
    /// What the ingest says.
    pub(crate) fn table(&self) -> Result<&Table> {
        match &self.source {
            Source::Recordings(set) => Ok(&self.ingested(set)?.0),
            Source::Table { table, .. } => Ok(table),
        }
    }

    /// What became of every recording and push.
    ///
    /// # Errors
    /// [`Lacking`] if the data are a table of steps; what the ingest says.
    pub(crate) fn ingest_report(&self) -> Result<&IngestReport> {
        Ok(&self.ingested(self.recordings()?)?.1)
    }

    /// The steps with what a comparison asks of them.
    ///
    /// # Errors
    /// [`Lacking`] for a table that does not tell what was pushed, or too few pushes.
    pub(crate) fn observations(&self) -> Result<Observations> {
        Ok(match &self.source {
            Source::Recordings(set) => Observations::of(self.table()?, set.manifest())?,
            Source::Table { mapping: Some(mapping), table } => {
                Observations::of_mapped(table, mapping)?
            }
            Source::Table { mapping: None, .. } => {
                return Err(self.lacking("what was pushed"));
            }
        })
    }

    /// The pushes of the first object, in a random order.
    ///
    /// # Errors
    /// [`Lacking`] for a table of single steps, or too few pushes.
    pub(crate) fn whole_pushes(&self) -> Result<Vec<RecordedPush>> {
        let (table, pusher) = (self.table()?, self.pusher()?);
        let too_few = || self.lacking("16 whole pushes of one object");
        let first = table.rows.first().ok_or_else(too_few)?;
        let objects = ObjectChoice::Fixed(Box::new(self.object(&first.recording)?));
        let rows = table.rows.iter().filter(|row| row.shape == first.shape).cloned().collect();
        let table = Table { rows, provenance: table.provenance.clone() };
        let mut pushes = StepSelection::default().pushes(&table, &objects, pusher.radius)?;
        pushes.retain(|push| push.steps.len() >= FEWEST_STEPS);
        if pushes.len() < FEWEST_PUSHES {
            return Err(too_few());
        }
        pushes.shuffle(&mut ChaCha8Rng::seed_from_u64(SEED));
        Ok(pushes)
    }

    /// The steps for a diagnosis: of recordings those whose noise is known.
    ///
    /// # Errors
    /// As [`Inputs::observations`].
    pub(crate) fn steady_observations(&self) -> Result<Observations> {
        let Source::Recordings(set) = &self.source else { return self.observations() };
        Ok(Observations::steady(&ingest(set, &steady_ingest())?.0, set.manifest())?)
    }

    /// The object of a recording.
    ///
    /// # Errors
    /// An unknown shape.
    pub(crate) fn object(&self, recording: &str) -> Result<ObjectSpec> {
        match &self.source {
            Source::Recordings(set) => Ok(set.manifest().object.of(recording)?),
            Source::Table { mapping: Some(mapping), .. } => Ok(mapping.object.clone()),
            Source::Table { mapping: None, table } => {
                let row = table.rows.iter().find(|row| *row.recording == *recording);
                Ok(ObjectSpec::mit(row.map_or("", |row| &row.shape))?)
            }
        }
    }

    /// The pusher.
    ///
    /// # Errors
    /// [`Lacking`] for a table that does not tell.
    pub(crate) fn pusher(&self) -> Result<PusherSpec> {
        match &self.source {
            Source::Recordings(set) => Ok(set.manifest().pusher),
            Source::Table { mapping: Some(mapping), .. } => Ok(mapping.pusher),
            Source::Table { mapping: None, .. } => Err(self.lacking("the pusher's size")),
        }
    }

    /// The table that the object is pushed on.
    ///
    /// # Errors
    /// [`Lacking`] for a table that does not tell.
    pub(crate) fn support(&self) -> Result<SupportSpec> {
        match &self.source {
            Source::Recordings(set) => Ok(set.manifest().support),
            Source::Table { mapping: Some(mapping), .. } => Ok(mapping.support),
            Source::Table { mapping: None, .. } => Err(self.lacking("the support's friction")),
        }
    }

    /// Name and SHA-256 of what was read so far: of one file, or of the list of many.
    pub(crate) fn sources(&self) -> Vec<(String, String)> {
        let faster = self.faster.iter().flat_map(Self::sources);
        self.own_sources().into_iter().chain(faster).collect()
    }

    fn own_sources(&self) -> Vec<(String, String)> {
        let table = match &self.source {
            Source::Recordings(_) => match self.ingested.0.get() {
                Some(Ok((table, _))) => table,
                _ => return Vec::new(),
            },
            Source::Table { table, .. } => table,
        };
        let entries = &table.provenance.entries;
        let sources = entries.iter().filter(|(key, _)| key == "source");
        // `sha256 <hash> <path>`, as the provenance of a table has it.
        let files: Vec<_> = sources.filter_map(|(_, text)| text.split(' ').nth(1)).collect();
        let n = files.len();
        match files[..] {
            [] => Vec::new(),
            [hash] => vec![(self.name.clone(), hash.to_owned())],
            _ => {
                let what = format!("{}: the list of the hashes of {n} recordings", self.name);
                let list = files.join("\n") + "\n";
                vec![(what, format!("{:x}", Sha256::digest(list)))]
            }
        }
    }

    /// The error for data that lack something.
    pub(crate) fn lacking(&self, needs: &'static str) -> anyhow::Error {
        let has = match self.source {
            Source::Recordings(_) => format!("the recordings of {}", self.name),
            Source::Table { .. } => format!("{}, a table of steps", self.name),
        };
        Lacking { needs, has }.into()
    }

    fn ingested(&self, set: &RecordingSet) -> Result<&(Table, IngestReport)> {
        let step = StepLength::Distance(STEP_WAY);
        let settings = IngestSettings { step, ..IngestSettings::default() };
        self.ingested.get(|| Ok(ingest(set, &settings)?))
    }
}

impl<T: Send + Sync> Once<T> {
    fn new() -> Self {
        Self(OnceLock::new())
    }

    fn get(&self, make: impl FnOnce() -> Result<T> + Send) -> Result<&T> {
        // On a thread of its own: while it waits for others, a thread of the figures' pool would take up
        // the next figure, which would wait here for this very result.
        let made = self.0.get_or_init(|| {
            std::thread::scope(|scope| scope.spawn(make).join())
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        made.as_ref().map_err(|error| match error.downcast_ref::<Lacking>() {
            Some(lacking) => lacking.clone().into(),
            None => anyhow!("{error:#}"),
        })
    }
}

fn open_source(path: &Path) -> Result<(String, Source)> {
    if is_table(path) {
        return open_table(path);
    }
    match RecordingSet::open(path) {
        Ok(set) => Ok((set.manifest().name.clone(), Source::Recordings(Box::new(set)))),
        Err(error @ DatasetError::NoManifest { .. }) => match &tables_in(path)?[..] {
            [table] => open_table(table),
            // The raw pushes as they are published.
            [] if has_json(path) => {
                let set = RecordingSet::open_with_preset(path, Preset::MitPush)?;
                Ok((set.manifest().name.clone(), Source::Recordings(Box::new(set))))
            }
            _ => Err(error.into()),
        },
        Err(error) => Err(error.into()),
    }
}

/// A table in this project's columns, or in those of the MIT square's table.
fn open_table(path: &Path) -> Result<(String, Source)> {
    match Table::read(path) {
        Ok(table) => {
            let name = table.provenance.get("set").unwrap_or("table of steps").to_owned();
            Ok((name, Source::Table { table, mapping: None }))
        }
        Err(own @ DatasetError::ColumnMissing { .. }) => {
            let mapping = TableMapping::mit_table()?;
            let table = match mapping.read_table(path) {
                Ok(table) => table,
                Err(DatasetError::ColumnMissing { .. }) => return Err(own.into()),
                Err(error) => return Err(error.into()),
            };
            let mapping = Some(Box::new(mapping));
            let name = mapping.as_ref().map_or("", |mapping| &mapping.name).to_owned();
            Ok((name, Source::Table { table, mapping }))
        }
        Err(error) => Err(error.into()),
    }
}

fn is_table(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    path.is_file() && matches!(extension, Some("csv" | "parquet"))
}

fn has_json(folder: &Path) -> bool {
    let is_json = |path: &Path| path.extension().is_some_and(|extension| extension == "json");
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).any(|path| is_json(&path))
}

fn tables_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut tables = Vec::new();
    let entries = std::fs::read_dir(folder);
    for entry in entries.with_context(|| format!("cannot read {}", folder.display()))? {
        tables.push(entry?.path());
    }
    tables.retain(|path| is_table(path));
    tables.sort();
    Ok(tables)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::{Inputs, Lacking};

    const MIT_TABLE: &str = "c,phi_rad,dx_c_m,dy_c_m_sign_flipped,dtheta_rad\n\
                             0.2,0.0,0.003,0.0,-0.03\n0.5,0.5,0.003,0.001,0.0\n";

    #[test]
    fn the_fixtures_give_recordings_and_a_table() {
        let inputs = Inputs::fixtures(false).unwrap();
        assert!(inputs.sources().is_empty(), "nothing is read before it is asked for");
        let rows = &inputs.table().unwrap().rows;
        let name = &rows[0].recording;
        assert!(rows.len() > 500 && inputs.recording(name).unwrap().wrench.is_some());
        assert!(std::ptr::eq(&inputs.table().unwrap().rows[0], &rows[0]), "ingested once");
        assert!((inputs.object(name).unwrap().mass - 0.8374).abs() < 1e-12);
        let sources = inputs.sources();
        assert_eq!((sources.len(), sources[0].1.len()), (1, 64));
        assert!(sources[0].0.ends_with("60 recordings"), "{}", sources[0].0);
    }

    #[test]
    fn a_table_is_found_in_its_folder_and_lacks_recordings() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("steps.csv"), MIT_TABLE).unwrap();
        let inputs = Inputs::open(folder.path(), true).unwrap();
        assert_eq!(inputs.table().unwrap().len(), 2);
        assert!(inputs.quick() && (inputs.pusher().unwrap().radius - 0.00475).abs() < 1e-12);
        assert_eq!(inputs.sources().len(), 1);
        let lacking = inputs.recordings().err().unwrap().downcast::<Lacking>().unwrap();
        let message = lacking.to_string();
        assert!(message.starts_with("needs recordings") && message.contains("a table of steps"));
    }

    #[test]
    fn what_is_neither_set_nor_table_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let error = |path: &std::path::Path| Inputs::open(path, false).err().unwrap();
        assert!(error(folder.path()).to_string().contains("dataset.toml"));
        let table = folder.path().join("other.csv");
        fs::write(&table, "a,b\n1,2\n").unwrap();
        assert!(error(&table).to_string().contains("no column"));
        assert!(error(&folder.path().join("missing")).downcast_ref::<Lacking>().is_none());
    }
}
