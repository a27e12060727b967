"""Plots of a run. Each returns a `Plot`, a figure of matplotlib that notebooks show by themselves."""

from __future__ import annotations

import fnmatch
import io
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from . import units
from .errors import NoResults

try:
    from matplotlib.collections import EllipseCollection
    from matplotlib.figure import Figure
except ModuleNotFoundError as error:
    raise ModuleNotFoundError("plots need matplotlib: pip install 'tidelock[plot]'") from error

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import Collection

    from .results import Results
    from .snapshots import Frame

# Largest number of lines in a panel with a legend.
MOST_LINES = 12
WALL, BODY = "#9aa0a6", "#c7cad0"


class Plot(Figure):
    """A figure that no window manager holds: freed when it is dropped, shown by notebooks."""

    def __init__(self, width: float = 7.0, height: float = 4.0):
        super().__init__(figsize=(width, height), layout="constrained", dpi=110)

    def _repr_png_(self) -> bytes:
        png = io.BytesIO()
        self.savefig(png, format="png")
        return png.getvalue()


def probes(run: Results, patterns: Sequence[str] = ()) -> Plot:
    """Probes over time, a panel for each unit."""
    table = run.probes
    chosen = [c for c in table.columns if not patterns or any(fnmatch.fnmatchcase(c, p) for p in patterns)]
    if not chosen:
        raise KeyError(f"no probe column {', '.join(patterns)}; there are {', '.join(table.columns)}")
    by_unit: dict[str, list[str]] = {}
    for column in chosen:
        by_unit.setdefault(units.split(column)[1], []).append(column)
    plot, panels = _panels(len(by_unit))
    for axes, (unit, columns) in zip(panels, by_unit.items()):
        _lines(axes, table[columns], unit)
    return plot


def forces(run: Results) -> Plot:
    """Forces over time."""
    ledger, found = _ledger(run), {}
    for letter in "xyz":
        for column in [c for c in ledger.columns if c.startswith(f"solid_force_{letter}_")]:
            found[f"fluid on solids {letter}"] = ledger[column]
    panels = [("interface", found)] if found else []
    probed = {c: run.probes[c] for c in run.probes.columns if units.split(c)[1] in ("N", "N/m") and "force" in c}
    if probed:
        panels.append(("probes", probed))
    if not panels:
        raise KeyError("no forces: the case has neither solids nor probes of forces")
    unit = "N/m" if run.summary["dimensions"] == 2 else "N"
    plot, all_axes = _panels(len(panels))
    for axes, (title, series) in zip(all_axes, panels):
        for name, values in list(series.items())[:MOST_LINES]:
            axes.plot(values.index, values, label=units.split(name)[0].replace("_", " "), linewidth=1)
        _finish(axes, f"force [{unit}]", title)
    return plot


def ledger(run: Results) -> Plot:
    """Imbalances and residuals on a logarithmic axis, with their tolerances."""
    table = _ledger(run)
    columns = ["imbalance_force", "imbalance_torque"]
    columns += [c for c in table.columns if c.endswith("momentum_residual")]
    plot = Plot()
    axes = plot.add_subplot()
    for column in [c for c in columns if c in table and (table[c] > 0).any()]:
        axes.plot(table.index, table[column].where(table[column] > 0), label=column.replace("_", " "), linewidth=1)
    for key in ["balance_tolerance", "momentum_tolerance"]:
        if f"ledger.{key}" in run.case:
            axes.axhline(run.case[f"ledger.{key}"], color="black", linestyle=":", linewidth=1)
    axes.set_yscale("log")
    _finish(axes, "share of the sum of magnitudes", "ledger; dotted: tolerance")
    return plot


def energy(run: Results) -> Plot:
    """Accounts of the energy of each side, changes since the start."""
    table = _ledger(run)
    sides = [s for s in ("fluid", "solid") if any(c.startswith(f"{s}_energy_") for c in table.columns)]
    if not sides:
        raise KeyError("no energies in ledger.csv")
    plot, panels = _panels(len(sides), 3.6)
    for axes, side in zip(panels, sides):
        accounts = {a["account"]: a["kind"] for a in run.summary["energy"].get(side, {}).get("accounts", [])}
        for column in [c for c in table.columns if c.startswith(f"{side}_energy_")]:
            name, unit = units.split(column)
            account = name.removeprefix(f"{side}_energy_")
            change = table[column] - table[column].iloc[0]
            # Accounts that stay at zero would only fill the legend.
            if account != "residual" and change.abs().max() == 0:
                continue
            style = {"work": "--", "loss": ":"}.get(accounts.get(account, ""), "-")
            width = 2.0 if account == "residual" else 1.2
            color = "black" if account == "residual" else None
            axes.plot(table.index, change, style, label=account.replace("_", " "), linewidth=width, color=color)
        _finish(axes, f"energy [{unit}]", f"{side}: stores solid, work dashed, losses dotted", outside=True)
    return plot


def snapshot(
    run: Results, frame: Frame, field: str = "pressure", low: float | None = None, high: float | None = None
) -> Plot:
    """Particles as discs of their size."""
    flat = run.summary["dimensions"] == 2
    fluid, solid, walls = frame.fluid, frame.solid, frame.walls
    across, up = ("x", "y") if flat else ("x", _upward(run))
    drawn: list[tuple[pd.DataFrame, str | None, str]] = []
    if len(walls) and flat:
        drawn.append((walls, None, WALL))
    if len(fluid):
        drawn.append((fluid, field, "viridis"))
    if len(solid):
        of_solid = field if not len(fluid) and _has(solid, field) else "von_mises"
        # Rigid bodies have no stress.
        strained = _has(solid, of_solid) and _values(solid, of_solid)[0].abs().max() > 0
        drawn.append((solid, of_solid, "inferno") if strained else (solid, None, BODY))
    places = pd.concat([table[[across, up]] for table, _, _ in drawn])
    bars = sum(1 for _, name, _ in drawn if name)
    inside = 7.5 - 0.8 - 0.95 * bars
    plot = Plot(7.5, min(max(inside * np.ptp(places[up]) / np.ptp(places[across]), 1.2), 8.0) + 0.8)
    axes = plot.add_subplot()
    for table, name, color in drawn:
        if not flat:
            table = table.iloc[_nearest_last(table, across, up)]
        discs = _discs(axes, table, across, up)
        if name is None:
            discs.set_facecolor(color)
            continue
        values, unit = _values(table, name)
        bounds = np.nanpercentile(values, [1, 99])
        if table is fluid or name == field:
            bounds = [b if b is not None else own for b, own in zip((low, high), bounds)]
        discs.set(array=values.to_numpy(), cmap=color)
        discs.set_clim(*bounds)
        side = "solid" if table is solid or "von_mises" in table else "water"
        label = f"{side}: {name.replace('_', ' ')} [{unit}]"
        plot.colorbar(discs, ax=axes, label=label, extend="both", aspect=28, pad=0.02)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set(xlabel=f"{across} [m]", ylabel=f"{up} [m]", title=f"{run.summary['case']}, t = {frame.time:.4g} s")
    return plot


def _discs(axes: Axes, table: pd.DataFrame, across: str, up: str) -> Collection:
    # A little larger than their cells, so that no background shines through.
    size = 2.6 * table["point_radius"]
    places = table[[across, up]].to_numpy()
    discs = EllipseCollection(size, size, np.zeros(len(table)), units="xy", offsets=places, linewidth=0)
    discs.set_offset_transform(axes.transData)
    axes.add_collection(discs)
    return discs


def time_step(run: Results) -> Plot:
    """Time step over time."""
    plot = Plot(7.0, 3.0)
    axes = plot.add_subplot()
    table = _ledger(run)
    axes.plot(table.index, table["time_step_s"], linewidth=1)
    axes.set_ylim(bottom=0)
    _finish(axes, "time step [s]", f"{run.summary['steps']} steps")
    return plot


def quality(run: Results) -> Plot:
    """Figures of quality over their thresholds."""
    table = run.quality
    judged = table[(table["verdict"] != "not-judged") & (table["threshold"] > 0)]
    share = judged["value"].abs() / judged["threshold"]
    # The number of particles across a body has a lower bound.
    at_least = judged.index == "particles_across"
    share = share.where(~at_least, 1 / share)
    plot = Plot(7.0, 0.6 + 0.4 * max(len(judged), 2))
    axes = plot.add_subplot()
    colors = ["#3a7d44" if verdict == "good" else "#c0392b" for verdict in judged["verdict"]]
    axes.barh([name.replace("_", " ") for name in judged.index], share, color=colors)
    axes.axvline(1, color="black", linestyle=":")
    axes.set_xlabel("value over threshold")
    return plot


def _ledger(run: Results) -> pd.DataFrame:
    """The ledger of a run that has one."""
    if run.ledger.empty:
        raise NoResults("the run has no ledger rows: it stopped before its first step")
    return run.ledger


def _panels(count: int, height: float = 2.6) -> tuple[Plot, list[Axes]]:
    plot = Plot(7.5, height * count)
    return plot, [plot.add_subplot(count, 1, k + 1) for k in range(count)]


def _lines(axes: Axes, table: pd.DataFrame, unit: str) -> None:
    for column in table.columns[:MOST_LINES]:
        axes.plot(table.index, table[column], label=units.split(column)[0].replace("_", " "), linewidth=1.2)
    if len(table.columns) > MOST_LINES:
        axes.set_title(f"the first {MOST_LINES} of {len(table.columns)} columns", fontsize=9)
    _finish(axes, f"[{unit}]" if unit else "[-]")


def _finish(axes: Axes, label: str, title: str = "", outside: bool = False) -> None:
    axes.set(xlabel="t [s]", ylabel=label)
    if title:
        axes.set_title(title, fontsize=10)
    if outside:
        axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5), frameon=False)
    elif axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=8)
    axes.grid(alpha=0.3)


def _has(table: pd.DataFrame, field: str) -> bool:
    return field in table or (field == "speed" and "velocity_x" in table)


def _values(table: pd.DataFrame, field: str) -> tuple[pd.Series, str]:
    if field == "speed":
        return (table[["velocity_x", "velocity_y", "velocity_z"]] ** 2).sum(axis=1) ** 0.5, "m/s"
    if field not in table:
        raise KeyError(f"no field {field!r}; there are speed, {', '.join(table.columns)}")
    return table[field], table.attrs["units"].get(field, "")


def _upward(run: Results) -> str:
    gravity = np.abs(run.case["body_force.gravity_m_s2"]) if "body_force.gravity_m_s2" in run.case else [0, 0, 1]
    axis = int(np.argmax(gravity))
    return "xyz"[axis] if axis > 0 and gravity[axis] > 0 else "z"


def _nearest_last(table: pd.DataFrame, across: str, up: str) -> np.ndarray:
    """Order in which particles hide those behind them; right-handed, seen against the third axis."""
    (depth,) = set("xyz") - {across, up}
    sign = 1 if (across, up) == ("x", "y") else -1
    return np.argsort(sign * table[depth].to_numpy(), kind="stable")
