"""The dataclasses of pushlab.compare/1, written by tests/schemas.py from its schema."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Dict, List, Optional

from ._result import Documented


@dataclass(frozen=True)
class ComparisonMadeByInput:
    """A part of Comparison."""

    path: str
    sha256: str


@dataclass(frozen=True)
class ComparisonMadeBy:
    """A part of Comparison."""

    tool: str
    arguments: List[str]
    inputs: List[ComparisonMadeByInput]


@dataclass(frozen=True)
class ComparisonPart:
    """A part of Comparison."""

    #: One of all, confirm.
    pushes: str
    n_fitted: Optional[int] = None


@dataclass(frozen=True)
class ComparisonUnexplained:
    """A part of Comparison."""

    dx: float
    dy: float
    dtheta: float
    all: float


@dataclass(frozen=True)
class ComparisonRuns:
    """A part of Comparison."""

    n: int
    n_rows: int
    shared: float
    p: float
    beta: float


@dataclass(frozen=True)
class ComparisonDoubtful:
    """A part of Comparison."""

    #: One of no_motion, off_normal, fast_slide.
    what: str
    n_steps: int
    n_pushes: int
    step_share: float
    error_share: float


@dataclass(frozen=True)
class ComparisonChannelFloor:
    """A part of Comparison."""

    rms: float
    low95: float
    high95: float
    constant: float
    per_meter: float


@dataclass(frozen=True)
class ComparisonChannel:
    """A part of Comparison."""

    #: One of dx, dy, dtheta, force_normal, force_tangential, gap_start, gap_end.
    name: str
    #: One of motion, force, gap.
    channel: str
    #: One of m, rad, N.
    unit: str
    n_steps: int
    rms: float
    rms_se: float
    bias: float
    bias_se: float
    nmse: Optional[float]
    floor: Optional[ComparisonChannelFloor]
    over_floor: Optional[float]


@dataclass(frozen=True)
class ComparisonFloorFloor:
    """A part of Comparison."""

    rms: float
    low95: float
    high95: float
    constant: float
    per_meter: float


@dataclass(frozen=True)
class ComparisonFloor:
    """A part of Comparison."""

    #: One of repeats, neighbours.
    source: str
    n_repeats: int
    n_cells: int
    numbers: List[Optional[ComparisonFloorFloor]]
    widened: Optional[List[str]] = None


@dataclass(frozen=True)
class ComparisonCovered:
    """A part of Comparison."""

    level: float
    share: float


@dataclass(frozen=True)
class ComparisonCalibration:
    """A part of Comparison."""

    #: One of dx, dy, dtheta, force_normal, force_tangential, gap_start, gap_end.
    name: str
    #: One of m, rad, N.
    unit: str
    n_steps: int
    coverage: List[ComparisonCovered]
    nlpd: float
    crps: float
    curve: List[ComparisonCovered]


@dataclass(frozen=True)
class ComparisonWorst:
    """A part of Comparison."""

    recording: str
    push: int
    n_steps: int
    rms: List[float]
    over_mean: float


@dataclass(frozen=True)
class ComparisonCondition:
    """A part of Comparison."""

    _keys: ClassVar[Dict[str, str]] = {"from_": "from"}
    #: One of p, beta, speed, orientation, direction, table_x, table_y, time, edge.
    covariate: str
    from_: Optional[float]
    to: Optional[float]


@dataclass(frozen=True)
class ComparisonFinding:
    """A part of Comparison."""

    sentence: str
    #: One of dx, dy, drift, dtheta, turn, force_normal, force_tangential, gap_start, gap_end.
    name: str
    #: One of m, rad, N.
    unit: str
    conditions: List[ComparisonCondition]
    n_steps: int
    n_pushes: int
    mean: float
    low95: float
    high95: float
    is_further: bool
    over_floor: Optional[float]
    share: float
    p_adjusted: float


@dataclass(frozen=True)
class ComparisonConcentration:
    """A part of Comparison."""

    sentence: str
    #: One of dx, dy, dtheta, force_normal, force_tangential, gap_start, gap_end.
    name: str
    #: One of m, rad, N.
    unit: str
    conditions: List[ComparisonCondition]
    n_steps: int
    n_pushes: int
    rms: float
    rms_elsewhere: float
    error_share: float
    step_share: float


@dataclass(frozen=True)
class ComparisonMapCell:
    """A part of Comparison."""

    ranges: List[List[float]]
    n_steps: int
    n_pushes: int
    mean: float
    low95: float
    high95: float
    rms: float
    over_floor: Optional[float]


@dataclass(frozen=True)
class ComparisonMap:
    """A part of Comparison."""

    #: One of dx, dy, drift, dtheta, turn, force_normal, force_tangential, gap_start, gap_end.
    name: str
    #: One of m, rad, N.
    unit: str
    covariates: List[str]
    cells: List[ComparisonMapCell]
    p_adjusted: float


@dataclass(frozen=True)
class ComparisonSuspicion:
    """A part of Comparison."""

    what: str
    evidence: str
    fix: str
    is_certain: bool


@dataclass(frozen=True)
class ComparisonSpread:
    """A part of Comparison."""

    mean: float
    median: float
    p90: float


@dataclass(frozen=True)
class ComparisonRollOutPush:
    """A part of Comparison."""

    recording: str
    push: int
    n_steps: int
    way: float
    position_error: float
    angle_error: float
    lost_contact: bool


@dataclass(frozen=True)
class ComparisonRollOut:
    """A part of Comparison."""

    position: ComparisonSpread
    angle: ComparisonSpread
    n_lost: int
    pushes: List[ComparisonRollOutPush]


@dataclass(frozen=True)
class ComparisonAgainstChange:
    """A part of Comparison."""

    #: One of dx, dy, dtheta, force_normal, force_tangential, gap_start, gap_end.
    name: str
    #: One of m, rad, N.
    unit: str
    before: float
    after: float
    square_change: float
    square_change_se: float
    better_share: float
    gap_closed: Optional[float]


@dataclass(frozen=True)
class ComparisonAgainst:
    """A part of Comparison."""

    model: str
    changes: List[ComparisonAgainstChange]


@dataclass(frozen=True)
class Comparison(Documented):
    """SI units; errors are observed less predicted; steps of one cluster share errors."""

    schema: str
    made_by: ComparisonMadeBy
    warnings: List[str]
    model: str
    #: What a step is, in words: its length, and which steps are compared.
    step: str
    part: ComparisonPart
    #: Of a hybrid: the share of what was learnt in what it says.
    unexplained: Optional[ComparisonUnexplained]
    n_pushes: int
    n_steps: int
    n_excluded: int
    excluded: str
    #: One of push, session.
    cluster: str
    not_asked: List[str]
    channels: List[ComparisonChannel]
    floor: ComparisonFloor
    calibration: List[ComparisonCalibration]
    worst: List[ComparisonWorst]
    findings: List[ComparisonFinding]
    concentrations: List[ComparisonConcentration]
    maps: List[ComparisonMap]
    roll_outs: Optional[ComparisonRollOut]
    against: Optional[ComparisonAgainst]
    runs: Optional[ComparisonRuns] = None
    doubtful: Optional[List[ComparisonDoubtful]] = None
    #: What of the recordings may be wrong; the errors hold only if none of it is. Left out
    #: where nothing is.
    suspicions: Optional[List[ComparisonSuspicion]] = None
