//! Recordings that lie where a set is read, and are not read.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::formats::format::LogFormat;
use crate::formats::list::all_formats;
use crate::input::limits::ReadLimits;
use crate::recording::name::recording_name;
use crate::remark::{Remark, RemarkKind};

/// Formats that a build may leave out, with the endings of their files.
const OPTIONAL: [(&str, &[&str]); 2] = [("ros1-bag", &["bag"]), ("mit-hdf5", &["h5", "hdf5"])];
/// Names that a remark has room for.
const MOST_NAMES: usize = 3;

/// What a folder has in other formats than the one that is read: a remark a format.
pub(crate) fn unread_formats(dir: &Path, read: &dyn LogFormat) -> Vec<Remark> {
    let others = all_formats().iter().filter(|format| format.id() != read.id());
    let found = others.filter_map(|format| Some((format.id(), recordings(*format, dir)?)));
    let known = |id: &str| all_formats().iter().any(|format| format.id() == id);
    let left_out = OPTIONAL.iter().filter(|(id, _)| !known(id) && read.id() != *id);
    let left_out = left_out.filter_map(|(id, endings)| Some((*id, files(dir, endings)?)));
    let remark = |(id, paths): (&str, Vec<PathBuf>)| {
        not_read(
            &paths,
            &format!(
                "recordings of format {id} in {} are not read, those of format {} are: set format \
                 = \"{id}\" in [recordings] to read them instead, or move them to a set of their own",
                dir.display(),
                read.id()
            ),
        )
    };
    found.chain(left_out).map(remark).collect()
}

/// The remark that these are not read.
pub(crate) fn not_read(paths: &[PathBuf], why: &str) -> Remark {
    let names = paths.iter().take(MOST_NAMES).map(|path| recording_name(path, &[]));
    let names = names.collect::<Vec<_>>().join(", ");
    let more = if paths.len() > MOST_NAMES { ", …" } else { "" };
    let text = format!("{} {why} ({names}{more})", paths.len());
    Remark { kind: RemarkKind::NotRead, stream: None, count: paths.len() as u64, text }
}

/// The recordings of a format; none if there are none.
fn recordings(format: &dyn LogFormat, dir: &Path) -> Option<Vec<PathBuf>> {
    let mut found = format.find(dir).ok()?;
    // Of the endings only this one is of other documents as well, such as those of this tool.
    if format.endings().contains(&"json") {
        found.retain(|path| format.inspect(path, &ReadLimits::default()).is_ok());
    }
    (!found.is_empty()).then_some(found)
}

fn files(dir: &Path, endings: &[&str]) -> Option<Vec<PathBuf>> {
    let paths = fs::read_dir(dir).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    let is_one = |path: &PathBuf| {
        let ending = path.extension().and_then(|ending| ending.to_str());
        ending.is_some_and(|ending| endings.contains(&ending))
    };
    let mut found: Vec<_> = paths.filter(is_one).collect();
    found.sort();
    (!found.is_empty()).then_some(found)
}
