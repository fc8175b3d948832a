//! The rows that methods learn from, and those that they are scored on.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use faer::Mat;
use fixtures::surface::{surface, turn};

/// Rows of two inputs, an output, and what it is to be scored against.
pub(super) struct Task {
    pub(super) name: String,
    pub(super) n_training: usize,
    /// x0, x1, y, and the truth: y itself where none is known.
    rows: Vec<[f64; 4]>,
}

/// Rows that are scored on.
const N_TEST: usize = 2000;
const SEED: u64 = 7;

pub(super) fn surface_task(n: usize) -> Task {
    let (x, y) = surface(n + N_TEST, SEED);
    let row = |i: usize| [x[(i, 0)], x[(i, 1)], y[i], turn(x[(i, 0)], x[(i, 1)])];
    Task { name: "surface".into(), n_training: n, rows: (0..n + N_TEST).map(row).collect() }
}

/// The turn of measured pushes, in standard deviations, for several numbers of rows; whole runs are
/// learnt from or scored on.
pub(super) fn pushes(folder: &Path) -> Result<Vec<Task>> {
    let read = |name: &str| -> Result<Vec<Vec<f64>>> {
        let path = folder.join(name);
        let text =
            fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let row = |line: &str| line.split(',').map(|cell| Ok(cell.trim().parse()?)).collect();
        text.lines().skip(1).map(row).collect()
    };
    let (table, runs) = (read("table.csv")?, read("runs.csv")?);
    ensure!(table.len() == runs.len(), "table.csv and runs.csv differ in rows");
    let wide = table.iter().all(|row| row.len() > 4) && runs.iter().all(|row| row.len() > 2);
    ensure!(wide, "table.csv needs five columns, runs.csv three");
    let of = |is_test: bool| -> Vec<[f64; 4]> {
        let pairs = table.iter().zip(&runs).filter(|(_, run)| (run[2] == 0.0) == is_test);
        pairs.map(|(row, _)| [row[0], row[1], row[4], row[4]]).collect()
    };
    let (mut training, mut test) = (of(false), of(true));
    let n = training.len() as f64;
    let mean = training.iter().map(|row| row[2]).sum::<f64>() / n;
    let sd = (training.iter().map(|row| (row[2] - mean).powi(2)).sum::<f64>() / n).sqrt();
    for row in training.iter_mut().chain(&mut test) {
        row[2] = (row[2] - mean) / sd;
        row[3] = row[2];
    }
    // Rows of a run follow each other: every so many of them are of all runs.
    let some = |n: usize| (0..n).map(|i| training[i * training.len() / n]).collect::<Vec<_>>();
    let sizes = [100, 300, 1000, training.len()];
    let task = |n: usize| {
        let mut rows = some(n);
        rows.extend(&test);
        Task { name: "pushes".into(), n_training: n, rows }
    };
    Ok(sizes.into_iter().filter(|n| *n <= training.len()).map(task).collect())
}

impl Task {
    /// The number of training rows, then all rows, as little-endian 64-bit floats.
    pub(super) fn write(&self, path: &Path) -> Result<()> {
        let numbers =
            std::iter::once(self.n_training as f64).chain(self.rows.iter().flatten().copied());
        let bytes: Vec<u8> = numbers.flat_map(f64::to_le_bytes).collect();
        Ok(output::write(path, bytes)?)
    }
}

/// Training and test rows of a file.
pub(super) struct Rows {
    pub(super) x: Mat<f64>,
    pub(super) y: Vec<f64>,
    pub(super) truth: Vec<f64>,
    pub(super) n_training: usize,
}

pub(super) fn read(path: &Path) -> Result<Rows> {
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    ensure!(bytes.len() >= 8 && (bytes.len() - 8).is_multiple_of(32), "a file of another kind");
    let number = |at: &[u8]| f64::from_le_bytes(at.try_into().unwrap_or_default());
    let numbers: Vec<f64> = bytes.chunks_exact(8).map(number).collect();
    let n_training = numbers[0] as usize;
    let rows: Vec<&[f64]> = numbers[1..].chunks_exact(4).collect();
    ensure!(n_training < rows.len(), "{n_training} training rows of {}", rows.len());
    Ok(Rows {
        x: Mat::from_fn(rows.len(), 2, |i, d| rows[i][d]),
        y: rows.iter().map(|row| row[2]).collect(),
        truth: rows.iter().map(|row| row[3]).collect(),
        n_training,
    })
}

#[cfg(test)]
mod tests {
    use super::{pushes, read, surface_task};

    #[test]
    fn a_task_is_written_and_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.bin");
        surface_task(7).write(&path).unwrap();
        let rows = read(&path).unwrap();
        assert_eq!((rows.n_training, rows.y.len(), rows.x.nrows()), (7, 2007, 2007));
        assert!(rows.y.iter().zip(&rows.truth).all(|(y, truth)| (y - truth).abs() < 0.2));
        std::fs::write(&path, [1, 2, 3]).unwrap();
        assert!(read(&path).is_err());
    }

    #[test]
    fn whole_runs_are_scored_on() {
        let folder = tempfile::tempdir().unwrap();
        let table: String = (0..300).map(|i| format!("{i},0.5,1,2,{}\n", i % 7)).collect();
        let runs: String = (0..300).map(|i| format!("{i},{},{}\n", i / 2, i / 2 % 3)).collect();
        std::fs::write(folder.path().join("table.csv"), format!("c,phi,dx,dy,dt\n{table}"))
            .unwrap();
        std::fs::write(folder.path().join("runs.csv"), format!("row,run,fold\n{runs}")).unwrap();
        let tasks = pushes(folder.path()).unwrap();
        assert_eq!(tasks.iter().map(|task| task.n_training).collect::<Vec<_>>(), [100, 200]);
        assert!(tasks[1].rows[..200].iter().all(|row| !(row[0] as usize / 2).is_multiple_of(3)));
        assert!(pushes(&folder.path().join("none")).is_err());
    }
}
