//! The ingest report in words.

use std::fmt;

use crate::ingest::force_zero::{ForceZero, UntaredReason};
use crate::ingest::push::Exclusion;
use crate::ingest::repair::RepairKind;
use crate::ingest::report::{IngestReport, PushReport, RecordingReport, Spread, StreamReport};
use crate::remark::StreamRole;
use crate::table::coverage::{Coverage, Histogram};

impl IngestReport {
    /// The report as text: the set first, then one paragraph a recording.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut out = self.summary_text();
        for recording in &self.recordings {
            out.push_str(&recording_text(recording));
        }
        out
    }

    /// The findings over the set as text, as [`IngestReport::to_text`] begins.
    #[must_use]
    pub fn summary_text(&self) -> String {
        SummaryText(self).to_string()
    }
}

struct SummaryText<'a>(&'a IngestReport);

impl fmt::Display for SummaryText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (report, summary) = (self.0, &self.0.summary);
        let excluded: usize = summary.excluded.values().sum();
        writeln!(f, "{} ({})", report.name, report.tool)?;
        for remark in &report.remarks {
            writeln!(f, "  {}", remark.text)?;
        }
        writeln!(
            f,
            "  {} recordings, {} pushes used, {excluded} excluded, {} rows, {} steps lost in gaps",
            report.recordings.len(),
            summary.pushes_used,
            summary.rows,
            summary.steps_lost_in_gaps
        )?;
        for (reason, n) in &summary.excluded {
            writeln!(f, "  excluded, {reason}: {n}")?;
        }
        self.write_splits(f)?;
        for (stream, rates) in &summary.rates_hz {
            spread(f, &format!("rate of the {stream} stream"), Some(*rates), 1.0, "Hz")?;
        }
        for (stream, repairs) in &summary.repairs {
            let counts = counts(repairs.iter());
            writeln!(f, "  repairs of the {stream} stream: {}", or_none(&counts))?;
        }
        let untared: Vec<_> =
            summary.untared.iter().map(|(reason, n)| format!("{n} {reason}")).collect();
        writeln!(
            f,
            "  force zero: found in {}, unknown in {}",
            summary.tared,
            or_none(&untared.join(", "))
        )?;
        if summary.contacts_lost > 0 {
            writeln!(
                f,
                "  {} pushes lose contact while the pusher goes on",
                summary.contacts_lost
            )?;
        }
        if summary.force_left_at_rest > 0 {
            writeln!(
                f,
                "  {} pushes leave more than half of μ·m·g on the sensor at rest: its zero is lost, \
                 or the pusher still presses",
                summary.force_left_at_rest
            )?;
        }
        spread(f, "μ·m·g by the manifest", summary.nominal_force_n, 1.0, "N")?;
        spread(f, "steady force, zero known", summary.steady_force_n, 1.0, "N")?;
        let untared = "steady force, untared but below 10 % of μ·m·g at rest";
        spread(f, untared, summary.steady_force_untared_n, 1.0, "N")?;
        spread(f, "object noise at rest", summary.resting_position_sd_m, 1e6, "µm")?;
        spread(f, "object noise at rest", summary.resting_angle_sd_rad, 1e6, "µrad")?;
        writeln!(f, "  largest tilt: {:.2}°", summary.max_tilt_rad.to_degrees())?;
        write!(f, "{}", summary.coverage)
    }
}

impl SummaryText<'_> {
    /// How recordings of several pushes were split, and what of them is no push.
    fn write_splits(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let recordings = &self.0.recordings;
        let several = || recordings.iter().filter(|one| one.pushes.len() > 1 && !one.is_of_ends());
        let n_pushes: usize = several().map(|one| one.pushes.len()).sum();
        let n_pauses: usize = several().map(|one| one.pauses_s.len()).sum();
        match several().count() {
            0 => {}
            1 => write!(f, "  one recording has {n_pushes} pushes")?,
            n => write!(f, "  {n} recordings have {n_pushes} pushes, each several")?,
        }
        match n_pauses {
            _ if n_pushes == 0 => {}
            0 => writeln!(f, ", split where the contact ends")?,
            n => writeln!(f, ", split where the contact ends and at {n} pauses of the log")?,
        }
        match recordings.iter().map(|one| one.passes).sum::<usize>() {
            0 => Ok(()),
            n => writeln!(
                f,
                "  set aside: the object passes under the tip or is carried past it {n} times"
            ),
        }
    }
}

impl fmt::Display for Coverage {
    /// A line a histogram and the rows on each edge, indented by two blanks.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for histogram in [&self.p, &self.beta, &self.speed, &self.orientation] {
            histogram_line(f, histogram)?;
        }
        writeln!(f, "  rows on edges: {:?}", self.edges)
    }
}

fn spread(
    f: &mut fmt::Formatter<'_>,
    what: &str,
    values: Option<Spread>,
    scale: f64,
    unit: &str,
) -> fmt::Result {
    match values {
        None => Ok(()),
        Some(Spread { low, median, high, n }) => writeln!(
            f,
            "  {what}: {:.3} {unit} ({:.3} to {:.3}, {n} values)",
            median * scale,
            low * scale,
            high * scale
        ),
    }
}

fn histogram_line(f: &mut fmt::Formatter<'_>, histogram: &Histogram) -> fmt::Result {
    let Histogram { quantity, unit, low, high, below, above, .. } = histogram;
    let unit = if *unit == "1" { String::new() } else { format!(" {unit}") };
    let outside = match below + above {
        0 => String::new(),
        n => format!(", {n} outside"),
    };
    writeln!(f, "  {quantity:<11} {low:6.2} |{}| {high:.2}{unit}{outside}", histogram.bars())
}

fn recording_text(recording: &RecordingReport) -> String {
    let mut out = format!("{}\n", recording.name);
    let mut line = |text: String| {
        out.push_str("  ");
        out.push_str(&text);
        out.push('\n');
    };
    if let Some(reason) = &recording.excluded {
        line(format!("excluded: {reason}"));
    }
    for remark in &recording.remarks {
        line(remark.text.clone());
    }
    let robot = recording.streams.iter().find(|stream| stream.stream == StreamRole::Robot);
    for stream in &recording.streams {
        line(stream_text(stream, robot));
    }
    line(format!("force: {}", recording.force_zero));
    for [start, end] in &recording.pauses_s {
        line(format!("cut at a pause of the log from {start:.3} to {end:.3} s"));
    }
    if recording.passes > 0 {
        line(format!(
            "set aside: {} times the object passes under the tip or is carried past it",
            recording.passes
        ));
    }
    for push in &recording.pushes {
        line(push_text(push));
    }
    out
}

/// One stream; `robot` is the one whose start the others are compared with.
fn stream_text(stream: &StreamReport, robot: Option<&StreamReport>) -> String {
    let rate = stream.rate_hz.map_or_else(String::new, |rate| format!(" at {rate:.0} Hz"));
    // Fewer than nine tenths of the samples are worth a word.
    let missing = stream.samples_due.filter(|due| 10 * stream.samples_read < 9 * due);
    let due = missing.map_or_else(String::new, |due| format!(" ({due} were due)"));
    let step_back = 1e3 * stream.largest_step_back_s;
    let order = match (step_back > 0.0, stream.kept_row_order) {
        (false, _) => String::new(),
        (true, true) => format!("; stamps run back by up to {step_back:.1} ms, kept in row order"),
        (true, false) => format!("; stamps run back by up to {step_back:.1} ms, sorted"),
    };
    let early_ms = robot.map_or(0.0, |robot| 1e3 * (robot.span_s[0] - stream.span_s[0]));
    let start = match early_ms.round() {
        ms if ms.abs() < 5.0 => String::new(),
        ms if ms > 0.0 => format!("; begins {ms} ms before the robot stream"),
        ms => format!("; begins {} ms after the robot stream", -ms),
    };
    format!(
        "{}: {} of {} samples{due}{rate}, longest gap {:.0} ms; {}{order}{start}",
        stream.stream,
        stream.samples_used,
        stream.samples_read,
        1e3 * stream.longest_gap_s,
        or_none(&counts(stream.repairs.iter()))
    )
}

fn push_text(push: &PushReport) -> String {
    let fate = match &push.excluded {
        Some(reason) => format!("excluded: {reason}"),
        None => format!("{} rows", push.rows),
    };
    let force = |what: &str, force: Option<f64>| {
        force.map_or_else(String::new, |force| format!(", {what} {force:.2} N"))
    };
    let contact = push.first_contact.map_or_else(String::new, |first| {
        format!(
            ", edge {} p {:.3} β {:.1}° at {:.0} mm/s",
            first.edge,
            first.p,
            first.beta_rad.to_degrees(),
            1e3 * first.speed_m_s
        )
    });
    let lost = if push.contact_lost { ", lost while the pusher goes on" } else { "" };
    format!(
        "push {}: {fate}; contact {:.3} to {:.3} s{lost}, rest at {:.3} s{contact}{}{}{}",
        push.push,
        push.contact_start_s,
        push.contact_end_s,
        push.rest_s,
        force("steady", push.steady_force_n),
        force("peak", push.peak_force_n),
        force("left at rest", push.resting_force_n)
    )
}

fn counts<'a>(repairs: impl Iterator<Item = (&'a RepairKind, &'a u32)>) -> String {
    repairs.map(|(kind, n)| format!("{n} {}", kind.name())).collect::<Vec<_>>().join(", ")
}

fn or_none(text: &str) -> &str {
    if text.is_empty() { "none" } else { text }
}

impl RepairKind {
    /// The finding in words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NonFinite => "not finite",
            Self::Backward => "backward",
            Self::Duplicate => "duplicate",
            Self::Crowded => "crowded",
            Self::Repeated => "repeated",
            Self::Wrap => "wrap of yaw",
            Self::Jump => "jump",
            Self::Teleport => "impossible jump",
            Self::Gap => "gap",
            Self::Isolated => "isolated",
        }
    }
}

impl UntaredReason {
    /// The reason in a few words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NeverFree => "never free",
            Self::ZeroJumps { .. } => "zero jumps",
            Self::Pulls { .. } => "contact would pull",
            Self::Blind => "sees no contact",
        }
    }
}

impl fmt::Display for ForceZero {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoForce => f.write_str("not recorded"),
            Self::Tared { offset_n: [x, y], noise_sd_n, n_samples } => write!(
                f,
                "zero ({x:.3}, {y:.3}) N subtracted, noise {noise_sd_n:.3} N, from {n_samples} free samples"
            ),
            Self::Untared { reason } => match reason {
                UntaredReason::NeverFree => {
                    f.write_str("untared: the pusher is never free; geometry alone decides")
                }
                UntaredReason::ZeroJumps { change_n } => {
                    write!(
                        f,
                        "untared: the zero changes by {change_n:.2} N while the pusher is free"
                    )
                }
                UntaredReason::Pulls { normal_n } => {
                    write!(f, "untared: the object would pull the pusher by {:.2} N", -normal_n)
                }
                UntaredReason::Blind => {
                    f.write_str("untared: no force is seen while the pusher moves the object")
                }
            },
        }
    }
}

impl Exclusion {
    /// The reason in a few words.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Unreadable { .. } => "unreadable",
            Self::NoOverlap => "no overlap",
            Self::NoContact { .. } => "no contact",
            Self::NoMotion => "no motion",
            Self::TooFewObjectSamples { .. } => "too few object samples",
            Self::GapInContact { .. } => "gap in contact",
            Self::Teleport { .. } => "impossible jump",
            Self::Tilted { .. } => "tilted",
            Self::OtherShape { .. } => "other shape",
            Self::NoWay { .. } => "no way of the pusher",
            Self::TrackingFlip { .. } => "tracking flip",
            Self::NoStep { .. } => "no step",
        }
    }
}

impl fmt::Display for Exclusion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable { error } => f.write_str(error),
            Self::NoOverlap => f.write_str("pusher and object were never seen at the same time"),
            Self::NoContact { smallest_gap_m: Some(gap) } => {
                write!(f, "the pusher comes no nearer than {:.1} mm", 1e3 * gap)
            }
            Self::NoContact { smallest_gap_m: None } => f.write_str("the pusher never touches"),
            Self::NoMotion => f.write_str("the object stays where it is"),
            Self::TooFewObjectSamples { found, needed } => {
                write!(f, "{found} object samples in contact, {needed} are needed")
            }
            Self::GapInContact { share, limit, longest_s } => write!(
                f,
                "{:.0} % of the contact is in gaps (limit {:.0} %), the longest {:.0} ms",
                100.0 * share,
                100.0 * limit,
                1e3 * longest_s
            ),
            Self::Teleport { way_m } => {
                write!(f, "the object jumps by {:.1} mm faster than anything moves", 1e3 * way_m)
            }
            Self::Tilted { tilt_rad, limit_rad } => write!(
                f,
                "the object is tilted by {:.1}° (limit {:.1}°)",
                tilt_rad.to_degrees(),
                limit_rad.to_degrees()
            ),
            Self::OtherShape { shape, object, pushes } => {
                write!(f, "{pushes} pushes of {shape}, the set is about {object}")
            }
            Self::NoWay { points } => write!(
                f,
                "the pusher's way has {points} points and does not move; give it in tip.csv, or in \
                 the columns tip_x0_m to tip_y1_m"
            ),
            Self::TrackingFlip { turn_rad, moved_m, way_m } => write!(
                f,
                "the object turns by {:.1}° and moves by {:.1} mm while the pusher goes {:.1} mm \
                 from its first to its last touch, which no contact does",
                turn_rad.to_degrees(),
                1e3 * moved_m,
                1e3 * way_m
            ),
            Self::NoStep { contact_s, lost_in_gaps } => write!(
                f,
                "no step in {:.0} ms of contact, {lost_in_gaps} lost in gaps",
                1e3 * contact_s
            ),
        }
    }
}
