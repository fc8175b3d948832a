//! A first manifest: looks at what a folder holds and writes a commented `dataset.toml`.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use output::{Existing, OutputFile};

use crate::formats::format::{ANY_FORMAT, Inspection, LogFormat, StreamInfo};
use crate::formats::list::all_formats;
use crate::input::limits::ReadLimits;
use crate::manifest::MANIFEST_NAME;
use crate::manifest::object::shape_in_name;
use crate::manifest::preset::Preset;
use crate::manifest::unread::{not_read, unread_formats};
use crate::{
    error::DatasetError,
    remark::{Remark, StreamRole},
};

/// Writes `dataset.toml` into a folder of recordings, by a preset or from what is there.
///
/// # Errors
/// `Output` if there is a manifest already, `NoRecordings` for a folder without recordings,
/// `Io`, and what inspecting the first recording may say.
pub fn init(dir: &Path, preset: Option<Preset>) -> Result<PathBuf, DatasetError> {
    let path = dir.join(MANIFEST_NAME);
    let output = OutputFile::new(&path, Existing::Refuse)?;
    let text = match preset {
        Some(preset) => preset.text().to_owned(),
        None => draft_manifest(dir)?,
    };
    output.write(text)?;
    Ok(path)
}

/// The text of a manifest for a folder, with all that its first recording tells.
///
/// What no recording can tell (shape, mass, pusher) is left as `"TODO"`, which is refused with the
/// allowed values until it is filled in.
///
/// # Errors
/// As [`init`].
pub fn draft_manifest(dir: &Path) -> Result<String, DatasetError> {
    let (format, folder, recordings) = find_recordings(dir)?;
    let Some(first) = recordings.first() else { return Err(none_found(dir)) };
    let inspection = format.inspect(first, &ReadLimits::default())?;
    let title = dir.file_name().unwrap_or(dir.as_os_str()).to_string_lossy();
    let example = first.file_name().unwrap_or(first.as_os_str()).to_string_lossy();
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write!(
        out,
        "# Written from {} recordings; the streams below are those of {}.\n\
         name = {}\n\n{}\n\
         [pusher]\n\
         radius_m = \"TODO\"         # of the round tip, in m\n\
         friction = 0.25             # pusher-object, nominal: CHECK\n\n\
         [support]\n\
         friction = 0.25             # object-table, nominal: CHECK\n\
         gravity_m_s2 = 9.81\n\n\
         [recordings]\n\
         format = {}\n\
         path = {}\n",
        recordings.len(),
        one_line(&example),
        quoted(&title),
        object_text(&example),
        quoted(format.id()),
        quoted(&folder),
    );
    for remark in unread_recordings(dir, format, &folder) {
        let _ = writeln!(out, "# {}", one_line(&remark.text));
    }
    for role in StreamRole::ALL {
        out.push_str(&stream_text(role, &inspection));
    }
    for remark in &inspection.remarks {
        let _ = write!(out, "\n# {}", one_line(&remark.text));
    }
    out.push('\n');
    Ok(out)
}

/// Recordings in the folder itself or in one below it, with their format and that folder's name.
///
/// # Errors
/// `Io` for a folder that cannot be read, `NoRecordings` for one without recordings.
pub fn find_recordings(
    dir: &Path,
) -> Result<(&'static dyn LogFormat, String, Vec<PathBuf>), DatasetError> {
    for folder in folders(dir)? {
        for &format in all_formats() {
            match format.find(&dir.join(&folder)) {
                Ok(recordings) if !recordings.is_empty() => {
                    return Ok((format, folder, recordings));
                }
                Ok(_) | Err(DatasetError::NoRecordings { .. }) => {}
                Err(error) => return Err(error),
            }
        }
    }
    Err(none_found(dir))
}

/// What [`find_recordings`] passes over: other formats in the folder that it takes, and recordings
/// in other folders.
///
/// - `format`, `folder`: what it gives.
#[must_use]
pub fn unread_recordings(dir: &Path, format: &dyn LogFormat, folder: &str) -> Vec<Remark> {
    let mut remarks = unread_formats(&dir.join(folder), format);
    for other in folders(dir).unwrap_or_default().iter().filter(|other| *other != folder) {
        let place = dir.join(other);
        let of_format =
            |known: &&'static dyn LogFormat| Some((known.id(), known.find(&place).ok()?));
        for (id, mut paths) in all_formats().iter().filter_map(of_format) {
            // A folder that is itself a recording was found as one.
            paths.retain(|path| *path != place);
            if !paths.is_empty() {
                let why = format!(
                    "recordings of format {id} in {} are not read, those in {} are: set path = {} \
                     in [recordings] to read them instead, or make a set of each folder",
                    place.display(),
                    dir.join(folder).display(),
                    quoted(other)
                );
                remarks.push(not_read(&paths, &why));
            }
        }
    }
    remarks
}

/// The folder itself and those in it, by name.
fn folders(dir: &Path) -> Result<Vec<String>, DatasetError> {
    let entries = fs::read_dir(dir).map_err(|error| DatasetError::io("read", dir, error))?;
    let mut below: Vec<_> = entries
        .filter_map(|entry| entry.ok())
        .filter(|entry| entry.path().is_dir())
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect();
    below.sort();
    below.insert(0, ".".to_owned());
    Ok(below)
}

fn none_found(dir: &Path) -> DatasetError {
    let (path, expected) = (dir.into(), ANY_FORMAT.to_owned());
    DatasetError::NoRecordings { path, format: "any", expected }
}

/// A text as TOML writes it.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A text on one line, as a comment needs it.
fn one_line(text: &str) -> String {
    let shown =
        |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(shown).collect()
}

fn object_text(recording: &str) -> &'static str {
    if shape_in_name(recording).is_some() {
        return "[object]\n\
                shape = \"by-file-name\"      # an MIT object, named in each recording's name\n";
    }
    "[object]\n\
     shape = \"TODO\"              # square | rectangle | polygon | ellipse, or an MIT object\n\
     # side_m = 0.09             # square; rectangle: width_m, height_m; ellipse: semi_axes_m\n\
     # vertices_m = [[0.0, 0.0]] # polygon, counter-clockwise, in the tracked body's frame\n\
     # mass_kg = 0.8\n\
     # moment_of_inertia_kg_m2 and center_of_mass_m: of uniform density if left out\n"
}

/// The table of one stream: its topic where only one fits, else all that do.
fn stream_text(role: StreamRole, inspection: &Inspection) -> String {
    let fitting: Vec<_> =
        inspection.streams.iter().filter(|stream| stream.fits.contains(&role)).collect();
    let mut out = format!("\n[streams.{role}]\n");
    match fitting[..] {
        [only] => {
            let _ = writeln!(out, "topic = {}  # {}", quoted(&only.name), describe(only));
        }
        [] => {
            out.push_str("# nothing fits by its type; the recording has:\n");
            for stream in &inspection.streams {
                let _ = writeln!(out, "#   {}: {}", one_line(&stream.name), describe(stream));
            }
        }
        _ => {
            out.push_str(
                "# several fit by type; without a topic the name decides, where it can:\n",
            );
            for stream in fitting {
                // As the key would be written, for which the comment sign alone has to go.
                let topic = one_line(&quoted(&stream.name));
                let _ = writeln!(out, "# topic = {topic}  # {}", describe(stream));
            }
        }
    }
    if role == StreamRole::Object && !inspection.frames.is_empty() {
        let frames: Vec<_> = inspection
            .frames
            .iter()
            .map(|(parent, child)| format!("{parent} <- {child}"))
            .collect();
        let _ = writeln!(out, "# frames in the log: {}", one_line(&frames.join(", ")));
        out.push_str("# transform = { tf_parent = \"…\", tf_child = \"…\" }\n");
    }
    if role == StreamRole::Wrench {
        out.push_str("# the force of the object on the pusher, in the world frame; else:\n");
        out.push_str("# frame = \"sensor\"\n# signs = [\"-x\", \"+y\", \"-z\"]\n");
    }
    out
}

fn describe(stream: &StreamInfo) -> String {
    let mut parts = Vec::new();
    if !stream.type_name.is_empty() {
        parts.push(stream.type_name.clone());
    }
    if !stream.columns.is_empty() {
        parts.push(format!("columns {}", stream.columns.join(", ")));
    }
    parts.push(format!("{} samples", stream.count));
    parts.extend(stream.rate_hz.map(|rate| format!("{rate:.0} Hz")));
    one_line(&parts.join(", "))
}

#[cfg(test)]
mod tests {
    use std::{fs, path::Path};

    use super::{draft_manifest, init};
    use crate::error::DatasetError;
    use crate::manifest::Manifest;
    use crate::manifest::preset::Preset;

    fn write_push(dir: &Path) {
        let push = dir.join("pushes/push-0000");
        fs::create_dir_all(&push).unwrap();
        fs::write(push.join("robot.csv"), "t_s,x_m,y_m\n1,0,0\n2,0.1,0\n").unwrap();
        fs::write(push.join("object.csv"), "t_s,x_m,y_m,theta_rad\n1,0,0,0\n2,0,0,0\n").unwrap();
    }

    #[test]
    fn a_draft_names_what_is_there_and_refuses_to_guess_the_rest() {
        let dir = tempfile::tempdir().unwrap();
        write_push(dir.path());
        let text = draft_manifest(dir.path()).unwrap();
        assert!(text.contains("format = \"csv\"\npath = \"pushes\""), "{text}");
        assert!(text.contains("columns t_s, x_m, y_m, theta_rad, 2 samples"), "{text}");
        let message = Manifest::parse(&text, Path::new("m.toml")).unwrap_err().to_string();
        let all = ["object.shape in line 5", "object.mass_kg (in kg", "pusher.radius_m in line 12"];
        assert!(all.iter().all(|one| message.contains(one)), "{message}");
        let filled = text.replacen("radius_m = \"TODO\"", "radius_m = 0.005", 1);
        let message = Manifest::parse(&filled, Path::new("m.toml")).unwrap_err().to_string();
        assert!(message.contains("2 values are"), "shape and mass: {message}");
        let heavy = filled.replacen("# mass_kg", "mass_kg", 1);
        let message = Manifest::parse(&heavy, Path::new("m.toml")).unwrap_err().to_string();
        assert!(message.contains("object.shape = TODO is not allowed"), "{message}");
        let filled = filled.replacen("shape = \"TODO\"", "shape = \"rect1\"", 1);
        Manifest::parse(&filled, Path::new("m.toml")).unwrap();
    }

    #[test]
    fn a_draft_of_a_folder_of_any_name_is_toml() {
        let dir = tempfile::tempdir().unwrap();
        let names =
            ["\u{7f}\u{85} ü", "a\u{301}\u{200b}\u{feff}", "\"q\" \\ 'x' '''", "line\nb\u{1b}"];
        for name in names {
            let set = dir.path().join(name);
            write_push(&set);
            let text = draft_manifest(&set).unwrap();
            let table: toml::Table = text.parse().unwrap_or_else(|e| panic!("{e}: {text}"));
            assert_eq!(table["name"].as_str(), Some(name));
        }
    }

    #[test]
    fn a_manifest_is_never_overwritten() {
        let dir = tempfile::tempdir().unwrap();
        let path = init(dir.path(), Some(Preset::MitPush)).unwrap();
        Manifest::read(&path).unwrap();
        let again = init(dir.path(), None);
        assert!(matches!(again, Err(DatasetError::Output(_))));
        fs::remove_file(&path).unwrap();
        let empty = init(dir.path(), None);
        assert!(matches!(empty, Err(DatasetError::NoRecordings { .. })));
    }
}
