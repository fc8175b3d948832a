"""What commands are about: a path, a recording set, or a table in memory."""

from __future__ import annotations

import os
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Iterator, Union

from .recordings import PathLike, RecordingSet, Steps

#: A recording set or a step table.
Source = Union[PathLike, RecordingSet, Steps]


@contextmanager
def named(source: Source) -> Iterator[tuple[str, dict[str, Any]]]:
    """The path by which a command finds a source, and the options that belong to it."""
    if isinstance(source, RecordingSet):
        yield os.fspath(source.path), dict(source._known)
    elif isinstance(source, Steps):
        with tempfile.TemporaryDirectory(prefix="pushlab-") as folder:
            table = Path(folder) / "steps.parquet"
            source.write(table)
            about = dict(source._about)
            if about.get("preset") and not about.get("manifest"):
                about.pop("shape", None)
            yield str(table), about
    else:
        yield os.fspath(source), {}
