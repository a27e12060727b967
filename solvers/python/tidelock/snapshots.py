"""The snapshots of a run, read when they are looked at."""

from __future__ import annotations

import pathlib
import xml.etree.ElementTree as xml
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, overload

import numpy as np
import pandas as pd

from . import vtp
from .errors import NoResults

if TYPE_CHECKING:
    import pyvista

SIDES = ("fluid", "solid", "walls")


class Frame:
    """All particles at one time: `fluid`, `solid` and `walls`."""

    def __init__(self, time: float, files: dict[str, pathlib.Path]):
        #: Time [s].
        self.time = time
        #: Files by side.
        self.files = files

    def particles(self, side: str) -> pd.DataFrame:
        """Particles of a side, a row each: `x`, `y`, `z` [m], `pressure`, `velocity_x` and so on.

        `attrs["units"]` has the unit of each column. `name` is the region, body or wall. Empty if the run has no such
        side.
        """
        if side not in self.files:
            if side not in SIDES:
                raise KeyError(f"no side {side!r}; there are {', '.join(SIDES)}")
            return pd.DataFrame()
        data = vtp.read(self.files[side])
        columns: dict[str, np.ndarray] = {}
        units: dict[str, str] = {}
        for name, values in data.arrays.items():
            unit = data.units.get(name, "")
            if values.ndim == 1:
                columns[name], units[name] = values, unit
                continue
            prefix = "" if name == "Points" else name + "_"
            letters = data.components.get(name, ["x", "y", "z"])
            for k, letter in enumerate(letters):
                columns[prefix + letter], units[prefix + letter] = values[:, k], unit
        table = pd.DataFrame(columns)
        if "group" in table and data.groups:
            table["name"] = pd.Categorical(np.array(data.groups, dtype=object)[table["group"]], categories=data.groups)
        table.attrs = {"units": units, "time": self.time}
        return table

    @property
    def fluid(self) -> pd.DataFrame:
        """Particles of the fluid."""
        return self.particles("fluid")

    @property
    def solid(self) -> pd.DataFrame:
        """Particles of all bodies."""
        return self.particles("solid")

    @property
    def walls(self) -> pd.DataFrame:
        """Particles of all walls."""
        return self.particles("walls")

    def mesh(self, side: str) -> pyvista.PolyData:
        """The particles of a side for PyVista (`pip install 'tidelock[frames]'`)."""
        import pyvista

        mesh = pyvista.read(self.files[side])
        assert isinstance(mesh, pyvista.PolyData)
        return mesh

    def __repr__(self) -> str:
        return f"<Frame t = {self.time:.6g} s: {', '.join(self.files)}>"


class Frames(Sequence[Frame]):
    """The frames of a run in order of time, by number or as `frames.at(time)`."""

    def __init__(self, folder: pathlib.Path):
        self.folder = folder
        path = folder / "all.pvd"
        if not path.is_file():
            raise NoResults(f"{path} is missing: the run wrote no snapshots")
        by_time: dict[float, dict[str, pathlib.Path]] = {}
        for entry in xml.parse(path).iterfind(".//DataSet"):
            files = by_time.setdefault(float(entry.get("timestep", "nan")), {})
            files[entry.get("name", "")] = folder / entry.get("file", "")
        self._frames = [Frame(time, files) for time, files in sorted(by_time.items())]

    @property
    def times(self) -> np.ndarray:
        """Times of all frames [s]."""
        return np.array([frame.time for frame in self._frames])

    def at(self, time: float) -> Frame:
        """The frame that is nearest to a time [s]."""
        return self._frames[int(np.abs(self.times - time).argmin())]

    @overload
    def __getitem__(self, number: int) -> Frame: ...

    @overload
    def __getitem__(self, number: slice) -> list[Frame]: ...

    def __getitem__(self, number):
        return self._frames[number]

    def __len__(self) -> int:
        return len(self._frames)

    def __iter__(self) -> Iterator[Frame]:
        return iter(self._frames)

    def __repr__(self) -> str:
        times = self.times
        return f"<{len(self)} frames, t = {times[0]:.6g} to {times[-1]:.6g} s>"
