"""Running commands: their words, their progress, their warnings."""

from __future__ import annotations

import json
import os
import sys
import time
import warnings
from typing import Any, Callable, Iterator, Sequence, Union

from . import _native

#: What long functions take as ``progress``: True for a line on standard error where somebody looks
#: at it, False for nothing, or a function of ``(text, done, total)``; ``total`` is 0 where nobody can
#: count the pieces.
Progress = Union[bool, Callable[[str, int, int], None]]


class PushlabWarning(UserWarning):
    """What is to be known of a result beside it; it is in the result's ``warnings`` as well."""


class _Line:
    """Progress as one line that is drawn over itself: of standard error, or of a notebook's cell."""

    SECONDS = 0.1

    def __init__(self) -> None:
        self._drawn = time.monotonic()
        self._width = 0
        self._cell: Any = None

    def __call__(self, text: str, done: int, total: int) -> None:
        now = time.monotonic()
        if now - self._drawn < self.SECONDS:
            return
        self._drawn = now
        if total:
            filled = 30 * done // total
            text = f"{text} {'█' * filled}{'░' * (30 - filled)} {done} of {total}"
        self._show(text)

    def clear(self) -> None:
        if self._width:
            self._show("")
            if self._cell is None:
                sys.stderr.write("\r")
                sys.stderr.flush()

    def _show(self, text: str) -> None:
        if "ipykernel" in sys.modules:
            self._show_in_cell({"text/plain": text})
        else:
            sys.stderr.write("\r" + text.ljust(self._width))
            sys.stderr.flush()
        self._width = len(text)

    def _show_in_cell(self, data: dict[str, str]) -> None:
        from IPython.display import display

        if self._cell is None:
            self._cell = display(data, raw=True, display_id=True)
        else:
            self._cell.update(data, raw=True)


def _is_watched() -> bool:
    """Whether standard error is a terminal, or this is a notebook."""
    return sys.stderr.isatty() or "ipykernel" in sys.modules


class Teller:
    """Hands what work says to whoever asked for it."""

    def __init__(self, progress: Progress) -> None:
        self._line = _Line() if progress is True and _is_watched() else None
        self._progress = progress if callable(progress) else self._line

    def __call__(self, kind: str, text: str, done: int, total: int) -> None:
        if kind == "told":
            if text.startswith("warning: "):
                text = text[len("warning: ") :]
                warnings.warn(text, PushlabWarning, stacklevel=4)
        elif self._progress is not None:
            self._progress(text, done, total)

    def __enter__(self) -> "Teller":
        return self

    def __exit__(self, *_: object) -> None:
        if self._line is not None:
            self._line.clear()


def call(words: Sequence[str], progress: Progress = True) -> tuple[dict[str, Any], str]:
    """The JSON document and the text of a command."""
    with Teller(progress) as tell:
        document, text = _native.run(list(words), tell)
    return (json.loads(document) if document else {}), text


def words(*positional: object, **options: object) -> list[str]:
    """Words of a command line.

    Options that are None or False are left out, True stands alone, lists are repeated.
    """
    listed = [
        os.fspath(word) if isinstance(word, os.PathLike) else str(word) for word in positional
    ]
    for name, value in options.items():
        listed.extend(_option("--" + name.replace("_", "-").strip("-"), value))
    return listed


def _option(name: str, value: object) -> Iterator[str]:
    if value is None or value is False:
        return
    if value is True:
        yield name
        return
    for one in value if isinstance(value, (list, tuple)) else [value]:
        # One word, for values that begin with a dash.
        yield f"{name}={os.fspath(one) if isinstance(one, os.PathLike) else one}"
