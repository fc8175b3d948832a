"""From recordings and a model to a verdict and a better model: the commands as functions.

Each takes what its command takes and gives what the command prints with ``--json``; ``str(result)`` is what
it prints for people. A ``source`` is the path of a recording set or of a step table, a
:class:`pushlab.RecordingSet`, or a :class:`pushlab.Steps`. Raises :class:`pushlab.PushlabError` in the words
of the command line. All can be interrupted; ``progress`` is as :data:`pushlab.Progress` says.
"""

from __future__ import annotations

import html
import tempfile
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Iterator, Mapping, Optional, Sequence, Union

from ._call import Progress, call, words
from ._comparison import Comparison
from ._diagnosis import Diagnosis
from ._result import Result
from ._source import Source, named
from .model import Model
from .recordings import PathLike, RecordingSet

#: A model, or the path of one.
ModelLike = Union[Model, PathLike]
#: A diagnosis, or the path of one.
DiagnosisLike = Union[Diagnosis, PathLike]


class MadeModel(Result):
    """What a command says of the model that it made."""

    def __init__(self, document: dict[str, Any], text: str, folder: Any) -> None:
        own = [line for line in text.splitlines() if not line.startswith("wrote ")]
        super().__init__(document, "\n".join(own))
        #: The model.
        self.model = Model._within(folder)


class Svg:
    """A figure, which a notebook shows."""

    def __init__(self, title: str, text: str) -> None:
        #: What it shows.
        self.title = title
        #: The SVG itself.
        self.text = text

    def save(self, path: PathLike) -> None:
        """Writes it as a file."""
        Path(path).write_text(self.text, encoding="utf-8")

    def _repr_svg_(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        return f'<div style="background:white">{self.text}</div>'

    def __repr__(self) -> str:
        return f"<Svg {self.title!r}>"


class Simulation(Result):
    """Pushes as a model rolls them out; its tables, figures and logs are files of ``folder``."""

    def __init__(self, document: dict[str, Any], text: str, folder: Path, keep: Any) -> None:
        super().__init__(document, text)
        #: ``poses.csv``, ``simulation.json``, and an .svg, .png and .mcap of each push.
        self.folder = folder
        self._keep = keep

    @property
    def figures(self) -> list[Svg]:
        """One a push: the table from above, and the angle over the time."""
        files = sorted(self.folder.glob("*.svg"))
        return [Svg(file.stem, file.read_text(encoding="utf-8")) for file in files]

    def _repr_html_(self) -> str:
        return super()._repr_html_() + "".join(figure._repr_html_() for figure in self.figures[:4])


class Report(Result):
    """One page about models and measurements, which a notebook shows within itself."""

    def __init__(self, document: dict[str, Any], text: str, page: str) -> None:
        super().__init__(document, text)
        #: The page: HTML without any file beside it.
        self.html = page

    def save(self, path: PathLike) -> None:
        """Writes the page."""
        Path(path).write_text(self.html, encoding="utf-8")

    def _repr_html_(self) -> str:
        frame = 'style="width:100%;height:48em;border:1px solid #ccc" sandbox="allow-scripts"'
        return f'<iframe {frame} srcdoc="{html.escape(self.html)}"></iframe>'


def check(
    source: Source, model: Optional[ModelLike] = None, *, progress: Progress = True
) -> Result:
    """What a set can and cannot show, before any model is fitted to it."""
    with named(source) as (path, about):
        return Result(*call(words("check", path, **about, model=_file(model)), progress))


def compare(
    source: Source,
    model: ModelLike,
    against: Optional[ModelLike] = None,
    *,
    step: Optional[str] = None,
    progress: Progress = True,
) -> Comparison:
    """How wrong a model is on recordings, where, and how wrong it may be at best.

    - ``against``: another model, to tell how the error changes from it on the same steps.
    - ``step``: all steps in contact, of a length such as ``"4mm"``; else 5 mm of smoothed motion.

    Where the model was fitted to a part of these recordings, only the held-out pushes count.
    """
    with named(source) as (path, about):
        options = {"model": _file(model), "against": _file(against), "step": step}
        return Comparison.of(*call(words("compare", path, **about, **options), progress))


def diagnose(
    source: Source,
    model: ModelLike,
    *,
    confirm: Optional[PathLike] = None,
    seed: int = 7,
    progress: Progress = True,
) -> Diagnosis:
    """The physical effect that a model lacks, or that these recordings cannot tell.

    - ``confirm``: a second set that confirms what is fitted to all of the first; else a quarter of the
      pushes is held out, by ``seed``.
    """
    with named(source) as (path, about):
        typed = words("diagnose", path, **about, model=_file(model), confirm=confirm, seed=seed)
        return Diagnosis.of(*call(typed, progress))


def fit(
    source: Source,
    model: ModelLike,
    free: Union[str, Sequence[str]],
    *,
    seed: int = 7,
    progress: Progress = True,
    **options: Any,
) -> MadeModel:
    """A model whose parameters are fitted to three quarters of the pushes.

    - ``free``: of ``pusher-friction``, ``pressure-radius``, ``support-friction``, and ids of effects
      that the model carries.
    - ``options``: as of ``pushlab fit``: ``points=4``, ``by_statics=True``, ``nuisances=True``.
    """
    free = free if isinstance(free, str) else ",".join(free)
    return _made(
        ("fit",), source, model=_file(model), free=free, seed=seed, progress=progress, **options
    )


def train(
    source: Source,
    kind: str,
    *,
    model: Optional[ModelLike] = None,
    residual_kind: Optional[str] = None,
    inputs: Sequence[str] = (),
    rows: Optional[int] = None,
    step: Optional[str] = None,
    seed: int = 7,
    progress: Progress = True,
) -> MadeModel:
    """A model that is learnt from three quarters of the pushes.

    - ``kind``: ``gp`` (to a thousand steps), ``spgp``, ``rff`` (to a hundred thousand and more), ``vhgp``,
      or ``hybrid``: one of these (``residual_kind``) on what the physics of ``model`` leave over.
    - ``inputs``: beside p and β: ``speed``, ``edge``, or ``contact`` in place of p.
    - ``rows``: most steps to learn from, a random part; ``step``: their length, else 200 ms.
    """
    options = {"kind": kind, "residual-kind": residual_kind, "with": ",".join(inputs) or None}
    model = _file(model)
    return _made(
        ("train",),
        source,
        **options,
        model=model,
        rows=rows,
        step=step,
        seed=seed,
        progress=progress,
    )


def add(
    model: ModelLike,
    effect: Optional[str] = None,
    *,
    values: Optional[Mapping[str, float]] = None,
    source: Optional[Source] = None,
    diagnosis: Optional[DiagnosisLike] = None,
    everything: bool = False,
    per_push: bool = False,
    seed: int = 7,
    progress: Progress = True,
) -> MadeModel:
    """A model with more effects: with values by hand, fitted to a source, or from a diagnosis.

    - ``values``: each parameter's value in its SI unit.
    - ``source``: what the effect is fitted to; ``per_push``: with how much it differs from push to push.
    - ``diagnosis``: what it identified, or ``effect`` alone; ``everything``: all that lowers the error.
    """
    with ExitStack() as stack:
        options: dict[str, Any] = {}
        if source is not None:
            path, options = stack.enter_context(named(source))
            options = {**options, "fit": path, "per-push": per_push, "seed": seed}
        given = [f"{name}={float(value)!r}" for name, value in (values or {}).items()]
        file = stack.enter_context(_diagnosis_file(diagnosis))
        options |= {"set": given, "from": file, "all": everything}
        folder = tempfile.TemporaryDirectory(prefix="pushlab-")
        output = Path(folder.name) / "model.toml"
        named_effect = () if effect is None else (effect,)
        typed = words("add", *named_effect, **options, model=_file(model), output=output)
        return MadeModel(*call(typed, progress), folder)


def calibrate(
    source: Source, model: ModelLike, *, step: Optional[str] = None, progress: Progress = True
) -> MadeModel:
    """A model that knows from a set how sure it may be of whole pushes."""
    return _made(("calibrate",), source, model=_file(model), step=step, progress=progress)


def suggest(
    diagnosis: DiagnosisLike,
    *,
    source: Optional[Source] = None,
    model: Optional[ModelLike] = None,
    pushes: int = 20,
    repeats: int = 5,
    effect: Optional[str] = None,
    speed: Optional[str] = None,
    area: Optional[str] = None,
    seed: int = 7,
    progress: Progress = True,
) -> Result:
    """The pushes to do next: those that decide between rivals, or measure what was named.

    - ``source``, ``model``: what was diagnosed; else what the diagnosis names.
    - ``effect``: one that the pushes are to show; ``speed``: such as ``"20mm/s,100mm/s"``;
      ``area``: where the object may be, in mm: ``"XMIN,XMAX,YMIN,YMAX"``.
    """
    with ExitStack() as stack:
        file = stack.enter_context(_diagnosis_file(diagnosis))
        path, about = stack.enter_context(named(source)) if source is not None else (None, {})
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="pushlab-"))
        options = {
            **about, "from": file, "model": _file(model), "pushes": pushes, "repeats": repeats,
            "for": effect, "speed": speed, "area": area, "seed": seed,
            "output": Path(folder) / "suggested.csv",
        }  # fmt: skip
        found = Result(
            *call(words("suggest", *(() if path is None else (path,)), **options), progress)
        )
        found.text = "\n".join(line for line in found.text.splitlines() if folder not in line)
        return found


def simulate(
    source: Source,
    model: ModelLike,
    *,
    output: Optional[PathLike] = None,
    pushes: int = 8,
    push: Sequence[str] = (),
    particles: Optional[int] = None,
    matched: Optional[str] = None,
    correlation: Optional[str] = None,
    step: Optional[str] = None,
    seed: int = 7,
    progress: Progress = True,
    **options: Any,
) -> Simulation:
    """Whole pushes rolled out by a model: where the object goes, and how sure that is.

    - ``source``: recordings, whose ends are compared, or a path of the pusher (``.csv``, ``.toml``, with
      ``manifest=...``).
    - ``output``: a new folder for its files; else one that lives as long as the result.
    - ``push``: recorded pushes as ``recording#number``; else an even choice of ``pushes``.
    - ``particles``: 10 000 if not said; ``matched``: do without: ``unscented``, ``gauss-hermite`` or
      ``exact``.
    - ``correlation``: a set that tells how sure the model may be of whole pushes, or ``"none"``.
    """
    keep = tempfile.TemporaryDirectory(prefix="pushlab-") if output is None else None
    folder = Path(keep.name) / "simulation" if keep else Path(output)  # type: ignore[arg-type]
    chosen = {"push": ",".join(push)} if push else {"pushes": pushes}
    with named(source) as (path, about):
        options = {
            **about, **options, **chosen, "model": _file(model), "particles": particles,
            "matched": matched, "correlation": correlation, "step": step, "seed": seed, "output": folder,
        }  # fmt: skip
        document, text = call(words("simulate", path, **options), progress)
    return Simulation(document, text, folder, keep)


def report(
    source: Source,
    models: Union[ModelLike, Sequence[ModelLike]],
    *,
    diagnosis: Optional[DiagnosisLike] = None,
    step: Optional[str] = None,
    progress: Progress = True,
) -> Report:
    """How models do on recordings: errors, maps and pushes to play on one page.

    - ``models``: one or several; the first is the one that others are seen beside.
    - ``diagnosis``: of the first model on this source.
    """
    several: list[ModelLike] = [*models] if isinstance(models, (list, tuple)) else [models]  # type: ignore[list-item]
    with ExitStack() as stack:
        path, about = stack.enter_context(named(source))
        file = stack.enter_context(_diagnosis_file(diagnosis))
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="pushlab-"))
        page = Path(folder) / "report.html"
        files = [_file(one) for one in several]
        typed = words(
            "report", path, **about, model=files, step=step, output=page, **{"from": file}
        )
        document, text = call(typed, progress)
        text = "\n".join(line for line in text.splitlines() if not line.startswith("wrote "))
        return Report(document, text, page.read_text(encoding="utf-8"))


def generate(
    output: PathLike,
    *,
    hidden: Union[str, Sequence[str]] = (),
    pushes: Optional[int] = None,
    seed: int = 7,
    progress: Progress = True,
    **options: Any,
) -> RecordingSet:
    """Simulates a rig and writes its recordings into a new folder.

    - ``hidden``: effects to hide, ``"ID"`` or ``"ID: NAME=VALUE, …"``, or ``"surprise"``.
    - ``options``: as of ``pushlab generate``: ``design="thesis"``, ``shape="tri1"``, ``rig="quiet"``,
      ``speed="20mm/s"``, ``sessions=5``, ``format="csv"``, ``settings="rig.toml"``.
    """
    hidden = [hidden] if isinstance(hidden, str) else list(hidden)
    typed = words("generate", hidden=hidden, pushes=pushes, seed=seed, **options, output=output)
    call(typed, progress)
    return RecordingSet(output)


def command(*typed: object, progress: Progress = True, **options: Any) -> Result:
    """Any command, as its words stand behind ``pushlab``: ``command("describe", "steps.csv")``.

    - ``options``: those of the command by name: ``part="3/8"``, ``force=True``, ``from_="diagnosis.json"``.
    """
    return Result(*call(words(*typed, **options), progress))


def _file(model: Optional[ModelLike]) -> Optional[PathLike]:
    return model.path if isinstance(model, Model) else model


def _made(names: Sequence[str], source: Source, *, progress: Progress, **options: Any) -> MadeModel:
    folder = tempfile.TemporaryDirectory(prefix="pushlab-")
    output = Path(folder.name) / "model.toml"
    with named(source) as (path, about):
        printed = call(words(*names, path, **about, **options, output=output), progress)
    return MadeModel(*printed, folder)


@contextmanager
def _diagnosis_file(diagnosis: Optional[DiagnosisLike]) -> Iterator[Optional[PathLike]]:
    if not isinstance(diagnosis, Diagnosis):
        yield diagnosis
        return
    with tempfile.TemporaryDirectory(prefix="pushlab-") as folder:
        path = Path(folder) / "diagnosis.json"
        diagnosis.save(path)
        yield path
