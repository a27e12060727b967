"""Cases: read or built, changed by key, checked, saved."""

from __future__ import annotations

import contextlib
import dataclasses
import os
import pathlib
import re
import tempfile
from collections.abc import Iterator, Mapping

import tomlkit
from tomlkit.exceptions import ParseError

from .errors import CaseRefused
from .program import call

# How messages call a case that has no file.
UNSAVED = "case.toml"


@dataclasses.dataclass(frozen=True)
class Check:
    """What `check` says of a case without mistakes."""

    text: str

    @property
    def particles(self) -> dict[str, int]:
        """Number of particles of each region, body and wall.

        >>> Check("particles\\n  fluid region water: 2300\\n  wall tank: 826\\n\\ntime step").particles
        {'fluid region water': 2300, 'wall tank': 826}
        """
        block = self.text.partition("particles\n")[2].partition("\n\n")[0]
        rows = re.findall(r"^ +((?:fluid region|body|wall) \S+): (\d+)", block, re.MULTILINE)
        return {name: int(count) for name, count in rows}

    def __str__(self) -> str:
        return self.text


class Case:
    """A case: a TOML document whose keys go by path, as for `--set`.

    >>> case = Case(name="tank")
    >>> case["domain"] = {"lower_m": [0.0, 0.0], "upper_m": [1.0, 0.5]}
    >>> case["fluid.particle_spacing_m"] = 0.01
    >>> case.add("wall", name="box", type="container", open_sides=["top"])
    >>> case["wall.box.condition"] = "no-slip"
    >>> case["domain.upper_m[1]"]
    0.5
    >>> "fluid.scheme" in case
    False

    Entries of lists go by their name or by their number from 0. Comments of a file that is read stay when it is saved.
    """

    def __init__(self, document: Mapping[str, object] | None = None, /, **keys: object):
        self.document = document if isinstance(document, tomlkit.TOMLDocument) else tomlkit.document()
        if document is not None and self.document is not document:
            self.document.update(document)
        #: Folder that paths in the case are relative to; None for one that was never read or saved.
        self.folder: pathlib.Path | None = None
        self.path: pathlib.Path | None = None
        for key, value in keys.items():
            self[key] = value

    @classmethod
    def read(cls, path: str | os.PathLike) -> Case:
        """The case of a file.

        Raises:
            CaseRefused: the file is no TOML. Whether its keys are right says `check`.
            FileNotFoundError: there is no such file.
        """
        path = pathlib.Path(path)
        return cls._of(path.read_text(encoding="utf-8"), path)

    @classmethod
    def parse(cls, text: str) -> Case:
        """The case that `text` holds.

        >>> Case.parse('name = "tank"')["name"]
        'tank'
        """
        return cls._of(text, None)

    @classmethod
    def _of(cls, text: str, path: pathlib.Path | None) -> Case:
        try:
            case = cls(tomlkit.parse(text))
        except ParseError as error:
            raise CaseRefused(f"{path or UNSAVED}: {error}") from None
        if path is not None:
            case.path, case.folder = path, path.resolve().parent
        return case

    @property
    def name(self) -> str:
        """The name of the case, "case" if it has none yet."""
        return str(self.document.get("name", "case"))

    def __getitem__(self, key: str):
        value = self._find(_steps(key), key)
        return value.unwrap() if hasattr(value, "unwrap") else value

    def __setitem__(self, key: str, value: object) -> None:
        *above, last = _steps(key)
        table = self._find(above, key, make=True)
        if isinstance(table, list):
            table[_number(table, last, key)] = _plain(value)
        else:
            table[last] = _plain(value)

    def __delitem__(self, key: str) -> None:
        *above, last = _steps(key)
        table = self._find(above, key)
        del table[_number(table, last, key) if isinstance(table, list) else last]

    def __contains__(self, key: str) -> bool:
        try:
            self._find(_steps(key), key)
        except KeyError:
            return False
        return True

    def update(self, values: Mapping[str, object]) -> Case:
        """Sets several keys by path; returns the case."""
        for key, value in values.items():
            self[key] = value
        return self

    def add(self, key: str, **entry: object) -> None:
        """Adds an entry to a list of tables, such as `fluid.region`, `wall`, `solid.body` and `probe`."""
        *above, last = _steps(key)
        table = self._find(above, key, make=True)
        if last not in table:
            table[last] = tomlkit.aot()
        made = tomlkit.table()
        made.update({name: _plain(value) for name, value in entry.items()})
        table[last].append(made)

    def copy(self) -> Case:
        """A case that can be changed alone."""
        other = Case.parse(self.to_toml())
        other.folder, other.path = self.folder, self.path
        return other

    def to_toml(self) -> str:
        """The text of the case file."""
        return tomlkit.dumps(self.document)

    def to_dict(self) -> dict:
        """All keys as nested dictionaries and lists."""
        return self.document.unwrap()

    def save(self, path: str | os.PathLike) -> pathlib.Path:
        """Writes the case file. Paths in it stay as they are and count from the folder of the new file."""
        path = pathlib.Path(path)
        path.write_text(self.to_toml(), encoding="utf-8")
        self.path, self.folder = path, path.resolve().parent
        return path

    def check(self, picture: str | os.PathLike | None = None) -> Check:
        """Checks the case without running it: particle counts, step, forecast of the run time.

        `picture` names a PNG to draw the particles at the start to.

        Raises:
            CaseRefused: with all mistakes at once.
        """
        with self.file() as path:
            code, text = call(["check", "--verbose", path, *(["--picture", picture] if picture else [])])
            if code != 0:
                raise CaseRefused(text.replace(str(path), str(self.path or UNSAVED)))
        return Check(text)

    @contextlib.contextmanager
    def file(self) -> Iterator[pathlib.Path]:
        """A file with the case as it is now, beside what its paths name."""
        if self.path is not None and self.path.is_file() and self.path.read_text(encoding="utf-8") == self.to_toml():
            yield self.path
            return
        if self.folder is None:
            with tempfile.TemporaryDirectory(prefix="tidelock-") as folder:
                path = pathlib.Path(folder) / f"{self.name}.toml"
                path.write_text(self.to_toml(), encoding="utf-8")
                yield path
            return
        # Relative paths in a case count from its file, so this one must stand beside the file that was read.
        number, name = tempfile.mkstemp(prefix=f".{self.name}-", suffix=".toml", dir=self.folder)
        try:
            with os.fdopen(number, "w", encoding="utf-8") as file:
                file.write(self.to_toml())
            yield pathlib.Path(name)
        finally:
            os.unlink(name)

    def __repr__(self) -> str:
        place = f", {self.path}" if self.path else ""
        return f"<Case {self.name}{place}>"

    def _find(self, steps: list[str], key: str, make: bool = False):
        place = self.document
        for step in steps:
            if isinstance(place, list):
                place = place[_number(place, step, key)]
            elif isinstance(place, Mapping):
                if step not in place:
                    if not make:
                        raise KeyError(f"{key}: no `{step}`; known here: {', '.join(place) or 'nothing'}")
                    place[step] = tomlkit.table()
                place = place[step]
            else:
                raise KeyError(f"{key}: `{step}` is in {place!r}, which has no keys")
        return place


def _steps(key: str) -> list[str]:
    """The parts of a path.

    >>> _steps("domain.upper_m[1]")
    ['domain', 'upper_m', '1']
    """
    return [step for step in re.split(r"[.\[\]]+", key) if step]


def _number(entries: list, step: str, key: str) -> int:
    names = [entry.get("name") if isinstance(entry, Mapping) else None for entry in entries]
    if step in names:
        return names.index(step)
    if step.isdigit() and int(step) < len(entries):
        return int(step)
    known = ", ".join(str(name) for name in names if name) or f"0 to {len(entries) - 1}"
    raise KeyError(f"{key}: no entry `{step}`; known here: {known}")


def _plain(value: object) -> object:
    """A value without types of NumPy, which TOML does not know; tables inside a value stay on one line."""
    if hasattr(value, "tolist"):
        value = value.tolist()  # type: ignore[attr-defined]
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    if isinstance(value, Mapping):
        return {key: _inline(entry) for key, entry in value.items()}
    return value


def _inline(value: object) -> object:
    value = _plain(value)
    if isinstance(value, dict):
        table = tomlkit.inline_table()
        table.update(value)
        return table
    return value
