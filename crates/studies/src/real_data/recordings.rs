//! Published recordings of the 2015 rig: as MCAP and as ROS 1 bags they give the same table.

use std::path::Path;

use anyhow::Result;
use dataset::{IngestReport, IngestSettings, Preset, RecordingSet, RemarkKind, ingest};
use serde_json::{Map, Value, json};

use super::Section;
use super::row::{Reference, Row};

pub(super) fn run(dir: &Path) -> Result<Section> {
    let set = RecordingSet::open_with_preset(dir, Preset::MitRig2015)?;
    let settings = IngestSettings::default();
    let (mcap, report) = ingest(&set.in_format("mcap")?, &settings)?;
    let (bag, bag_report) = ingest(&set.in_format("ros1-bag")?, &settings)?;
    let pairs = mcap.rows.iter().zip(&bag.rows);
    let n_equal = pairs.filter(|(a, b)| a == b).count();
    let summary = &report.summary;
    let excluded: usize = summary.excluded.values().sum();
    let rows = vec![
        Row::new(
            "recordings: pushes used or excluded",
            (summary.pushes_used + excluded) as f64,
            Reference::Exactly(report.recordings.len() as f64),
        ),
        Row::new("recordings: steps of the bags", bag.len() as f64, Reference::None),
        Row::new(
            "recordings: steps equal in MCAP and bag",
            n_equal as f64,
            Reference::Exactly(mcap.len().max(bag.len()) as f64),
        ),
        Row::new("recordings: late messages", late(&report) as f64, Reference::None),
        Row::new(
            "recordings: late messages of the bags",
            late(&bag_report) as f64,
            Reference::Exactly(late(&report) as f64),
        ),
    ];
    let entry = json!({
        "used": summary.pushes_used,
        "excluded": excluded,
        "reasons": summary.excluded,
        "steps": mcap.len(),
        "steps_equal_in_bag": n_equal,
        "mcap_equals_bag": n_equal == mcap.len() && n_equal == bag.len(),
        "recordings": report.recordings.iter().map(|recording| json!({
            "name": recording.name,
            "remarks": recording.remarks.iter().map(|remark| &remark.text).collect::<Vec<_>>(),
            "force_zero": recording.force_zero,
            "streams": recording.streams,
        })).collect::<Vec<Value>>(),
    });
    Ok(Section { json: Map::from_iter([("recordings".to_owned(), entry)]), rows })
}

/// Messages that reached the log long after their stamps.
fn late(report: &IngestReport) -> u64 {
    let remarks = report.recordings.iter().flat_map(|recording| &recording.remarks);
    remarks.filter(|remark| remark.kind == RemarkKind::Late).map(|remark| remark.count).sum()
}
