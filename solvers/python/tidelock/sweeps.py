"""Many runs of one case."""

from __future__ import annotations

import functools
import os
import pathlib
from collections.abc import Mapping, Sequence

import pandas as pd

from .case import Case
from .errors import NoResults
from .program import settings, written
from .results import Results
from .running import carry_out


class Sweep:
    """The runs of a sweep: a table of key figures, and each member's results."""

    def __init__(self, folder: str | os.PathLike):
        self.folder = pathlib.Path(folder)
        if not (self.folder / "sweep.csv").is_file():
            raise NoResults(f"{self.folder}: no sweep.csv")

    @functools.cached_property
    def table(self) -> pd.DataFrame:
        """A row for each member, by its number: values of the keys, state, key figures."""
        return pd.read_csv(self.folder / "sweep.csv", index_col="member")

    @functools.cached_property
    def members(self) -> list[Results]:
        """Results of all members that have some, in order."""
        folders = [self.folder / "members" / str(name) / "results" for name in self.table["run"]]
        return [Results(folder) for folder in folders if folder.is_dir()]

    def plot(self, figure: str, over: str | None = None):
        """A key figure over a key, by default the first one; both named by a part of the column."""
        from .plots import Plot

        keys = list(self.table.columns[2 : self.table.columns.get_loc("steps")])
        key = next(column for column in keys if over is None or over in column)
        value = next(column for column in self.table.columns if figure in column and column not in keys)
        plot = Plot(6.0, 3.6)
        axes = plot.add_subplot()
        axes.plot(self.table[key], self.table[value], "o-")
        axes.set(xlabel=key, ylabel=value)
        axes.grid(alpha=0.3)
        return plot

    def __repr__(self) -> str:
        return f"<Sweep {self.folder}: {len(self.table)} members>"


def sweep(
    case: Case | str | os.PathLike,
    over: Mapping[str, Sequence[object] | str],
    out: str | os.PathLike,
    *,
    figures: Sequence[str] = (),
    set: Mapping[str, object] | None = None,
    jobs: int = 1,
    threads: int | None = None,
    seeds: int = 0,
    echo: bool = False,
    options: Sequence[str] = (),
) -> Sweep:
    """Runs a case over values of its keys, all combinations; finished members are kept.

    Args:
        over: for each key its values, or a range such as `"1e5..1e6:log"` with `options=["--latin", "8"]`.
        figures: key figures, such as `"largest tip_displacement_x_m"`; by default of every column of the probes.
        jobs: runs at a time.
        seeds: number of disturbed copies of each point.

    Raises:
        CaseRefused: a member has mistakes.
        RunFailed: members failed; the others are complete and `Sweep(out)` opens them.
    """
    case = case if isinstance(case, Case) else Case.read(case)
    out = pathlib.Path(out)
    words: list[object] = ["--out", out, "--jobs", jobs, "--seeds", seeds, *settings(set)]
    for key, values in over.items():
        entries = values if isinstance(values, str) else ",".join(_entry(value) for value in values)
        words += ["--over", f"{key}={entries}"]
    for figure in figures:
        words += ["--figure", figure]
    if threads is not None:
        words += ["--threads", threads]
    if not echo:
        words.append("--quiet")
    carry_out("sweep", case, [*words, *options], out, echo)
    return Sweep(out)


def _entry(value: object) -> str:
    return value if isinstance(value, str) else written(value)
