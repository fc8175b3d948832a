//! The names of the MIT objects.

/// The names of the eleven objects.
pub const MIT_NAMES: [&str; 11] = [
    "rect1", "rect2", "rect3", "tri1", "tri2", "tri3", "ellip1", "ellip2", "ellip3", "hex",
    "butter",
];
