"""Makes `tidelock/case_types.py`, types of all tables of a case file, from the JSON Schema that `tidelock schema` prints.

    python3 solvers/python/case_types.py docs/case.schema.json

A table is a TypedDict: editors and type checkers know its keys, their types and meanings.
"""

import json
import keyword
import pathlib
import re
import sys
import textwrap

TARGET = pathlib.Path(__file__).resolve().parent / "tidelock" / "case_types.py"
HEAD = '''"""Tables of a case file, made from its JSON Schema by solvers/python/case_types.py; do not edit."""

from typing import Any, Literal, NotRequired, TypeAlias, TypedDict
'''
PLAIN = {"string": "str", "number": "float", "integer": "int", "boolean": "bool", "null": "None"}


class Types:
    """The types of a schema, in the order in which they must stand."""

    def __init__(self, schema):
        self.schema, self.texts, self.names = schema, [], {}

    def of(self, node, name):
        """The type of a value; tables in it get `name`.

        >>> Types({}).of({"type": "array", "items": {"type": ["number", "string"]}}, "X")
        'list[float | str]'
        >>> Types({}).of({"enum": ["slip", "no-slip"]}, "X")
        "Literal['slip', 'no-slip']"
        """
        if node in (True, {}) or not isinstance(node, dict):
            return "Any"
        if "$ref" in node:
            return self.reference(node["$ref"])
        if "const" in node:
            return f"Literal[{node['const']!r}]"
        if "enum" in node:
            return f"Literal[{', '.join(map(repr, node['enum']))}]"
        if len(node.get("allOf", [])) == 1:
            return self.of(node["allOf"][0], name)
        if node.get("properties"):
            # Which of its keys go together is left to `check`.
            return self.table(node, name)
        for key in ("oneOf", "anyOf"):
            if key in node:
                return union(self.of(choice, variant(name, choice, k)) for k, choice in enumerate(node[key]))
        kind = node.get("type")
        if isinstance(kind, list):
            return union(self.of({**node, "type": one}, name) for one in kind)
        if kind == "array":
            entries = node.get("prefixItems") or [node.get("items", {})]
            return f"list[{union(self.of(entry, name) for entry in entries)}]"
        if kind == "object":
            return "dict[str, Any]"
        return PLAIN.get(kind, "Any")

    def reference(self, path):
        if path not in self.names:
            node = self.schema
            for step in path.removeprefix("#/").split("/"):
                node = node[step.replace("~1", "/").replace("~0", "~")]
            # Known before its parts are made, for tables that contain themselves, such as shapes.
            self.names[path] = f'"{class_name(path.rsplit("/", 1)[1])}"'
            made = self.of(node, self.names[path].strip('"'))
            if made != self.names[path].strip('"'):
                kinds = "\n    | ".join(made.strip('"').split(" | "))
                # Text, since it may contain itself.
                self.texts.append(f'{self.names[path].strip(chr(34))}: TypeAlias = """\n    {kinds}\n"""\n')
        return self.names[path]

    def table(self, node, name):
        """A TypedDict of an object; its name."""
        lines = []
        for key, value in node["properties"].items():
            kind = self.of(value, name + class_name(key))
            if key not in node.get("required", []):
                kind = f"NotRequired[{kind}]"
            lines += [f"    # {line}" for line in textwrap.wrap(value.get("description", ""), 112)]
            lines.append(f"    {key}: {kind}")
        doc = "\n    ".join(textwrap.wrap(node.get("description", "A table of a case file."), 110))
        if any(keyword.iskeyword(key) or not key.isidentifier() for key in node["properties"]):
            # Keys that are no names of Python, such as `lambda` and `from`.
            entries = "\n".join(f"        {self.entry(node, key, value, name)}," for key, value in node["properties"].items())
            self.texts.append(f'{name} = TypedDict(\n    "{name}",\n    {{\n{entries}\n    }},\n)\n')
        else:
            self.texts.append("\n".join([f"class {name}(TypedDict):", f'    """{doc}"""', "", *lines, ""]))
        return name

    def entry(self, node, key, value, name):
        kind = self.of(value, name + class_name(key)).replace('"', "'")
        return f'"{key}": {kind if key in node.get("required", []) else f"NotRequired[{kind}]"}'


def variant(name, choice, number):
    """The name of one of several tables: by its `type` if it has one, else by its number.

    >>> variant("Probe", {"properties": {"type": {"const": "water-level"}}}, 1), variant("Probe", {}, 1)
    ('ProbeWaterLevel', 'Probe2')
    """
    kind = choice.get("properties", {}).get("type", {}) if isinstance(choice, dict) else {}
    kinds = [kind["const"]] if "const" in kind else kind.get("enum", [])
    return name + (class_name(kinds[0]) if len(kinds) == 1 else str(number + 1))


def union(kinds):
    """A union; names of tables stay text, since those that contain themselves are not there yet."""
    distinct = list(dict.fromkeys(kinds))
    if len(distinct) > 1 and any('"' in kind for kind in distinct):
        return '"' + " | ".join(kind.replace('"', "") for kind in distinct) + '"'
    return " | ".join(distinct)


def class_name(key):
    """A key as the name of a class.

    >>> class_name("fluid_region"), class_name("total-lagrangian")
    ('FluidRegion', 'TotalLagrangian')
    """
    return "".join(part[:1].upper() + part[1:] for part in re.split(r"[^A-Za-z0-9]+", key))


def generated(schema):
    """The module for a schema."""
    types = Types(schema)
    types.of(schema, "CaseFile")
    return HEAD + "\n\n" + "\n\n".join(types.texts)


def main():
    schema = json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
    TARGET.write_text(generated(schema), encoding="utf-8")


if __name__ == "__main__":
    main()
