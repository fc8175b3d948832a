//! Draws every mark and panel kind onto one page: `cargo run -p pushlab-report --example gallery -- OUT`.

use std::error::Error;
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};

use report::{
    Arrows, Axis, Band, Bars, BoxPlot, Claim, Color, ColorMap, Contours, Curve, Data, Ellipse,
    ErrorBars, Figure, Grid, Guide, HeatMap, Histogram, LegendPlace, Line, Note, Page, Panel,
    Plate, Points, Polygon, Provenance, Section, Space, SpatialArrows, Steps, Surface, Table,
    Verdict,
};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).map_or_else(|| "target/gallery".into(), PathBuf::from);
    let plates = [
        ("lines", "Lines, points, bands and bars.", lines()),
        ("fields", "Heat maps, contours and colored points.", fields()),
        ("geometry", "Outlines, ellipses, arrows and notes, drawn to scale.", geometry()),
        ("statistics", "Histograms, boxes, bars and steps.", statistics()),
        ("surfaces", "Surfaces in space with normals, curves and a wireframe.", surfaces()),
        ("cloud", "Twenty thousand points become one small picture.", cloud()),
    ];
    let mut section = Section::new("marks", "Every mark")
        .text("Each figure below was drawn from synthetic numbers by the example itself.");
    for (name, caption, (figure, data)) in plates {
        let drawn = figure.write(&folder, name, &data)?;
        section = section.figure(Plate::new(
            drawn,
            caption,
            "cargo run -p pushlab-report --example gallery",
        ));
    }
    page(section).write(&folder)?;
    println!("{}", folder.join("index.html").display());
    check_size(&folder)?;
    Ok(())
}

fn check_size(folder: &Path) -> Result<(), Box<dyn Error>> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        println!("{:>8} bytes  {}", entry.metadata()?.len(), entry.file_name().to_string_lossy());
    }
    Ok(())
}

fn page(section: Section) -> Page {
    let provenance = Provenance {
        tool: "report 0.1.0, example gallery".to_owned(),
        arguments: "gallery OUT".to_owned(),
        seed: Some(7),
        inputs: Vec::new(),
    };
    let claim = |claim: &str, value: &str, verdict, reason: &str| Claim {
        claim: claim.to_owned(),
        value: value.to_owned(),
        verdict,
        reason: reason.to_owned(),
    };
    let claims = vec![
        claim(
            "A decade is drawn equally long anywhere",
            "200 px",
            Verdict::Holds,
            "by construction",
        ),
        claim(
            "A scatter of 20 000 points stays vector",
            "0 points",
            Verdict::DoesNotHold,
            "above the size limit it is drawn as one picture",
        ),
        claim("Printed colors match", "", Verdict::NotTestable, "needs a printer"),
    ];
    Page::new("Gallery of marks", "What the figures of this workspace are made of.", provenance)
        .with(section)
        .with(Section::new("claims", "Claims").claims(claims).table(
            &["panel", "axes"],
            vec![vec!["Panel".into(), "two".into()], vec!["Space".into(), "three".into()]],
        ))
}

/// Repeatable noise about 0 with unit variance: sums of a linear congruential generator.
fn noise(n: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut uniform = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..n).map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0).collect()
}

fn span(low: f64, high: f64, n: usize) -> Vec<f64> {
    (0..n).map(|i| low + (high - low) * i as f64 / (n - 1) as f64).collect()
}

fn map(x: &[f64], f: impl Fn(f64) -> f64) -> Vec<f64> {
    x.iter().map(|&x| f(x)).collect()
}

fn lines() -> (Figure, Data) {
    let x = span(0.0, 2.0, 200);
    let mean = map(&x, |x| (3.0 * x).sin());
    let low = map(&x, |x| (3.0 * x).sin() - 0.1 - 0.2 * x);
    let high = map(&x, |x| (3.0 * x).sin() + 0.1 + 0.2 * x);
    let at = span(0.05, 1.4, 18);
    let scatter = noise(18, 3);
    let seen: Vec<f64> = at.iter().zip(&scatter).map(|(x, e)| (3.0 * x).sin() + 0.12 * e).collect();
    let posterior = Panel::new("contact position p", "Δx in mm")
        .title("Posterior and data")
        .with(Band::new(&x, &low, &high).label("±2 standard deviations"))
        .with(Line::new(&x, &mean).label("mean"))
        .with(
            Line::new(&x, &map(&x, |x| (2.8 * x).sin())).color(Color::GRAY).dashed().label("truth"),
        )
        .with(Points::new(&at, &seen).color(Color::VERMILION).label("pushes"));

    let data = Table::new()
        .column("x", &x)
        .column("mean", &mean)
        .column("low", &low)
        .column("high", &high);
    let figure = Figure::new(2, 2)
        .title("Lines and their kin")
        .with(posterior)
        .with(learning_curves())
        .with(force_profile())
        .with(small_numbers());
    (figure, data.into())
}

fn learning_curves() -> Panel {
    let n = [10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0];
    let curve = |floor: f64, slope: f64| map(&n, |n| floor + slope / n);
    Panel::new(Axis::new("training pushes").log(), Axis::new("normalized mean squared error").log())
        .title("Learning curves")
        .with(Guide::horizontal(0.12).dashed().label("analytical"))
        .with(Line::new(&n, &curve(0.03, 4.0)).label("GP"))
        .with(Points::new(&n, &curve(0.03, 4.0)))
        .with(ErrorBars::new(
            &n,
            &map(&curve(0.03, 4.0), |v| 0.8 * v),
            &map(&curve(0.03, 4.0), |v| 1.25 * v),
        ))
        .with(Line::new(&n, &curve(0.03, 0.7)).color(Color::VERMILION).label("hybrid"))
        .with(Points::new(&n, &curve(0.03, 0.7)).color(Color::VERMILION).hollow())
}

fn force_profile() -> Panel {
    let t = span(0.0, 3.0, 900);
    let jitter = noise(900, 11);
    let force: Vec<f64> = t
        .iter()
        .zip(&jitter)
        .map(|(t, e)| {
            0.06 * e
                + if (0.6..2.4).contains(t) { 2.05 + 0.9 * (-(t - 0.6) / 0.05).exp() } else { 0.0 }
        })
        .collect();
    Panel::new("time in s", Axis::new("normal force in N").range(-0.4, 3.4))
        .title("Force profile with the interval of contact found from force alone")
        .with(Guide::interval(0.6, 2.4).label("contact"))
        .with(Line::new(&t, &force).width(1.0).label("measured"))
        .with(Guide::horizontal(2.05).color(Color::VERMILION).dashed().label("μₛ m g = 2.05 N"))
        .with(Note::new([0.6, 2.9], "static peak").offset(10.0, -4.0))
}

fn small_numbers() -> Panel {
    let h = span(0.0, 4e-4, 50);
    Panel::new("step in m", "error in rad")
        .title("Small numbers")
        .legend(LegendPlace::BottomRight)
        .with(Line::new(&h, &map(&h, |h| 900.0 * h * h)).label("second order"))
        .with(Guide::vertical(2e-4).dashed())
}

fn fields() -> (Figure, Data) {
    let push = |p: f64, beta: f64| 4.0 * beta.cos() * (1.0 - 0.6 * (p - 0.5).powi(2));
    let residual = |p: f64, beta: f64| 0.4 * (TAU * p).sin() * (2.0 * beta).cos() - 0.1 * beta;
    let (p, beta) = ((0.0, 1.0), (-0.6, 0.6));
    let axes = || Panel::new("contact position p", "pushing angle β in rad");
    let grid = Grid::sample(p, beta, 60, 60, push);
    let smooth = axes()
        .title("Displacement")
        .with(HeatMap::new(grid.clone(), "Δx in mm"))
        .with(Contours::new(grid, &[3.2, 3.5, 3.8]).color(Color::WHITE));
    let signed = Grid::sample(p, beta, 12, 12, residual);
    let shown = (0..144).map(|i| i % 12 > 1 || i / 12 > 3).collect();
    let coarse = axes()
        .title("Residual, cells without data left out")
        .with(HeatMap::new(signed.mask(shown), "residual in mm").map(ColorMap::Diverging));
    let lines = axes().title("Numbered contours").with(
        Contours::new(
            Grid::sample(p, beta, 60, 60, residual),
            &[-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3],
        )
        .numbered()
        .color(Color::BLUE),
    );
    let (u, v, e) = (noise(400, 1), noise(400, 2), noise(400, 5));
    let (x, y) = (map(&u, |u| 0.5 + 0.15 * u), map(&v, |v| 0.2 * v));
    let value: Vec<f64> =
        x.iter().zip(&y).zip(&e).map(|((p, b), e)| push(*p, *b) + 0.02 * e).collect();
    let points = axes()
        .title("Points colored by value")
        .with(Points::new(&x, &y).radius(3.5).values(&value, ColorMap::Cividis, "Δx in mm"));
    let data = Table::new().column("p", &x).column("beta in rad", &y).column("dx in mm", &value);
    let figure = Figure::new(2, 2)
        .panel_size(400.0, 310.0)
        .with(smooth)
        .with(coarse)
        .with(lines)
        .with(points);
    (figure, data.into())
}

fn geometry() -> (Figure, Data) {
    let square = |x: f64, y: f64, turn: f64| -> Vec<[f64; 2]> {
        (0..4)
            .map(|i| turn + PI * (0.25 + 0.5 * f64::from(i)))
            .map(|a| [x + 0.064 * a.cos(), y + 0.064 * a.sin()])
            .collect()
    };
    let path = span(0.0, 1.0, 40);
    let track: Vec<[f64; 2]> = path.iter().map(|s| [0.16 * s, 0.02 * s * s]).collect();
    let world = Panel::new("x in m", "y in m")
        .title("A push in the world")
        .equal_aspect()
        .legend(LegendPlace::TopLeft)
        .with_all((0..5).map(|i| {
            let s = f64::from(i) / 4.0;
            let opacity = 0.05 + 0.2 * s;
            Polygon::new(&square(0.06 + 0.16 * s, 0.02 * s * s, 0.6 * s))
                .color(Color::GRAY)
                .fill(Color::BLUE, opacity)
        }))
        .with(Line::through(&track).color(Color::VERMILION).label("pusher"))
        .with(Ellipse::circle([0.16, 0.02], 0.005).fill(Color::VERMILION, 1.0))
        .with(Arrows::new(&[[0.0, 0.0]], &[[0.04, 0.0]]).label("velocity"))
        .with(Note::new([0.27, 0.07], "end").offset(6.0, 6.0));

    let tails: Vec<[f64; 2]> = (0..12)
        .flat_map(|i| (0..12).map(move |j| (i, j)))
        .map(|(i, j)| [-0.055 + 0.01 * f64::from(i), -0.055 + 0.01 * f64::from(j)])
        .collect();
    let field: Vec<[f64; 2]> = tails.iter().map(|[x, y]| [0.02 - y, x - 0.01]).collect();
    let motion = Panel::new("x in m", "y in m")
        .title("Velocity field about its COR")
        .equal_aspect()
        .with(Polygon::new(&square(0.0, 0.0, 0.0)).fill(Color::LIGHT, 0.6))
        .with(
            Arrows::new(&tails, &field).scale(0.12).width(1.1).color(Color::BLUE).label("velocity"),
        )
        .with(Points::at(&[[0.01, 0.02]]).radius(4.0).color(Color::VERMILION).label("COR"));

    let curve = Ellipse::new([0.0, 0.0], [2.05, 2.05], 0.0).label("limit curve");
    let angles = span(0.0, TAU, 13);
    let on: Vec<[f64; 2]> = angles[..12].iter().map(|a| [2.05 * a.cos(), 2.05 * a.sin()]).collect();
    let out: Vec<[f64; 2]> = angles[..12].iter().map(|a| [a.cos(), a.sin()]).collect();
    let limit = Panel::new("Fx in N", "Fy in N")
        .title("Limit curve and normals")
        .equal_aspect()
        .with(curve)
        .with(Arrows::new(&on, &out).scale(0.6).color(Color::VERMILION).label("velocity direction"))
        .with(
            Ellipse::of_covariance([0.3, -0.2], [0.3, 0.15, 0.2], 2.0)
                .color(Color::GREEN)
                .fill(Color::GREEN, 0.2)
                .dashed()
                .label("2σ of the samples"),
        );
    let x: Vec<f64> = track.iter().map(|p| p[0]).collect();
    let y: Vec<f64> = track.iter().map(|p| p[1]).collect();
    let figure = Figure::new(1, 3).panel_size(340.0, 330.0).with(world).with(motion).with(limit);
    (figure, Table::new().column("x in m", &x).column("y in m", &y).into())
}

fn statistics() -> (Figure, Data) {
    let (gp, plain) =
        (map(&noise(2000, 21), |e| 0.4 * e), map(&noise(2000, 22), |e| 0.3 + 0.8 * e));
    let histograms = Panel::new("error in mm", "density in 1/mm")
        .title("Errors")
        .with(Histogram::new(&plain, 40).range(-3.0, 3.0).color(Color::ORANGE).label("analytical"))
        .with(Histogram::new(&gp, 40).range(-3.0, 3.0).label("GP"))
        .with(Guide::vertical(0.0));
    let shapes = ["rect1", "rect2", "tri1", "ellip1", "butter"];
    let names: Vec<(f64, &str)> =
        shapes.iter().enumerate().map(|(i, name)| (i as f64, *name)).collect();
    let boxes = Panel::new(Axis::new("shape").names(&names), "error in mm")
        .title("Errors by shape")
        .with_all((0..5).map(|i| {
            BoxPlot::new(
                f64::from(i),
                &map(&noise(200, 40 + i as u64), |e| 1.0 + 0.2 * f64::from(i) + 0.3 * e),
                0.55,
            )
        }));
    let effects = ["table tilt", "pusher friction", "offset of the center of friction", "none"];
    let names: Vec<(f64, &str)> =
        effects.iter().enumerate().map(|(i, name)| (i as f64, *name)).collect();
    let bars = Panel::new(Axis::new("effect added").names(&names), "gain in nats")
        .title("Gain by effect")
        .with(
            Bars::new(&[0.0, 1.0, 2.0, 3.0], &[120.0, 45.0, 260.0, -8.0], 0.6).color(Color::GREEN),
        )
        .with(Guide::horizontal(0.0).color(Color::INK));
    let coverage = Panel::new(
        Axis::new("nominal coverage").range(0.0, 1.0),
        Axis::new("observed coverage").range(0.0, 1.0),
    )
    .title("Coverage")
    .equal_aspect()
    .with(Line::new(&[0.0, 1.0], &[0.0, 1.0]).color(Color::GRAY).dashed().label("ideal"))
    .with(
        Steps::new(&span(0.0, 1.0, 11), &map(&span(0.05, 0.95, 10), |x| x.powf(1.4)))
            .color(Color::PURPLE)
            .label("observed"),
    );
    let figure = Figure::new(2, 2).with(histograms).with(boxes).with(bars).with(coverage);
    (
        figure,
        serde_json::json!({ "effects": effects, "gain_nats": [120.0, 45.0, 260.0, -8.0] }).into(),
    )
}

fn sphere(u: f64, v: f64) -> [f64; 3] {
    let ((su, cu), (sv, cv)) = ((TAU * u).sin_cos(), (PI * (v - 0.5)).sin_cos());
    [cv * cu, cv * su, sv]
}

/// A wrench from one in units of the largest force and moment, in N and N·m.
fn scaled([x, y, z]: [f64; 3]) -> [f64; 3] {
    [2.05 * x, 2.05 * y, 0.08 * z]
}

fn load_space(title: &str) -> Space {
    Space::new("Fx in N", "Fy in N", "M in N·m").title(title)
}

fn surfaces() -> (Figure, Data) {
    let spots: Vec<[f64; 3]> = (0..6)
        .flat_map(|i| (1..4).map(move |j| sphere(f64::from(i) / 6.0, f64::from(j) / 4.0)))
        .collect();
    let tails: Vec<[f64; 3]> = spots.iter().map(|p| scaled(*p)).collect();
    let normals: Vec<[f64; 3]> = spots.iter().map(|p| scaled(p.map(|c| 0.35 * c))).collect();
    let ring: Vec<[f64; 3]> = span(0.0, 1.0, 80).iter().map(|u| scaled(sphere(*u, 0.62))).collect();
    let ellipsoid = load_space("Ellipsoid with normals")
        .with(Surface::parametric(48, 24, |u, v| scaled(sphere(u, v))).label("ellipsoid"))
        .with(SpatialArrows::new(&tails, &normals).label("normal"))
        .with(Curve::new(&ring).label("constant moment"));
    let unit = Space::new("x in m", "y in m", "z in m")
        .title("Drawn to scale, from below")
        .equal_aspect()
        .view(2.2, -0.4)
        .with(
            Surface::parametric(30, 15, |u, v| {
                let [x, y, z] = sphere(u, v);
                [2.0 * x, y, 0.7 * z]
            })
            .color(Color::PURPLE),
        );
    let figure = Figure::new(2, 2)
        .panel_size(400.0, 360.0)
        .with(ellipsoid)
        .with(two_surfaces())
        .with(polytope())
        .with(unit);
    let column = |i: usize| tails.iter().map(|p| p[i]).collect::<Vec<f64>>();
    let data = Table::new()
        .column("fx in N", &column(0))
        .column("fy in N", &column(1))
        .column("m in Nm", &column(2));
    (figure, data.into())
}

fn two_surfaces() -> Space {
    let bulging = |u, v| {
        let [x, y, z] = sphere(u, v);
        let norm = (x.powi(4) + y.powi(4) + z.powi(4)).powf(0.25);
        scaled([x / norm, y / norm, z / norm])
    };
    let outer = |u, v| scaled(sphere(u, v).map(|c| 1.12 * c));
    let ellipsoid = Surface::parametric(24, 12, outer).wireframe().color(Color::BLUE);
    load_space("A surface and a wireframe")
        .with(Surface::parametric(48, 24, bulging).color(Color::ORANGE).label("quartic"))
        .with(ellipsoid.label("ellipsoid"))
}

fn polytope() -> Space {
    let corners = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ]
    .map(scaled);
    let facets =
        [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]];
    let surface = Surface::triangles(&corners, &facets).edges().color(Color::GREEN);
    load_space("Facets and vertices").view(0.5, 0.3).with(surface.opacity(0.85))
}

fn cloud() -> (Figure, Data) {
    let (x, y) = (noise(20_000, 8), noise(20_000, 9));
    let bent: Vec<f64> = x.iter().zip(&y).map(|(x, y)| 0.5 * x * x + 0.6 * y).collect();
    let panel = Panel::new("final x in mm", "final y in mm")
        .title("Particles")
        .with(Points::new(&x, &bent).radius(1.6).opacity(0.25).label("20 000 particles"))
        .with(
            Ellipse::of_covariance([0.0, 0.5], [1.0, 0.0, 0.86], 2.0)
                .color(Color::VERMILION)
                .label("Gaussian, 2σ"),
        );
    (Figure::single(panel), Table::new().column("x in mm", &x).column("y in mm", &bent).into())
}
