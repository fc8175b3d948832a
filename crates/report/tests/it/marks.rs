//! Laws that every mark and body obeys.

use report::{
    Arrows, Axis, Band, Bars, Body, BoxPlot, Contours, Curve, Ellipse, ErrorBars, Figure, Grid,
    Guide, HeatMap, Histogram, Line, Mark, Note, Panel, Points, Polygon, ReportError, Space,
    SpatialArrows, Steps, Surface,
};

/// A mark of every kind made from numbers near `v`, which NaN spoils.
fn marks(v: f64) -> Vec<Box<dyn Mark>> {
    let (x, y) = ([0.0, 1.0, 2.0], [1.0, v, 1.5]);
    let grid = || Grid::sample((0.0, 2.0), (0.0, 2.0), 6, 6, |x, y| x * y + v - 1.0);
    vec![
        Box::new(Line::new(&x, &y)),
        Box::new(Steps::new(&[0.0, 1.0, 2.0, 3.0], &y)),
        Box::new(Points::new(&x, &y)),
        Box::new(ErrorBars::new(&x, &[0.5, 0.5, 0.5], &y)),
        Box::new(Band::new(&x, &[0.5, 0.5, 0.5], &y)),
        Box::new(Arrows::new(&[[0.5, 0.5]], &[[1.0, v]])),
        Box::new(Polygon::new(&[[0.5, 0.5], [1.5, 0.5], [1.0, v]])),
        Box::new(Ellipse::new([1.0, v], [0.5, 0.3], 0.4)),
        Box::new(Histogram::new(&y, 4)),
        Box::new(Bars::new(&x, &y, 0.5)),
        Box::new(BoxPlot::new(1.0, &y, 0.5)),
        Box::new(HeatMap::new(grid(), "value in m")),
        Box::new(Contours::new(grid(), &[1.0])),
        Box::new(Note::new([1.0, v], "note")),
        Box::new(Guide::horizontal(v)),
    ]
}

fn bodies(v: f64) -> Vec<Box<dyn Body>> {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, v]];
    vec![
        Box::new(Surface::triangles(&corners, &[[0, 1, 2]])),
        Box::new(Surface::triangles(&corners, &[[0, 1, 2]]).wireframe()),
        Box::new(Curve::new(&corners)),
        Box::new(SpatialArrows::new(&[[0.0; 3]], &[[0.5, 0.5, v]])),
    ]
}

/// A mark handed on, so that a list of kinds can be added to panels.
#[derive(Debug)]
struct Boxed(Box<dyn Mark>);

impl Mark for Boxed {
    fn name(&self) -> String {
        self.0.name()
    }
    fn check(&self) -> Result<(), ReportError> {
        self.0.check()
    }
    fn extent(&self) -> report::Extent {
        self.0.extent()
    }
    fn draw(&self, canvas: &mut report::Canvas<'_>) {
        self.0.draw(canvas);
    }
}

#[derive(Debug)]
struct BoxedBody(Box<dyn Body>);

impl Body for BoxedBody {
    fn name(&self) -> String {
        self.0.name()
    }
    fn check(&self) -> Result<(), ReportError> {
        self.0.check()
    }
    fn points(&self) -> Vec<[f64; 3]> {
        self.0.points()
    }
    fn pieces(&self, view: &report::View) -> Vec<report::Piece> {
        self.0.pieces(view)
    }
}

/// A figure on fixed axes, so that only the mark itself can change the picture.
fn with_mark(mark: Option<Box<dyn Mark>>) -> Figure {
    let axis = || Axis::new("value in m").range(-1.0, 4.0);
    let panel = Panel::new(axis(), axis()).with(Guide::horizontal(-0.9));
    Figure::single(match mark {
        Some(mark) => panel.with(Boxed(mark)),
        None => panel,
    })
}

fn with_body(body: Option<Box<dyn Body>>) -> Figure {
    let axis = || Axis::new("value in m").range(-1.0, 2.0);
    let space = Space::new(axis(), axis(), axis()).with(Curve::new(&[[-1.0; 3], [-0.9; 3]]));
    Figure::single(match body {
        Some(body) => space.with(BoxedBody(body)),
        None => space,
    })
}

#[test]
fn every_mark_changes_both_pictures() {
    let empty = (with_mark(None).svg().unwrap(), with_mark(None).png().unwrap());
    for mark in marks(1.2) {
        let name = mark.name();
        let figure = with_mark(Some(mark));
        assert_ne!(figure.svg().unwrap(), empty.0, "{name}");
        assert_ne!(figure.png().unwrap(), empty.1, "{name}");
    }
    let empty = (with_body(None).svg().unwrap(), with_body(None).png().unwrap());
    for body in bodies(1.2) {
        let name = body.name();
        let figure = with_body(Some(body));
        assert_ne!(figure.svg().unwrap(), empty.0, "{name}");
        assert_ne!(figure.png().unwrap(), empty.1, "{name}");
    }
}

#[test]
fn every_mark_refuses_values_that_are_not_finite_and_says_where() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for mark in marks(value) {
            let error = with_mark(Some(mark)).svg().unwrap_err();
            assert!(matches!(error, ReportError::NotFinite { .. }), "{error}");
        }
        for body in bodies(value) {
            let error = with_body(Some(body)).svg().unwrap_err();
            assert!(matches!(error, ReportError::NotFinite { .. }), "{error}");
        }
    }
    let line = Line::new(&[0.0, 1.0], &[1.0, f64::NAN]).label("GP");
    let error = line.check().unwrap_err().to_string();
    assert_eq!(error, "line `GP`: y[1] is NaN; remove or mask it before drawing");
}

#[test]
fn every_mark_without_data_is_refused() {
    let empty: [Box<dyn Mark>; 9] = [
        Box::new(Line::new(&[], &[])),
        Box::new(Steps::new(&[0.0], &[])),
        Box::new(Points::new(&[], &[])),
        Box::new(ErrorBars::new(&[], &[], &[])),
        Box::new(Band::new(&[], &[], &[])),
        Box::new(Arrows::new(&[], &[])),
        Box::new(Polygon::new(&[])),
        Box::new(Histogram::new(&[], 3)),
        Box::new(BoxPlot::new(0.0, &[], 1.0)),
    ];
    for mark in empty {
        assert!(matches!(mark.check(), Err(ReportError::Empty { .. })), "{}", mark.name());
    }
}

#[test]
fn lengths_that_differ_are_refused() {
    let marks: [Box<dyn Mark>; 6] = [
        Box::new(Line::new(&[0.0, 1.0], &[0.0])),
        Box::new(Steps::new(&[0.0, 1.0], &[0.0, 1.0])),
        Box::new(Band::new(&[0.0, 1.0], &[0.0, 1.0], &[0.0])),
        Box::new(Arrows::new(&[[0.0; 2]], &[])),
        Box::new(Bars::new(&[0.0, 1.0], &[0.0], 1.0)),
        Box::new(HeatMap::new(Grid::new((0.0, 1.0), (0.0, 1.0), 2, 2, vec![0.0; 3]), "m")),
    ];
    for mark in marks {
        assert!(matches!(mark.check(), Err(ReportError::Length { .. })), "{}", mark.name());
    }
}

#[test]
fn parameters_out_of_range_are_refused() {
    let bad_facet = Surface::triangles(&[[0.0; 3]], &[[0, 0, 1]]);
    assert!(matches!(bad_facet.check(), Err(ReportError::Parameter { .. })));
    for mark in [Ellipse::new([0.0; 2], [1.0, 0.0], 0.0), Ellipse::circle([0.0; 2], -1.0)] {
        assert!(matches!(mark.check(), Err(ReportError::Parameter { .. })));
    }
    let no_bins = Histogram::new(&[1.0], 0);
    assert!(matches!(no_bins.check(), Err(ReportError::Parameter { .. })));
}

#[test]
fn covariance_ellipse_has_the_semi_axes_of_its_eigenvalues() {
    let ellipse = Ellipse::of_covariance([0.0; 2], [2.5, 1.5, 2.5], 2.0);
    let extent = ellipse.extent();
    // The bounding box of a covariance ellipse reaches n·√variance along each axis.
    let reach = 2.0 * 2.5f64.sqrt();
    for (low, high) in [extent.x.unwrap(), extent.y.unwrap()] {
        assert!((high - reach).abs() < 5e-3 && (low + reach).abs() < 5e-3, "{low} {high}");
    }
}
