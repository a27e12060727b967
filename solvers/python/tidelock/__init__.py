"""Protocol fsi.v2 for solid solvers in Python: a solver defines its physics, this package the communication.

    from tidelock import Solver, main

    class Piston(Solver):
        ...            # see tidelock.solver.Solver

    main(Piston)

See `docs/solvers.md`, and the examples `rigid_body.py` and `beam.py` next to this package.
"""

from .clock import StageTime
from .server import main
from .setup import Refused, Setup
from .solver import Diverged, Solver, StageBudget, Torques

__all__ = ["Diverged", "Refused", "Setup", "Solver", "StageBudget", "StageTime", "Torques", "main"]
