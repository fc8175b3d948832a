//! What no recording tells of a set, and who is asked for it.

use std::io::{BufRead, ErrorKind};

use anyhow::{Result, bail};
use toml::{Table, Value};

use super::stated::{Stated, value};

/// A key of the manifest that has to be told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Asked {
    pub(super) key: &'static str,
    /// What it is, with its unit.
    pub(super) what: &'static str,
    /// What people may take without measuring.
    usual: Option<f64>,
}

impl Asked {
    const fn new(key: &'static str, what: &'static str) -> Self {
        Self { key, what, usual: None }
    }

    const fn usually(self, usual: f64) -> Self {
        Self { usual: Some(usual), ..self }
    }
}

const SHAPE: Asked = Asked::new(
    "object.shape",
    "the outline: square, rectangle, polygon or ellipse, or the name of an MIT object",
);
const MASS: Asked = Asked::new("object.mass_kg", "mass of the object, in kg");
const RIG: [Asked; 3] = [
    Asked::new("pusher.radius_m", "radius of the pusher's round tip, in m"),
    Asked::new("pusher.friction", "coefficient of friction between pusher and object")
        .usually(0.25),
    Asked::new("support.friction", "coefficient of friction between object and table")
        .usually(0.25),
];

/// Outlines that have a size, with what tells it.
const SIZES: [(&str, &[Asked]); 4] = [
    ("square", &[Asked::new("object.side_m", "side of the square, in m")]),
    (
        "rectangle",
        &[
            Asked::new("object.width_m", "width of the rectangle, along the body's x, in m"),
            Asked::new("object.height_m", "height of the rectangle, along the body's y, in m"),
        ],
    ),
    (
        "polygon",
        &[Asked::new("object.vertices_m", "corners, counter-clockwise, as [[x, y], …] in m")],
    ),
    (
        "ellipse",
        &[Asked::new("object.semi_axes_m", "semi-axes, along the body's x and y, in m, as [a, b]")],
    ),
];

/// What a manifest does not tell yet. The friction of a `draft` is a guess, and not told until it is stated.
pub(super) fn missing(manifest: &Table, is_draft: bool, stated: &[Stated]) -> Vec<Asked> {
    let is_stated = |key: &str| stated.iter().any(|one| one.key == key);
    let is_guess = |asked: &Asked| is_draft && asked.usual.is_some() && !is_stated(asked.key);
    let is_missing = |asked: &Asked| is_guess(asked) || is_open(value(manifest, asked.key));
    let shape = value(manifest, SHAPE.key).and_then(Value::as_str).unwrap_or_default();
    let sizes = SIZES.into_iter().find(|(name, _)| *name == shape);
    // Until the outline is told, its size cannot be asked for, and the mass of MIT's objects is known.
    let has_mass = sizes.is_some() || is_missing(&SHAPE);
    let sizes = sizes.map_or(&[][..], |(_, sizes)| sizes).iter().copied();
    let all = [SHAPE].into_iter().chain(sizes).chain(has_mass.then_some(MASS)).chain(RIG);
    all.filter(is_missing).collect()
}

/// Whether a value is still to be told.
pub(super) fn is_open(value: Option<&Value>) -> bool {
    value.is_none_or(|value| value.as_str() == Some("TODO"))
}

/// Asks a person until the answer is a value.
///
/// # Errors
/// If nothing more can be read.
pub(super) fn ask(asked: &Asked, answers: &mut dyn BufRead, tell: &dyn Fn(&str)) -> Result<Stated> {
    let Asked { key, what, usual } = asked;
    loop {
        let or = usual.map_or(String::new(), |usual| format!(" [{usual}]"));
        tell(&format!("{key}, {what}{or}:"));
        let mut line = String::new();
        match answers.read_line(&mut line) {
            Ok(0) => bail!("no answer; state it with --set {key}=…"),
            // Keys that no text in UTF-8 comes from are asked for again.
            Err(error) if error.kind() != ErrorKind::InvalidData => return Err(error.into()),
            _ => {}
        }
        let typed = match (line.trim(), usual) {
            ("", Some(usual)) => usual.to_string(),
            (typed, _) => typed.to_owned(),
        };
        let stated = Stated::new(key, &typed);
        if is_sensible(&stated) {
            return Ok(stated);
        }
    }
}

/// Whether an answer is of the kind that its key needs; the manifest checks the rest.
fn is_sensible(stated: &Stated) -> bool {
    match (&stated.value, stated.key.as_str()) {
        (Value::String(text), "object.shape") => !text.is_empty(),
        (Value::Array(_), "object.vertices_m" | "object.semi_axes_m") => true,
        (_, "object.shape" | "object.vertices_m" | "object.semi_axes_m") => false,
        // A tip may be a point.
        (Value::Float(number), _) => *number >= 0.0,
        (Value::Integer(number), _) => *number >= 0,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::{RIG, ask, missing};

    fn keys(text: &str, is_draft: bool) -> Vec<&'static str> {
        let manifest = text.parse().unwrap();
        missing(&manifest, is_draft, &[]).into_iter().map(|one| one.key).collect()
    }

    #[test]
    fn what_a_draft_leaves_open_is_asked_for_and_the_size_of_its_outline() {
        let rig = "[pusher]\nradius_m = 0.005\nfriction = 0.3\n[support]\nfriction = 0.2\n";
        assert_eq!(keys(rig, false), ["object.shape", "object.mass_kg"]);
        assert_eq!(
            keys(&format!("{rig}[object]\nshape = \"rectangle\"\nwidth_m = 0.1"), false),
            ["object.height_m", "object.mass_kg"]
        );
        assert_eq!(
            keys(&format!("{rig}[object]\nshape = \"rect1\""), true),
            ["pusher.friction", "support.friction"]
        );
        assert!(keys(&format!("{rig}[object]\nshape = \"by-file-name\""), false).is_empty());
    }

    #[test]
    fn a_person_is_asked_until_the_answer_is_a_number() {
        let told = RefCell::new(Vec::new());
        let tell = |text: &str| told.borrow_mut().push(text.to_owned());
        let answer = |typed: &str| ask(&RIG[1], &mut typed.as_bytes(), &tell);
        assert_eq!(answer("a third\n-1\n0.3\n").unwrap().to_string(), "pusher.friction=0.3");
        assert_eq!(told.borrow().len(), 3);
        assert!(told.borrow()[0].ends_with("object [0.25]:"), "{told:?}");
        assert_eq!(answer("\n").unwrap().to_string(), "pusher.friction=0.25");
        let message = answer("").unwrap_err().to_string();
        assert_eq!(message, "no answer; state it with --set pusher.friction=…");
    }
}
