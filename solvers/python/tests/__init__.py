"""Tests of the skin and its solvers: `python3 -m unittest` in the folder above."""
