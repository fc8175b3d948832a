//! Laws of pages with drawings and players: one file, no request, text stays text, same bytes.

use std::path::Path;

use report::{
    Cells, CellsOf, Color, ColoredCell, Drawing, Figure, Hover, Line, Page, Panel, PlayedPush,
    PlayedSteps, Player, PlayerAxis, PlayerNumber, Provenance, Region, ReportError, Section, Shown,
    Table,
};

const NASTY: &str = "</script><script>alert('1')</script> & \"2\" 🦀";

fn drawing() -> Drawing {
    let cell = |x: f64| ColoredCell { x: [x, x + 1.0], y: [0.0, 2.0], value: x - 0.5 };
    let panel = Panel::new("x in m", "y in m")
        .with(Cells::new(vec![cell(0.0), cell(1.0)], "error in mm"))
        .with(Line::new(&[0.0, 2.0], &[0.5, 1.5]).color(Color::GREEN))
        .with(Hover::new().cell_of([0.0, 0.0], [1.0, 2.0], NASTY, &[3]).disc(
            [1.5, 1.0],
            5.0,
            "a disc",
        ));
    let cells_of =
        CellsOf { models: vec![0], number: "turn".to_owned(), over: vec!["p".to_owned()] };
    let table = Table::new().names(NASTY, &[NASTY]);
    let drawing = Drawing::new(&Figure::single(panel).named(NASTY), NASTY);
    let drawing = drawing.and_then(|drawing| drawing.data(&table)).expect("the drawing is sound");
    drawing.cells_of(cells_of)
}

fn player() -> Player {
    let push = PlayedPush {
        name: NASTY.to_owned(),
        outline: 0,
        times: vec![0.0, 0.2],
        measured: vec![[0.1, 0.2, 0.3], [0.1, 0.21, 0.3]],
        pusher: vec![[0.0, 0.2], [0.0, 0.21]],
        predicted: vec![Some(vec![[0.1, 0.2, 0.3]; 2])],
        steps: PlayedSteps {
            times: vec![[0.0, 0.2]],
            cells: vec![vec![0]],
            observed: vec![vec![Some(0.1)]],
            residuals: vec![vec![vec![None]]],
        },
    };
    let number = PlayerNumber {
        key: "turn".to_owned(),
        name: NASTY.to_owned(),
        unit: NASTY.to_owned(),
        shown: Shown::Values,
    };
    let axis = PlayerAxis {
        key: "p".to_owned(),
        name: NASTY.to_owned(),
        short: NASTY.to_owned(),
        unit: NASTY.to_owned(),
        cells: vec![NASTY.to_owned()],
    };
    Player {
        pusher_radius: 0.005,
        models: vec![NASTY.to_owned()],
        outlines: vec![vec![[0.0, 0.0], [0.1, 0.0], [0.1, 0.1]]],
        axes: vec![axis],
        numbers: vec![number],
        pushes: vec![push],
        order: NASTY.to_owned(),
        groups_are: NASTY.to_owned(),
        groups: vec![vec![0]],
        limit: 1 << 20,
    }
}

fn html() -> String {
    let inputs = (0..20).map(|k| (format!("{NASTY} {k}"), "abc".to_owned())).collect();
    let provenance = Provenance { inputs, ..Provenance::default() };
    let about = Region {
        model: 0,
        number: NASTY.to_owned(),
        cells: vec![(NASTY.to_owned(), vec![3])],
        anchor: "map".to_owned(),
    };
    let section = Section::new("maps", NASTY)
        .list(vec![NASTY.to_owned()])
        .linked_list(vec![(NASTY.to_owned(), Some(about))])
        .drawings(vec![drawing().anchor("map").before(drawing().anchor("other"))])
        .folded_drawings(NASTY, vec![drawing(), drawing()])
        .player(player());
    Page::new(NASTY, NASTY, provenance).with(section).single_file().expect("the page is sound")
}

#[test]
fn text_from_outside_never_becomes_markup() {
    let html = html();
    assert!(!html.contains("<script>alert") && !html.contains("</script> &amp;"));
    // The data of the player, and each script of drawings and players once.
    assert_eq!(html.matches("<script").count(), 7);
    assert_eq!(html.matches("</script>").count(), 7);
    assert!(html.contains("\\u003c/script>") && html.contains('🦀'));
}

#[test]
fn the_page_asks_for_nothing_and_its_policy_forbids_it() {
    let html = html();
    let own = html.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http:", "https:", "//cdn", "@import", "url(", "src=", "<link", "fetch("] {
        assert!(!own.contains(outside), "{outside}");
    }
    assert!(html.contains("Content-Security-Policy\" content=\"default-src 'none'"));
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    assert_eq!(html(), html());
}

#[test]
fn every_element_that_opens_closes() {
    let html = html();
    for name in ["div", "figure", "svg", "details", "table", "section", "ul", "dl", "figcaption"] {
        let opened =
            html.matches(&format!("<{name}>")).count() + html.matches(&format!("<{name} ")).count();
        assert_eq!(opened, html.matches(&format!("</{name}>")).count(), "{name}");
    }
}

#[test]
fn dark_colors_know_every_color_of_a_drawing() {
    let css = include_str!("../../src/page.css");
    let dark = css.rsplit("@media screen").next().unwrap();
    let named = [Color::INK, Color::GRAY, Color::LIGHT, Color::BLUE, Color::VERMILION];
    for color in named.into_iter().chain([Color::GREEN, Color::PURPLE]) {
        let long = format!("#{:02x}{:02x}{:02x}", color.r, color.g, color.b);
        let short = format!("#{:x}{:x}{:x}", color.r % 16, color.g % 16, color.b % 16);
        let known = |hex: &str| dark.contains(&format!("[fill=\"{hex}\"]"));
        assert!(known(&long) || known(&short), "{long}");
    }
}

#[test]
fn hover_texts_are_in_the_drawing_and_not_in_files() {
    let html = html();
    assert_eq!(html.matches("class=\"spot\"").count(), 2 * 4);
    assert_eq!(html.matches("class=\"spot\" data-cell=\"3\" d=").count(), 4);
    assert!(html.contains("<title>a disc</title>"));
    assert!(html.contains("tabindex=\"0\" aria-roledescription"));
}

#[test]
fn cells_findings_and_numbers_of_drawings_are_there_for_scripts_and_without_them() {
    let html = html();
    let map = "id=\"map\" data-models=\"0\" data-number=\"turn\" data-over=\"p\"";
    assert_eq!(html.matches(map).count(), 1);
    assert!(html.contains("<a class=\"steps\" href=\"#map\" data-in=\"0/"));
    assert_eq!(html.matches("<div class=\"pair\" data-pair>").count(), 1);
    assert_eq!(html.matches("<pre hidden data-csv>").count(), 4);
    let twice = Section::new("a", "A").drawings(vec![drawing().anchor("a")]);
    let page = Page::new("t", "", Provenance::default()).with(twice);
    assert!(matches!(page.single_file(), Err(ReportError::Duplicate { .. })));
}

#[test]
fn a_figure_with_files_is_refused_on_a_page_without() {
    let folder = tempfile::tempdir().unwrap();
    let panel = Panel::new("x", "y").with(Line::new(&[0.0, 1.0], &[0.0, 1.0]));
    let data = report::Table::new().column("x", &[0.0]).into();
    let drawn = Figure::single(panel).write(folder.path(), "f", &data).unwrap();
    let section = Section::new("a", "A").figure(report::Plate::new(drawn, "c", "d"));
    let page = Page::new("t", "", Provenance::default()).with(section);
    assert!(matches!(page.single_file(), Err(ReportError::NotAlone { .. })));
    assert!(page.html(Path::new(folder.path())).is_ok());
}

#[test]
fn cells_and_hovers_that_cannot_be_drawn_are_refused() {
    let figure = |panel: Panel| Figure::single(panel).svg().map(|_| ());
    let panel = || Panel::new("x", "y");
    assert!(matches!(
        figure(panel().with(Cells::new(vec![], "e"))),
        Err(ReportError::Empty { .. })
    ));
    let cell = ColoredCell { x: [0.0, f64::NAN], y: [0.0, 1.0], value: 0.0 };
    let infinite = figure(panel().with(Cells::new(vec![cell], "e")));
    assert!(matches!(infinite, Err(ReportError::NotFinite { .. })));
    let flat = figure(panel().with(Hover::new().disc([0.0, 0.0], 0.0, "t")));
    assert!(matches!(flat, Err(ReportError::Parameter { field: "radius", .. })));
}
