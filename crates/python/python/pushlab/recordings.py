"""Recording sets and step tables."""

from __future__ import annotations

import html
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, Iterator, Mapping, Optional, Union

import numpy as np

from . import _native
from ._call import Progress, call, words
from ._result import Shown, records

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow

PathLike = Union[str, "os.PathLike[str]"]

#: Columns that the first look at a table shows.
_FIRST = [
    "recording",
    "push",
    "step",
    "t_s",
    "p",
    "beta_rad",
    "speed_m_s",
    "dx_m",
    "dy_m",
    "dtheta_rad",
]


class RecordingSet(Shown):
    """Recordings of pushes, with what says of which object, pusher and table they are.

    - ``path``: a folder with a ``dataset.toml`` (``pushlab init`` writes a draft), or recordings of
      others with the ``preset`` that knows them.
    - ``preset``: ``mit-push``, ``mit-rig-2015``, ``mit-endpoints`` or ``cmu-known-supports``.
    - ``shape``: of public data about several shapes, the pushes of this one alone.

    Recordings are found, and not yet read.
    """

    def __init__(
        self, path: PathLike, *, preset: Optional[str] = None, shape: Optional[str] = None
    ) -> None:
        self._set = _native.RecordingSet(path, preset, shape)
        self._known = {"preset": preset, "shape": shape}
        self.path = Path(path)

    @property
    def name(self) -> str:
        """The set's name in its manifest."""
        return self._set.name

    @property
    def recordings(self) -> list[Path]:
        """The logs, by name."""
        return [Path(one) for one in self._set.recordings]

    @property
    def text(self) -> str:  # type: ignore[override]
        """What was found, in words."""
        n, format_, folder = len(self.recordings), self._set.format, self._set.folder
        found = f"{self.name}: {n} recordings ({format_}) in {folder}"
        return "\n".join([found, *self._set.remarks])

    def __repr__(self) -> str:
        return f"RecordingSet({str(self.path)!r})"

    def ingest(
        self,
        *,
        step: Optional[str] = None,
        curve: Optional[str] = None,
        progress: Progress = True,
    ) -> Steps:
        """The recordings as a table of steps, with a report of every repair.

        - ``step``: length of a step: a time (``"200ms"``) or a way of the pusher (``"4mm"``); else
          0.2 s.
        - ``curve``: through the samples of a pose: ``"interpolate"`` (default) or ``"smooth"``.

        Raises :class:`pushlab.PushlabError` if no push can be used.
        """
        with tempfile.TemporaryDirectory(prefix="pushlab-") as folder:
            table = Path(folder) / "steps.parquet"
            typed = words("ingest", self.path, **self._known, step=step, curve=curve, output=table)
            document, _ = call(typed, progress)
            about = {"manifest": self._manifest(), **self._known}
            return Steps._read(table, about, document.get("report"))

    def _manifest(self) -> Optional[Path]:
        own = Path(self._set.folder) / "dataset.toml"
        if self.path.is_file() and self.path.suffix == ".toml":
            own = self.path
        return own if self._known["preset"] is None and own.is_file() else None


class Steps(Mapping[str, np.ndarray]):
    """A table of steps: short pieces of pushes, one a row, as NumPy columns by name.

    ``steps["dx_m"]`` is an array of N numbers in the unit that the name ends with (SI throughout), NaN
    where nothing was measured; columns of text are arrays of strings. ``units`` and ``meanings`` tell
    each column; the outputs of a model are ``dx_m`` and ``dy_m`` (along the pusher's motion and along
    its left normal) and ``dtheta_rad`` (counter-clockwise).

    Made by :meth:`RecordingSet.ingest` and :func:`read_steps`.
    """

    #: The report of the ingest that made the table: what was repaired, excluded and why.
    report: Any = None
    _table: _native.Steps
    _about: dict[str, Any]
    _described: list[tuple[str, str, str]]
    _kept: dict[str, Any]

    def __init__(self) -> None:
        raise TypeError("tables come from RecordingSet(...).ingest() and read_steps(...)")

    @classmethod
    def _of(cls, native: _native.Steps, about: dict[str, Any], report: Any) -> Steps:
        steps = object.__new__(cls)
        steps._table, steps._about, steps.report = native, about, records(report)
        steps._described = native.columns
        steps._kept = {}
        return steps

    @classmethod
    def _read(cls, path: PathLike, about: dict[str, Any], report: Any = None) -> Steps:
        return cls._of(_native.Steps.read(path, **about), about, report)

    @property
    def columns(self) -> list[str]:
        """Names of the columns, in the order in which files have them."""
        return [name for name, _, _ in self._described]

    @property
    def units(self) -> dict[str, str]:
        """The unit of each column; ``1`` for numbers without one, empty for text."""
        return {name: unit for name, unit, _ in self._described}

    @property
    def meanings(self) -> dict[str, str]:
        """What each column holds."""
        return {name: meaning for name, _, meaning in self._described}

    @property
    def provenance(self) -> list[tuple[str, str]]:
        """What made the rows: tool, arguments, and the SHA-256 of every source."""
        return self._table.provenance

    @property
    def pushes(self) -> np.ndarray:
        """The push of each row, as ``recording#push``: N strings."""
        numbers = self["push"].astype(str)
        return np.char.add(np.char.add(self["recording"], "#"), numbers)

    @property
    def n_rows(self) -> int:
        """Number of steps."""
        return len(self._table)

    def __len__(self) -> int:
        return len(self._described)

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self:
            raise KeyError(name)
        column = self._column(name)
        if isinstance(column, tuple):
            codes, known = column
            return np.asarray(known, dtype=str)[codes] if known else np.empty(0, dtype=str)
        return column

    def _column(self, name: str) -> Any:
        if name not in self._kept:
            column = self._table.column(name)
            # Everyone gets the same array: it stays as it is.
            (column[0] if isinstance(column, tuple) else column).setflags(write=False)
            self._kept[name] = column
        return self._kept[name]

    def select(self, rows: Any) -> Steps:
        """Some of the rows: a mask of N truth values, or numbers of rows from 0."""
        chosen = np.asarray(rows)
        if chosen.dtype == bool:
            if chosen.shape != (self.n_rows,):
                raise _native.PushlabError(
                    f"a mask has one value a row: expected shape ({self.n_rows},), got {chosen.shape}"
                )
            chosen = np.flatnonzero(chosen)
        if chosen.size > 0 and chosen.dtype.kind not in "iu":
            raise _native.PushlabError(f"rows are a mask or whole numbers, got {chosen.dtype}")
        chosen = np.ascontiguousarray(chosen, dtype=np.int64)
        return Steps._of(self._table.select(chosen), self._about, self.report)

    def write(self, path: PathLike) -> None:
        """Writes a ``.csv`` or ``.parquet`` file with the provenance, in place of one that is there."""
        self._table.write(path)

    def to_pandas(self) -> pandas.DataFrame:
        """As a :class:`pandas.DataFrame`; text as categories. Needs pandas."""
        import pandas

        def column(name: str) -> Any:
            one = self._column(name)
            return pandas.Categorical.from_codes(one[0], one[1]) if isinstance(one, tuple) else one

        return pandas.DataFrame({name: column(name) for name in self.columns}, copy=False)

    def to_polars(self) -> polars.DataFrame:
        """As a :class:`polars.DataFrame`; text as categories. Needs polars."""
        import polars

        def column(name: str) -> Any:
            one = self._column(name)
            if not isinstance(one, tuple):
                return polars.Series(name, one)
            known = polars.Series(name, one[1], dtype=polars.String)
            return known.gather(one[0]).cast(polars.Categorical)

        return polars.DataFrame([column(name) for name in self.columns])

    def to_arrow(self) -> pyarrow.Table:
        """As a :class:`pyarrow.Table` with units and meanings in its fields. Needs pyarrow."""
        import pyarrow

        def column(name: str) -> Any:
            one = self._column(name)
            if isinstance(one, tuple):
                return pyarrow.DictionaryArray.from_arrays(
                    one[0], pyarrow.array(one[1], pyarrow.string())
                )
            return pyarrow.array(one)

        columns = [column(name) for name in self.columns]
        fields = [
            pyarrow.field(name, column.type, metadata={"unit": unit, "meaning": meaning})
            for (name, unit, meaning), column in zip(self._described, columns)
        ]
        return pyarrow.Table.from_arrays(columns, schema=pyarrow.schema(fields))

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        return self.to_arrow().__arrow_c_stream__(requested_schema)

    def __repr__(self) -> str:
        return f"<Steps: {self.n_rows} rows, {len(self)} columns>"

    def _repr_html_(self) -> str:
        def text(value: Any) -> str:
            return html.escape(f"{value:.5g}" if isinstance(value, float) else str(value))

        n_shown = min(self.n_rows, 8)
        head = "".join(
            f'<th title="{html.escape(self.meanings[name])}">{name}</th>' for name in _FIRST
        )
        columns = [self[name][:n_shown].tolist() for name in _FIRST]
        rows = "".join(
            "<tr>" + "".join(f"<td>{text(value)}</td>" for value in row) + "</tr>"
            for row in zip(*columns)
        )
        size = f"{self.n_rows} rows, {len(self)} columns"
        return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table><p>{size}</p>"


def read_steps(
    path: PathLike,
    *,
    manifest: Optional[PathLike] = None,
    mapping: Optional[PathLike] = None,
    preset: Optional[str] = None,
    progress: Progress = True,
) -> Steps:
    """Reads a step table, ``.csv`` or ``.parquet``.

    - ``manifest``: the ``dataset.toml`` of the set that the rows are of; else the one beside the table,
      if there is one. Models need it.
    - ``mapping``, ``preset``: for a table of others, how its columns become ours: a file, or
      ``"mit-table"``.

    Raises :class:`pushlab.PushlabError` with line, column and value of what does not fit.
    """
    if mapping is not None or preset == "mit-table":
        about: dict[str, Any] = {"mapping": mapping, "preset": preset}
        with tempfile.TemporaryDirectory(prefix="pushlab-") as folder:
            table = Path(folder) / "steps.parquet"
            document, _ = call(words("ingest", path, **about, output=table), progress)
            return Steps._read(table, about, document.get("table"))
    beside = Path(path).with_name("dataset.toml")
    if manifest is None and preset is None and beside.is_file():
        manifest = beside
    return Steps._read(path, {"manifest": manifest, "preset": preset})
