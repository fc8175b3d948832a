//! A limit surface as facets for drawing.

use std::f64::consts::{PI, TAU};

use anyhow::Result;
use mechanics::LimitSurface;
use planar::Wrench;

/// Points of the surface along rays from the origin, and the facets between them.
pub(crate) struct Rays {
    pub(crate) points: Vec<[f64; 3]>,
    pub(crate) facets: Vec<Vec<usize>>,
}

const COLUMNS: usize = 60;
const ROWS: usize = 30;

impl Rays {
    /// Shoots rays evenly in longitude and latitude; moments are scaled by the surface's length.
    pub(crate) fn shoot(surface: &dyn LimitSurface) -> Result<Self> {
        let length = surface.characteristic_length();
        let mut points = Vec::with_capacity((ROWS + 1) * COLUMNS);
        for row in 0..=ROWS {
            let latitude = PI * (row as f64 / ROWS as f64 - 0.5);
            for column in 0..COLUMNS {
                let longitude = TAU * column as f64 / COLUMNS as f64;
                let (sin, cos) = longitude.sin_cos();
                let ring = latitude.cos();
                let ray = Wrench::new(ring * cos, ring * sin, length * latitude.sin());
                let on_surface = 1.0 / surface.level(&ray)? * ray;
                points.push([on_surface.force.x, on_surface.force.y, on_surface.torque]);
            }
        }
        let facets = (0..ROWS)
            .flat_map(|row| (0..COLUMNS).map(move |column| (row * COLUMNS, column)))
            .map(|(start, column)| {
                let next = (column + 1) % COLUMNS;
                vec![start + column, start + next, start + COLUMNS + next, start + COLUMNS + column]
            })
            .collect();
        Ok(Self { points, facets })
    }

    /// One coordinate (0: Fx, 1: Fy, 2: M) of all points.
    pub(crate) fn column(&self, k: usize) -> Vec<f64> {
        self.points.iter().map(|point| point[k]).collect()
    }
}
