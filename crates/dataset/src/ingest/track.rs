//! A pose stream as a curve on its own clock, never evaluated across a gap.

use std::sync::Arc;

use nalgebra::Vector2;
use planar::{Pose, Twist};

use crate::curves::noise::noise_sd;
use crate::curves::smoothing::{Smoother, smooth};
use crate::curves::spline::{CubicSpline, EndCondition};
use crate::error::DatasetError;
use crate::ingest::repair::CleanStream;
use crate::ingest::settings::Curve;

/// Position and yaw over time, piece by piece between gaps.
#[derive(Clone, Debug)]
pub(crate) struct PoseTrack {
    pieces: Arc<[Piece]>,
    noise: PoseNoise,
    /// Whether the curve leaves its samples, so that its bias counts.
    smooths: bool,
}

/// Standard deviations of a pose stream's samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PoseNoise {
    /// Per axis, in m.
    pub(crate) position: f64,
    /// In rad.
    pub(crate) angle: f64,
}

#[derive(Clone, Debug)]
struct Piece {
    curves: [CubicSpline; 3],
    smoothers: Smoothers,
}

/// Hat matrices of x, y and yaw: the same if they interpolate.
#[derive(Clone, Debug)]
enum Smoothers {
    One(Smoother),
    Each([Smoother; 3]),
}

impl PoseTrack {
    /// The curve through the samples `from..to` of a stream.
    ///
    /// # Errors
    /// `SplineKnots` if the samples are not in order, which repair prevents.
    pub(crate) fn new(
        stream: &CleanStream,
        samples: std::ops::Range<usize>,
        curve: Curve,
        noise: PoseNoise,
    ) -> Result<Self, DatasetError> {
        let inner = stream.breaks.iter().copied().filter(|i| samples.contains(i));
        let mut edges: Vec<_> = std::iter::once(samples.start).chain(inner).collect();
        edges.push(samples.end);
        edges.dedup();
        let mut pieces = Vec::new();
        for pair in edges.windows(2).filter(|pair| pair[1] >= pair[0] + 2) {
            pieces.push(Piece::new(stream, pair[0]..pair[1], curve, noise)?);
        }
        let smooths = !matches!(curve, Curve::Interpolate(_));
        Ok(Self { pieces: pieces.into(), noise, smooths })
    }

    /// The same curve with an estimate of its samples' noise.
    pub(crate) fn with_noise(self, noise: PoseNoise) -> Self {
        Self { noise, ..self }
    }

    /// The pose at a time; none outside the samples and in gaps.
    pub(crate) fn pose(&self, t: f64) -> Option<Pose> {
        let curves = &self.piece(t)?.curves;
        let place = curves[0].place(t)?;
        let [x, y, angle] = curves.each_ref().map(|curve| curve.value_at(&place));
        Some(Pose::new(x, y, angle))
    }

    /// The position at a time, in m; none outside the samples and in gaps.
    pub(crate) fn position(&self, t: f64) -> Option<Vector2<f64>> {
        let [x, y, _] = &self.piece(t)?.curves;
        let place = x.place(t)?;
        Some(Vector2::new(x.value_at(&place), y.value_at(&place)))
    }

    /// Times of the knots at which there is a curve, and the positions there.
    pub(crate) fn knots(&self) -> impl Iterator<Item = (f64, Vector2<f64>)> {
        self.pieces.iter().flat_map(|Piece { curves: [x, y, _], .. }| {
            // As of the curve, which never gives a negative zero.
            let place = |(x, y): (&f64, &f64)| Vector2::new(*x + 0.0, *y + 0.0);
            x.knots().iter().copied().zip(x.values().iter().zip(y.values()).map(place))
        })
    }

    /// Velocity and yaw rate in the world at a time.
    pub(crate) fn twist(&self, t: f64) -> Option<Twist> {
        let curves = &self.piece(t)?.curves;
        let place = curves[0].place(t)?;
        let [x, y, angle] = curves.each_ref().map(|curve| curve.derivative_at(&place));
        Some(Twist { linear: Vector2::new(x, y), angular: angle })
    }

    /// Standard deviations of position (per axis) and yaw at a time, from the samples' noise.
    pub(crate) fn sd(&self, t: f64) -> Option<PoseNoise> {
        let gain = |smoother: &Smoother| match self.smooths {
            true => smoother.error_gain(t),
            false => smoother.noise_gain(t),
        };
        let [x, y, angle] = match &self.piece(t)?.smoothers {
            Smoothers::One(smoother) => [gain(smoother)?; 3],
            Smoothers::Each([x, y, angle]) => [gain(x)?, gain(y)?, gain(angle)?],
        };
        let mean_square = 0.5 * (x.powi(2) + y.powi(2));
        Some(PoseNoise {
            position: self.noise.position * mean_square.sqrt(),
            angle: self.noise.angle * angle,
        })
    }

    /// Whether both times lie in one piece.
    pub(crate) fn connects(&self, from: f64, to: f64) -> bool {
        self.piece(from).is_some_and(|piece| piece.curves[0].value(to).is_some())
    }

    fn piece(&self, t: f64) -> Option<&Piece> {
        let after = self.pieces.partition_point(|piece| piece.curves[0].span().0 <= t);
        self.pieces[..after].last().filter(|piece| t <= piece.curves[0].span().1)
    }
}

impl Piece {
    fn new(
        stream: &CleanStream,
        samples: std::ops::Range<usize>,
        curve: Curve,
        noise: PoseNoise,
    ) -> Result<Self, DatasetError> {
        let t = &stream.t[samples.clone()];
        let channel = |k: usize| &stream.channels[k][samples.clone()];
        let ends = match curve {
            Curve::Interpolate(ends) => ends,
            Curve::Smooth | Curve::SmoothKnown { .. } => {
                let (x, x_smoother) = smooth(t, channel(0), noise.position)?;
                let (y, y_smoother) = smooth(t, channel(1), noise.position)?;
                let (angle, angle_smoother) = smooth(t, channel(2), noise.angle)?;
                return Ok(Self {
                    curves: [x, y, angle],
                    smoothers: Smoothers::Each([x_smoother, y_smoother, angle_smoother]),
                });
            }
        };
        // The hat matrix of the natural spline also serves not-a-knot, which differs from it only
        // near the ends of a piece.
        let smoother = Smoother::new(t, 0.0)?;
        let curves = match ends {
            EndCondition::Natural => smoother.fit_columns([0, 1, 2].map(channel))?,
            EndCondition::NotAKnot => {
                let curve = |k: usize| CubicSpline::interpolate(t, channel(k), ends);
                [curve(0)?, curve(1)?, curve(2)?]
            }
        };
        Ok(Self { curves, smoothers: Smoothers::One(smoother) })
    }
}

/// The noise of a pose stream's samples between two times, estimated from neighbors.
pub(crate) fn pose_noise(stream: &CleanStream, from: f64, to: f64) -> Option<PoseNoise> {
    let range = stream.range(from, to);
    let t = &stream.t[range.clone()];
    let of = |channel: usize| noise_sd(t, &stream.channels[channel][range.clone()]);
    let (x, y, angle) = (of(0)?, of(1)?, of(2)?);
    Some(PoseNoise { position: (0.5 * (x * x + y * y)).sqrt(), angle })
}
