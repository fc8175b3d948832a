"""Gaussian processes as regressors of scikit-learn, with their uncertainty. Needs scikit-learn.

Three that predict alike and differ in their cost: exact to a few thousand rows, through learnt
pseudo-inputs, and on random features for a hundred thousand rows and more. Hyperparameters are learnt from
the marginal likelihood; starts come from the data, so nothing needs to be standardised first. The same
``random_state`` gives the same numbers whatever the number of threads.
"""

from __future__ import annotations

import json
from typing import Any, Mapping, Optional, Union

import numpy as np
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils import check_random_state
from sklearn.utils.validation import check_is_fitted, validate_data

from . import _native
from .kernels import Kernel, SquaredExponential

__all__ = [
    "GaussianProcessRegressor",
    "RandomFeatureGaussianProcessRegressor",
    "SparseGaussianProcessRegressor",
]


class _Regressor(RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """What the regressors share once they have a posterior."""

    def predict(
        self, X: Any, return_std: bool = False, return_cov: bool = False, noise: bool = False
    ) -> Any:
        """The mean of the function at each row of ``X`` (M×D): M numbers.

        - ``return_std``: its standard deviations as well, M.
        - ``return_cov``: its covariance of all rows together as well, M×M.
        - ``noise``: whether these are of an observation, and not of the function without noise.

        Raises ``ValueError`` if both are asked for, or for another number of inputs than was learnt from.
        """
        if return_std and return_cov:
            raise ValueError("return_std and return_cov cannot both be asked for")
        X = self._inputs(X)
        if return_cov:
            mean, covariance = self.posterior_.predict_joint(X)
            if noise:
                covariance[np.diag_indices_from(covariance)] += self.posterior_.predict_noise(X)
            return mean, covariance
        if return_std:
            mean, variance = self.posterior_.predict(X)
            if noise:
                variance = variance + self.posterior_.predict_noise(X)
            return mean, np.sqrt(variance)
        return self.posterior_.predict_mean(X)

    def sample_y(self, X: Any, n_samples: int = 1, random_state: Any = 0) -> np.ndarray:
        """Draws of the function at all rows of ``X`` together, M×``n_samples``."""
        return self.posterior_.sample(self._inputs(X), n_samples, _seed(random_state))

    @property
    def hyperparameters_(self) -> dict[str, float]:
        """The kernel's parameters and ``noise_variance``, in the units of the data."""
        return dict(self.posterior_.hyperparameters)

    @property
    def log_marginal_likelihood_value_(self) -> float:
        """The log marginal likelihood of the rows, in nats; of a sparse process its bound or stand-in."""
        return self.posterior_.log_marginal_likelihood

    def _inputs(self, X: Any) -> np.ndarray:
        check_is_fitted(self, "posterior_")
        return validate_data(self, X, reset=False, dtype=np.float64, order="C")

    def _rows(self, X: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
        X, y = validate_data(
            self, X, y, dtype=np.float64, order="C", y_numeric=True, ensure_min_samples=2
        )
        return X, np.ascontiguousarray(y, dtype=np.float64)

    def _kernel(self, kernel: Optional[Kernel], n_inputs: int) -> str:
        if kernel is None:
            kernel = SquaredExponential([1.0] * n_inputs)
        if not isinstance(kernel, Kernel):
            raise TypeError(f"kernel must be one of pushlab.kernels, got {kernel!r}")
        return kernel.to_json()

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.regressor_tags.poor_score = False
        return tags


class GaussianProcessRegressor(_Regressor):
    """The exact Gaussian process: O(N³) time, for a few thousand rows.

    - ``kernel``: family and start, of :mod:`pushlab.kernels`; else a squared exponential with a
      lengthscale an input.
    - ``alpha``: known noise variance of each row (N, or one number for all) beside the learnt one, in the
      squared unit of the output.
    - ``noise_variance``: where learning starts, or with ``learn=False`` what it is.
    - ``mean``: ``"constant"`` or ``"linear"``, learnt and integrated out, or a known number.
    - ``learn``: whether hyperparameters are learnt, or kept as the kernel has them.
    - ``fixed``, ``bounds``: values and ranges of hyperparameters by name, such as
      ``{"matern52.lengthscale[0]": 0.1}``; a name without its index stands for all.
    - ``n_starts``: of the optimiser; ``random_state``: an int, a ``RandomState`` or None.
    """

    def __init__(
        self,
        kernel: Optional[Kernel] = None,
        *,
        alpha: Any = 0.0,
        noise_variance: Optional[float] = None,
        mean: Union[str, float] = "constant",
        learn: bool = True,
        fixed: Optional[Mapping[str, float]] = None,
        bounds: Optional[Mapping[str, tuple[float, float]]] = None,
        n_starts: int = 4,
        random_state: Any = 0,
    ) -> None:
        self.kernel = kernel
        self.alpha = alpha
        self.noise_variance = noise_variance
        self.mean = mean
        self.learn = learn
        self.fixed = fixed
        self.bounds = bounds
        self.n_starts = n_starts
        self.random_state = random_state

    def fit(self, X: Any, y: Any) -> GaussianProcessRegressor:
        """Learns from rows ``X`` (N×D) and outputs ``y`` (N).

        Raises :class:`pushlab.PushlabError` for what cannot be learnt from, such as outputs that are all
        the same, with what to do.
        """
        X, y = self._rows(X, y)
        noise = np.broadcast_to(np.asarray(self.alpha, dtype=np.float64), y.shape)
        mean = {"constant": "estimated", "linear": "linear"}.get(self.mean, {"fixed": self.mean})  # type: ignore[arg-type]
        self.posterior_ = _native.Posterior.exact(
            self._kernel(self.kernel, X.shape[1]),
            X,
            y,
            noise_variance=self.noise_variance,
            row_noise=np.ascontiguousarray(noise) if noise.any() else None,
            mean=json.dumps(mean),
            learn=self.learn,
            fixed=list((self.fixed or {}).items()),
            bounds=[(name, low, high) for name, (low, high) in (self.bounds or {}).items()],
            n_starts=self.n_starts,
            seed=_seed(self.random_state),
        )
        return self

    @property
    def report_(self) -> Optional[str]:
        """How learning went: every start, and what ended at a bound."""
        return self.posterior_.report


class SparseGaussianProcessRegressor(_Regressor):
    """A Gaussian process through M learnt pseudo-inputs: O(N M²) time, for tens of thousands of rows.

    - ``n_pseudo_inputs``: M, at most the number of rows.
    - ``approximation``: ``"vfe"``, ``"fitc"`` (SPGP) or ``"dtc"``.
    - ``kernel``, ``n_starts``, ``random_state``: as of :class:`GaussianProcessRegressor`.
    """

    def __init__(
        self,
        kernel: Optional[Kernel] = None,
        *,
        n_pseudo_inputs: int = 50,
        approximation: str = "vfe",
        n_starts: int = 1,
        random_state: Any = 0,
    ) -> None:
        self.kernel = kernel
        self.n_pseudo_inputs = n_pseudo_inputs
        self.approximation = approximation
        self.n_starts = n_starts
        self.random_state = random_state

    def fit(self, X: Any, y: Any) -> SparseGaussianProcessRegressor:
        """Learns from rows ``X`` (N×D) and outputs ``y`` (N); raises :class:`pushlab.PushlabError`."""
        X, y = self._rows(X, y)
        self.posterior_ = _native.Posterior.sparse(
            self._kernel(self.kernel, X.shape[1]),
            X,
            y,
            n_pseudo_inputs=min(self.n_pseudo_inputs, len(y)),
            approximation=self.approximation,
            n_starts=self.n_starts,
            seed=_seed(self.random_state),
        )
        return self


class RandomFeatureGaussianProcessRegressor(_Regressor):
    """A Gaussian process on M random Fourier features: O(N M²) time, for a hundred thousand rows and more.

    - ``kernel``: ``"squared_exponential"``, ``"matern32"`` or ``"matern52"``, with a lengthscale an input.
    - ``n_features``: M.
    - ``n_starts``, ``random_state``: as of :class:`GaussianProcessRegressor`.
    """

    def __init__(
        self,
        kernel: str = "squared_exponential",
        *,
        n_features: int = 200,
        n_starts: int = 2,
        random_state: Any = 0,
    ) -> None:
        self.kernel = kernel
        self.n_features = n_features
        self.n_starts = n_starts
        self.random_state = random_state

    def fit(self, X: Any, y: Any) -> RandomFeatureGaussianProcessRegressor:
        """Learns from rows ``X`` (N×D) and outputs ``y`` (N); raises :class:`pushlab.PushlabError`."""
        X, y = self._rows(X, y)
        self.posterior_ = _native.Posterior.features(
            self.kernel,
            X,
            y,
            n_features=self.n_features,
            n_starts=self.n_starts,
            seed=_seed(self.random_state),
        )
        return self


def _seed(random_state: Any) -> int:
    if isinstance(random_state, (int, np.integer)) and not isinstance(random_state, bool):
        return int(random_state)
    return int(check_random_state(random_state).randint(np.iinfo(np.int32).max))
