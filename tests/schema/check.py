"""The schema of case files in the hands of others: a JSON-Schema library and the language servers that editors use.

    python3 tests/schema/check.py PROGRAM [--servers]

PROGRAM is tidelock. Every shipped case and every template must be valid. Then each key and each table of the
shipped cases is mistyped once, and `check` and the library must both find it; with `--servers` tombi and taplo as well.
It needs the packages of requirements.txt.
"""

import argparse
import json
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

from jsonschema import Draft7Validator

import editor

ROOT = Path(__file__).resolve().parents[2]


def output(*words, ok=True):
    """Standard output and error of a command, colours left out."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    text = done.stdout + done.stderr
    if ok and done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}: {text}")
    return done.returncode, re.sub(r"\x1b\[[0-9;]*m", "", text)


def undescribed(schema, path=""):
    """Keys that lack description, unit, default or range."""
    for name, key in schema.get("properties", {}).items():
        lacking = [word for word in ("description", "x-unit", "x-default", "x-range") if not key.get(word)]
        if lacking:
            yield f"{path}{name}: {', '.join(lacking)}"
    for word in ("oneOf", "anyOf"):
        for option in schema.get(word, []):
            yield from undescribed(option, f"{path}{option.get('title', '')}.")
    for name, table in schema.get("definitions", {}).items():
        yield from undescribed(table, f"{name}.")


def mistyped(cases):
    """Name, text and mistyped word of copies of cases, in each of which one key or table is wrong.

    The smallest case that has it is taken, since `check` lays out all particles.
    """
    seen = set()
    for case in sorted(cases, key=lambda path: path.stat().st_size):
        text = case.read_text()
        found = re.finditer(r"^(?!#).*?$", text, re.MULTILINE)
        for line in found:
            code = re.sub(r'"[^"]*"', lambda quoted: " " * len(quoted[0]), line[0]).split("#")[0]
            for word in re.finditer(r"\b([a-z]\w*)(?= =)|^\[+([a-z_.]+)", code):
                group = 1 if word[1] else 2
                if word[group] in seen:
                    continue
                seen.add(word[group])
                # A letter of its last part is doubled, so that the unit stays wrong, too.
                at = line.start() + word.end(group)
                wrong = text[:at] + text[at - 1] + text[at:]
                yield f"{case.stem}-{word[group]}", wrong, word[group].split(".")[-1] + text[at - 1]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program", type=Path)
    arguments.add_argument("--servers", action="store_true")
    arguments = arguments.parse_args()
    program = arguments.program.resolve()
    failures = []

    schema = json.loads(output(program, "schema")[1])
    Draft7Validator.check_schema(schema)
    failures += [f"not described: {key}" for key in undescribed(schema)]
    validator = Draft7Validator(schema)

    cases = sorted((ROOT / "cases").rglob("*.toml"))
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        templates = [line.split()[0] for line in output(program, "new", "--list")[1].splitlines()]
        for template in templates:
            output(program, "new", "--template", template, folder / f"{template}.toml")
        good = cases + sorted(folder.glob("*.toml"))
        for case in good:
            for error in validator.iter_errors(tomllib.loads(case.read_text())):
                failures.append(f"{case}: {error.json_path}: {error.message[:200]}")
        print(f"{len(good)} cases against the schema")
        if arguments.servers:
            for words in (["tombi", "lint", "--offline"], ["taplo", "check"]):
                code, text = output(*words, *good, ok=False)
                failures += [f"{words[0]}: {text[-2000:]}"] if code else []
                print(f"{len(good)} cases by {words[0]}")
            missing = editor.failures(["tombi", "lsp", "--offline"], folder)
            failures += [f"tombi in an editor: {what}" for what in missing]
            print("completion, explanation and mistakes in an editor by tombi")

        # With the files that cases name.
        shutil.copytree(ROOT / "cases", folder / "cases")
        (folder / "docs").mkdir()
        (folder / "docs" / "case.schema.json").write_text(json.dumps(schema))
        names = []
        for number, (name, text, word) in enumerate(mistyped(sorted((folder / "cases").rglob("*.toml")))):
            path = folder / "cases" / f"mistyped{number}.toml"
            path.write_text("#:schema ../docs/case.schema.json\n" + text.split("\n", 1)[1])
            names.append((path, name))
            if not any(validator.iter_errors(tomllib.loads(text))):
                failures.append(f"{name}: `{word}` is valid by the schema")
            code, said = output(program, "check", path, ok=False)
            if code == 0 or "unknown key" not in said or word not in said:
                failures.append(f"{name}: `check` does not find `{word}`: {said[-300:]}")
        print(f"{len(names)} mistyped keys by the schema and `check`")
        if arguments.servers:
            for words in (["tombi", "lint", "--offline"], ["taplo", "check"]):
                for path, name in names:
                    code, _ = output(*words, path, ok=False)
                    failures += [] if code else [f"{words[0]} does not find {name}"]
                print(f"{len(names)} mistyped keys by {words[0]}")
    for failure in failures:
        print(failure)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
