//! Files cut short or with bytes changed, in every format: errors or remarks, never a panic.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::made::{Made, write_set};
use dataset::{IngestSettings, ReadLimits, RecordingSet, all_writers, format_by_id, ingest};

/// Damaged copies of each format.
const N_CASES: u64 = 60;

/// Numbers that look random, from mixed bits.
fn mixed(seed: u64) -> u64 {
    let mixed = (seed + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    mixed ^ (mixed >> 32)
}

/// A third of the cases cut the file short, the rest change up to eight of its bytes.
fn damage(whole: &[u8], case: u64) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    let place = |k: u64| (mixed(1000 * case + k) % whole.len() as u64) as usize;
    if case.is_multiple_of(3) {
        bytes.truncate(place(0));
    } else {
        for k in 0..1 + case % 8 {
            bytes[place(2 * k)] = mixed(1000 * case + 2 * k + 1) as u8;
        }
    }
    bytes
}

/// The one file of a recording that is damaged.
fn victim(recording: &Path) -> PathBuf {
    if recording.is_dir() { recording.join("object.csv") } else { recording.to_path_buf() }
}

#[test]
fn damaged_files_never_panic_and_always_say_why() {
    let made = Made { duration: 0.3, ..Made::default() };
    for writer in all_writers() {
        let dir = tempfile::tempdir().unwrap();
        write_set(dir.path(), writer.id(), &[made.recording("push")]);
        let set = RecordingSet::open(dir.path()).unwrap();
        let path = victim(&set.recordings()[0]);
        let whole = fs::read(&path).unwrap();
        let (mut n_used, mut n_refused) = (0, 0);
        for case in 0..N_CASES {
            fs::write(&path, damage(&whole, case)).unwrap();
            match ingest(&set, &IngestSettings::default()) {
                Ok((table, _)) => {
                    n_used += 1;
                    assert!(table.rows.iter().all(|row| row.dx.is_finite()), "{}", writer.id());
                }
                Err(error) => {
                    n_refused += 1;
                    let message = error.to_string();
                    assert!(message.contains("1 recordings"), "{}: {message}", writer.id());
                }
            }
            let format = format_by_id(writer.format()).unwrap();
            let _ = format.inspect(&set.recordings()[0], &ReadLimits::default());
        }
        assert!(n_refused > 0, "{}: {n_used} used", writer.id());
        fs::write(&path, &whole).unwrap();
        assert!(ingest(&set, &IngestSettings::default()).is_ok(), "{}", writer.id());
    }
}

#[test]
fn a_log_cut_short_yields_what_is_whole() {
    let made = Made { duration: 3.0, ..Made::default() };
    for id in ["mcap-ros2", "mcap-json"] {
        let dir = tempfile::tempdir().unwrap();
        write_set(dir.path(), id, &[made.recording("push")]);
        let set = RecordingSet::open(dir.path()).unwrap();
        let whole = fs::read(&set.recordings()[0]).unwrap();
        fs::write(&set.recordings()[0], &whole[..whole.len() - 200]).unwrap();
        let (_, report) = ingest(&set, &IngestSettings::default()).unwrap();
        let text = report.to_text();
        assert!(text.contains("the index at the end of the file is missing"), "{text}");
    }
}
