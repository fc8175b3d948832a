//! Which observed steps are of use.

use dataset::Table;
use effects::Track;
use models::{ChannelObservation, ChannelSteps, Excluded, ExclusionReason};

use crate::data::clusters::numbered;
use crate::data::pose_jumps::after_jumps;

/// What is observed in a row, and its number.
type Known = (ChannelObservation, usize);

/// The steps whose pusher moves as is wanted, up to a jump of the pose in their push, with their rows.
pub(crate) fn kept(
    found: ChannelSteps,
    table: &Table,
    is_wanted: fn(&Track) -> bool,
) -> (Vec<ChannelObservation>, Vec<usize>, Excluded) {
    let ChannelSteps { steps, rows, mut excluded } = found;
    let mut keep = |known: Vec<Known>, is_kept: Vec<bool>, reason| {
        let mut is_kept = is_kept.into_iter();
        let (kept, others): (Vec<_>, Vec<_>) =
            known.into_iter().partition(|_| is_kept.next().unwrap_or(true));
        if !others.is_empty() {
            let rows = excluded.rows.entry(reason).or_default();
            rows.extend(others.into_iter().map(|(_, row)| row));
        }
        kept
    };
    let steps: Vec<Known> = steps.into_iter().zip(rows).collect();
    // A whole push begins and ends at rest, and is wanted whole.
    let moves =
        |(step, row): &Known| table.rows[*row].is_whole_push() || is_wanted(&step.input.track);
    let moves = steps.iter().map(moves).collect();
    let steps = keep(steps, moves, ExclusionReason::PusherAtRest);
    let push = |row: usize| (&table.rows[row].recording, table.rows[row].push);
    let pushes = numbered(steps.iter().map(|(_, row)| push(*row)));
    let jumps = after_jumps(pushes.into_iter().zip(steps.iter().map(|(step, _)| step)));
    let is_before = jumps.into_iter().map(|is_after| !is_after).collect();
    let steps = keep(steps, is_before, ExclusionReason::PoseJump);
    let (steps, rows) = steps.into_iter().unzip();
    (steps, rows, excluded)
}
