"""Writes the dataclasses of the documented results from their schemas: ``python tests/schemas.py``."""

import json
import keyword
import sys
import textwrap
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
PACKAGE = Path(__file__).resolve().parents[1] / "python" / "pushlab"
#: Schema, module, and the class of the whole document.
DOCUMENTS = [
    ("diagnosis.schema.json", "_diagnosis.py", "Diagnosis"),
    ("comparison.schema.json", "_comparison.py", "Comparison"),
]
PLAIN = {"string": "str", "number": "float", "integer": "int", "boolean": "bool"}


class Module:
    """The classes of one schema, inner ones first."""

    def __init__(self, schema, whole):
        self.schema, self.whole = schema, whole
        self.classes = {}

    def text(self):
        self.add(self.whole, self.schema)
        head = f'"""The dataclasses of {self.schema["$id"]}, written by tests/schemas.py from its schema."""'
        imports = (
            "from __future__ import annotations\n\n"
            "from dataclasses import dataclass\n"
            "from typing import Any, ClassVar, Dict, List, Optional\n\n"
            "from ._result import Documented"
        )
        return head + "\n\n" + imports + "\n\n\n" + "\n\n\n".join(self.classes.values()) + "\n"

    def add(self, name, schema):
        """A class for an object with known fields."""
        if name in self.classes:
            return name
        required, optional, keys = [], [], {}
        for key, inner in schema["properties"].items():
            field = key + "_" if keyword.iskeyword(key) else key
            if field != key:
                keys[field] = key
            hint, about = self.hint(name, key, inner), self.about(inner)
            is_needed = key in schema.get("required", [])
            if not is_needed and not hint.startswith("Optional"):
                hint = f"Optional[{hint}]"
            lines = [f"    {field}: {hint}" + ("" if is_needed else " = None")]
            if about:
                lines += textwrap.wrap(
                    about, 96, initial_indent="    #: ", subsequent_indent="    #: "
                )
                lines = lines[1:] + lines[:1]
            (required if is_needed else optional).append("\n".join(lines))
        is_whole = name == self.whole
        about = schema.get("description", "").replace("`", "``") or f"A part of {self.whole}."
        about = textwrap.fill(f'"""{about}"""', 96, initial_indent="    ", subsequent_indent="    ")
        head = f"@dataclass(frozen=True)\nclass {name}{'(Documented)' if is_whole else ''}:\n{about}\n\n"
        if keys:
            head += f"    _keys: ClassVar[Dict[str, str]] = {json.dumps(keys)}\n"
        self.classes[name] = head + "\n".join(required + optional)
        return name

    def hint(self, owner, key, schema):
        """The type of a field."""
        if "$ref" in schema:
            name = schema["$ref"].rsplit("/", 1)[1]
            inner = self.schema["$defs"][name]
            if "properties" in inner:
                return self.add(self.whole + camel(name), inner)
            return self.hint(owner, name.replace("_or_null", ""), inner)
        if "oneOf" in schema:
            inner = [one for one in schema["oneOf"] if one != {"type": "null"}]
            return f"Optional[{self.hint(owner, key, inner[0])}]"
        if "properties" in schema:
            return self.add(owner + camel(singular(key)), schema)
        if schema.get("type") == "array":
            return f"List[{self.hint(owner, key, schema['items'])}]"
        if "enum" in schema or "const" in schema:
            return "str"
        return PLAIN.get(schema.get("type"), "Any")

    def about(self, schema):
        if "description" not in schema and "$ref" in schema:
            schema = self.schema["$defs"][schema["$ref"].rsplit("/", 1)[1]]
        about = schema.get("description", "")
        if "enum" in schema:
            about = f"{about} One of {', '.join(schema['enum'])}.".strip()
        return about


def camel(name):
    return "".join(part.capitalize() for part in name.split("_"))


def singular(name):
    if name.endswith("shes"):
        return name[:-2]
    return name[:-1] if name.endswith("s") and not name.endswith("ss") else name


def modules():
    """The path and the text of each module."""
    for schema, module, whole in DOCUMENTS:
        text = (ROOT / "docs" / schema).read_text(encoding="utf-8")
        yield PACKAGE / module, Module(json.loads(text), whole).text()


if __name__ == "__main__":
    for path, text in modules():
        path.write_text(text, encoding="utf-8")
    sys.exit(0)
