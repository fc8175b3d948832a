//! Limit surfaces as grids of loads, for drawing.

use crate::{LimitSurface, MechanicsError};
use planar::{Twist, Wrench};
use std::f64::consts::{PI, TAU};

/// A closed surface as rows from the clockwise to the counter-clockwise turn.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Loads, in N and N·m; row by row, each row closed by its first load.
    pub wrenches: Vec<Vec<Wrench>>,
    /// The outward normals there: motions of unit size in (vx, vy, ω ρ).
    pub normals: Vec<Vec<Twist>>,
}

/// The loads of `2n + 1` by `4n + 1` motions, evenly spread in latitude and longitude of
/// (vx, vy, ω ρ); ρ is `length`, in m.
///
/// A facet shows as the gap between its center and the loads of the neighboring motions.
///
/// # Errors
/// `NotPositive` for the length, and those of the surface.
pub fn mesh(surface: &dyn LimitSurface, length: f64, n: usize) -> Result<Mesh, MechanicsError> {
    if !(length > 0.0 && length.is_finite()) {
        let name = "length of the mesh";
        return Err(MechanicsError::NotPositive { name, value: length, unit: "m" });
    }
    let n = n.max(1);
    let motion = |row: usize, column: usize| {
        let (height, level) = (PI * (row as f64 / (2 * n) as f64 - 0.5)).sin_cos();
        let (sin, cos) = (TAU * (column % (4 * n)) as f64 / (4 * n) as f64).sin_cos();
        Twist::new(level * cos, level * sin, height / length)
    };
    let normals: Vec<Vec<_>> =
        (0..=2 * n).map(|row| (0..=4 * n).map(|column| motion(row, column)).collect()).collect();
    let wrenches = normals
        .iter()
        .map(|row| row.iter().map(|twist| surface.wrench(twist)).collect())
        .collect::<Result<_, _>>()?;
    Ok(Mesh { wrenches, normals })
}

#[cfg(test)]
mod tests {
    use super::mesh;
    use crate::{Ellipsoid, LimitSurface};

    #[test]
    fn a_mesh_is_closed_on_the_surface_and_its_normals_point_outward() {
        let surface = Ellipsoid::new(2.0, 0.08).unwrap();
        let mesh = mesh(&surface, 0.04, 6).unwrap();
        assert_eq!((mesh.wrenches.len(), mesh.wrenches[0].len()), (13, 25));
        for (row, normals) in mesh.wrenches.iter().zip(&mesh.normals) {
            assert_eq!(row.first(), row.last());
            for (wrench, normal) in row.iter().zip(normals) {
                assert!((surface.level(wrench).unwrap() - 1.0).abs() < 1e-14);
                assert!(wrench.power(normal) > 0.0);
            }
        }
    }
}
