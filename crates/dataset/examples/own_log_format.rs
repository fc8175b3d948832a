//! A log format of one's own: the fixtures written as text and read back to the same table.

use std::fmt::Write as _;
use std::path::Path;

use dataset::{
    DatasetError, IngestSettings, Limit, LogFormat, PoseStream, ReadLimits, Recording,
    RecordingSet, Streams, WrenchStream, ingest, read_text, recording_name,
};

/// One sample a line: `tip t x y`, `object t x y theta`, `force t fx fy`, in SI units and the world
/// frame, times in s.
pub(crate) struct TextLog;

impl LogFormat for TextLog {
    fn id(&self) -> &'static str {
        "text-log"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["log"]
    }

    fn read(
        &self,
        path: &Path,
        _: &Streams,
        limits: &ReadLimits,
    ) -> Result<Recording, DatasetError> {
        let (mut robot, mut object) = (PoseStream::default(), PoseStream::default());
        let mut force = WrenchStream::default();
        for (index, line) in read_text(path)?.lines().enumerate() {
            let mut words = line.split_whitespace();
            let kind = words.next();
            let numbers: Result<Vec<f64>, _> = words.map(str::parse).collect();
            limits.check(path, Limit::Samples, || "lines".into(), index as u64 + 1)?;
            match (kind, numbers.as_deref()) {
                (Some("tip"), Ok(&[t, x, y])) => robot.push(t, x, y, 0.0),
                (Some("object"), Ok(&[t, x, y, theta])) => object.push(t, x, y, theta),
                (Some("force"), Ok(&[t, fx, fy])) => force.push(t, fx, fy),
                _ => {
                    let (path, line, what) = (path.into(), index as u64 + 1, line.to_owned());
                    return Err(DatasetError::Parse { path, line, what });
                }
            }
        }
        let name = recording_name(path, self.endings());
        Recording::made(name, 0, robot, object, Some(force)).with_source(path)
    }
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/pushes");
    let known = RecordingSet::open(&fixtures)?;
    let folder = std::env::temp_dir().join(format!("own-log-format-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("pushes"))?;
    let manifest = std::fs::read_to_string(fixtures.join("dataset.toml"))?;
    std::fs::write(folder.join("dataset.toml"), manifest.replace("format = \"csv\"\n", ""))?;
    for path in known.recordings() {
        let recording = known.read(path)?;
        let log = folder.join("pushes").join(format!("{}.log", recording.name));
        std::fs::write(log, text(&recording)?)?;
    }
    let own = RecordingSet::open_with_format(&folder, &TextLog)?;
    let settings = IngestSettings::default();
    let (table, expected) = (ingest(&own, &settings)?.0, ingest(&known, &settings)?.0);
    std::fs::remove_dir_all(&folder)?;
    println!("{} recordings as text: {} steps", own.recordings().len(), table.len());
    let same = table.rows.iter().zip(&expected.rows).filter(|(a, b)| (a.dx - b.dx).abs() < 1e-9);
    assert_eq!((same.count(), table.len()), (expected.len(), expected.len()));
    Ok(())
}

fn text(recording: &Recording) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    for (kind, stream) in [("tip", &recording.robot), ("object", &recording.object)] {
        for i in 0..stream.len() {
            write!(text, "{kind} {} {} {}", stream.t[i], stream.x[i], stream.y[i])?;
            match kind {
                "object" => writeln!(text, " {}", stream.theta[i])?,
                _ => writeln!(text)?,
            }
        }
    }
    for stream in recording.wrench.iter() {
        for i in 0..stream.len() {
            writeln!(text, "force {} {} {}", stream.t[i], stream.fx[i], stream.fy[i])?;
        }
    }
    Ok(text)
}
