//! What is learnt beside the physics, projected away from what the physics can explain.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::physics::fit::{PhysicsFit, weighed};
use crate::physics::{Free, Physics};
use crate::{ModelError, OrthogonalDiscrepancy, StepInput, Unexplained};

impl OrthogonalDiscrepancy {
    /// For processes with the means `learnt` beside the physics of a fit, at the training steps.
    pub(crate) fn of(
        fit: &PhysicsFit,
        steps: &[&StepInput],
        learnt: &[Vector3<f64>],
    ) -> Result<Self, ModelError> {
        let slopes = fit.physics.jacobian(&fit.free, steps)?;
        let taken = solved(&slopes, learnt, &fit.output_sd);
        let mut beside = Self {
            parameters: fit.free.iter().map(|free| free.name.clone()).collect(),
            taken,
            covariance: rows(&fit.covariance),
            output_sd: fit.output_sd.into(),
            physics_mean: [0.0; 3],
            unexplained: Unexplained::default(),
        };
        let left = beside.left(learnt, &slopes);
        beside.measure(steps, &fit.physics.outputs(steps)?, &left);
        Ok(beside)
    }

    /// For processes that are not projected.
    pub(crate) fn unprojected(
        physics: &Physics,
        output_sd: Vector3<f64>,
        steps: &[&StepInput],
        learnt: &[Vector3<f64>],
    ) -> Result<Self, ModelError> {
        let mut beside = Self {
            parameters: Vec::new(),
            taken: Vec::new(),
            covariance: Vec::new(),
            output_sd: output_sd.into(),
            physics_mean: [0.0; 3],
            unexplained: Unexplained::default(),
        };
        beside.measure(steps, &physics.outputs(steps)?, learnt);
        Ok(beside)
    }

    /// The free parameters that γ belongs to.
    ///
    /// # Errors
    /// `OtherPhysics` where the physics have not all of them.
    pub(crate) fn free(
        &self,
        physics: &Physics,
        step: &StepInput,
    ) -> Result<Vec<Free>, ModelError> {
        let free = physics.chosen(&self.parameters, step)?;
        match self.parameters.iter().find(|name| !free.iter().any(|free| free.name == **name)) {
            Some(name) => Err(ModelError::OtherPhysics { parameter: name.clone() }),
            None => Ok(free),
        }
    }
}

/// The weighed least-squares coefficients of values in the slopes, by orthogonal factorisation.
fn solved(
    slopes: &[Vec<Vector3<f64>>],
    values: &[Vector3<f64>],
    output_sd: &Vector3<f64>,
) -> Vec<f64> {
    if slopes.is_empty() {
        return Vec::new();
    }
    let scaled = values.iter().flat_map(|value| value.component_div(output_sd).data.0[0]);
    let right = DVector::from_iterator(3 * values.len(), scaled);
    let factors = weighed(slopes, output_sd).qr();
    let along = factors.q().tr_mul(&right);
    // The fit has left out the columns that would make this triangle singular.
    let solution = factors.r().solve_upper_triangular(&along);
    solution.map_or_else(|| vec![0.0; slopes.len()], |solution| solution.as_slice().to_vec())
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}
