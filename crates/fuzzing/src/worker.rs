//! A process that reads damaged inputs one after the other, until one of them ends it.

use std::fs::{self, File};
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use super::case::{Fault, judge, remember_panics};
use super::memory;
use super::mutate::case;
use super::reader::{Reader, Verdict};

/// File in a worker's folder with the number of the case that it is at.
pub(super) const AT: &str = "at";
/// Folder in a worker's folder that readers write to.
const FILES: &str = "files";
/// Folder in a worker's folder that the corpus is made in.
const CORPUS: &str = "corpus";

/// What a worker has to do.
#[derive(Clone, Debug)]
pub(super) struct Order {
    pub(super) seed: u64,
    /// First case, and how many to the next.
    pub(super) first: u64,
    pub(super) stride: u64,
    /// Case to stop before.
    pub(super) end: u64,
    pub(super) seconds: f64,
}

/// What a worker did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Tally {
    pub(super) cases: u64,
    pub(super) accepted: u64,
    /// Time in the reader and for making its inputs, in s.
    pub(super) busy: f64,
    /// Longest time of a case, in s.
    pub(super) slowest: f64,
    /// That case.
    pub(super) slowest_case: u64,
}

impl Tally {
    pub(super) fn add(&mut self, other: &Self) {
        self.cases += other.cases;
        self.accepted += other.accepted;
        self.busy += other.busy;
        if other.slowest > self.slowest {
            (self.slowest, self.slowest_case) = (other.slowest, other.slowest_case);
        }
    }

    /// As a worker prints it.
    fn line(&self) -> String {
        let Self { cases, accepted, busy, slowest, slowest_case } = self;
        format!("tally\t{cases}\t{accepted}\t{busy}\t{slowest}\t{slowest_case}")
    }

    /// From what a worker printed.
    pub(super) fn parse(line: &str) -> Option<Self> {
        let mut cells = line.strip_prefix("tally\t")?.split('\t');
        Some(Self {
            cases: cells.next()?.parse().ok()?,
            accepted: cells.next()?.parse().ok()?,
            busy: cells.next()?.parse().ok()?,
            slowest: cells.next()?.parse().ok()?,
            slowest_case: cells.next()?.parse().ok()?,
        })
    }
}

/// A failure as a worker prints it, and back.
pub(super) fn fault_line(case: u64, fault: &Fault) -> String {
    format!("fault\t{case}\t{}\t{}", fault.kind, fault.place)
}

pub(super) fn parse_fault(line: &str) -> Option<(u64, Fault)> {
    let mut cells = line.strip_prefix("fault\t")?.splitn(3, '\t');
    let case = cells.next()?.parse().ok()?;
    let kind = cells.next()?.parse().ok()?;
    Some((case, Fault { kind, place: cells.next()?.to_owned() }))
}

/// The inputs that cases are made from.
///
/// Those that were kept are not among them: a case would be another one after each that is kept.
pub(super) fn corpus(reader: &dyn Reader, dir: &Path) -> Result<Vec<Vec<u8>>> {
    let folder = dir.join(CORPUS);
    fs::create_dir_all(&folder)?;
    reader.corpus(&folder).with_context(|| format!("the corpus of {}", reader.name()))
}

/// Reads cases until the time or the cases end; prints each new failure, and the tally at the end.
///
/// # Errors
/// If the corpus cannot be made, or its valid inputs are not accepted.
pub(super) fn work(reader: &dyn Reader, dir: &Path, order: &Order) -> Result<()> {
    let corpus = corpus(reader, dir)?;
    let files = dir.join(FILES);
    fs::create_dir_all(&files)?;
    let mut at = File::create(dir.join(AT))?;
    memory::limit()?;
    remember_panics();
    let mut known: Vec<Fault> = Vec::new();
    let mut tally = Tally::default();
    let start = Instant::now();
    let time = Duration::from_secs_f64(order.seconds);
    let mut index = order.first;
    let mut now = start;
    while index < order.end && now - start < time {
        at.seek(SeekFrom::Start(0))?;
        at.write_all(&index.to_le_bytes())?;
        let input = case(reader.name(), order.seed, index, &corpus, reader.tokens());
        match judge(reader, &files, &input) {
            Ok(verdict) => tally.accepted += u64::from(verdict == Verdict::Accepted),
            Err(fault) if known.iter().any(|other| other.is_like(&fault)) => {}
            Err(fault) => {
                println!("{}", fault_line(index, &fault));
                known.push(fault);
            }
        }
        let end = Instant::now();
        let took = (end - now).as_secs_f64();
        tally.add(&Tally { cases: 1, accepted: 0, busy: took, slowest: took, slowest_case: index });
        now = end;
        index = index.saturating_add(order.stride);
    }
    println!("{}", tally.line());
    Ok(())
}

/// Reads one input; prints its failure if there is one.
///
/// # Errors
/// If the worker's folder cannot be used, or the corpus cannot be made.
pub(super) fn replay(reader: &dyn Reader, dir: &Path, input: &[u8]) -> Result<()> {
    // As where all cases are read: what is reserved for good by then does not count.
    corpus(reader, dir)?;
    let files = dir.join(FILES);
    fs::create_dir_all(&files)?;
    File::create(dir.join(AT))?.write_all(&0_u64.to_le_bytes())?;
    memory::limit()?;
    remember_panics();
    if let Err(fault) = judge(reader, &files, input) {
        println!("{}", fault_line(0, &fault));
    }
    println!("{}", Tally { cases: 1, ..Tally::default() }.line());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::case::{Fault, Kind};
    use super::{Tally, fault_line, parse_fault};

    #[test]
    fn what_a_worker_prints_is_read_back() {
        let tally = Tally { cases: 7, accepted: 3, busy: 0.25, slowest: 0.125, slowest_case: 4 };
        assert_eq!(Tally::parse(&tally.line()), Some(tally));
        assert_eq!(Tally::parse("something else"), None);
        let fault = Fault { kind: Kind::Wrong, place: "x is NaN\tat 1".to_owned() };
        assert_eq!(parse_fault(&fault_line(9, &fault)), Some((9, fault)));
    }
}
