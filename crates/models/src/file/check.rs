//! From the tables of `model.toml` to a base that can be built, or to what is wrong with them.

use nalgebra::Matrix3;
use serde_spanned::Spanned;

use super::ModelFile;
use super::made_for::MadeFor;
use super::raw::{Raw, RawBase};
use super::source::Source;
use crate::analytical::{FRICTION_RANGE, LENGTH_RANGE, is_covariance};
use crate::{
    Analytical, Base, Calibration, CharacteristicLength, Estimate, ModelError, ProcessKind, Split,
    SurfaceKind, model_kinds,
};

const PRESSURES: [&str; 1] = ["uniform"];
const MOST_POINTS: i64 = 10_000;

impl Source<'_> {
    /// The base, after a check of everything but the weights file.
    pub(super) fn base(&self, raw: &Raw) -> Result<Base, ModelError> {
        self.expect(&raw.schema, "schema", &[ModelFile::SCHEMA])?;
        let kinds: Vec<&str> = model_kinds().iter().map(|kind| kind.id).collect();
        self.expect(&raw.base.get_ref().kind, "base.kind", &kinds)?;
        let kind = raw.base.get_ref().kind.get_ref().as_str();
        match &raw.learned {
            None if kind != "analytical" => {
                let problem = "this kind needs the table; train the model, or use kind analytical";
                return Err(self.invalid(raw.base.span().start, "learned", problem));
            }
            Some(learned) if kind == "analytical" => {
                let problem = "an analytical model has no weights; remove the table";
                return Err(self.invalid(learned.span().start, "learned", problem));
            }
            _ => {}
        }
        match kind {
            "analytical" => Ok(Base::Analytical(self.analytical(&raw.base)?)),
            "hybrid" => Ok(Base::Hybrid(self.analytical(&raw.base)?)),
            _ => {
                self.without_mechanics(raw.base.get_ref())?;
                let process = ProcessKind::by_id(kind);
                Ok(Base::Process(process.expect("every kind without mechanics is a process")))
            }
        }
    }

    /// The split, if it does not contradict itself.
    pub(super) fn split(&self, raw: Option<Spanned<Split>>) -> Result<Option<Split>, ModelError> {
        let Some(raw) = raw else { return Ok(None) };
        match raw.get_ref().problem() {
            Some(problem) => Err(self.invalid(raw.span().start, "split", problem)),
            None => Ok(Some(raw.into_inner())),
        }
    }

    /// What the model was made for, if a rig can be so.
    pub(super) fn made_for(
        &self,
        raw: Option<Spanned<MadeFor>>,
    ) -> Result<Option<MadeFor>, ModelError> {
        let Some(raw) = raw else { return Ok(None) };
        match raw.get_ref().problem() {
            Some((key, problem)) => Err(self.invalid(raw.span().start, key, problem)),
            None => Ok(Some(raw.into_inner())),
        }
    }

    /// How sure the model may be of whole pushes, if anything can be so.
    pub(super) fn calibration(
        &self,
        raw: Option<Spanned<Calibration>>,
    ) -> Result<Option<Calibration>, ModelError> {
        let Some(raw) = raw else { return Ok(None) };
        match raw.get_ref().problem() {
            Some((key, problem)) => Err(self.invalid(raw.span().start, key, problem)),
            None => Ok(Some(raw.into_inner())),
        }
    }

    /// Refuses the keys of an analytical model.
    fn without_mechanics(&self, base: &RawBase) -> Result<(), ModelError> {
        let spans = [
            base.limit_surface.as_ref().map(Spanned::span),
            base.n_points.as_ref().map(Spanned::span),
            base.pressure.as_ref().map(Spanned::span),
            base.scatter_per_m.as_ref().map(Spanned::span),
            base.pusher_friction.as_ref().map(Spanned::span),
            base.characteristic_length.as_ref().map(Spanned::span),
            base.quartic.as_ref().map(Spanned::span),
        ];
        match spans.into_iter().flatten().min_by_key(|span| span.start) {
            Some(span) => {
                let problem = "this kind has no mechanics; remove its keys, or use kind hybrid";
                Err(self.invalid(span.start, "base", problem))
            }
            None => Ok(()),
        }
    }

    fn analytical(&self, base: &Spanned<RawBase>) -> Result<Analytical, ModelError> {
        let (raw, start) = (base.get_ref(), base.span().start);
        let surface = self.surface(raw, start)?;
        let key = "base.pusher_friction";
        let friction = match &raw.pusher_friction {
            Some(friction) => self.estimate(friction, key, FRICTION_RANGE)?,
            None => return Err(self.invalid(start, key, "is missing; give a value")),
        };
        let length = self.length(raw, start, surface)?;
        Analytical::new(friction, length, self.scatter(raw)?)?.with_surface(surface)
    }

    fn surface(&self, raw: &RawBase, start: usize) -> Result<SurfaceKind, ModelError> {
        let kind = match &raw.limit_surface {
            Some(name) if name.get_ref() == SurfaceKind::EFFECTIVE => self.effective(raw, start)?,
            Some(name) => SurfaceKind::named(name.get_ref()).ok_or_else(|| {
                let names = SurfaceKind::all().map(SurfaceKind::name);
                let names: Vec<_> = names.chain([SurfaceKind::EFFECTIVE]).collect();
                self.unknown(name, "base.limit_surface", &names)
            })?,
            None => SurfaceKind::default(),
        };
        if let (Some(quartic), false) = (&raw.quartic, matches!(kind, SurfaceKind::Effective(_))) {
            let problem = "is for limit_surface = \"effective-quartic\" alone; remove it";
            return Err(self.invalid(quartic.span().start, "base.quartic", problem));
        }
        let key = "base.n_points";
        match (kind, &raw.n_points) {
            (kind, None) => Ok(kind),
            (SurfaceKind::Points { .. }, Some(number)) => match *number.get_ref() {
                n @ 4..=MOST_POINTS => Ok(SurfaceKind::Points { n_points: n as usize }),
                n => {
                    let problem = format!("must be from 4 to {MOST_POINTS}, got {n}");
                    Err(self.invalid(number.span().start, key, problem))
                }
            },
            (_, Some(number)) => {
                let problem = "is for limit_surface = \"points\" alone; remove it";
                Err(self.invalid(number.span().start, key, problem))
            }
        }
    }

    /// A measured surface, which is checked to be convex.
    fn effective(&self, raw: &RawBase, start: usize) -> Result<SurfaceKind, ModelError> {
        let key = "base.quartic";
        let Some(quartic) = &raw.quartic else {
            let problem = "is missing; give length and coefficients, or another limit_surface";
            return Err(self.invalid(start, key, problem));
        };
        let surface = *quartic.get_ref();
        let (low, high) = LENGTH_RANGE;
        if !(low..=high).contains(&surface.length()) {
            let problem = format!("must be from {low} to {high}, got {:?}", surface.length());
            let key = "base.quartic.length";
            return Err(self.invalid(quartic.span().start, key, problem));
        }
        match surface.bearing(1.0) {
            Ok(_) => Ok(SurfaceKind::Effective(surface)),
            Err(error) => Err(self.invalid(quartic.span().start, key, error.to_string())),
        }
    }

    fn length(
        &self,
        raw: &RawBase,
        start: usize,
        surface: SurfaceKind,
    ) -> Result<CharacteristicLength, ModelError> {
        if let Some(pressure) = &raw.pressure {
            self.expect(pressure, "base.pressure", &PRESSURES)?;
        }
        match (&raw.characteristic_length, &raw.pressure) {
            (None, None) if matches!(surface, SurfaceKind::Effective(_)) => {
                Ok(CharacteristicLength::UniformPressure)
            }
            (_, Some(pressure)) if matches!(surface, SurfaceKind::Effective(_)) => {
                let problem = "is not known of a measured surface; remove it";
                Err(self.invalid(pressure.span().start, "base.pressure", problem))
            }
            (None, Some(_)) => Ok(CharacteristicLength::UniformPressure),
            (Some(length), None) if surface == SurfaceKind::Ellipsoid => {
                let key = "base.characteristic_length";
                Ok(CharacteristicLength::Given(self.estimate(length, key, LENGTH_RANGE)?))
            }
            (Some(length), None) => {
                let name = surface.name();
                let problem = format!("is for an ellipsoid; on {name} give pressure = \"uniform\"");
                Err(self.invalid(length.span().start, "base.characteristic_length", problem))
            }
            _ => {
                let problem = "give either pressure = \"uniform\" or [base.characteristic_length]";
                Err(self.invalid(start, "base.pressure", problem))
            }
        }
    }

    fn scatter(&self, raw: &RawBase) -> Result<Matrix3<f64>, ModelError> {
        let Some(rows) = &raw.scatter_per_m else { return Ok(Matrix3::zeros()) };
        let matrix = Matrix3::from_fn(|i, j| rows.get_ref()[i][j]);
        if is_covariance(&matrix) {
            return Ok(matrix);
        }
        let problem = "must be symmetric and positive semi-definite";
        Err(self.invalid(rows.span().start, "base.scatter_per_m", problem))
    }

    fn estimate(
        &self,
        raw: &Spanned<Estimate>,
        key: &str,
        (low, high): (f64, f64),
    ) -> Result<Estimate, ModelError> {
        let Estimate { value, se, .. } = *raw.get_ref();
        for (name, value, low) in [("value", value, low), ("se", se, 0.0)] {
            if !(low..=high).contains(&value) {
                let problem = format!("must be from {low} to {high}, got {value:?}");
                return Err(self.invalid(raw.span().start, &format!("{key}.{name}"), problem));
            }
        }
        Ok(raw.get_ref().clone())
    }
}
