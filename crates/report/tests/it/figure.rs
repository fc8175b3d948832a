//! Laws of whole figures: size, determinism, files and errors.

use std::path::Path;

use report::{
    Axis, Bars, Color, Data, Figure, Grid, HeatMap, LegendPlace, Line, Panel, Points, ReportError,
    Space, Surface, Table,
};

fn line() -> Panel {
    Panel::new("time in s", "force in N").with(Line::new(&[0.0, 1.0], &[2.0, 3.0]).label("a & <b>"))
}

fn heavy() -> Figure {
    let walk: Vec<f64> = (0..5_000).map(|i| (f64::from(i) * 12.9898).sin() * 43.7).collect();
    let index: Vec<f64> = (0..5_000).map(f64::from).collect();
    let bowl = |u: f64, v: f64| [u, v, (u - 0.5).powi(2) + (v - 0.5).powi(2)];
    let grid = Grid::sample((0.0, 1.0), (0.0, 1.0), 200, 200, |x, y| x * y);
    Figure::new(2, 2)
        .with(Panel::new("i", "value in m").with(Points::new(&index, &walk).opacity(0.3)))
        .with(Panel::new("i", "value in m").with(Line::new(&index, &walk)))
        .with(Panel::new("x in m", "y in m").with(HeatMap::new(grid, "product in m²")))
        .with(Space::new("x in m", "y in m", "z in m²").with(Surface::parametric(80, 80, bowl)))
}

#[test]
fn svg_is_valid_xml_and_stays_light_whatever_is_in_it() {
    for figure in [heavy(), Figure::single(line())] {
        let svg = figure.svg().unwrap();
        let document = roxmltree::Document::parse(&svg).unwrap();
        assert!(svg.len() < 300_000, "{}", svg.len());
        let attributes = document.descendants().flat_map(|node| node.attributes());
        for attribute in attributes.filter(|attribute| attribute.name() != "href") {
            let value = attribute.value();
            assert!(!value.contains("NaN") && !value.contains("inf"), "{value}");
        }
    }
}

#[test]
fn one_legend_says_each_thing_once() {
    let two = || Figure::new(1, 2).with(line()).with(line());
    let count = |figure: Figure| figure.svg().unwrap().matches("a &amp; &lt;b&gt;").count();
    assert_eq!((count(two()), count(two().one_legend())), (2, 1));
}

#[test]
fn a_legend_below_a_narrow_panel_stays_in_the_picture() {
    let panel = ["object at the start", "at the end, measured", "pusher's center", "object"]
        .into_iter()
        .fold(
            Panel::new("x in m", "y in m").legend(LegendPlace::Below).equal_aspect(),
            |panel, name| panel.with(Line::new(&[0.0, 1.0], &[0.0, 20.0]).label(name)),
        );
    let svg = Figure::single(panel).svg().unwrap();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    let left: Vec<f64> = texts.filter_map(|text| text.attribute("x")?.parse().ok()).collect();
    // A swatch of 24 px and its distance are before each name.
    assert!(left.len() > 4 && left.iter().all(|x| *x > 0.0), "{left:?}");
    let lines = document.descendants().filter(|node| node.has_tag_name("path"));
    let starts = lines.filter_map(|line| {
        let (x, _) = line.attribute("d")?.strip_prefix('M')?.split_once([' ', ','])?;
        x.parse::<f64>().ok()
    });
    let starts: Vec<f64> = starts.collect();
    assert!(!starts.is_empty() && starts.iter().all(|x| *x >= 0.0), "{starts:?}");
}

#[test]
fn a_name_is_for_readers_and_not_in_the_picture() {
    let svg = Figure::single(line()).named("force profile").svg().unwrap();
    assert_eq!(svg.matches("force profile").count(), 1);
    assert!(svg.contains("<title>force profile</title>"));
}

#[test]
fn a_convex_body_is_drawn_without_the_half_that_it_hides() {
    let ball = |u: f64, v: f64| {
        let ((a, b), (c, d)) =
            ((std::f64::consts::TAU * u).sin_cos(), (std::f64::consts::PI * (v - 0.5)).sin_cos());
        [b * d, a * d, c]
    };
    let paths = |surface: Surface| {
        let space = Space::new("x in m", "y in m", "z in m").with(surface);
        Figure::single(space).svg().unwrap().matches("<path").count()
    };
    let whole = Surface::parametric(40, 20, ball);
    let (all, seen) = (paths(whole.clone()), paths(whole.convex()));
    assert!(all > 800 && (350..450).contains(&(all - seen)), "{all} {seen}");
}

#[test]
fn labels_are_text_in_the_svg() {
    let svg = Figure::single(line()).svg().unwrap();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let texts: Vec<&str> = document.descendants().filter_map(|node| node.text()).collect();
    for label in ["time in s", "force in N", "a & <b>"] {
        assert!(texts.contains(&label), "{label}");
    }
}

#[test]
fn same_data_give_the_same_bytes() {
    assert_eq!(heavy().svg().unwrap(), heavy().svg().unwrap());
    assert_eq!(heavy().png().unwrap(), heavy().png().unwrap());
}

#[test]
fn png_is_at_least_1400_pixels_wide_and_twice_the_svg() {
    for (columns, width) in [(1, 1400), (3, 3 * 360 * 2)] {
        let mut figure = Figure::new(1, columns);
        for _ in 0..columns {
            figure = figure.with(line());
        }
        let png = figure.png().unwrap();
        assert_eq!(png[..8], *b"\x89PNG\r\n\x1a\n");
        assert_eq!(u32::from_be_bytes([png[16], png[17], png[18], png[19]]), width);
    }
}

#[test]
fn figure_leaves_three_whole_files_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let table: Data = Table::new().column("time in s", &[0.0, 1.0]).into();
    let inner = folder.path().join("made/here");
    let drawn = Figure::single(line()).write(&inner, "force", &table).unwrap();
    let mut names: Vec<String> = std::fs::read_dir(&inner)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names, ["force.csv", "force.png", "force.svg"]);
    assert_eq!(std::fs::read_to_string(drawn.path("svg")).unwrap(), drawn.svg());
    assert_eq!(std::fs::read_to_string(drawn.path("csv")).unwrap(), "time in s\n0.0\n1.0\n");
}

#[test]
fn bad_data_leave_no_file_behind() {
    let folder = tempfile::tempdir().unwrap();
    let table: Data = Table::new().column("time in s", &[f64::NAN]).into();
    let refused = Figure::single(line()).write(folder.path(), "force", &table);
    assert!(matches!(refused, Err(ReportError::NotFinite { .. })));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let table: Data = Table::new().column("x", &[0.0]).into();
    let refused = Figure::single(line()).write(&file.join("below"), "force", &table);
    assert!(matches!(refused, Err(ReportError::Write { .. })), "{refused:?}");
}

#[test]
fn names_that_do_not_fit_a_file_are_refused() {
    let table: Data = Table::new().column("x", &[0.0]).into();
    for name in ["", "../up", "a b", ".hidden", "a/b", "ä"] {
        let refused = Figure::single(line()).write(Path::new("/nowhere"), name, &table);
        assert!(matches!(refused, Err(ReportError::Name { .. })), "{name}");
    }
}

#[test]
fn empty_panels_and_full_grids_are_refused() {
    let empty = Figure::single(Panel::new("x", "y").title("lonely")).svg();
    assert!(matches!(empty, Err(ReportError::EmptyPanel { index: 0, .. })));
    assert!(matches!(Figure::new(1, 1).svg(), Err(ReportError::Panels { found: 0, .. })));
    let full = Figure::new(1, 1).with(line()).with(line()).svg();
    assert!(matches!(full, Err(ReportError::Panels { found: 2, .. })));
    let small = Figure::new(1, 1).panel_size(80.0, 60.0).with(line()).svg();
    assert!(matches!(small, Err(ReportError::TooSmall { .. })));
}

#[test]
fn logarithmic_axes_refuse_zero_and_marks_that_need_even_spacing() {
    let zero = Panel::new(Axis::new("n").log(), "y").with(Line::new(&[0.0, 1.0], &[1.0, 2.0]));
    let error = Figure::single(zero).svg();
    assert!(matches!(error, Err(ReportError::NotPositive { value: 0.0, .. })));
    let bars = Panel::new("x", Axis::new("y").log()).with(Bars::new(&[1.0], &[1.0], 0.5));
    assert!(matches!(Figure::single(bars).svg(), Err(ReportError::NeedsLinear { .. })));
}

#[test]
fn a_constant_and_a_single_point_can_be_drawn() {
    for y in [0.0, -3.0, 1e-12, 1e12] {
        let panel = Panel::new("x", "y").with(Points::new(&[5.0], &[y]).color(Color::GREEN));
        assert!(Figure::single(panel).svg().is_ok(), "{y}");
    }
}
