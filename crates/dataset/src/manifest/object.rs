//! The pushed object of a recording set: its outline, mass and moment, as the manifest states them.

use nalgebra::Vector2;
use planar::{Ellipse, MIT_NAMES, PlanarError, Polygon, Shape, mit_object};
use serde::Deserialize;
use serde_spanned::Spanned;

use crate::error::DatasetError;
use crate::manifest::text::Source;
use crate::table::column::MOST_EDGES;

/// Lengths outside of this, in m, are taken for another unit.
const SMALLEST_LENGTH: f64 = 1e-4;
const LARGEST_LENGTH: f64 = 10.0;

/// Which object a recording is about.
#[derive(Clone, Debug, PartialEq)]
pub enum ObjectChoice {
    /// One object for the whole set.
    Fixed(Box<ObjectSpec>),
    /// An object of the MIT set, named by `shape=…` in each recording's name.
    ByFileName,
}

/// An object as the manifest states it, in its body frame B.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectSpec {
    /// Name of the shape, for the table.
    pub name: String,
    /// The outline, in m.
    pub shape: Shape,
    /// Mass, in kg.
    pub mass: f64,
    /// Moment of inertia about the center of mass, in kg·m²; that of uniform density if not stated.
    pub moment_of_inertia: f64,
    /// Center of mass in the body frame, in m; the outline's centroid if not stated.
    pub center_of_mass: Vector2<f64>,
}

impl ObjectChoice {
    /// The object of one recording.
    ///
    /// # Errors
    /// `UnknownObject` if the name of the recording is to tell the shape and does not.
    pub fn of(&self, recording: &str) -> Result<ObjectSpec, PlanarError> {
        match self {
            Self::Fixed(object) => Ok((**object).clone()),
            Self::ByFileName => {
                let name = shape_in_name(recording)
                    .ok_or_else(|| PlanarError::UnknownObject { name: recording.to_owned() })?;
                ObjectSpec::mit(name)
            }
        }
    }
}

impl ObjectSpec {
    /// An object of the MIT set.
    ///
    /// # Errors
    /// `UnknownObject` for another name.
    pub fn mit(name: &str) -> Result<Self, PlanarError> {
        let object = mit_object(name)?;
        Ok(Self {
            name: object.name.to_owned(),
            center_of_mass: object.shape.centroid(),
            shape: object.shape,
            mass: object.mass,
            moment_of_inertia: object.moment_of_inertia,
        })
    }
}

/// The value of `shape=` in a recording's name, up to the next underscore.
pub(crate) fn shape_in_name(recording: &str) -> Option<&str> {
    recording.split('_').find_map(|part| part.strip_prefix("shape="))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectTable {
    shape: Spanned<String>,
    side_m: Option<Spanned<f64>>,
    width_m: Option<Spanned<f64>>,
    height_m: Option<Spanned<f64>>,
    vertices_m: Option<Spanned<Vec<[f64; 2]>>>,
    semi_axes_m: Option<Spanned<[f64; 2]>>,
    mass_kg: Option<Spanned<f64>>,
    moment_of_inertia_kg_m2: Option<Spanned<f64>>,
    center_of_mass_m: Option<Spanned<[f64; 2]>>,
    pub(super) support: Option<Spanned<String>>,
    pub(super) support_points_m: Option<Spanned<Vec<[f64; 2]>>>,
    pub(super) support_shares: Option<Spanned<Vec<f64>>>,
    pub(super) support_map: Option<Spanned<Vec<Vec<f64>>>>,
}

impl ObjectTable {
    pub(crate) fn check(&self, source: &Source<'_>) -> Result<ObjectChoice, DatasetError> {
        let name = self.shape.get_ref().as_str();
        let own_keys: &[&str] = match name {
            "square" => &["side_m"],
            "rectangle" => &["width_m", "height_m"],
            "polygon" => &["vertices_m"],
            "ellipse" => &["semi_axes_m"],
            "by-file-name" => &[],
            known if MIT_NAMES.contains(&known) => &[],
            other => return Err(unknown_shape(source, self.shape.span(), other)),
        };
        self.refuse_other_keys(own_keys, source)?;
        let known = if MIT_NAMES.contains(&name) { ObjectSpec::mit(name).ok() } else { None };
        let shape = match (name, &known) {
            ("by-file-name", _) => return self.by_file_name(source),
            (_, Some(object)) => object.shape.clone(),
            _ => self.shape(source)?,
        };
        let mass = match (&self.mass_kg, &known) {
            (Some(mass), _) => source.positive("object.mass_kg", mass, " kg")?,
            (None, Some(object)) => object.mass,
            (None, None) => {
                return Err(source.missing(self.shape.span(), "object.mass_kg", "a mass in kg"));
            }
        };
        let center_of_mass = self.center_of_mass(&shape, source)?;
        let moment_of_inertia = match (&self.moment_of_inertia_kg_m2, &known) {
            (Some(moment), _) => {
                source.positive("object.moment_of_inertia_kg_m2", moment, " kg·m²")?
            }
            (None, Some(object)) => object.moment_of_inertia * mass / object.mass,
            (None, None) => mass / shape.area() * shape.second_moment(&center_of_mass),
        };
        let name = name.to_owned();
        Ok(ObjectChoice::Fixed(Box::new(ObjectSpec {
            name,
            shape,
            mass,
            moment_of_inertia,
            center_of_mass,
        })))
    }

    /// The stated center of mass, or the outline's centroid.
    fn center_of_mass(
        &self,
        shape: &Shape,
        source: &Source<'_>,
    ) -> Result<Vector2<f64>, DatasetError> {
        let Some(center) = &self.center_of_mass_m else { return Ok(shape.centroid()) };
        let [x, y] = *center.get_ref();
        if shape.contains(&Vector2::new(x, y)) {
            return Ok(Vector2::new(x, y));
        }
        let (key, value) = ("object.center_of_mass_m", format!("[{x}, {y}]"));
        Err(source.refuse(center.span(), key, value, " m", "a point inside the outline"))
    }

    fn by_file_name(&self, source: &Source<'_>) -> Result<ObjectChoice, DatasetError> {
        let spans = [
            self.mass_kg.as_ref().map(|value| ("object.mass_kg", value.span())),
            self.moment_of_inertia_kg_m2
                .as_ref()
                .map(|value| ("object.moment_of_inertia_kg_m2", value.span())),
            self.center_of_mass_m.as_ref().map(|value| ("object.center_of_mass_m", value.span())),
        ];
        match spans.into_iter().flatten().next() {
            Some((key, span)) => {
                let allowed = "no value: the shape named by each file has its own";
                Err(source.refuse(span, key, "(given)", "", allowed))
            }
            None => Ok(ObjectChoice::ByFileName),
        }
    }

    fn refuse_other_keys(&self, own: &[&str], source: &Source<'_>) -> Result<(), DatasetError> {
        let number = |value: &Spanned<f64>| (value.span(), value.get_ref().to_string());
        let given = [
            ("side_m", self.side_m.as_ref().map(number)),
            ("width_m", self.width_m.as_ref().map(number)),
            ("height_m", self.height_m.as_ref().map(number)),
            ("vertices_m", self.vertices_m.as_ref().map(|v| (v.span(), "[…]".to_owned()))),
            (
                "semi_axes_m",
                self.semi_axes_m.as_ref().map(|v| (v.span(), format!("{:?}", v.get_ref()))),
            ),
        ];
        for (key, value) in given {
            if let Some((span, value)) = value.filter(|_| !own.contains(&key)) {
                let shape = self.shape.get_ref();
                let allowed = match own {
                    [] => format!("no dimensions for shape {shape}"),
                    _ => format!("only {} for shape {shape}", own.join(", ")),
                };
                return Err(source.refuse(span, &format!("object.{key}"), value, " m", allowed));
            }
        }
        Ok(())
    }

    fn shape(&self, source: &Source<'_>) -> Result<Shape, DatasetError> {
        let at = self.shape.span();
        let length = |key: &str, value: &Option<Spanned<f64>>| match value {
            Some(value) => check_length(source, key, *value.get_ref(), value.span()),
            None => Err(source.missing(at.clone(), key, "a length in m")),
        };
        match self.shape.get_ref().as_str() {
            "square" => {
                let side = length("object.side_m", &self.side_m)?;
                Shape::square(side).map_err(|e| refuse_shape(source, at, "object.side_m", &e))
            }
            "rectangle" => {
                let width = length("object.width_m", &self.width_m)?;
                let height = length("object.height_m", &self.height_m)?;
                Shape::rectangle(width, height)
                    .map_err(|e| refuse_shape(source, at, "object.width_m", &e))
            }
            "polygon" => {
                const KEY: &str = "object.vertices_m";
                let Some(vertices) = &self.vertices_m else {
                    return Err(source.missing(at, KEY, "points in m, counter-clockwise"));
                };
                let n_vertices = vertices.get_ref().len();
                if n_vertices > MOST_EDGES {
                    let (value, allowed) = (n_vertices, format!("at most {MOST_EDGES} vertices"));
                    return Err(source.refuse(vertices.span(), KEY, value, " vertices", allowed));
                }
                for &coordinate in vertices.get_ref().iter().flatten() {
                    if coordinate != 0.0 {
                        check_length(source, KEY, coordinate.abs(), vertices.span())?;
                    }
                }
                let points = vertices.get_ref().iter().map(|v| Vector2::new(v[0], v[1])).collect();
                Polygon::new(points)
                    .map(Shape::Polygon)
                    .map_err(|e| refuse_shape(source, vertices.span(), KEY, &e))
            }
            "ellipse" => {
                const KEY: &str = "object.semi_axes_m";
                let Some(axes) = &self.semi_axes_m else {
                    return Err(source.missing(at, KEY, "two lengths in m"));
                };
                let [a, b] = *axes.get_ref();
                check_length(source, KEY, a, axes.span())?;
                check_length(source, KEY, b, axes.span())?;
                Ellipse::new(a, b)
                    .map(Shape::Ellipse)
                    .map_err(|e| refuse_shape(source, axes.span(), KEY, &e))
            }
            other => Err(unknown_shape(source, at, other)),
        }
    }
}

fn unknown_shape(source: &Source<'_>, span: std::ops::Range<usize>, name: &str) -> DatasetError {
    let own = ["square", "rectangle", "polygon", "ellipse", "by-file-name"];
    let names: Vec<_> = own.into_iter().chain(MIT_NAMES).collect();
    source.refuse(span, "object.shape", name, "", format!("one of {}", names.join(", ")))
}

fn check_length(
    source: &Source<'_>,
    key: &str,
    value: f64,
    span: std::ops::Range<usize>,
) -> Result<f64, DatasetError> {
    if (SMALLEST_LENGTH..=LARGEST_LENGTH).contains(&value) {
        return Ok(value);
    }
    let allowed =
        format!("a length from {SMALLEST_LENGTH} to {LARGEST_LENGTH} m (lengths are in m, not mm)");
    Err(source.refuse(span, key, value, " m", allowed))
}

fn refuse_shape(
    source: &Source<'_>,
    span: std::ops::Range<usize>,
    key: &str,
    error: &PlanarError,
) -> DatasetError {
    source.refuse(span, key, "[…]", "", format!("a simple, counter-clockwise outline: {error}"))
}
