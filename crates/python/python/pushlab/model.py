"""Pushing models: what a step of a push does to the object."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Optional

import numpy as np

from . import _native
from ._call import Progress, Teller, call, words
from ._result import Result, Shown
from ._source import Source, named
from .recordings import PathLike, Steps


@dataclass(frozen=True)
class Prediction:
    """Gaussians over the motion of the object in some steps."""

    #: The rows of the table that are steps in contact, N numbers from 0; others have no prediction.
    rows: np.ndarray
    #: Expected motion, N×3: along the pusher's motion (m), along its left normal (m), counter-clockwise
    #: (rad); as the columns ``dx_m``, ``dy_m`` and ``dtheta_rad`` of the table.
    mean: np.ndarray
    #: Covariances, N×3×3, in the same units.
    covariance: np.ndarray

    @property
    def sd(self) -> np.ndarray:
        """Standard deviations, N×3."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))


class Model(Shown):
    """A pushing model, from a ``model.toml`` or made by a function of this package.

    It does not change: functions such as :func:`pushlab.add` give another one.
    """

    def __init__(self, path: PathLike) -> None:
        self._native = _native.Model.read(path)
        self._path = Path(path)
        self._folder: Optional[tempfile.TemporaryDirectory[str]] = None

    @classmethod
    def read(cls, path: PathLike) -> Model:
        """Reads a model file, and its weights beside it if it has some.

        Raises :class:`pushlab.PushlabError` with line and key of what the format does not allow.
        """
        return cls(path)

    @classmethod
    def _within(cls, folder: tempfile.TemporaryDirectory[str]) -> Model:
        """The model that a command left in a folder, which lives as long as the model."""
        model = cls(Path(folder.name) / "model.toml")
        model._folder = folder
        return model

    @classmethod
    def nominal(cls, source: Source) -> Model:
        """The analytical model with the nominal values of a recording set or table.

        An ellipsoidal limit surface of uniform pressure, and the pusher's friction of the manifest.
        """
        folder = tempfile.TemporaryDirectory(prefix="pushlab-")
        with named(source) as (path, about):
            output = Path(folder.name) / "model.toml"
            call(words("models", "init", path, **about, output=output), progress=False)
        return cls._within(folder)

    @property
    def path(self) -> Path:
        """The file; of a model that was not saved, one that lives as long as this object."""
        return self._path

    @property
    def name(self) -> str:
        """The model's name."""
        return self._native.name

    @property
    def effects(self) -> list[str]:
        """Ids of the physical effects that it carries."""
        return self._native.effects

    @property
    def held_out(self) -> list[str]:
        """The pushes that no fit of it has seen, as ``recording#push``; none for one that was not fitted.

        :attr:`pushlab.Steps.pushes` has the same names for each row.
        """
        return self._native.split[1] if self._native.split else []

    @property
    def parameters(self) -> Result:
        """Kind, parameters, their standard errors and sources, as ``pushlab models show`` says them."""
        return Result(*call(words("models", "show", self._path), progress=False))

    @property
    def text(self) -> str:  # type: ignore[override]
        """The same in words."""
        return self.parameters.text

    def save(self, path: PathLike, *, replace: bool = False) -> Model:
        """Writes the model, with its weights beside it, and returns the model of that file.

        A file that is there is refused, unless ``replace``.
        """
        self._native.write(path, replace)
        return Model(path)

    def predict(self, steps: Steps, *, noise: bool = True, progress: Progress = True) -> Prediction:
        """The motion of the object in the steps of a table that are in contact.

        - ``noise``: whether covariances are of an observed step (what the model does not know, and what
          scatters between repeats), or of the model's own function alone.

        Raises :class:`pushlab.PushlabError` for a table that does not tell its rig (see
        :func:`read_steps`), and for what the mechanics refuse.
        """
        with Teller(progress) as tell:
            return Prediction(*self._native.predict(steps._table, noise=noise, tell=tell))

    def __repr__(self) -> str:
        return f"<Model {self.name!r}>"
