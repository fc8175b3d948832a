//! MCAP recordings to rows, beside plain reading of all their messages.

use std::fs;
use std::hint::black_box;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use dataset::{
    IngestSettings, PoseStream, Recording, RecordingSet, WrenchStream, all_writers, ingest_each,
};
use mcap::MessageStream;
use rayon::ThreadPoolBuilder;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::benchmark::Benchmark;
use super::timing::{Case, Row};
use fixtures::workspace_root;

pub(super) const BENCHMARK: Benchmark = Benchmark {
    name: "ingest",
    about: "MCAP recordings (ROS 2 messages) to rows, beside reading all their messages with `mcap`",
    rows: |_| rows(),
};

/// Pushes of the small and the large set.
const N_PUSHES: [usize; 2] = [100, 400];
const THREADS: [usize; 2] = [1, 2];
const HALF_SIDE: f64 = 0.045;
const RADIUS: f64 = 0.00475;
const REST: f64 = 0.3;
const APPROACH: f64 = 0.004;
const SPEED: f64 = 0.02;
const PUSHED: f64 = 2.5;

fn rows() -> Result<Vec<Row>> {
    let folder = workspace_root().join("target/bench-data/ingest");
    let sets = N_PUSHES.map(|n_pushes| generated(&folder, n_pushes));
    let mut rows = Vec::new();
    let mut peaks = Vec::new();
    // From small to large: the peak of a process never falls.
    for (set, n_pushes) in sets.into_iter().zip(N_PUSHES) {
        let set = set?;
        for threads in THREADS {
            rows.push(row(&set, n_pushes, threads)?);
        }
        peaks.extend(peak_memory());
    }
    if let [small, large] = peaks[..] {
        println!(
            "peak memory after {} pushes: {:.1} MB, after {}: {:.1} MB",
            N_PUSHES[0],
            small as f64 / 1e6,
            N_PUSHES[1],
            large as f64 / 1e6
        );
    }
    Ok(rows)
}

fn row(set: &RecordingSet, n_pushes: usize, threads: usize) -> Result<Row> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
    let settings = IngestSettings::default();
    let ingested = || -> Result<usize> {
        let mut n_rows = 0;
        let report = pool.install(|| {
            ingest_each(set, &settings, |_, rows| {
                n_rows += rows.len();
                Ok(())
            })
        })?;
        ensure!(report.summary.pushes_used == n_pushes, "a push was excluded");
        Ok(n_rows)
    };
    let read = || pool.install(|| set.recordings().par_iter().map(|path| read(path)).sum());
    ensure!(ingested()? > 0, "no rows");
    let n_bytes: u64 = read_all(set)?;
    let case = Case { name: "mcap to table", size: n_pushes, threads, rounds: 7, calls: 1 };
    let row = case.compare(|| ingested().map_err(black_box), || -> usize { read() });
    println!(
        "{n_pushes} pushes, {threads} threads: {:.1} MB/s, {:.0} pushes/s; plain reading {:.1} MB/s",
        n_bytes as f64 / 1e6 / row.median_seconds,
        n_pushes as f64 / row.median_seconds,
        n_bytes as f64 / 1e6 / row.reference_seconds
    );
    Ok(row)
}

/// The reference: every message of a log, unpacked and looked at; 0 for one that cannot be read.
fn read(path: &Path) -> usize {
    let Ok(bytes) = fs::read(path) else { return 0 };
    let Ok(messages) = MessageStream::new(&bytes) else { return 0 };
    messages.filter_map(Result::ok).map(|message| black_box(message.data.len())).sum()
}

/// Size of a set's files, in bytes, after a check that all of them can be read plainly.
fn read_all(set: &RecordingSet) -> Result<u64> {
    let mut n_bytes = 0;
    for path in set.recordings() {
        ensure!(read(path) > 0, "{}: no messages", path.display());
        n_bytes += fs::metadata(path)?.len();
    }
    Ok(n_bytes)
}

/// Most memory that this process ever had in use, in bytes; none where the system does not tell.
pub(super) fn peak_memory() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(1024 * line.trim().strip_suffix(" kB")?.parse::<u64>().ok()?)
}

/// A set of its own making: straight pushes of a square, each at another place of one side.
fn generated(folder: &Path, n_pushes: usize) -> Result<RecordingSet> {
    let dir = folder.join(n_pushes.to_string());
    let pushes = dir.join("pushes");
    let writer = all_writers()
        .iter()
        .find(|writer| writer.id() == "mcap-ros2")
        .context("there is no writer of MCAP")?;
    for i in 0..n_pushes {
        writer.write(&recording(i), &pushes)?;
    }
    output::write(
        &dir.join("dataset.toml"),
        format!(
            "name = \"bench\"\n[object]\nshape = \"square\"\nside_m = {}\nmass_kg = 0.8\n\
             [pusher]\nradius_m = {RADIUS}\nfriction = 0.25\n[support]\nfriction = 0.25\n\
             [recordings]\nformat = \"mcap\"\npath = \"pushes\"\n",
            2.0 * HALF_SIDE
        ),
    )?;
    Ok(RecordingSet::open(&dir)?)
}

/// Rest, approach, push along x, rest: robot and object at 250 Hz, the force likewise.
fn recording(push: usize) -> Recording {
    const RATE: f64 = 250.0;
    let y = 0.03 * ((push % 41) as f64 / 20.0 - 1.0);
    let touch = REST + APPROACH / SPEED;
    let times: Vec<f64> =
        (0..((touch + PUSHED + REST) * RATE) as usize).map(|i| i as f64 / RATE).collect();
    // Noise by hand, so that the files are the same everywhere and do not compress to nothing.
    let noise =
        |i: usize, k: usize| 1e-5 * (((i * 7919 + k * 104_729 + push) % 101) as f64 / 50.0 - 1.0);
    let poses = |x: &dyn Fn(f64) -> f64, y: f64, k: usize| PoseStream {
        t: times.clone(),
        x: times.iter().enumerate().map(|(i, &t)| x(t) + noise(i, k)).collect(),
        y: times.iter().enumerate().map(|(i, _)| y + noise(i, k + 1)).collect(),
        theta: times.iter().enumerate().map(|(i, _)| noise(i, k + 2)).collect(),
        ..PoseStream::default()
    };
    let stop = touch + PUSHED;
    let robot =
        poses(&|t| -HALF_SIDE - RADIUS - APPROACH + SPEED * (t.min(stop) - REST).max(0.0), y, 0);
    let object = poses(&|t| SPEED * (t.min(stop) - touch).max(0.0), 0.0, 3);
    let force = |t: f64| if (touch..stop).contains(&t) { -2.0 } else { 0.0 };
    let wrench = WrenchStream {
        t: times.clone(),
        fx: times.iter().enumerate().map(|(i, &t)| force(t) + 1e3 * noise(i, 6)).collect(),
        fy: times.iter().enumerate().map(|(i, _)| 1e3 * noise(i, 7)).collect(),
        tz: vec![0.0; times.len()],
        ..WrenchStream::default()
    };
    Recording {
        name: format!("push-{push:04}"),
        path: PathBuf::new(),
        sha256: String::new(),
        epoch_ns: 1_000_000_000,
        robot,
        object,
        wrench: Some(wrench),
        remarks: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::{generated, read_all, row};

    #[test]
    fn both_sides_see_the_whole_of_a_made_set() {
        let dir = tempfile::tempdir().unwrap();
        let set = generated(dir.path(), 3).unwrap();
        assert_eq!(set.recordings().len(), 3);
        assert!(read_all(&set).unwrap() > 10_000);
        let row = row(&set, 3, 2).unwrap();
        assert_eq!((row.size, row.threads), (3, 2));
    }
}
