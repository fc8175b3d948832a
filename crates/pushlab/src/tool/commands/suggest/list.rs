//! Suggested pushes as `pushlab generate --design` and robots read them.

use diagnosis::{SuggestedPush, Suggestion};
use planar::Pose;

use crate::tool::origin::Origin;

const HEADER: &str = "edge,p,angle_deg,speed_mm_s,travel_mm,x_mm,y_mm,theta_deg,repeat,\
                      start_x_mm,start_y_mm,touch_x_mm,touch_y_mm,end_x_mm,end_y_mm";

/// One push a line, in the order in which they are to be done.
pub(super) fn csv(suggestion: &Suggestion, origin: &Origin) -> String {
    let mut text = origin.comment();
    let radius = 1e3 * suggestion.pusher_radius;
    text += &format!(
        "# Lay the object's frame at x, y, theta; move the center of the tip (radius {radius:.3} mm) \
         straight from start over touch to end at speed. World frame.\n"
    );
    text += HEADER;
    text.push('\n');
    suggestion.pushes.iter().for_each(|push| text += &line(push));
    text
}

fn line(push: &SuggestedPush) -> String {
    let SuggestedPush { edge, p, angle, speed, travel, pose_wb, path_w, repeat } = push;
    let Pose { position, angle: theta } = pose_wb;
    let numbers = [angle.to_degrees(), 1e3 * speed, 1e3 * travel];
    let place = [1e3 * position.x, 1e3 * position.y, theta.to_degrees()];
    let round = |value: f64| {
        let rounded = format!("{value:.1}");
        if rounded == "-0.0" { "0.0".to_owned() } else { rounded }
    };
    let numbers: Vec<String> = numbers.into_iter().chain(place).map(round).collect();
    let path = path_w.iter().flat_map(|point| [1e3 * point.x, 1e3 * point.y]);
    let path: Vec<String> = path.map(|value| format!("{value:.2}")).collect();
    format!("{edge},{p:.3},{},{repeat},{}\n", numbers.join(","), path.join(","))
}
