//! The extension module `pushlab._native`, which the package's Python is written on.

/// What of the Rust crates Python sees; `pushlab/_native.pyi` says it with types.
#[pyo3::pymodule(name = "_native")]
mod native {
    #[pymodule_export]
    use crate::commands::run;
    #[pymodule_export]
    use crate::failure::PushlabError;
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::particle_filter::ParticleFilter;
    #[pymodule_export]
    use crate::posterior::Posterior;
    #[pymodule_export]
    use crate::recordings::RecordingSet;
    #[pymodule_export]
    use crate::steps::Steps;
}
