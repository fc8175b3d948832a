//! The eleven steel objects of the MIT push data set.

use crate::{Ellipse, PlanarError, Polygon, Shape};
use nalgebra::Vector2;

/// One of the eleven objects, in the frame of its tracked body.
///
/// # Source
/// Yu, Bauza, Fazeli & Rodriguez (2016), "More than a million ways to be pushed", data set tools.
#[derive(Clone, Debug, PartialEq)]
pub struct MitObject {
    /// The data set's name for it.
    pub name: &'static str,
    /// The outline, in m. The triangles' origin is not their centroid.
    pub shape: Shape,
    /// Mass, in kg.
    pub mass: f64,
    /// Moment of inertia about the center of mass, in kg·m².
    pub moment_of_inertia: f64,
}

/// Finds an object by the data set's name.
///
/// # Errors
/// `UnknownObject` for any other name than those in [`crate::MIT_NAMES`].
pub fn mit_object(name: &str) -> Result<MitObject, PlanarError> {
    let row = ROWS.iter().find(|row| row.name == name);
    let row = row.ok_or_else(|| PlanarError::UnknownObject { name: name.to_owned() })?;
    let shape = match row.outline {
        Outline::Vertices(vertices) => {
            let vertices = vertices.iter().map(|v| Vector2::new(v[0], v[1])).collect();
            Shape::Polygon(Polygon::new(vertices)?)
        }
        Outline::SemiAxes(a, b) => Shape::Ellipse(Ellipse::new(a, b)?),
    };
    let (mass, moment_of_inertia) = (row.mass, row.moment_of_inertia);
    Ok(MitObject { name: row.name, shape, mass, moment_of_inertia })
}

struct Row {
    name: &'static str,
    outline: Outline,
    mass: f64,
    moment_of_inertia: f64,
}

enum Outline {
    Vertices(&'static [[f64; 2]]),
    SemiAxes(f64, f64),
}

const ROWS: [Row; 11] = [
    Row {
        name: "rect1",
        outline: Outline::Vertices(&[
            [0.045, 0.045],
            [-0.045, 0.045],
            [-0.045, -0.045],
            [0.045, -0.045],
        ]),
        mass: 0.8374,
        moment_of_inertia: 0.001131,
    },
    Row {
        name: "rect2",
        outline: Outline::Vertices(&[
            [0.044955, 0.05629],
            [-0.044955, 0.05629],
            [-0.044955, -0.05629],
            [0.044955, -0.05629],
        ]),
        mass: 1.045,
        moment_of_inertia: 0.001808,
    },
    Row {
        name: "rect3",
        outline: Outline::Vertices(&[
            [0.067505, 0.04497],
            [-0.067505, 0.04497],
            [-0.067505, -0.04497],
            [0.067505, -0.04497],
        ]),
        mass: 1.2508,
        moment_of_inertia: 0.002744,
    },
    Row {
        name: "tri1",
        outline: Outline::Vertices(&[[0.045, 0.045], [-0.0809, 0.045], [0.045, -0.08087]]),
        mass: 0.8028,
        moment_of_inertia: 0.001414,
    },
    Row {
        name: "tri2",
        outline: Outline::Vertices(&[[0.045, 0.045], [-0.106, 0.045], [0.045, -0.08087]]),
        mass: 0.9826,
        moment_of_inertia: 0.002108,
    },
    Row {
        name: "tri3",
        outline: Outline::Vertices(&[[0.045, 0.045], [-0.1315, 0.045], [0.045, -0.08061]]),
        mass: 1.1326,
        moment_of_inertia: 0.002957,
    },
    Row {
        name: "ellip1",
        outline: Outline::SemiAxes(0.0525, 0.0525),
        mass: 0.8937,
        moment_of_inertia: 0.001231,
    },
    Row {
        name: "ellip2",
        outline: Outline::SemiAxes(0.0525, 0.065445),
        mass: 1.1104,
        moment_of_inertia: 0.001953,
    },
    Row {
        name: "ellip3",
        outline: Outline::SemiAxes(0.0525, 0.0785),
        mass: 1.3338,
        moment_of_inertia: 0.002973,
    },
    Row {
        name: "hex",
        outline: Outline::Vertices(&[
            [0.0605, 0.0],
            [0.03025, 0.052395],
            [-0.03025, 0.052395],
            [-0.0605, 0.0],
            [-0.03025, -0.052395],
            [0.03025, -0.052395],
        ]),
        mass: 0.9827,
        moment_of_inertia: 0.001497,
    },
    Row {
        name: "butter",
        outline: Outline::Vertices(&BUTTER),
        mass: 1.1974,
        moment_of_inertia: 0.002954,
    },
];

/// The butterfly's outline, thinned from the data set's curve.
#[rustfmt::skip]
const BUTTER: [[f64; 2]; 159] = [
    [-0.02746, 0.0], [-0.02778, -0.00249], [-0.02837, -0.00498], [-0.02924, -0.00746],
    [-0.0303, -0.00995], [-0.03157, -0.01243], [-0.03296, -0.01491], [-0.03447, -0.01738],
    [-0.03604, -0.01985], [-0.03765, -0.02232], [-0.03925, -0.02478], [-0.04082, -0.02723],
    [-0.0423, -0.02968], [-0.04368, -0.03212], [-0.0449, -0.03455], [-0.04595, -0.03697],
    [-0.04675, -0.03939], [-0.04731, -0.04179], [-0.04757, -0.04419], [-0.04752, -0.04656],
    [-0.04716, -0.04893], [-0.04651, -0.05125], [-0.04558, -0.05356], [-0.04438, -0.05579],
    [-0.04294, -0.05799], [-0.04126, -0.0601], [-0.03937, -0.06217], [-0.03726, -0.06412],
    [-0.03497, -0.06602], [-0.0325, -0.06776], [-0.02988, -0.06945], [-0.02711, -0.07096],
    [-0.02422, -0.07241], [-0.0212, -0.07365], [-0.0181, -0.07481], [-0.0149, -0.07574],
    [-0.01165, -0.07659], [-0.00833, -0.07717], [-0.00498, -0.07766], [-0.00161, -0.07787],
    [0.00177, -0.07797], [0.00515, -0.07776], [0.00849, -0.07746], [0.01181, -0.07688],
    [0.01506, -0.07621], [0.01826, -0.07528], [0.02136, -0.07427], [0.02438, -0.07303],
    [0.02727, -0.07172], [0.03004, -0.07021], [0.03266, -0.06864], [0.03513, -0.06689],
    [0.03742, -0.06509], [0.03953, -0.06315], [0.04142, -0.06116], [0.0431, -0.05905],
    [0.04455, -0.05691], [0.04574, -0.05467], [0.04667, -0.05242], [0.04733, -0.05009],
    [0.04768, -0.04775], [0.04773, -0.04538], [0.04747, -0.04299], [0.04691, -0.04059],
    [0.04611, -0.03818], [0.04506, -0.03576], [0.04385, -0.03334], [0.04246, -0.0309],
    [0.04098, -0.02846], [0.03941, -0.02601], [0.03781, -0.02355], [0.0362, -0.02109],
    [0.03463, -0.01862], [0.03312, -0.01614], [0.03173, -0.01367], [0.03046, -0.01119],
    [0.0294, -0.00871], [0.02853, -0.00622], [0.02794, -0.00373], [0.02762, -0.00124],
    [0.02762, 0.00124], [0.02794, 0.00373], [0.02881, 0.00622], [0.02967, 0.00871],
    [0.03094, 0.01119], [0.0322, 0.01367], [0.03371, 0.01614], [0.03523, 0.01862],
    [0.03684, 0.02109], [0.03846, 0.02355], [0.04004, 0.02601], [0.04161, 0.02846],
    [0.04299, 0.0309], [0.04438, 0.03334], [0.04542, 0.03576], [0.04647, 0.03818],
    [0.04703, 0.04059], [0.04759, 0.04299], [0.04754, 0.04538], [0.04749, 0.04775],
    [0.04684, 0.05009], [0.04618, 0.05242], [0.04498, 0.05467], [0.04379, 0.05691],
    [0.0421, 0.05905], [0.04042, 0.06116], [0.03831, 0.06315], [0.03621, 0.06509],
    [0.03374, 0.06689], [0.03127, 0.06864], [0.0285, 0.07021], [0.02572, 0.07172],
    [0.02271, 0.07303], [0.0197, 0.07427], [0.0165, 0.07528], [0.01331, 0.07621],
    [0.00999, 0.07688], [0.00667, 0.07746], [0.0033, 0.07776], [-8e-05, 0.07797],
    [-0.00346, 0.07787], [-0.00683, 0.07766], [-0.01015, 0.07717], [-0.01347, 0.07659],
    [-0.01666, 0.07574], [-0.01986, 0.07481], [-0.02287, 0.07365], [-0.02588, 0.07241],
    [-0.02866, 0.07096], [-0.03143, 0.06945], [-0.0339, 0.06776], [-0.03637, 0.06602],
    [-0.03847, 0.06412], [-0.04058, 0.06217], [-0.04226, 0.0601], [-0.04395, 0.05799],
    [-0.04514, 0.05579], [-0.04634, 0.05356], [-0.047, 0.05125], [-0.04765, 0.04893],
    [-0.0477, 0.04656], [-0.04775, 0.04419], [-0.04719, 0.04179], [-0.04663, 0.03939],
    [-0.04558, 0.03697], [-0.04454, 0.03455], [-0.04315, 0.03212], [-0.04177, 0.02968],
    [-0.0402, 0.02723], [-0.03862, 0.02478], [-0.037, 0.02232], [-0.03539, 0.01985],
    [-0.03387, 0.01738], [-0.03236, 0.01491], [-0.0311, 0.01243], [-0.02983, 0.00995],
    [-0.02897, 0.00746], [-0.0281, 0.00498], [-0.02778, 0.00249],
];

#[cfg(test)]
mod tests {
    use super::mit_object;
    use crate::MIT_NAMES;
    use crate::PlanarError;
    use nalgebra::Vector2;

    #[test]
    fn areas_and_centroids_are_those_published() {
        let published = [
            ("rect1", 0.0081, [0.0, 0.0]),
            ("rect2", 0.0101221, [0.0, 0.0]),
            ("rect3", 0.0121428, [0.0, 0.0]),
            ("tri1", 0.0079235, [0.003033, 0.003043]),
            ("tri2", 0.0095032, [-0.005333, 0.003043]),
            ("tri3", 0.0110851, [-0.013833, 0.00313]),
            ("ellip1", 0.008659, [0.0, 0.0]),
            ("ellip2", 0.0107941, [0.0, 0.0]),
            ("ellip3", 0.0129473, [0.0, 0.0]),
            ("hex", 0.0095097, [0.0, 0.0]),
            ("butter", 0.0115934, [1e-06, 1.1e-05]),
        ];
        assert_eq!(published.map(|row| row.0), MIT_NAMES);
        for (name, area, centroid) in published {
            let shape = mit_object(name).unwrap().shape;
            assert!((shape.area() - area).abs() < 1e-7, "{name}: {}", shape.area());
            let centroid = Vector2::new(centroid[0], centroid[1]);
            assert!((shape.centroid() - centroid).norm() < 2e-6, "{name}: {}", shape.centroid());
        }
    }

    #[test]
    fn moments_of_inertia_are_those_of_uniform_plates_within_two_percent() {
        for name in MIT_NAMES {
            let object = mit_object(name).unwrap();
            let own = object.shape.second_moment(&object.shape.centroid()) / object.shape.area();
            let ratio = object.moment_of_inertia / (object.mass * own);
            assert!((ratio - 1.0).abs() < 0.02, "{name}: {ratio}");
        }
    }

    #[test]
    fn an_unknown_name_is_refused_with_the_known_ones() {
        let error = mit_object("rect9").unwrap_err();
        assert_eq!(error, PlanarError::UnknownObject { name: "rect9".into() });
        assert!(error.to_string().contains("`rect9`") && error.to_string().contains("butter"));
    }
}
