//! What an object rests on, as the manifest states it.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector2;
use planar::Shape;
use serde_spanned::Spanned;

use crate::error::DatasetError;
use crate::manifest::object::{ObjectChoice, ObjectTable};
use crate::manifest::text::Source;

/// What an object rests on, and by which limit surface a nominal model has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum ObjectSupport {
    /// Its whole face, by the ellipsoid of uniform pressure: the thesis' approximation.
    #[default]
    Ellipsoid,
    /// Its whole face, by the exact surface of uniform pressure.
    Patch,
    /// Points.
    Points {
        /// In m, body frame B.
        places: Vec<Vector2<f64>>,
        /// Of the weight, together 1; those of statics where they are not stated.
        shares: Option<Vec<f64>>,
    },
    /// The cells of a grid over the outline's bounding box: shares of the weight, together 1, by rows from
    /// the smallest y, each from the smallest x.
    Map {
        /// 25 of five rows.
        shares: Vec<f64>,
    },
}

const KINDS: [&str; 4] = ["ellipsoid", "patch", "points", "map"];
const N_POINTS: std::ops::RangeInclusive<usize> = 3..=6;
/// Rows and columns of a map.
const SIDE: usize = 5;
/// Shares as people round them: 0.333 three times is a whole.
const ROUNDED: f64 = 2e-3;
/// Of an angle, in rad: a center on the line between two points is between them.
const STRAIGHT: f64 = 1e-6;

/// The keys of `[object]` about what the object rests on.
struct SupportKeys<'a> {
    kind: &'a Option<Spanned<String>>,
    points: &'a Option<Spanned<Vec<[f64; 2]>>>,
    shares: &'a Option<Spanned<Vec<f64>>>,
    map: &'a Option<Spanned<Vec<Vec<f64>>>>,
}

impl ObjectSupport {
    /// What the keys of a table say of an object.
    pub(crate) fn of(
        table: &ObjectTable,
        object: &ObjectChoice,
        source: &Source<'_>,
    ) -> Result<Self, DatasetError> {
        let ObjectTable { support, support_points_m, support_shares, support_map, .. } = table;
        let (kind, points) = (support, support_points_m);
        SupportKeys { kind, points, shares: support_shares, map: support_map }.check(object, source)
    }
}

impl SupportKeys<'_> {
    fn check(
        &self,
        object: &ObjectChoice,
        source: &Source<'_>,
    ) -> Result<ObjectSupport, DatasetError> {
        let kind = self.kind.as_ref().map_or(KINDS[0], |kind| kind.get_ref().as_str());
        for (key, span, of) in [
            ("object.support_points_m", self.points.as_ref().map(Spanned::span), "points"),
            ("object.support_shares", self.shares.as_ref().map(Spanned::span), "points"),
            ("object.support_map", self.map.as_ref().map(Spanned::span), "map"),
        ] {
            if let Some(span) = span.filter(|_| kind != of) {
                let allowed = format!("no value, or support = \"{of}\" beside it");
                return Err(source.refuse(span, key, "(given)", "", allowed));
            }
        }
        let Some(stated) = &self.kind else { return Ok(ObjectSupport::default()) };
        match (kind, object) {
            ("ellipsoid", _) => Ok(ObjectSupport::Ellipsoid),
            ("patch", _) => Ok(ObjectSupport::Patch),
            ("points" | "map", ObjectChoice::ByFileName) => {
                let allowed = "ellipsoid or patch: with by-file-name objects differ";
                Err(source.refuse(stated.span(), "object.support", kind, "", allowed))
            }
            ("points", ObjectChoice::Fixed(object)) => {
                let places = self.places(&object.shape, stated, source)?;
                let shares = self.shares_of(places.len(), source)?;
                if shares.is_none() && !is_between(&object.center_of_mass, &places) {
                    let (key, center) = ("object.support_points_m", object.center_of_mass);
                    let value = format!("points about no [{}, {}]", center.x, center.y);
                    let allowed = "points with the center of mass between them, or support_shares";
                    let span = self.points.as_ref().map_or(stated.span(), Spanned::span);
                    return Err(source.refuse(span, key, value, " m", allowed));
                }
                Ok(ObjectSupport::Points { places, shares })
            }
            ("map", ObjectChoice::Fixed(_)) => self.cells(stated, source),
            _ => {
                let allowed = format!("one of {}", KINDS.join(", "));
                Err(source.refuse(stated.span(), "object.support", kind, "", allowed))
            }
        }
    }

    fn places(
        &self,
        shape: &Shape,
        kind: &Spanned<String>,
        source: &Source<'_>,
    ) -> Result<Vec<Vector2<f64>>, DatasetError> {
        const KEY: &str = "object.support_points_m";
        let Some(points) = self.points else {
            return Err(source.missing(kind.span(), KEY, "three to six points [x, y] in m"));
        };
        let n_points = points.get_ref().len();
        if !N_POINTS.contains(&n_points) {
            let allowed = "three to six points [x, y]";
            return Err(source.refuse(points.span(), KEY, n_points, " points", allowed));
        }
        let place = |[x, y]: &[f64; 2]| {
            let place = Vector2::new(*x, *y);
            if shape.contains(&place) {
                return Ok(place);
            }
            let allowed = "points inside the outline (in m, not mm)";
            Err(source.refuse(points.span(), KEY, format!("[{x}, {y}]"), " m", allowed))
        };
        points.get_ref().iter().map(place).collect()
    }

    fn shares_of(
        &self,
        n_points: usize,
        source: &Source<'_>,
    ) -> Result<Option<Vec<f64>>, DatasetError> {
        const KEY: &str = "object.support_shares";
        let Some(shares) = self.shares else { return Ok(None) };
        let n_shares = shares.get_ref().len();
        if n_shares != n_points {
            let allowed = format!("one for each of the {n_points} points");
            return Err(source.refuse(shares.span(), KEY, n_shares, " shares", allowed));
        }
        whole(shares.get_ref().clone(), KEY, shares.span(), source).map(Some)
    }

    fn cells(
        &self,
        kind: &Spanned<String>,
        source: &Source<'_>,
    ) -> Result<ObjectSupport, DatasetError> {
        const KEY: &str = "object.support_map";
        let allowed = "five rows, from the smallest y, of five shares, from the smallest x";
        let Some(map) = self.map else {
            return Err(source.missing(kind.span(), KEY, allowed));
        };
        let rows = map.get_ref();
        if rows.len() != SIDE || rows.iter().any(|row| row.len() != SIDE) {
            let lengths: Vec<String> = rows.iter().map(|row| row.len().to_string()).collect();
            let value = format!("rows of {}", lengths.join(", "));
            return Err(source.refuse(map.span(), KEY, value, "", allowed));
        }
        let shares = whole(rows.concat(), KEY, map.span(), source)?;
        Ok(ObjectSupport::Map { shares })
    }
}

/// Shares that are together 1 but for rounding, made so.
fn whole(
    mut shares: Vec<f64>,
    key: &str,
    span: std::ops::Range<usize>,
    source: &Source<'_>,
) -> Result<Vec<f64>, DatasetError> {
    if let Some(share) = shares.iter().find(|share| !(0.0..=1.0).contains(*share)) {
        return Err(source.refuse(span, key, share, "", "shares of the weight from 0 to 1"));
    }
    let sum: f64 = shares.iter().sum();
    if (sum - 1.0).abs() > ROUNDED {
        let (value, allowed) = (format!("shares of {sum} together"), "shares that sum to 1");
        return Err(source.refuse(span, key, value, "", allowed));
    }
    shares.iter_mut().for_each(|share| *share /= sum);
    Ok(shares)
}

/// Whether a place is in the convex hull of others: no half of the plane about it is free of them.
fn is_between(center: &Vector2<f64>, places: &[Vector2<f64>]) -> bool {
    let arms = places.iter().map(|place| place - center);
    let mut angles: Vec<f64> =
        arms.filter(|arm| arm.norm() > 0.0).map(|arm| arm.y.atan2(arm.x)).collect();
    if angles.len() < places.len() {
        return true;
    }
    angles.sort_by(f64::total_cmp);
    let around = angles[0] + TAU - angles[angles.len() - 1];
    let widest = angles.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max);
    widest <= PI + STRAIGHT
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Vector2;

    use super::ObjectSupport;
    use crate::manifest::Manifest;

    fn read(object: &str) -> Result<ObjectSupport, String> {
        let text = format!(
            "name = \"x\"\n[object]\n{object}\n[pusher]\nradius_m = 0.005\nfriction = 0.2\n\
             [support]\nfriction = 0.3\n[recordings]\nformat = \"csv\"\n"
        );
        let read = Manifest::parse(&text, Path::new("dataset.toml"));
        read.map(|manifest| manifest.object_support).map_err(|error| error.to_string())
    }

    const SQUARE: &str = "shape = \"square\"\nside_m = 0.1\nmass_kg = 1.0\n";
    const FEET: &str = "support_points_m = [[0.04, 0.0], [-0.04, 0.03], [-0.04, -0.03]]\n";

    #[test]
    fn what_an_object_rests_on_is_read() {
        assert_eq!(read(SQUARE), Ok(ObjectSupport::Ellipsoid));
        let patch = |object: &str| read(&format!("{object}support = \"patch\""));
        assert_eq!(patch(SQUARE), Ok(ObjectSupport::Patch));
        assert_eq!(patch("shape = \"by-file-name\"\n"), Ok(ObjectSupport::Patch));
        let feet = read(&format!("{SQUARE}support = \"points\"\n{FEET}")).unwrap();
        let ObjectSupport::Points { places, shares } = feet else { panic!("points") };
        assert_eq!((places[1], shares), (Vector2::new(-0.04, 0.03), None));
        let shares = "support_shares = [0.333, 0.333, 0.333]";
        let feet = read(&format!("{SQUARE}support = \"points\"\n{FEET}{shares}")).unwrap();
        let ObjectSupport::Points { shares: Some(shares), .. } = feet else { panic!("shares") };
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        let row = "[0.04, 0.04, 0.04, 0.04, 0.04]";
        let map = format!("support = \"map\"\nsupport_map = [{row}, {row}, {row}, {row}, {row}]");
        let ObjectSupport::Map { shares } = read(&format!("{SQUARE}{map}")).unwrap() else {
            panic!("a map")
        };
        assert_eq!(shares.len(), 25);
    }

    #[test]
    fn what_no_object_can_rest_on_is_refused_with_what_to_do() {
        for (keys, says) in [
            ("support = \"feet\"", "one of ellipsoid, patch, points, map"),
            ("support = \"points\"", "three to six points"),
            ("support_points_m = [[0.0, 0.0]]", "support = \"points\" beside it"),
            ("support = \"points\"\nsupport_points_m = [[0.0, 0.0]]", "1 points is not allowed"),
            (
                "support = \"points\"\nsupport_points_m = [[40, 0], [-40, 30], [-40, -30]]",
                "inside the outline",
            ),
            (
                "support = \"points\"\nsupport_points_m = [[0.04, 0.0], [0.01, 0.03], [0.01, -0.03]]",
                "the center of mass between them",
            ),
            ("support = \"map\"", "five rows"),
            ("support = \"map\"\nsupport_map = [[1.0]]", "rows of 1"),
        ] {
            let error = read(&format!("{SQUARE}{keys}")).unwrap_err();
            assert!(error.contains(says) && error.contains("dataset.toml"), "{keys}: {error}");
        }
        for (shares, says) in [
            ("[0.5, 0.5]", "one for each of the 3 points"),
            ("[0.5, 0.6, -0.1]", "from 0 to 1"),
            ("[0.5, 0.3, 0.3]", "sum to 1"),
        ] {
            let keys = format!("support = \"points\"\n{FEET}support_shares = {shares}");
            let error = read(&format!("{SQUARE}{keys}")).unwrap_err();
            assert!(error.contains(says), "{shares}: {error}");
        }
        let by_name = format!("shape = \"by-file-name\"\nsupport = \"points\"\n{FEET}");
        assert!(read(&by_name).unwrap_err().contains("ellipsoid or patch"));
    }
}
