//! The log formats: every recording is read and inspected.

use std::fs;
use std::path::Path;

use anyhow::Result;
use dataset::{Limit, ReadLimits, Streams, format_by_id};

use super::super::reader::{Reader, Verdict, join_files, write_files};
use super::log_variants::{bags, hdf5_files, mcap_files};
use super::recording::{push, write, written, wrong};

/// Samples of each stream.
const N_SAMPLES: usize = 4;
/// Files of a recording in CSV.
const CSV_FILES: [&str; 3] = ["robot.csv", "object.csv", "wrench.csv"];

/// MCAP with each schema encoding, with and without chunks, compression and index.
pub(super) struct McapLogs;
/// ROS 1 bags with each compression.
pub(super) struct Bags;
/// The MIT format in HDF5.
pub(super) struct Hdf5;
/// The MIT format in JSON.
pub(super) struct MitJson;
/// A folder of CSV.
pub(super) struct CsvFolder;

fn read_and_inspect(format: &str, path: &Path) -> Verdict {
    let Ok(format) = format_by_id(format) else {
        return Verdict::Wrong(format!("format {format} is not known"));
    };
    // What can be seen of a recording and whether it can be read are independent.
    let limits = limits();
    let _ = format.inspect(path, &limits);
    Verdict::of(format.read(path, &Streams::default(), &limits), wrong)
}

/// Limits far below the memory of a worker: a reader that keeps them is not ended by it.
fn limits() -> ReadLimits {
    [(Limit::ChunkBytes, 1 << 26), (Limit::UnpackedBytes, 1 << 27), (Limit::Samples, 1 << 18)]
        .into_iter()
        .fold(ReadLimits::default(), |limits, (limit, value)| limits.with(limit, value))
}

fn read_file(format: &str, dir: &Path, name: &str, input: &[u8]) -> Verdict {
    let path = dir.join(name);
    match fs::write(&path, input) {
        Ok(()) => read_and_inspect(format, &path),
        Err(error) => Verdict::Wrong(format!("scratch is not usable: {error}")),
    }
}

impl Reader for McapLogs {
    fn name(&self) -> &'static str {
        "mcap"
    }

    fn corpus(&self, dir: &Path) -> Result<Vec<Vec<u8>>> {
        let mut inputs = Vec::new();
        for writer in ["mcap-ros2", "mcap-ros1", "mcap-json", "mcap-protobuf"] {
            inputs.extend(mcap_files(&written(writer, &push(N_SAMPLES), dir)?)?);
        }
        Ok(inputs)
    }

    fn tokens(&self) -> &'static [&'static str] {
        &[
            "ros2msg",
            "ros1msg",
            "jsonschema",
            "protobuf",
            "cdr",
            "zstd",
            "lz4",
            "float64[]",
            "float64[1000000000] a\n",
            "string",
            "wstring",
            "geometry_msgs/",
            "geometry_msgs/Point",
            "===\nMSG: a/b\n",
            "uint8[<=4]",
            "time",
            "duration",
            "Header header\n",
            "\"pose\":",
            "[[[[[[[[",
            "{\"a\":",
            "PoseStamped",
            "\x00\x01\x00\x00",
        ]
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        read_file("mcap", dir, "push.mcap", input)
    }
}

impl Reader for Bags {
    fn name(&self) -> &'static str {
        "bag"
    }

    fn corpus(&self, dir: &Path) -> Result<Vec<Vec<u8>>> {
        bags(&written("ros1-bag", &push(N_SAMPLES), dir)?)
    }

    fn tokens(&self) -> &'static [&'static str] {
        &[
            "compression=",
            "none",
            "bz2",
            "lz4",
            "size=",
            "op=\x05",
            "op=\x02",
            "op=\x07",
            "conn=",
            "topic=",
            "type=",
            "message_definition=",
            "callerid=",
            "time=",
            "chunk_pos=",
            "float64[]",
            "float64[1000000000] a\n",
            "===\nMSG: a/b\n",
            "string s\n",
        ]
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        read_file("ros1-bag", dir, "push.bag", input)
    }
}

impl Reader for Hdf5 {
    fn name(&self) -> &'static str {
        "hdf5"
    }

    fn corpus(&self, dir: &Path) -> Result<Vec<Vec<u8>>> {
        hdf5_files(written("mit-hdf5", &push(N_SAMPLES), dir)?)
    }

    fn tokens(&self) -> &'static [&'static str] {
        &["tip_pose", "object_pose", "ft_wrench", "TREE", "SNOD", "HEAP", "OHDR", "OCHK", "FRHP"]
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        read_file("mit-hdf5", dir, "push.h5", input)
    }
}

impl Reader for MitJson {
    fn name(&self) -> &'static str {
        "mit-json"
    }

    fn corpus(&self, dir: &Path) -> Result<Vec<Vec<u8>>> {
        let large = br#"{"tip_pose": [[1e3, 1, 0, 0.5]], "object_pose": [[-5, 1e-3, 2, 1e2]]}"#;
        Ok(vec![written("mit-json", &push(N_SAMPLES), dir)?, large.to_vec()])
    }

    fn tokens(&self) -> &'static [&'static str] {
        &[
            "tip_pose",
            "object_pose",
            "ft_wrench",
            "[[[[[[[[",
            "null",
            "\"",
            "1e400",
            "-0",
            "\\ud800",
        ]
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        read_file("mit-json", dir, "push.json", input)
    }
}

impl Reader for CsvFolder {
    fn name(&self) -> &'static str {
        "csv-folder"
    }

    fn corpus(&self, dir: &Path) -> Result<Vec<Vec<u8>>> {
        let folder = write("csv", &push(N_SAMPLES), dir)?;
        Ok(vec![join_files(&folder, &CSV_FILES)?])
    }

    fn tokens(&self) -> &'static [&'static str] {
        &["t_s", "x_m", "y_m", "theta_rad", "qw", "fx_n", "tz_nm", "\"", "\"\"", "#", "\r\n", ",,"]
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        match write_files(dir, &CSV_FILES, input) {
            Ok(()) => read_and_inspect("csv", dir),
            Err(error) => Verdict::Wrong(format!("scratch is not usable: {error}")),
        }
    }
}
