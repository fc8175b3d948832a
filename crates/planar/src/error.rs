//! What can be wrong with a shape.

/// Why a shape was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanarError {
    /// A coordinate is NaN or infinite.
    #[error("vertex {index} is not finite: ({x}, {y}) m")]
    NotFinite {
        /// 0-based number of the vertex.
        index: usize,
        /// Its x coordinate, in m.
        x: f64,
        /// Its y coordinate, in m.
        y: f64,
    },
    /// A polygon with fewer than three vertices.
    #[error("a polygon needs at least 3 vertices, got {count}")]
    TooFewVertices {
        /// How many were given.
        count: usize,
    },
    /// Two neighboring vertices fall together.
    #[error(
        "edge {edge} has no length: vertices {edge} and the next are both at ({x}, {y}) m; remove one"
    )]
    EdgeWithoutLength {
        /// 0-based number of the edge.
        edge: usize,
        /// The x coordinate of both vertices, in m.
        x: f64,
        /// The y coordinate of both vertices, in m.
        y: f64,
    },
    /// The vertices run clockwise.
    #[error("the vertices run clockwise (signed area {area} m²); list them counter-clockwise")]
    Clockwise {
        /// The signed area, in m².
        area: f64,
    },
    /// The outline encloses no area.
    #[error(
        "the outline encloses no area (signed area {area} m² over a perimeter of {perimeter} m)"
    )]
    NoArea {
        /// The signed area, in m².
        area: f64,
        /// The perimeter, in m.
        perimeter: f64,
    },
    /// Two edges that are not neighbors cross or touch.
    #[error("edges {first} and {second} cross or touch; the outline must be simple")]
    SelfIntersection {
        /// 0-based number of one edge.
        first: usize,
        /// 0-based number of the other edge.
        second: usize,
    },
    /// A length that must be positive and finite is not.
    #[error("{name} must be positive and finite, got {value} m")]
    NotPositive {
        /// Which length.
        name: &'static str,
        /// What was given, in m.
        value: f64,
    },
    /// A name that is not one of the eleven objects.
    #[error("unknown object `{name}`; known are {}", crate::MIT_NAMES.join(", "))]
    UnknownObject {
        /// What was asked for.
        name: String,
    },
}
