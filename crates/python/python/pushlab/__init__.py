"""Find out what your model of pushing lacks: recordings of robot pushes, models of them, and a diagnosis.

- recordings: :class:`RecordingSet`, :func:`read_steps`, :class:`Steps`, :func:`generate`
- models: :class:`Model`, :func:`fit`, :func:`train`, :func:`add`, :func:`calibrate`
- how they do: :func:`check`, :func:`compare`, :func:`diagnose`, :func:`suggest`, :func:`simulate`,
  :func:`report`
- learning and filtering without pushes: :mod:`pushlab.sklearn`, :mod:`pushlab.kernels`,
  :class:`ParticleFilter`

Units are SI, and stand behind the names of columns. Every error is a :class:`PushlabError`.
"""

from . import kernels
from ._call import Progress, PushlabWarning
from ._comparison import Comparison
from ._diagnosis import Diagnosis
from ._native import PushlabError
from ._result import Result
from .analysis import (
    MadeModel,
    Report,
    Simulation,
    Svg,
    add,
    calibrate,
    check,
    command,
    compare,
    diagnose,
    fit,
    generate,
    report,
    simulate,
    suggest,
    train,
)
from .filter import ParticleFilter, Update
from .model import Model, Prediction
from .recordings import RecordingSet, Steps, read_steps

__all__ = [
    "Comparison",
    "Diagnosis",
    "MadeModel",
    "Model",
    "ParticleFilter",
    "Prediction",
    "Progress",
    "PushlabError",
    "PushlabWarning",
    "RecordingSet",
    "Report",
    "Result",
    "Simulation",
    "Steps",
    "Svg",
    "Update",
    "add",
    "calibrate",
    "check",
    "command",
    "compare",
    "diagnose",
    "fit",
    "generate",
    "kernels",
    "read_steps",
    "report",
    "simulate",
    "suggest",
    "train",
]
