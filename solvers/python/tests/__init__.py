"""Tests of the package and its solvers: `python3 -m unittest` in the folder above."""
