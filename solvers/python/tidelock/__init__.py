"""A skin for solid solvers in Python: a solver writes its physics, the skin speaks the protocol fsi.v1.

    from tidelock import Solver, main

    class Piston(Solver):
        ...            # see tidelock.solver.Solver

    main(Piston)

`docs/solvers.md` tells how, and `rigid_body.py` and `beam.py` beside this package are examples.
"""

from .clock import StageTime
from .server import main
from .setup import Refused, Setup
from .solver import Books, Diverged, Solver, Torques

__all__ = ["Books", "Diverged", "Refused", "Setup", "Solver", "StageTime", "Torques", "main"]
