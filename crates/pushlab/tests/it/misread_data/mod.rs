//! What the tool says of recordings that are read wrongly: each mistake by its name, on slow and on
//! fast pushes, as `docs/misread-data.md` shows it; and what `pushlab diagnose` answers.

mod mistakes;
mod written;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use dataset::{CHECKS, Manifest, Recording, RecordingSet, Suspicion, suspicions};
use plant::{Design, GenerateSettings, PushedObject, Scatter, generate};
use serde_json::Value;
use tempfile::TempDir;

use self::mistakes::{MISTAKES, Mistake};
use self::written::{Yaw, write_set};

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/misread-data.md");
const SLOW: [f64; 1] = [0.02];
const FAST: [f64; 3] = [0.2, 0.3, 0.4];

/// Sixteen pushes of the simulated rig.
fn made(
    speeds: &[f64],
    seed: u64,
    change: fn(&mut GenerateSettings),
) -> (Vec<Recording>, Manifest) {
    let folder = tempfile::tempdir().unwrap();
    let design = Design { n_pushes: 16, speeds: speeds.to_vec(), ..Design::default() };
    let (object, format) = (PushedObject::Square { side: 0.09, mass: 0.837 }, "csv".to_owned());
    let mut settings =
        GenerateSettings { object, design, format, seed, ..GenerateSettings::default() };
    change(&mut settings);
    generate(&settings, &folder.path().join("set")).unwrap();
    let set = RecordingSet::open(&folder.path().join("set")).unwrap();
    let read = |path| set.read(path).unwrap();
    (set.recordings().iter().map(|path| read(path)).collect(), set.manifest().clone())
}

/// A set with a mistake.
fn mistaken(
    (recordings, manifest): &(Vec<Recording>, Manifest),
    mistake: &Mistake,
) -> (Vec<Recording>, Manifest) {
    let (mut own, mut stated) = (recordings.clone(), manifest.clone());
    for recording in &mut own {
        // Of the manifest it is made once.
        stated = manifest.clone();
        (mistake.make)(recording, &mut stated);
    }
    (own, stated)
}

/// What is said, in a cell of the table.
fn cell(found: &[Suspicion]) -> String {
    let Some(first) = found.first() else { return "nothing: it is not used".to_owned() };
    let how = if first.is_certain { "**refused:**" } else { "warned: perhaps" };
    format!("{how} {}", first.what)
}

fn as_named(found: &[Suspicion], mistake: &Mistake) -> bool {
    let says = |one: &Suspicion| mistake.named.iter().any(|part| one.to_string().contains(part));
    match mistake.named {
        [] => found.is_empty(),
        _ => found.len() == 1 && says(&found[0]),
    }
}

/// Sets on the disk, as the tool reads them, beside a model.
struct Tool(TempDir);

impl Tool {
    fn new(sound: &(Vec<Recording>, Manifest)) -> Self {
        let tool = Self(tempfile::tempdir().unwrap());
        write_set(&tool.0.path().join("sound"), sound, Yaw::Angle);
        assert!(tool.run(&["models", "init", "sound"]).status.success());
        tool
    }

    fn run(&self, words: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pushlab"));
        command.args(words).arg("-q").current_dir(self.0.path()).output().unwrap()
    }

    /// The answer of `diagnose`, and what it tells people.
    fn diagnosed(&self, set: &str) -> (Option<Value>, String) {
        let run = self.run(&["diagnose", set, "--model", "model.toml", "--json"]);
        let told = String::from_utf8(run.stderr).unwrap();
        (run.status.success().then(|| serde_json::from_slice(&run.stdout).unwrap()), told)
    }

    /// What `diagnose` does with a set with a mistake, or its answer where it is confident without a
    /// word of the mistake.
    fn outcome(
        &self,
        sound: &(Vec<Recording>, Manifest),
        mistake: &Mistake,
    ) -> Result<&'static str, String> {
        let (recordings, manifest) = mistaken(sound, mistake);
        let folder = self.0.path().join("misread");
        match mistake.is_of_quaternions() {
            true => write_set(&folder, sound, Yaw::ReorderedQuaternion),
            false => write_set(&folder, &(recordings, manifest), Yaw::Angle),
        }
        let (answer, told) = self.diagnosed("misread");
        fs::remove_dir_all(folder).unwrap();
        let is_told = |text: &str| mistake.named.iter().any(|part| text.contains(part));
        match &answer {
            _ if mistake.named.is_empty() => {
                let of = |answer: Option<Value>| answer.map(|answer| answer["sentence"].clone());
                match of(answer.clone()) == of(self.diagnosed("sound").0) && answer.is_some() {
                    true => Ok("answers as without it"),
                    false => Err(format!("{answer:?} {told}")),
                }
            }
            None if is_told(&told) && told.contains("contradict the mechanics") => Ok("refuses"),
            None if is_told(&told) && told.starts_with("warning: perhaps") => {
                Ok("warns, and finds no answer")
            }
            Some(found)
                if is_told(&told)
                    && is_told(&found["suspicions"][0].to_string())
                    && found["sentence"].to_string().starts_with("\"Only if what may be") =>
            {
                Ok("warns, and answers `only if`")
            }
            _ => Err(format!("{answer:?} {told}")),
        }
    }
}

/// The two tables of the page.
fn tables(rows: &[String]) -> String {
    let mut text = "| check | looks at | names |\n|---|---|---|\n".to_owned();
    for check in CHECKS {
        let _ = writeln!(text, "| `{}` | {} | {} |", check.id, check.looks_at, check.names);
    }
    text += "\n| mistake | of | at 20 mm/s | at 200 to 400 mm/s | \
             `diagnose`, then |\n|---|---|---|---|---|\n";
    text + &rows.concat()
}

#[test]
fn each_mistake_is_told_by_its_name_slow_and_fast_as_the_page_shows() {
    let sets = [made(&SLOW, 5, |_| {}), made(&FAST, 5, |_| {})];
    let (mut rows, mut wrong) = (Vec::new(), Vec::new());
    let tool = Tool::new(&sets[1]);
    for mistake in MISTAKES {
        let found = sets.each_ref().map(|set| {
            let (recordings, manifest) = mistaken(set, mistake);
            suspicions(recordings, &manifest)
        });
        for found in &found {
            if !as_named(found, mistake) {
                wrong.push(format!("{} of {}: {found:?}", mistake.name, mistake.stream));
            }
        }
        let outcome = tool.outcome(&sets[1], mistake).unwrap_or_else(|answer| {
            wrong.push(format!("{} of {} is diagnosed: {answer}", mistake.name, mistake.stream));
            "**says nothing of it**"
        });
        let [slow, fast] = found.each_ref().map(|found| cell(found));
        let Mistake { name, stream, .. } = mistake;
        rows.push(format!("| {name} | {stream} | {slow} | {fast} | {outcome} |\n"));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let page = fs::read_to_string(PAGE).unwrap();
    let (before, after) = page.split_once("<!-- made: begin -->\n").unwrap();
    let (shown, after) = after.split_once("<!-- made: end -->").unwrap();
    let made = tables(&rows);
    if shown != made {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("misread-data.md");
        let begin = "<!-- made: begin -->\n";
        fs::write(&path, format!("{before}{begin}{made}<!-- made: end -->{after}")).unwrap();
        panic!("misread-data.md as it should be: {}", path.display());
    }
}

/// Other seeds, shapes and rigs than those with which the limits were found.
#[test]
fn sound_recordings_of_rough_rigs_are_told_nothing() {
    fn rough(settings: &mut GenerateSettings) {
        settings.scatter = Scatter {
            support_friction_sd: 0.1,
            tip_friction_sd: 0.15,
            pressure_center_sd: 3e-3,
            contact_sd: 1e-3,
            force_bias_sd: 0.1,
            ..Scatter::default()
        };
        let sensors = &mut settings.sensors;
        (sensors.object.noise_sd, sensors.object.yaw_noise_sd) = (3e-4, 5e-3);
        (sensors.robot.noise_sd, sensors.force.noise_sd) = (1e-4, 0.1);
        (sensors.object.jitter_sd, sensors.object.gap_rate) = (2e-3, 0.3);
        sensors.object.gap_length = 0.05;
    }
    fn shaped(settings: &mut GenerateSettings, name: &str) {
        rough(settings);
        settings.object = PushedObject::Mit { name: name.into() };
    }
    let rigs: [fn(&mut GenerateSettings); 4] = [
        rough,
        |settings| shaped(settings, "tri3"),
        |settings| shaped(settings, "ellip3"),
        |settings| shaped(settings, "hex"),
    ];
    for (index, rig) in rigs.into_iter().enumerate() {
        for speeds in [&SLOW[..], &FAST[..]] {
            let (recordings, manifest) = made(speeds, 900 + index as u64, rig);
            let found = suspicions(recordings, &manifest);
            assert!(found.is_empty(), "rig {index} at {speeds:?} m/s: {found:?}");
        }
    }
}
