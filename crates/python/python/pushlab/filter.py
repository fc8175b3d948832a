"""A particle filter over any state, with models that are functions of NumPy arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Union

import numpy as np

from . import _native

#: Moves states, n×D, with randomness from the generator, and returns them, n×D.
Motion = Callable[[np.ndarray, np.random.Generator], np.ndarray]
#: The log density of a measurement under each state, n×D → n, up to a constant; −inf where impossible.
Likelihood = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Update:
    """What a measurement did."""

    #: Log density of the measurement given all before it.
    log_evidence: float
    #: Effective number of particles with the new weights, before any resampling.
    effective_size: float
    #: Whether particles were drawn anew.
    resampled: bool


class ParticleFilter:
    """A distribution over states as N weighted particles.

    - ``particles``: N×D, of equal weight.
    - ``resampler``: ``systematic``, ``stratified``, ``residual`` or ``multinomial``.
    - ``resample_below``: particles are drawn anew when their effective number falls below this share of
      N, from 0 (never) to 1.
    - ``seed``: of everything random; the same seed gives the same particles for any number of threads.

    For example, something that walks and is seen::

        def walk(x, rng):
            return x + [1.0] + 0.1 * rng.standard_normal(x.shape)

        filter = pushlab.ParticleFilter(np.zeros((10_000, 1)))
        filter.predict(walk)
        filter.update(lambda x: -0.5 * ((x[:, 0] - 1.2) / 0.2) ** 2)
        filter.mean()
    """

    def __init__(
        self,
        particles: Any,
        *,
        resampler: str = "systematic",
        resample_below: float = 0.5,
        seed: int = 7,
    ) -> None:
        particles = np.asarray(particles, dtype=np.float64)
        if particles.ndim != 2:
            raise _native.PushlabError(
                f"particles must be an array N×D, got one of shape {particles.shape}"
            )
        self._filter = _native.ParticleFilter(particles, resampler, resample_below, seed)

    @property
    def particles(self) -> np.ndarray:
        """The states, N×D (a copy)."""
        return self._filter.particles

    @property
    def weights(self) -> np.ndarray:
        """Their weights, N, which sum to 1 (a copy)."""
        return self._filter.weights

    @property
    def effective_size(self) -> float:
        """Effective number of particles 1/Σw², from 1 to N."""
        return self._filter.effective_size

    @property
    def step(self) -> int:
        """Motions made so far."""
        return self._filter.step

    def predict(self, motion: Motion) -> None:
        """Moves every particle by one step.

        ``motion(states, rng)`` is called for blocks of at most 1024 particles, each with a generator of
        its own, and returns the moved ones in the same shape. What it raises is raised here.
        """

        def move(states: np.ndarray, seed: int) -> np.ndarray:
            moved = motion(states, np.random.default_rng(seed))
            return np.ascontiguousarray(moved, dtype=np.float64)

        self._filter.predict(move)

    def update(self, log_likelihood: Union[Likelihood, np.ndarray]) -> Update:
        """Weighs the particles by a measurement, and draws them anew where ``resample_below`` asks for it.

        - ``log_likelihood``: a function of the states (N×D → N), or its N values.

        Raises :class:`pushlab.PushlabError` if no particle can explain the measurement; the filter is
        then as before.
        """
        values = log_likelihood(self.particles) if callable(log_likelihood) else log_likelihood
        values = np.asarray(values, dtype=np.float64)
        if values.ndim != 1:
            raise _native.PushlabError(
                f"log likelihoods must be one number a particle, got an array of shape {values.shape}"
            )
        return Update(*self._filter.update(np.ascontiguousarray(values)))

    def resample(self) -> None:
        """Draws all particles anew by their weights, which become equal."""
        self._filter.resample()

    def mean(self) -> np.ndarray:
        """The weighted mean of the states, D."""
        return self.weights @ self.particles

    def covariance(self) -> np.ndarray:
        """The weighted covariance of the states, D×D."""
        off = self.particles - self.mean()
        return (self.weights[:, None] * off).T @ off

    def __repr__(self) -> str:
        n, dimension = self.particles.shape
        return f"<ParticleFilter: {n} particles of {dimension} numbers, {self.effective_size:.0f} effective>"
