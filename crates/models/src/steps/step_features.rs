//! What a learnt model sees of a step.

use faer::Mat;

use crate::steps::contact_place::ContactPlaces;
use crate::{ModelError, StepInput};

/// The inputs of the processes: (p, β), and what is chosen beside them or in place of p.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepFeatures {
    /// The contact as the friction of the support sees it, in place of p: the lever of its normal
    /// about the centroid and the depth of the centroid behind it, over the mean distance ρ of the
    /// outline's area from its centroid, and the outline's curvature times ρ. These do not change
    /// when a body frame is turned, moved, or scaled with its object, and the outputs are learnt of
    /// the centroid, Δθ times ρ: steps of several outlines can be learnt from together, and others
    /// asked about.
    pub contact: bool,
    /// The pusher's mean speed, in m/s: for pushes that are not quasi-static.
    pub speed: bool,
    /// The contact normal in the body's frame: edges are told apart, and on a curved outline the
    /// places of the normal too. Without it all edges are folded into one.
    pub normal: bool,
}

impl StepFeatures {
    const PLACE: [&str; 2] = ["p", "beta_rad"];
    const CONTACT: [&str; 4] = ["lever", "depth", "curvature", "beta_rad"];
    const SPEED: [&str; 1] = ["speed_m_s"];
    const NORMAL: [&str; 2] = ["normal_x", "normal_y"];

    /// The most inputs that there can be.
    const MOST: usize = Self::CONTACT.len() + Self::SPEED.len() + Self::NORMAL.len();

    /// Every choice.
    pub const ALL: [Self; 8] = [
        Self { contact: false, speed: false, normal: false },
        Self { contact: false, speed: true, normal: false },
        Self { contact: false, speed: false, normal: true },
        Self { contact: false, speed: true, normal: true },
        Self { contact: true, speed: false, normal: false },
        Self { contact: true, speed: true, normal: false },
        Self { contact: true, speed: false, normal: true },
        Self { contact: true, speed: true, normal: true },
    ];

    /// Names of the inputs in order, as in `model.toml`.
    pub fn names(self) -> Vec<&'static str> {
        let place: &[&str] = if self.contact { &Self::CONTACT } else { &Self::PLACE };
        let chosen = |is_chosen: bool, names: &'static [&str]| {
            if is_chosen { names } else { &[] }.iter().copied()
        };
        let places = place.iter().copied();
        places
            .chain(chosen(self.speed, &Self::SPEED))
            .chain(chosen(self.normal, &Self::NORMAL))
            .collect()
    }

    /// How many inputs there are.
    pub(crate) fn n_inputs(self) -> usize {
        let chosen = |is_chosen: bool, n: usize| if is_chosen { n } else { 0 };
        let place = if self.contact { Self::CONTACT.len() } else { Self::PLACE.len() };
        place + chosen(self.speed, Self::SPEED.len()) + chosen(self.normal, Self::NORMAL.len())
    }

    /// The choice with these names.
    pub fn by_names(names: &[String]) -> Option<Self> {
        Self::ALL.into_iter().find(|choice| choice.names() == names)
    }

    /// The inputs to learn from, which may not be the same in all steps.
    ///
    /// # Errors
    /// `ConstantInput` for the speed, or both numbers of the normal; those of [`Self::rows`].
    pub(crate) fn training_rows(self, steps: &[&StepInput]) -> Result<Mat<f64>, ModelError> {
        let rows = self.rows(steps.iter().copied())?;
        let varies = |name: &str| {
            let column = self.names().iter().position(|known| *known == name);
            column.is_some_and(|d| rows.col(d).iter().any(|value| *value != rows[(0, d)]))
        };
        let n_steps = steps.len();
        if self.speed && n_steps > 0 && !varies(Self::SPEED[0]) {
            return Err(ModelError::ConstantInput { input: Self::SPEED[0], n_steps });
        }
        if self.normal && n_steps > 0 && !Self::NORMAL.iter().any(|name| varies(name)) {
            return Err(ModelError::ConstantInput { input: Self::NORMAL[0], n_steps });
        }
        Ok(rows)
    }

    /// The inputs, one row a step.
    ///
    /// # Errors
    /// `NoSpeed` for a step that does not say how long it took.
    pub(crate) fn rows<'a>(
        self,
        steps: impl ExactSizeIterator<Item = &'a StepInput>,
    ) -> Result<Mat<f64>, ModelError> {
        let mut places = ContactPlaces::default();
        let mut rows = Mat::zeros(steps.len(), self.n_inputs());
        for (i, step) in steps.enumerate() {
            let row = self.row(step, &mut places)?;
            (0..self.n_inputs()).for_each(|d| rows[(i, d)] = row[d]);
        }
        Ok(rows)
    }

    /// The inputs of one step, of which the first [`Self::n_inputs`] count.
    ///
    /// # Errors
    /// As [`Self::rows`].
    pub(crate) fn row(
        self,
        step: &StepInput,
        places: &mut ContactPlaces,
    ) -> Result<[f64; Self::MOST], ModelError> {
        let mut row = [0.0; Self::MOST];
        let mut next = 0;
        let mut add = |values: &[f64]| {
            row[next..next + values.len()].copy_from_slice(values);
            next += values.len();
        };
        match self.contact {
            true => add(&places.of(step).inputs()),
            false => add(&[step.p()]),
        }
        add(&[step.beta()]);
        if self.speed {
            add(&[step.speed().ok_or(ModelError::NoSpeed)?]);
        }
        if self.normal {
            add(step.shape().inward_normal_at(step.edge(), step.p()).as_slice());
        }
        Ok(row)
    }
}
