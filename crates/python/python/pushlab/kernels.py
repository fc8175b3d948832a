"""Covariance functions of Gaussian processes.

Kernels are added and multiplied: ``Matern52() + Linear()``, ``2.0 * Periodic(1.0)``. A lengthscale, a period
or a slope variance is one number for all inputs, or a list of one an input. Lengthscales are in the unit of
their input, variances in the squared unit of the output. Regressors take the values as the family and the
start of what they learn.
"""

from __future__ import annotations

import json
from typing import Any, Sequence, Union

import numpy as np

__all__ = [
    "Constant",
    "Cosine",
    "Kernel",
    "Linear",
    "Matern12",
    "Matern32",
    "Matern52",
    "Periodic",
    "Polynomial",
    "RationalQuadratic",
    "SquaredExponential",
    "White",
]

#: One number for all inputs, or one an input.
PerInput = Union[float, Sequence[float]]


class Kernel:
    """A covariance function k(x, x′)."""

    def __init__(self, spec: dict[str, Any]) -> None:
        self._spec = spec

    @property
    def spec(self) -> dict[str, Any]:
        """Kind and parameters as plain data."""
        return self._spec

    def to_json(self) -> str:
        """The same as text."""
        return json.dumps(self._spec)

    def active(self, columns: Sequence[int]) -> Kernel:
        """The kernel over some of the inputs, by their columns from 0."""
        return Kernel({"kind": "active_inputs", "kernel": self._spec, "columns": list(columns)})

    def __add__(self, other: Union[Kernel, float]) -> Kernel:
        return Kernel({"kind": "sum", "first": self._spec, "second": _kernel(other)._spec})

    def __radd__(self, other: float) -> Kernel:
        return _kernel(other) + self

    def __mul__(self, other: Union[Kernel, float]) -> Kernel:
        return Kernel({"kind": "product", "first": self._spec, "second": _kernel(other)._spec})

    def __rmul__(self, other: float) -> Kernel:
        return _kernel(other) * self

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Kernel) and self._spec == other._spec

    def __hash__(self) -> int:
        return hash(self.to_json())

    def __repr__(self) -> str:
        return f"Kernel({_told(self._spec)})"


def _kernel(value: Union[Kernel, float]) -> Kernel:
    return value if isinstance(value, Kernel) else Constant(float(value))


def _told(spec: dict[str, Any]) -> str:
    kind = spec["kind"]
    if kind in ("sum", "product"):
        sign = " + " if kind == "sum" else " * "
        return f"({_told(spec['first'])}{sign}{_told(spec['second'])})"
    if kind == "active_inputs":
        return f"{_told(spec['kernel'])}.active({spec['columns']})"
    name = "".join(part.capitalize() for part in kind.split("_"))
    return f"{name}({', '.join(f'{key}={value}' for key, value in spec.items() if key != 'kind')})"


def _each(value: PerInput) -> Any:
    return float(value) if np.ndim(value) == 0 else [float(one) for one in value]  # type: ignore[arg-type,union-attr]


def _radial(
    kind: str, lengthscale: PerInput, signal_variance: float, **more: Any
) -> dict[str, Any]:
    scales = {"lengthscales": _each(lengthscale), "signal_variance": float(signal_variance)}
    return {"kind": kind, **scales, **more}


class SquaredExponential(Kernel):
    """s² exp(−r²/2), r the distance in lengthscales: infinitely smooth."""

    def __init__(self, lengthscale: PerInput = 1.0, signal_variance: float = 1.0) -> None:
        super().__init__(_radial("squared_exponential", lengthscale, signal_variance))


class Matern12(Kernel):
    """s² exp(−r): continuous, and rough."""

    def __init__(self, lengthscale: PerInput = 1.0, signal_variance: float = 1.0) -> None:
        super().__init__(_radial("matern12", lengthscale, signal_variance))


class Matern32(Kernel):
    """Matérn with ν = 3/2: differentiable once."""

    def __init__(self, lengthscale: PerInput = 1.0, signal_variance: float = 1.0) -> None:
        super().__init__(_radial("matern32", lengthscale, signal_variance))


class Matern52(Kernel):
    """Matérn with ν = 5/2: differentiable twice."""

    def __init__(self, lengthscale: PerInput = 1.0, signal_variance: float = 1.0) -> None:
        super().__init__(_radial("matern52", lengthscale, signal_variance))


class RationalQuadratic(Kernel):
    """s² (1 + r²/2α)^−α: squared exponentials of many lengthscales."""

    def __init__(
        self, lengthscale: PerInput = 1.0, alpha: float = 1.0, signal_variance: float = 1.0
    ) -> None:
        super().__init__(
            _radial("rational_quadratic", lengthscale, signal_variance, alpha=float(alpha))
        )


class Polynomial(Kernel):
    """A polynomial of the inputs over their lengthscales, of a degree."""

    def __init__(
        self, degree: int, lengthscale: PerInput = 1.0, signal_variance: float = 1.0
    ) -> None:
        super().__init__(_radial("polynomial", lengthscale, signal_variance, degree=int(degree)))


class Periodic(Kernel):
    """Functions that repeat after a period; lengthscales have no unit."""

    def __init__(self, period: PerInput, lengthscale: PerInput = 1.0) -> None:
        scales = {"periods": _each(period), "lengthscales": _each(lengthscale)}
        super().__init__({"kind": "periodic", **scales})


class Cosine(Kernel):
    """A cosine of a period."""

    def __init__(self, period: PerInput, signal_variance: float = 1.0) -> None:
        signal = float(signal_variance)
        super().__init__({"kind": "cosine", "periods": _each(period), "signal_variance": signal})


class Linear(Kernel):
    """Linear functions through the origin; slope variances in squared units of output over input."""

    def __init__(self, slope_variance: PerInput = 1.0) -> None:
        super().__init__({"kind": "linear", "slope_variances": _each(slope_variance)})


class Constant(Kernel):
    """Constants of a variance."""

    def __init__(self, variance: float = 1.0) -> None:
        super().__init__({"kind": "constant", "variance": float(variance)})


class White(Kernel):
    """Noise of a variance in the function itself."""

    def __init__(self, variance: float = 1.0) -> None:
        super().__init__({"kind": "white", "variance": float(variance)})
