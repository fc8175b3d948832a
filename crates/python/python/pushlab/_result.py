"""Results as objects that are made from the documents of the commands."""

from __future__ import annotations

import dataclasses
import html
import json
import os
import typing
from pathlib import Path
from typing import Any, ClassVar, Type, TypeVar, Union

R = TypeVar("R")

_STYLE = "font-family:monospace;line-height:1.35;text-align:left;white-space:pre-wrap"


class Record(dict):  # type: ignore[type-arg]
    """A part of a document, whose fields are attributes as well."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            known = ", ".join(self)
            raise AttributeError(f"there is no field {name!r}; there are {known}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self]


class Shown:
    """Something with the text of the command line."""

    #: What ``pushlab`` prints on a terminal.
    text: str

    def __str__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        return f'<pre style="{_STYLE}">{html.escape(self.text)}</pre>'


class Result(Shown):
    """What a command found.

    ``document`` is what ``pushlab --json`` prints, and its fields are attributes: ``result.warnings``.
    """

    def __init__(self, document: dict[str, Any], text: str) -> None:
        self.document = records(document)
        self.text = text

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "document":
            raise AttributeError(name)
        return getattr(self.document, name)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.document]

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {', '.join(self.document)}>"


def records(value: Any) -> Any:
    """The same with dictionaries that have their fields as attributes."""
    if isinstance(value, dict):
        return Record({name: records(one) for name, one in value.items()})
    if isinstance(value, list):
        return [records(one) for one in value]
    return value


class Documented(Shown):
    """A dataclass that is made from a document with a schema."""

    _keys: ClassVar[dict[str, str]] = {}
    document: dict[str, Any]

    @classmethod
    def of(cls: Type[R], document: dict[str, Any], text: str) -> R:
        """From what a command or a file says."""
        made = _made(cls, document)
        object.__setattr__(made, "document", document)
        object.__setattr__(made, "text", text)
        return typing.cast(R, made)

    @classmethod
    def read(cls: Type[R], path: Union[str, os.PathLike[str]]) -> R:
        """From a file that the command line wrote with ``-o``, or :meth:`save`."""
        document = json.loads(Path(path).read_text(encoding="utf-8"))
        text = document.get("sentence") or json.dumps(document, indent=2, ensure_ascii=False)
        return cls.of(document, text)  # type: ignore[attr-defined,no-any-return]

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes the document as the command line does with ``-o``."""
        text = json.dumps(self.document, indent=2, ensure_ascii=False) + "\n"
        Path(path).write_text(text, encoding="utf-8")


def _made(hint: Any, value: Any) -> Any:
    if value is None:
        return None
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        hints = typing.get_type_hints(hint)
        keys = getattr(hint, "_keys", {})
        fields = [
            (field.name, keys.get(field.name, field.name)) for field in dataclasses.fields(hint)
        ]
        return hint(**{name: _made(hints[name], value.get(key)) for name, key in fields})
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin is list:
        return [_made(inner[0], one) for one in value]
    if origin is typing.Union:
        return _made(next(one for one in inner if one is not type(None)), value)
    return value
