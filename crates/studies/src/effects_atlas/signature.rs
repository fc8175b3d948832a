//! What an effect changes, over (p, β), speed and orientation.

use std::f64::consts::TAU;
use std::sync::Arc;

use anyhow::Result;
use effects::{Channel, Channels, Effect, Object, PushPhysics, Rig, StepInput, Surface, Track};
use nalgebra::Vector2;
use planar::{Pose, Shape, Twist, perpendicular};
use report::{Axis, Color, ColorMap, Figure, Grid, HeatMap, LegendPlace, Line, Panel};

/// Each channel's name, its unit for people, that unit's size in SI, and a sensor's standard deviation.
const CHANNELS: [(&str, &str, f64, f64); 7] = [
    ("Δx", "mm", 1e-3, 3e-5),
    ("Δy", "mm", 1e-3, 3e-5),
    ("Δθ", "°", TAU / 360.0, 1.4e-3),
    ("fn", "N", 1.0, 0.05),
    ("ft", "N", 1.0, 0.05),
    ("gap at start", "mm", 1e-3, 1e-4),
    ("gap at end", "mm", 1e-3, 1e-4),
];
/// Cells of a map along each side.
const CELLS: usize = 24;
/// Changes below this many standard deviations are not drawn as lines.
const SEEN: f64 = 0.02;
/// Parameters that a title has room for.
const MOST_SHOWN: usize = 6;
const RADIUS: f64 = 0.00475;
const WAY: f64 = 0.01;
const SLOW: f64 = 0.02;

const QUARTERS: [(f64, &str); 5] =
    [(0.0, "0"), (90.0, "90"), (180.0, "180"), (270.0, "270"), (360.0, "360")];

/// One push of the atlas.
#[derive(Clone, Copy)]
struct Shot {
    p: f64,
    beta: f64,
    speed: f64,
    angle: f64,
}

struct Atlas {
    object: Arc<Object>,
    without: PushPhysics,
    with: PushPhysics,
}

/// Two maps and two sets of lines.
pub(super) fn figure(effect: &Arc<dyn Effect>) -> Result<Figure> {
    let atlas = Atlas::new(effect)?;
    let changes = (0..CELLS * CELLS).map(|cell| atlas.change(&shot_of_cell(cell), true));
    let changes: Vec<_> = changes.collect::<Result<_>>()?;
    let [first, second] = strongest(&changes);
    let size = |cell: &usize| {
        changes[*cell].iter().zip(CHANNELS).map(|(x, (.., sd))| (x / sd).powi(2)).sum::<f64>()
    };
    // The lines are for the push that shows the effect most.
    let cells = (0..changes.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
    let shot = shot_of_cell(cells.unwrap_or(0));
    let about = effect.info();
    let values: Vec<_> = (about.parameters.iter().zip(about.typical(atlas.without.rig())))
        .map(|(parameter, value)| match parameter.unit {
            "1" => format!("{} {value}", parameter.name),
            unit => format!("{} {value} {unit}", parameter.name),
        })
        .collect();
    let values = if values.len() > MOST_SHOWN { String::new() } else { values.join(", ") };
    let colon = if values.is_empty() { "" } else { ": " };
    Ok(Figure::new(2, 2)
        .title(&format!("{}{colon}{values}", about.title))
        .panel_size(350.0, 280.0)
        .with(map(&changes, first))
        .with(map(&changes, second))
        .with(atlas.over_speed(shot)?)
        .with(atlas.over_orientation(shot)?))
}

fn shot_of_cell(cell: usize) -> Shot {
    let share = |index: usize| (index as f64 + 0.5) / CELLS as f64;
    let (p, beta) = (share(cell % CELLS), 1.2 * (share(cell / CELLS) - 0.5));
    Shot { p, beta, speed: SLOW, angle: 0.0 }
}

/// The two channels with the largest changes, in standard deviations; the gap at most once.
fn strongest(changes: &[[f64; 7]]) -> [usize; 2] {
    let size = |channel: usize| {
        changes.iter().map(|change| (change[channel] / CHANNELS[channel].3).powi(2)).sum::<f64>()
    };
    let mut order: Vec<usize> = (0..7).collect();
    order.sort_by(|a, b| size(*b).total_cmp(&size(*a)));
    let is_gap = |channel: usize| Channels::KINDS[channel] == Channel::Gap;
    let second = order.iter().skip(1).find(|other| !(is_gap(order[0]) && is_gap(**other)));
    [order[0], *second.unwrap_or(&order[1])]
}

fn map(changes: &[[f64; 7]], channel: usize) -> Panel {
    let (name, unit, scale, _) = CHANNELS[channel];
    let value = |cell: usize| changes[cell][channel] / scale;
    let largest = (0..changes.len()).map(|cell| value(cell).abs()).fold(0.0, f64::max);
    // A channel that does not change is drawn as such, not as rounding.
    let reach = if largest < 1e-6 { 1.0 } else { largest };
    let values = (0..changes.len()).map(value).collect();
    let grid = Grid::new((0.0, 1.0), (-0.6, 0.6), CELLS, CELLS, values);
    Panel::new("place p", "angle β in rad").title(&format!("change of {name}")).with(
        HeatMap::new(grid, &format!("{name} in {unit}"))
            .map(ColorMap::Diverging)
            .range(-reach, reach),
    )
}

impl Atlas {
    fn new(effect: &Arc<dyn Effect>) -> Result<Self> {
        let shape = Arc::new(Shape::square(0.09)?);
        let without = PushPhysics::new(Rig::new(Surface::Ellipsoid, 0.25, 0.25)?);
        let values = effect.info().typical(without.rig());
        let with = without.clone().with(effect, &values)?;
        Ok(Self { object: Arc::new(Object::uniform(shape, 0.8374)?), without, with })
    }

    /// What the effect changes in every channel, in SI units.
    fn change(&self, shot: &Shot, is_pushed: bool) -> Result<[f64; 7]> {
        let step = self.step(shot, is_pushed)?;
        let (with, without) = (self.with.predict(&step)?, self.without.predict(&step)?);
        let (with, without) = (Channels::to_array(&with), Channels::to_array(&without));
        Ok(std::array::from_fn(|channel| with[channel] - without[channel]))
    }

    /// A push at the left edge, or the tenth of a second after it.
    fn step(&self, shot: &Shot, is_pushed: bool) -> Result<StepInput> {
        let (edge, shape) = (1, self.object.shape());
        let pose_wb = Pose::new(0.2, 0.1, shot.angle);
        let normal = shape.inward_normal_at(edge, shot.p);
        let start = pose_wb.transform_point(&(shape.point_at(edge, shot.p) - RADIUS * normal));
        let direction: Vector2<f64> =
            pose_wb.rotate(&Pose::new(0.0, 0.0, shot.beta).rotate(&normal));
        let straight = |way: f64| {
            let track = Track::straight(start, start + way * direction, way / shot.speed);
            StepInput {
                object: self.object.clone(),
                pusher_radius: RADIUS,
                pose_wb,
                twist_wb: Twist::default(),
                track,
                touching: true,
                since_contact: 1.0,
                run_up: None,
                progress: 1.0,
                session: 0,
            }
        };
        // The object moves already at the start of the step, as the quasi-static push would have it.
        let short = straight(1e-6);
        let moved = self.without.predict(&short)?;
        let linear = moved.dx * direction + moved.dy * perpendicular(&direction);
        let twist = Twist { linear, angular: moved.dtheta };
        let twist_wb = (1.0 / short.track.duration()) * twist;
        if is_pushed {
            return Ok(StepInput { twist_wb, ..straight(WAY) });
        }
        let track = Track::straight(start, start, 0.1);
        Ok(StepInput { twist_wb, track, touching: false, ..short })
    }

    fn over_speed(&self, shot: Shot) -> Result<Panel> {
        let speeds: Vec<f64> = (0..21).map(|k| 0.01 * 50_f64.powf(f64::from(k) / 20.0)).collect();
        let shots = speeds.iter().map(|&speed| Shot { speed, ..shot });
        let speeds_mm_s: Vec<f64> = speeds.iter().map(|speed| 1e3 * speed).collect();
        let panel = self.lines(Axis::new("speed in mm/s").log(), &speeds_mm_s, shots.clone())?;
        let slides: Vec<f64> = shots
            .map(|shot| Ok(self.change(&shot, false)?[0] / CHANNELS[0].3))
            .collect::<Result<_>>()?;
        let is_seen = slides.iter().any(|slide| slide.abs() > SEEN);
        let line = || Line::new(&speeds_mm_s, &slides).color(Color::GRAY).dashed();
        Ok(if is_seen { panel.with(line().label("Δx after the stop")) } else { panel })
    }

    fn over_orientation(&self, shot: Shot) -> Result<Panel> {
        let degrees: Vec<f64> = (0..37).map(|k| 10.0 * f64::from(k)).collect();
        let shots = degrees.iter().map(|angle| Shot { angle: angle.to_radians(), ..shot });
        self.lines(Axis::new("orientation in °").names(&QUARTERS), &degrees, shots)
    }

    fn lines(&self, x: Axis, at: &[f64], shots: impl Iterator<Item = Shot>) -> Result<Panel> {
        let shots: Vec<_> = shots.collect();
        let changes =
            shots.iter().map(|shot| self.change(shot, true)).collect::<Result<Vec<_>>>()?;
        let title = format!("p = {:.2}, β = {:.2} rad", shots[0].p, shots[0].beta);
        let mut panel = Panel::new(x, "change in sensor sd")
            .title(&title)
            .legend(LegendPlace::Below)
            .with(Line::new(&[at[0], at[at.len() - 1]], &[0.0, 0.0]).color(Color::LIGHT));
        for (channel, (name, _, _, sd)) in CHANNELS.iter().enumerate() {
            let line: Vec<f64> = changes.iter().map(|change| change[channel] / sd).collect();
            // The gap at the start repeats that at the end, but for steps that begin a push.
            if channel != 5 && line.iter().any(|value| value.abs() > SEEN) {
                let color = Color::cycle(if channel == 6 { 5 } else { channel });
                panel = panel.with(Line::new(at, &line).color(color).label(name));
            }
        }
        Ok(panel)
    }
}
