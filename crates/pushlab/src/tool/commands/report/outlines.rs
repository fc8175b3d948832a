//! Mean residual motion on the outline of the object.

use ::report::{
    Anchor, Arrows, Color, Drawing, Figure, Hover, LegendPlace, Note, Panel, Points, Polygon,
    ReportError, Section,
};
use diagnosis::{MapSettings, OutlineCell, OutlineMap};
use planar::Shape;

use super::measure::Measure;
use super::{Report, tag};

/// A stretch is a small part of the outline, and few pushes reach it.
pub(super) const SETTINGS: MapSettings =
    MapSettings { fewest_steps: 6, fewest_pushes: 3, n_flips: 0, seed: 0 };
/// The longest arrow, in radii of the object.
const LONGEST: f64 = 0.55;
/// Corners of a drawn ellipse.
const CORNERS: usize = 96;
/// Up to so many edges are numbered.
const MOST_NUMBERED: usize = 12;

pub(super) fn section(report: &Report) -> Result<Section, ReportError> {
    let largest = report
        .models
        .iter()
        .flat_map(|model| &model.outlines)
        .flat_map(|map| &map.cells)
        .map(|cell| cell.mean[0].hypot(cell.mean[1]))
        .fold(0.0, f64::max);
    let mut drawings = Vec::new();
    for (index, model) in report.models.iter().enumerate() {
        for map in model.outlines.iter().filter(|map| !map.cells.is_empty()) {
            drawings.push(drawing(&format!("{} {}", tag(index), model.name), map, largest)?);
        }
    }
    let section = Section::new("outline", "On the outline").text(
        "Where the pusher touches, arrows show how the object moves beyond what is predicted: the \
         mean of observed less predicted over a step. Colors tell the sense of the error of turn, \
         dots its size.",
    );
    Ok(if drawings.is_empty() {
        section.text("No stretch of the outline has steps of enough pushes.")
    } else {
        section.drawings(drawings)
    })
}

/// The senses of a turn error with their colors.
const SENSES: [(&str, Color); 3] = [
    ("turn error counter-clockwise", Color::VERMILION),
    ("turn error clockwise", Color::BLUE),
    ("turn error within its interval", Color::GRAY),
];

fn sense(cell: &OutlineCell) -> usize {
    match cell.mean[2] {
        turn if turn > cell.half95[2] => 0,
        turn if -turn > cell.half95[2] => 1,
        _ => 2,
    }
}

fn drawing(name: &str, map: &OutlineMap, largest: f64) -> Result<Drawing, ReportError> {
    let shape = map.object.shape();
    let per = Measure::of("m").per;
    let radius = per * shape.bounding_radius();
    let outline: Vec<[f64; 2]> =
        shape.outline(CORNERS).iter().map(|corner| [per * corner.x, per * corner.y]).collect();
    let scale = LONGEST * radius / largest.max(f64::MIN_POSITIVE);
    let mut panel = Panel::new("x of the body in mm", "y of the body in mm")
        .equal_aspect()
        .legend(LegendPlace::Below)
        .with(Polygon::new(&outline).fill(Color::GRAY, 0.12));
    for (edge, at) in edge_labels(shape, per) {
        panel = panel.with(Note::new(at, &format!("edge {edge}")).anchor(Anchor::Middle));
    }
    let strongest =
        map.cells.iter().map(|cell| cell.mean[2].abs()).fold(f64::MIN_POSITIVE, f64::max);
    for (index, (label, color)) in SENSES.iter().enumerate() {
        let cells: Vec<_> = map.cells.iter().filter(|cell| sense(cell) == index).collect();
        if cells.is_empty() {
            continue;
        }
        let at = |cell: &&OutlineCell| [per * cell.contact_b.x, per * cell.contact_b.y];
        let tails: Vec<_> = cells.iter().map(at).collect();
        let vectors: Vec<_> = cells.iter().map(|cell| [cell.mean[0], cell.mean[1]]).collect();
        let arrows = Arrows::new(&tails, &vectors).scale(scale).color(*color).width(1.8);
        panel = panel.with(arrows.label(label)).with_all(cells.iter().map(|cell| {
            let size = 1.5 + 4.0 * (cell.mean[2].abs() / strongest).sqrt();
            Points::at(&[at(cell)]).radius(size).color(*color)
        }));
    }
    let mut hover = Hover::new();
    for cell in &map.cells {
        let at = [per * cell.contact_b.x, per * cell.contact_b.y];
        hover = hover.disc(at, 8.0, &text(cell));
    }
    let reference = Measure::of("m").text(largest);
    let foot = [-1.15 * radius, -1.3 * radius];
    panel = panel
        .with(Arrows::new(&[foot], &[[largest, 0.0]]).scale(scale))
        .with(Note::new([foot[0] + LONGEST * radius, foot[1]], &reference).offset(6.0, -4.0))
        .with(hover);
    let figure = Figure::new(1, 1).panel_size(330.0, 370.0).named(name).with(panel);
    Drawing::new(&figure, &format!("{name}: the longest arrow of all is {reference} a step."))
}

/// Numbers inside the edges.
fn edge_labels(shape: &Shape, per: f64) -> Vec<(usize, [f64; 2])> {
    let n = shape.n_edges();
    if n == 1 || n > MOST_NUMBERED {
        return Vec::new();
    }
    let inside = 0.22 * shape.bounding_radius();
    let label = |edge: usize| {
        let at = shape.point_at(edge, 0.5) + inside * shape.inward_normal_at(edge, 0.5);
        (edge, [per * at.x, per * at.y])
    };
    (0..n).map(label).collect()
}

fn text(cell: &OutlineCell) -> String {
    let [x, y, turn] = [0, 1, 2].map(|k| {
        let unit = if k == 2 { "rad" } else { "m" };
        Measure::of(unit).plus_minus(cell.mean[k], cell.half95[k])
    });
    format!(
        "edge {}\nx {x}\ny {y}\nturn {turn}\n{} steps of {} pushes",
        cell.edge, cell.n_steps, cell.n_pushes
    )
}
