"""The results of a run: tables, summary, frames, plots."""

from __future__ import annotations

import functools
import json
import os
import pathlib
from typing import TYPE_CHECKING

import pandas as pd

from . import units
from .case import Case
from .errors import NoResults
from .snapshots import Frame, Frames

if TYPE_CHECKING:
    from .plots import Plot

# Layout of `summary.json` that this package reads.
FORMAT = 1


def open(folder: str | os.PathLike) -> Results:
    """The results in a folder, finished or not.

    Raises:
        NoResults: no run wrote to it.
    """
    return Results(folder)


def read_table(path: pathlib.Path) -> pd.DataFrame:
    """A table of a run by time [s]; `attrs["units"]` has the unit of each column."""
    partial = path.with_name(path.name + ".partial")
    if not path.is_file():
        if not partial.is_file():
            raise NoResults(f"{path} is missing")
        path = partial
    table = pd.read_csv(path, index_col="t_s")
    table.index.name = "t_s"
    table.attrs = {"units": {column: units.split(column)[1] for column in table.columns}}
    return table


class Results:
    """What a run wrote; everything is read when it is first asked for.

    Plots need matplotlib (`pip install 'tidelock[plot]'`). Each returns a figure, which a notebook shows and
    `savefig(path)` writes.
    """

    def __init__(self, folder: str | os.PathLike):
        self.folder = pathlib.Path(folder)
        if not any((self.folder / name).exists() for name in ["summary.json", "run.partial", "case.toml"]):
            raise NoResults(f"{self.folder}: no results of a run (no summary.json and no run.partial)")

    @functools.cached_property
    def summary(self) -> dict:
        """`summary.json`: verdict, reason, quality, energies, performance.

        Raises:
            NoResults: the run has not ended, or a newer program wrote it.
        """
        path = self.folder / "summary.json"
        if not path.is_file():
            raise NoResults(f"{path} is missing: the run has not ended, or was lost")
        summary = json.loads(path.read_text(encoding="utf-8"))
        if summary.get("format") != FORMAT:
            raise NoResults(f"{path}: format {summary.get('format')}, this package reads {FORMAT}: update it")
        return summary

    @property
    def verdict(self) -> str:
        """One word on how the run ended; "completed" if it reached its end."""
        return self.summary["verdict"]

    @property
    def reservations(self) -> list:
        """What casts doubt on the answer; empty in a good run."""
        return self.summary["reservations"]

    @functools.cached_property
    def probes(self) -> pd.DataFrame:
        """`probes.csv` by time."""
        return read_table(self.folder / "probes.csv")

    @functools.cached_property
    def ledger(self) -> pd.DataFrame:
        """`ledger.csv` by time: balances, impulses, energies."""
        return read_table(self.folder / "ledger.csv")

    @functools.cached_property
    def frames(self) -> Frames:
        """The snapshots, read one by one as they are looked at."""
        return Frames(self.folder / "snapshots")

    @functools.cached_property
    def case(self) -> Case:
        """The case with every default written out."""
        return Case.read(self.folder / "case.toml")

    @property
    def quality(self) -> pd.DataFrame:
        """Figures that judge the answer, with threshold, verdict, meaning and advice."""
        return pd.DataFrame(self.summary["quality"]).set_index("name")

    def frame(self, time: float = float("inf")) -> Frame:
        """The snapshot that is nearest to a time [s]; by default the last."""
        return self.frames[-1] if time == float("inf") else self.frames.at(time)

    def plot_probes(self, *columns: str) -> Plot:
        """Probes over time, a panel for each unit; `columns` are names or patterns such as `"tip_*"`."""
        from . import plots

        return plots.probes(self, columns)

    def plot_forces(self) -> Plot:
        """Force of the fluid on the solids, from the ledger, and all probes of forces."""
        from . import plots

        return plots.forces(self)

    def plot_ledger(self) -> Plot:
        """Imbalance across the interface and residuals of momentum, against their tolerances."""
        from . import plots

        return plots.ledger(self)

    def plot_energy(self) -> Plot:
        """Energies of both sides over time, and what no account explains."""
        from . import plots

        return plots.energy(self)

    def plot_snapshot(self, time: float = float("inf"), field: str = "pressure", **limits: float) -> Plot:
        """Particles at a time, by default the last.

        Water by `field`, solids by it too if they have it, else by von Mises stress. `speed` is the magnitude of the
        velocity. `low` and `high` bound the colours. In space the view is from the side.
        """
        from . import plots

        return plots.snapshot(self, self.frame(time), field, **limits)

    def plot_time_step(self) -> Plot:
        """Time step over time."""
        from . import plots

        return plots.time_step(self)

    def plot_quality(self) -> Plot:
        """Figures of quality as shares of their thresholds."""
        from . import plots

        return plots.quality(self)

    def __repr__(self) -> str:
        try:
            summary = self.summary
        except NoResults:
            return f"<Results {self.folder}: not ended>"
        end = summary["simulated"]["end_s"]
        return f"<Results {self.folder}: {summary['verdict']}, {end:.4g} s in {summary['steps']} steps>"

    def _repr_html_(self) -> str:
        try:
            rows = {"verdict": self.verdict, "reason": self.summary["reason"]}
        except NoResults as error:
            rows = {"verdict": str(error)}
        else:
            rows["simulated"] = f"{self.summary['simulated']['end_s']:.4g} s in {self.summary['steps']} steps"
            rows["wall time"] = f"{self.summary['wall_seconds']:.3g} s"
            rows["reservations"] = ", ".join(map(str, self.reservations)) or "none"
        cells = "".join(f"<tr><th>{key}</th><td>{value}</td></tr>" for key, value in rows.items())
        return f"<table><caption>{self.folder}</caption>{cells}</table>"
