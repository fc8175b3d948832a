//! The table of poses with their uncertainty.

use anyhow::Result;

use super::rolled::Rolled;

const HEADER: &str = "push,t_s,pusher_x_m,pusher_y_m,x_m,y_m,theta_rad,sd_x_m,sd_y_m,sd_theta_rad,\
                      cov_xy_m2,cov_xtheta_m_rad,cov_ytheta_m_rad,\
                      x_q025_m,x_q500_m,x_q975_m,y_q025_m,y_q500_m,y_q975_m,\
                      theta_q025_rad,theta_q500_rad,theta_q975_rad,\
                      pushed,touched,at_vertex,lost,unseen,\
                      measured_x_m,measured_y_m,measured_theta_rad\n";

/// One line a push and moment; what was not measured is empty.
///
/// # Errors
/// None that memory does not make.
pub(super) fn table(rolled: &[Rolled]) -> Result<Vec<u8>> {
    let mut bytes = HEADER.as_bytes().to_vec();
    let mut table = csv::Writer::from_writer(&mut bytes);
    for one in rolled {
        for (index, moment) in one.moments.iter().enumerate() {
            let (mean, covariance) = (moment.pose_wb.mean, moment.pose_wb.covariance);
            let mut numbers = vec![moment.time, moment.pusher_w[0], moment.pusher_w[1]];
            numbers.extend(mean.iter());
            numbers.extend((0..3).map(|axis| covariance[(axis, axis)].max(0.0).sqrt()));
            numbers.extend([(0, 1), (0, 2), (1, 2)].map(|place| covariance[place]));
            let quantiles = &one.quantiles[index];
            numbers.extend((0..3).flat_map(|axis| quantiles.iter().map(move |q| q[axis])));
            let mut cells = vec![one.name.clone()];
            cells.extend(numbers.iter().map(f64::to_string));
            let events = moment.events;
            let counts =
                [events.pushed, events.touched, events.at_vertex, events.lost, events.unseen];
            cells.extend(counts.iter().map(usize::to_string));
            cells.extend(match one.measured_wb.as_ref().and_then(|measured| measured[index]) {
                Some(pose) => {
                    [pose.position.x, pose.position.y, pose.angle].map(|value| value.to_string())
                }
                None => [const { String::new() }; 3],
            });
            table.write_record(&cells)?;
        }
    }
    drop(table);
    Ok(bytes)
}
