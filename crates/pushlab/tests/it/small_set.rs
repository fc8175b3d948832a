//! A small recording set with a known motion, and the tool run on it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use dataset::{PoseStream, Recording, WrenchStream, all_writers};
use tempfile::TempDir;

const RADIUS: f64 = 0.005;
const HALF_SIDE: f64 = 0.045;
/// Of the pusher, in m/s.
const SPEED: f64 = 0.02;
/// From the first sample to the first contact, and from the stop to the last sample, in s.
const REST: f64 = 0.5;
/// In contact and moving, in s.
const PUSHED: f64 = 1.0;

/// A folder in which the tool runs, with a recording set named `set`.
pub(crate) struct SmallSet {
    dir: TempDir,
}

/// The end of a run.
pub(crate) struct Run {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl SmallSet {
    /// Two pushes as CSV folders, with a manifest.
    pub(crate) fn new() -> Self {
        Self::written_by("csv")
    }

    /// Two pushes, as one of dataset's writers writes them, with a manifest.
    pub(crate) fn written_by(writer_id: &str) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let pushes = dir.path().join("set/pushes");
        std::fs::create_dir_all(&pushes).unwrap();
        let writer = all_writers().iter().find(|writer| writer.id() == writer_id).unwrap();
        for (name, y) in [("push-0", 0.01), ("push-1", -0.02)] {
            writer.write(&recording(name, y), &pushes).unwrap();
        }
        std::fs::write(dir.path().join("set/dataset.toml"), manifest(writer.format())).unwrap();
        Self { dir }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    pub(crate) fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// Replaces text of a file, which has to be there.
    pub(crate) fn edit(&self, name: &str, from: &str, to: &str) {
        let text = self.read(name);
        assert!(text.contains(from), "{name} has no {from:?}");
        self.write(name, &text.replacen(from, to, 1));
    }

    /// The tool, to be run in the folder.
    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pushlab"));
        command.args(arguments).current_dir(self.dir.path());
        for name in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "COLUMNS"] {
            command.env_remove(name);
        }
        command
    }

    pub(crate) fn run(&self, arguments: &[&str]) -> Run {
        Run::of(self.command(arguments).output().unwrap())
    }

    /// Runs the tool, which has to end within a minute.
    pub(crate) fn ends(&self, arguments: &[&str]) -> Run {
        let mut command = self.command(arguments);
        let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = child.spawn().unwrap();
        let start = Instant::now();
        while child.try_wait().unwrap().is_none() {
            if start.elapsed() > Duration::from_secs(60) {
                child.kill().unwrap();
                panic!("{arguments:?} does not end");
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        Run::of(child.wait_with_output().unwrap())
    }

    /// Runs the tool, which has to end well.
    pub(crate) fn done(&self, arguments: &[&str]) -> Run {
        let run = self.run(arguments);
        assert_eq!(run.code, Some(0), "{arguments:?}: {}", run.stderr);
        run
    }

    /// The message of a run that fails with exit code 1 and prints no result.
    pub(crate) fn error(&self, arguments: &[&str]) -> String {
        let run = self.run(arguments);
        assert_eq!(run.code, Some(1), "{arguments:?}: {}", run.stderr);
        assert_eq!(run.stdout, "", "{arguments:?}");
        assert!(run.stderr.contains("error: "), "{}", run.stderr);
        run.stderr
    }

    /// The message of a run that is refused with exit code 2.
    pub(crate) fn wrong_usage(&self, arguments: &[&str]) -> String {
        let run = self.run(arguments);
        assert_eq!(run.code, Some(2), "{arguments:?}: {}", run.stderr);
        run.stderr
    }

    pub(crate) fn exists(&self, name: &str) -> bool {
        Path::exists(&self.path(name))
    }
}

impl Run {
    pub(crate) fn of(output: Output) -> Self {
        Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

pub(crate) fn manifest(format: &str) -> String {
    format!(
        "name = \"small\"\n\n[object]\nshape = \"square\"\nside_m = 0.09\nmass_kg = 0.8\n\n\
         [pusher]\nradius_m = {RADIUS}\nfriction = 0.25\n\n[support]\nfriction = 0.25\n\n\
         [recordings]\nformat = \"{format}\"\npath = \"pushes\"\n"
    )
}

/// The pusher moves along +x at the height `y` and carries the square before it without a turn.
fn recording(name: &str, y: f64) -> Recording {
    let approach = SPEED * REST;
    let end = 2.0 * REST + PUSHED;
    let stamps: Vec<f64> =
        (0..).map(|i| f64::from(i) / 100.0).take_while(|&t| t <= end + 1e-9).collect();
    let way = |t: f64| SPEED * t.min(REST + PUSHED);
    let poses = |source: &str, pose: &dyn Fn(f64) -> [f64; 2]| PoseStream {
        source: source.into(),
        x: stamps.iter().map(|&t| pose(t)[0]).collect(),
        y: stamps.iter().map(|&t| pose(t)[1]).collect(),
        theta: vec![0.0; stamps.len()],
        t: stamps.clone(),
        max_tilt: 0.0,
    };
    let in_contact = |t: f64| (REST..=REST + PUSHED).contains(&t);
    Recording {
        name: name.into(),
        path: name.into(),
        sha256: String::new(),
        epoch_ns: 1_000_000_000_000,
        robot: poses("robot", &|t| [-HALF_SIDE - RADIUS - approach + way(t), y]),
        object: poses("object", &|t| [(way(t) - approach).max(0.0), 0.0]),
        wrench: Some(WrenchStream {
            source: "wrench".into(),
            fx: stamps.iter().map(|&t| if in_contact(t) { -2.0 } else { 0.0 }).collect(),
            fy: vec![0.0; stamps.len()],
            tz: Vec::new(),
            t: stamps.clone(),
        }),
        remarks: Vec::new(),
    }
}
