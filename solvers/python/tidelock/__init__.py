"""Tidelock from Python: write cases, run them, read and draw results, and couple a solver of your own.

Cases and results:

    import tidelock

    run = tidelock.run("cases/obstacle.toml", set={"fluid.particle_spacing_m": 0.004})
    run.probes["tip_displacement_x_m"].max()
    run.plot_snapshot().savefig("water.png")

A solid solver defines its physics, this package the communication (protocol fsi.v2):

    from tidelock import Solver, main

    class Piston(Solver):
        ...            # see tidelock.solver.Solver

    main(Piston)

Parts are imported when they are first used, so that a solver needs no pandas and a notebook no gRPC.
"""

import importlib
from typing import TYPE_CHECKING

from .version import __version__

# Which module defines what this package offers.
_PLACES = {
    "case": ["Case", "Check"],
    "errors": ["CaseRefused", "NoResults", "ProgramNotFound", "RunFailed", "TidelockError"],
    "program": ["find_program"],
    "results": ["Results", "open"],
    "running": ["run"],
    "sweeps": ["Sweep", "sweep"],
    "clock": ["StageTime"],
    "server": ["main"],
    "setup": ["Refused", "Setup"],
    "solver": ["Diverged", "Solver", "StageBudget", "Torques"],
}
_MODULES = {name: module for module, names in _PLACES.items() for name in names}

__all__ = sorted([*_MODULES, "__version__"])

if TYPE_CHECKING:
    from .case import Case, Check
    from .clock import StageTime
    from .errors import CaseRefused, NoResults, ProgramNotFound, RunFailed, TidelockError
    from .program import find_program
    from .results import Results, open
    from .running import run
    from .server import main
    from .setup import Refused, Setup
    from .solver import Diverged, Solver, StageBudget, Torques
    from .sweeps import Sweep, sweep


def __getattr__(name: str):
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f".{_MODULES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__():
    return __all__
