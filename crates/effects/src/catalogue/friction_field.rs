//! Friction that is its own at each place of the table.

use std::f64::consts::PI;

use nalgebra::Vector2;

use crate::{
    Channel, Confounder, Effect, EffectInfo, Nuisance, Off, Origin, Parameter, Role, Sliding, Stage,
};

/// Friction field: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrictionField;

/// A number that says where the rectangle is.
const fn side(name: &'static str, meaning: &'static str, typical: f64, least: f64) -> Parameter {
    let (off, role) = (Off::Undefined, Role::Reference);
    Parameter { name, unit: "m", meaning, off, typical, range: (least, 10.0), role }
}

/// The amplitude of a wave, which falls with its number of half waves. `SIZE` makes fields of such amplitudes,
/// each of either sign, 15 % of the friction (root mean square over the rectangle).
const fn wave(name: &'static str, index: usize) -> Parameter {
    const SIZE: f64 = 0.25;
    let (x, y) = WAVES[index];
    let sign = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
    Parameter {
        name,
        unit: "1",
        meaning: "Amplitude of so many half waves along x and y of the rectangle",
        off: Off::At(0.0),
        typical: sign * SIZE / (1 + x * x + y * y) as f64,
        range: (-0.5, 0.5),
        role: Role::Wave,
    }
}

const N_SIDES: usize = 4;
const N_WAVES: usize = 18;

/// Half waves along x and y, in the order of the parameters.
const WAVES: [(usize, usize); N_WAVES] = [
    (0, 1),
    (0, 2),
    (0, 3),
    (0, 4),
    (1, 0),
    (1, 1),
    (1, 2),
    (1, 3),
    (1, 4),
    (2, 0),
    (2, 1),
    (2, 2),
    (2, 3),
    (3, 0),
    (3, 1),
    (3, 2),
    (4, 0),
    (4, 1),
];

const PARAMETERS: [Parameter; N_SIDES + N_WAVES] = [
    side("x", "Middle of the rectangle along x of the table", 0.1, -10.0),
    side("y", "Middle of the rectangle along y of the table", 0.1, -10.0),
    side("half_x", "Half of its length along x", 0.3, 0.01),
    side("half_y", "Half of its length along y", 0.3, 0.01),
    wave("x0_y1", 0),
    wave("x0_y2", 1),
    wave("x0_y3", 2),
    wave("x0_y4", 3),
    wave("x1_y0", 4),
    wave("x1_y1", 5),
    wave("x1_y2", 6),
    wave("x1_y3", 7),
    wave("x1_y4", 8),
    wave("x2_y0", 9),
    wave("x2_y1", 10),
    wave("x2_y2", 11),
    wave("x2_y3", 12),
    wave("x3_y0", 13),
    wave("x3_y1", 14),
    wave("x3_y2", 15),
    wave("x4_y0", 16),
    wave("x4_y1", 17),
];

static INFO: EffectInfo = EffectInfo {
    id: "friction-field",
    title: "Field of friction over the table",
    physics: "Every place of the table has a friction of its own, by its grain, wear and dust. Waves \
        over a rectangle of the table tell it, the shortest half as long as the rectangle; beyond, \
        friction is that of the nearest place of the rectangle. A fit puts the rectangle about all that its \
        pushes touch, and takes the amplitudes to be about 0, the smaller the shorter the wave: a \
        Gaussian process in a few functions. What it says where no push went is a guess.",
    equation: "μ(x) = μs exp f(x), f = Σ a_jk cos(jπu) cos(kπv) over j, k from 0 with 0 < j² + k² ≤ 17, u and v \
        being the place within the rectangle, 0 to 1; beforehand a_jk is normal with standard deviation \
        0.25/(1 + j² + k²).",
    source: "Solin & Särkkä (2020), Hilbert space methods for reduced-rank Gaussian process regression, \
        Statistics and Computing 30; of a table's friction: Yu, Bauza, Fazeli & Rodriguez (2016), More \
        than a million ways to be pushed, IROS.",
    stages: &[Stage::Local],
    origin: Origin::Table,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &PARAMETERS,
    confounders: &[Confounder {
        id: "friction-gradient",
        when: "always: a gradient is the longest of its waves",
    }],
    nuisance: Nuisance::No,
    shown_by: &["pushes that cross each other's ways, over all of the table that counts"],
};

impl FrictionField {
    /// The waves at a place of the table, −1 to 1, in the order of their amplitudes among the parameters.
    ///
    /// - `values`: of all parameters, in their order.
    /// - `place_w`: in m, frame W.
    pub fn waves(values: &[f64], place_w: &Vector2<f64>) -> [f64; N_WAVES] {
        let along = |middle: f64, half: f64, at: f64| {
            let share = (0.5 * (1.0 + (at - middle) / half)).clamp(0.0, 1.0);
            let first = (PI * share).cos();
            let square = first * first;
            let second = 2.0 * square - 1.0;
            [1.0, first, second, first * (4.0 * square - 3.0), 2.0 * second * second - 1.0]
        };
        let x = along(values[0], values[2], place_w.x);
        let y = along(values[1], values[3], place_w.y);
        WAVES.map(|(along_x, along_y)| x[along_x] * y[along_y])
    }

    /// The logarithm of friction at a place over the nominal one; 0 when off.
    ///
    /// - `values`: of all parameters, in their order.
    /// - `place_w`: in m, frame W.
    pub fn log_ratio(values: &[f64], place_w: &Vector2<f64>) -> f64 {
        let amplitudes = &values[N_SIDES..];
        if amplitudes.iter().all(|amplitude| *amplitude == 0.0) {
            return 0.0;
        }
        let waves = Self::waves(values, place_w);
        amplitudes.iter().zip(waves).map(|(amplitude, wave)| amplitude * wave).sum()
    }
}

impl Effect for FrictionField {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn local_friction(&self, values: &[f64], sliding: &Sliding) -> f64 {
        Self::log_ratio(values, &sliding.place_w).exp_m1()
    }

    fn local_growth(&self, _: &[f64], _: &Sliding, _: f64) -> f64 {
        0.0
    }
}
