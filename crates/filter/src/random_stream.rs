//! Random numbers that depend on the seed, the step and the chunk, never on the thread.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Particles that share a stream of random numbers.
pub(crate) const CHUNK: usize = 1024;

/// What random numbers are for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    Motion,
    Resampling,
    Injection,
    Smoothing,
}

/// The stream of a chunk of particles in one step.
pub(crate) fn stream(seed: u64, purpose: Purpose, step: usize, chunk: usize) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    // 38 bits of steps, 24 of chunks: 17 billion particles.
    random.set_stream(((step as u64) << 26) | ((chunk as u64) << 2) | purpose as u64);
    random
}
