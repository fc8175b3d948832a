"""The dataclasses of pushlab.diagnosis/2, written by tests/schemas.py from its schema."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Dict, List, Optional

from ._result import Documented


@dataclass(frozen=True)
class DiagnosisMotion:
    """A part of Diagnosis."""

    #: Along the body's x, in m.
    dx_m: Optional[float]
    #: Along the body's y, in m.
    dy_m: Optional[float]
    #: Of the turn, in rad.
    dtheta_rad: Optional[float]
    #: Of the force along the inward normal at the contact, in N; absent where it was not
    #: measured, or has no floor.
    force_normal_n: Optional[float] = None
    #: Of the force along the tangent, in N; absent as well.
    force_tangential_n: Optional[float] = None


@dataclass(frozen=True)
class DiagnosisError:
    """The error on pushes that no fit has seen."""

    #: Of the model asked about.
    before: float
    #: Of the model with the claimed effects.
    after: float
    #: Of a perfect model.
    floor: float
    #: (before − after)/(before − floor); null where before − floor is below twice its standard
    #: error.
    gap_closed: Optional[float]
    #: What the numbers are.
    unit: str
    before_si: DiagnosisMotion
    after_si: DiagnosisMotion
    floor_si: DiagnosisMotion


@dataclass(frozen=True)
class DiagnosisSplit:
    """The pushes that the model was fitted to, and those that no fit has seen."""

    #: SHA-256 over the hashes of the set's recordings.
    set: str
    #: Of the choice.
    seed: int
    #: What was chosen as a whole: the steps of a push, or the pushes of a measuring session.
    #: One of push, session.
    cluster: str
    #: Each as `recording#number`, the number counted from 0; in one part, once.
    fit: List[str]
    #: Each as `recording#number`, the number counted from 0; in one part, once.
    confirm: List[str]
    #: The set that the pushes of `confirm` are of, as `set`, where it is another one.
    confirm_set: Optional[str] = None


@dataclass(frozen=True)
class DiagnosisEffectLogDensityGain:
    """A part of Diagnosis."""

    #: The sum over the confirming clusters, none of which counts for more than 10, in nats.
    mean: float
    #: Its standard error, from whole clusters.
    se: float


@dataclass(frozen=True)
class DiagnosisParameter:
    """A part of Diagnosis."""

    #: Name, as in model.toml.
    name: str
    #: SI unit; `1` for none.
    unit: str
    #: Value when the effect is not there; null for a direction.
    off: Optional[float]
    #: The best value.
    estimate: Optional[float]
    #: Its standard error, from whole clusters; 0 for a switch.
    se: Optional[float]
    #: Lower end of the 95 % interval.
    low95: Optional[float]
    #: Upper end.
    high95: Optional[float]
    #: The size that these data would show with 90 % probability.
    detection_limit: Optional[float]


@dataclass(frozen=True)
class DiagnosisEffect:
    """A part of Diagnosis."""

    #: Id in the catalogue, or of the user's own effect.
    id: str
    #: identified: missing; ambiguous: a member of a group; effective: it lowers the error, see
    #: `why`; hint; below_detection_limit: not seen, with a limit; not_testable: see `why`. One
    #: of identified, ambiguous, effective, hint, below_detection_limit, not_testable.
    grade: str
    #: Probability of as strong a sign of any effect where none is missing; null if not tested.
    #: By flips of the signs of whole clusters; of a nominal number that is claimed by its
    #: estimate and standard error, times the number of effects asked for.
    p_adjusted: Optional[float]
    #: Share of the gap to the floor that the effect closes alone, on pushes that no fit has
    #: seen.
    gap_closed: Optional[float]
    #: Gain in log predictive density on pushes that no fit has seen.
    log_density_gain: Optional[DiagnosisEffectLogDensityGain]
    parameters: List[DiagnosisParameter]
    #: Effects that these data can hardly tell from it.
    rivals: List[str]
    #: Why it is not testable, or what else is to be known.
    why: str
    #: Whether it is there and hardly seen: it changes every number of a step by less than 0.3
    #: of its noise, and is not known to close a twentieth of the gap. The verdict and the lists
    #: of names leave it out.
    small: Optional[bool] = None


@dataclass(frozen=True)
class DiagnosisLeftover:
    """Structure in the residuals of the best model."""

    #: Probability of as much structure in noise.
    p: Optional[float]
    #: Over what it shows most; null where there is none.
    covariate: Optional[str]
    #: What of the rig most of it comes from: by what the pushes share that are missed by far,
    #: where that is all that is told, else by what can be predicted of it, else by the speed,
    #: time or place on the table where it shows; null where none tells.
    origin: Optional[str] = None


@dataclass(frozen=True)
class DiagnosisRemainGain:
    """What free components of all origins together gain on held-out pushes."""

    #: The sum over clusters, none of which counts for more than 10, in nats.
    mean: float
    #: Its standard error, from whole clusters.
    se: float


@dataclass(frozen=True)
class DiagnosisRemainSmooth:
    """What any smooth function of place along the edge, direction and speed gains."""

    #: The sum over clusters, none of which counts for more than 10, in nats.
    mean: float
    #: Its standard error, from whole clusters.
    se: float


@dataclass(frozen=True)
class DiagnosisRemainOriginGain:
    """What its component gains alone."""

    #: The sum over clusters, none of which counts for more than 10, in nats.
    mean: float
    #: Its standard error, from whole clusters.
    se: float


@dataclass(frozen=True)
class DiagnosisRemainOrigin:
    """A part of Diagnosis."""

    #: One of support, contact, table, dynamics, time, measurement.
    origin: str
    #: What its component gains alone.
    gain: DiagnosisRemainOriginGain
    #: That as a share of what all together gain; null where that is not sure.
    alone: Optional[float]
    #: Share of what all together gain that is lost without it; null where that is not sure.
    last_in: Optional[float]
    #: Where it gains most, in words; null where that is nowhere in particular.
    at: Optional[str]


@dataclass(frozen=True)
class DiagnosisRemain:
    """What of the rig the error comes from that the effects leave; missing with fewer than
    eight clusters."""

    #: What free components of all origins together gain on held-out pushes.
    gain: DiagnosisRemainGain
    #: Share of the squared error, in units of the noise, that they take off.
    share: float
    #: What any smooth function of place along the edge, direction and speed gains.
    smooth: DiagnosisRemainSmooth
    #: Every origin that has a component, that of the largest gain first.
    origins: List[DiagnosisRemainOrigin]


@dataclass(frozen=True)
class DiagnosisNoisePushToPush:
    """A part of Diagnosis."""

    #: The effect's id.
    effect: str
    #: SI unit of the standard deviation.
    unit: str
    #: Standard deviation; of a vector that of each component.
    sd: float
    #: Lower end of its 95 % interval.
    low95: float
    #: Upper end.
    high95: float
    #: Share of the variance of a step's motion and force that is noise to the best model.
    share: float


@dataclass(frozen=True)
class DiagnosisNoise:
    """A part of Diagnosis."""

    #: Repeated pushes, or an estimate from nearest neighbours. One of repeats, neighbours.
    source: str
    #: Groups of repeated pushes.
    n_cells: int
    #: Parameters of effects that differ from push to push, what scatters the steps most first.
    push_to_push: Optional[List[DiagnosisNoisePushToPush]] = None


@dataclass(frozen=True)
class DiagnosisDataRun:
    """Left out where rows have ids or share no errors: how many runs of rows without ids are
    taken for a push each; the share of their variance that the residuals of the nearest rows
    have in common; the differences in p and in β (rad) up to which rows are linked."""

    n: int
    n_rows: int
    shared: float
    p: float
    beta: float


@dataclass(frozen=True)
class DiagnosisClusters:
    """What is taken for independent among the pushes fitted to, or among those that
    confirmed."""

    #: What shares errors: the steps of a push, or the pushes of a measuring session. One of
    #: push, session.
    kind: str
    #: How many there are.
    n: int


@dataclass(frozen=True)
class DiagnosisData:
    """A part of Diagnosis."""

    #: Pushes with steps that were used.
    pushes_used: int
    #: Pushes without.
    pushes_set_aside: int
    #: Pushes that fits used: of a large set a part of those of the split.
    pushes_fitted: int
    #: Pushes that confirmed, likewise.
    pushes_confirming: int
    #: Steps used.
    steps: int
    #: Left out where rows have ids or share no errors: how many runs of rows without ids are
    #: taken for a push each; the share of their variance that the residuals of the nearest rows
    #: have in common; the differences in p and in β (rad) up to which rows are linked.
    runs: Optional[DiagnosisDataRun] = None
    #: What is taken for independent among the pushes fitted to, or among those that confirmed.
    clusters_fitted: Optional[DiagnosisClusters] = None
    #: What is taken for independent among the pushes fitted to, or among those that confirmed.
    clusters_confirming: Optional[DiagnosisClusters] = None
    #: Clusters to fit to that lack for an adjusted probability of 0.01, without which no effect
    #: is named.
    clusters_missing: Optional[int] = None


@dataclass(frozen=True)
class DiagnosisSuspicion:
    """A part of Diagnosis."""

    what: str
    #: The numbers that say so.
    evidence: str
    #: What to correct.
    fix: str
    is_certain: bool


@dataclass(frozen=True)
class DiagnosisMadeByInput:
    """A part of Diagnosis."""

    path: str
    sha256: str


@dataclass(frozen=True)
class DiagnosisMadeBy:
    """What made the answer, where a tool did."""

    tool: str
    arguments: List[str]
    inputs: List[DiagnosisMadeByInput]


@dataclass(frozen=True)
class Diagnosis(Documented):
    """Which physical effect a pushing model lacks, as ``pushlab diagnose`` writes it; SI
    units."""

    schema: str
    #: What may be claimed. One of identified, ambiguous, effective, unexplained, none_found,
    #: inconclusive.
    verdict: str
    #: Effects that are missing, in the order of adding.
    identified: List[str]
    #: Groups of effects of which one is missing and these data cannot tell which.
    ambiguous: List[List[str]]
    #: Effects that lower the error on pushes that no fit has seen, though another cause may be
    #: behind it.
    effective: List[str]
    #: The answer in words.
    sentence: str
    #: The error on pushes that no fit has seen.
    error: DiagnosisError
    #: The pushes that the model was fitted to, and those that no fit has seen.
    split: DiagnosisSplit
    #: Every effect that was asked for, those claimed first.
    effects: List[DiagnosisEffect]
    #: Structure in the residuals of the best model.
    leftover: DiagnosisLeftover
    noise: DiagnosisNoise
    data: DiagnosisData
    #: What of the rig the error comes from that the effects leave; missing with fewer than
    #: eight clusters.
    remains: Optional[DiagnosisRemain] = None
    #: What the tool told beside the answer; answers of earlier releases do without.
    warnings: Optional[List[str]] = None
    #: What to do next, as commands of the tool that made it. Left out where no tool did.
    next: Optional[List[str]] = None
    #: What of the recordings may be wrong; the verdict holds only if none of it is. Left out
    #: where nothing is.
    suspicions: Optional[List[DiagnosisSuspicion]] = None
    #: What made the answer, where a tool did.
    made_by: Optional[DiagnosisMadeBy] = None
