//! What every benchmark shares: interleaved timing, rows, the table and the JSON file.

mod report;
mod timing;
