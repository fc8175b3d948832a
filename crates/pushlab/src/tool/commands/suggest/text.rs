//! Suggested pushes in words.

use std::fmt;

use diagnosis::{Precision, Separation, SuggestedPush};

use super::Suggested;
use crate::tool::people::behind_number;
use crate::tool::terminal::TITLE;

/// A pair that is told apart so well is told by its likelihoods in 19 of 20 sets: 2Δlog L of 6 or
/// more, √6 + 1.64 standard deviations.
const ENOUGH: f64 = 4.1;

impl fmt::Display for Suggested {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { list, rig, aim, effects, n_feasible, suggestion } = self;
        let pushes = &suggestion.pushes;
        let mut different: Vec<&SuggestedPush> = Vec::new();
        for push in pushes {
            if !different.iter().any(|other| other.repeat == push.repeat) {
                different.push(push);
            }
        }
        different.sort_by(|a, b| a.repeat.cmp(&b.repeat));
        let groups: Vec<String> = effects.iter().map(|group| group.join(", ")).collect();
        let what = match *aim {
            "rivals" => format!("to tell apart {}", groups.join("; and ")),
            "precision" => format!("to measure {}", groups.join("; ")),
            _ => format!("to show {}, should it be there", groups.join("; ")),
        };
        writeln!(f, "{TITLE}{} pushes {what}{TITLE:#}", pushes.len())?;
        let n = different.len();
        writeln!(
            f,
            "  {n} different ones of {n_feasible} that can be done, repeated, in random order"
        )?;
        let [[x0, x1], [y0, y1]] = suggestion.area.map(|ends| ends.map(|end| 1e3 * end));
        writeln!(f, "  the object stays within x {x0:.0} to {x1:.0} mm, y {y0:.0} to {y1:.0} mm")?;
        write_separations(f, &suggestion.separations)?;
        write_precisions(f, &suggestion.precisions)?;
        writeln!(f, "{TITLE}times  edge  p      angle  speed    way    laid at{TITLE:#}")?;
        for push in different {
            let times = pushes.iter().filter(|other| other.repeat == push.repeat).count();
            write_push(f, push, times)?;
        }
        let list = list.display();
        let rig = rig.as_ref().map_or(String::new(), |rig| format!("--shape {} ", rig.display()));
        writeln!(
            f,
            "{TITLE}wrote {list}{TITLE:#}, for `pushlab generate {rig}--design {list} -o twin` and \
             robots"
        )
    }
}

fn write_separations(f: &mut fmt::Formatter<'_>, separations: &[Separation]) -> fmt::Result {
    for Separation { one, other, now, expected, with_random } in separations {
        writeln!(f, "{TITLE}{one} against {other}{TITLE:#}")?;
        let enough = match *expected >= ENOUGH {
            true => "enough for a name",
            false => "not enough for a name: repeat them more often",
        };
        writeln!(
            f,
            "  {now:.1} sd apart so far, {expected:.1} expected with these pushes, {enough}; \
             {with_random:.1} with as many random ones"
        )?;
    }
    Ok(())
}

fn write_precisions(f: &mut fmt::Formatter<'_>, precisions: &[Precision]) -> fmt::Result {
    for one in precisions {
        let unit = behind_number(&one.unit);
        writeln!(f, "{TITLE}{} {}{TITLE:#}", one.effect, one.name)?;
        writeln!(
            f,
            "  standard error {:.2e}{unit} so far, {:.2e} expected with these pushes; {:.2e} with as \
             many random ones",
            one.now, one.expected, one.with_random
        )?;
        let (now, then) = (one.detection_limit_now, one.detection_limit);
        let usual = one.usual;
        writeln!(
            f,
            "  would be found from {then:.2e}{unit} on ({now:.2e} so far); usual: {usual:.2e}"
        )?;
    }
    Ok(())
}

fn write_push(f: &mut fmt::Formatter<'_>, push: &SuggestedPush, times: usize) -> fmt::Result {
    let SuggestedPush { edge, p, angle, speed, travel, pose_wb, .. } = push;
    let (angle, speed, travel) = (angle.to_degrees(), 1e3 * speed, 1e3 * travel);
    let (x, y, theta) =
        (1e3 * pose_wb.position.x, 1e3 * pose_wb.position.y, pose_wb.angle.to_degrees());
    writeln!(
        f,
        "{times:>5}  {edge:>4}  {p:.3}  {angle:>5.1}°  {speed:>3.0} mm/s  {travel:.0} mm  \
         {x:.1}, {y:.1} mm, {theta:.1}°"
    )
}
