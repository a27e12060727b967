"""Cases, runs and results from Python."""

import doctest
import importlib
import os
import pathlib
import tempfile
import unittest

import tidelock

ROOT = pathlib.Path(__file__).resolve().parents[3]
MODULES = ["case", "program", "units"]


def missing() -> str:
    """What these tests need and this machine lacks."""
    try:
        for name in ["matplotlib", "pandas", "tomlkit"]:
            importlib.import_module(name)
        tidelock.find_program()
    except (ModuleNotFoundError, tidelock.ProgramNotFound) as error:
        return str(error)
    return ""


MISSING = missing()
if MISSING and "TIDELOCK_REQUIRE_PYTHON" in os.environ:
    raise RuntimeError(MISSING)


def load_tests(_loader, tests, _pattern):
    if not MISSING:
        for name in MODULES:
            tests.addTests(doctest.DocTestSuite(importlib.import_module(f"tidelock.{name}")))
    return tests


@unittest.skipIf(MISSING, MISSING)
class Cases(unittest.TestCase):
    def test_comments_stay_and_nothing_else_changes(self):
        path = ROOT / "cases" / "obstacle.toml"
        case = tidelock.Case.read(path)
        self.assertEqual(case.to_toml(), path.read_text())
        case["solid.body.obstacle.material.young_modulus_pa"] = 2e6
        changed = [pair for pair in zip(case.to_toml().splitlines(), path.read_text().splitlines()) if pair[0] != pair[1]]
        self.assertEqual(len(changed), 1)
        self.assertIn("young_modulus_pa = 2000000.0", changed[0][0])

    def test_a_case_from_nothing_passes_check(self):
        case = tidelock.Case(name="tank", domain={"lower_m": [0, 0], "upper_m": [0.2, 0.2]})
        case["time"] = {"end_time_s": 0.01, "step": {"type": "adaptive"}}
        case["fluid"] = {"particle_spacing_m": 0.01, "sound_speed_m_s": 15.0, "rest_density_kg_m3": 1000.0}
        square = {"type": "rectangle", "lower_m": [0, 0], "upper_m": [0.1, 0.1]}
        case.add("fluid.region", name="water", shape=square)
        case.add("wall", name="box", type="container", open_sides=["top"])
        self.assertEqual(case.check().particles["fluid region water"], 100)

    def test_mistakes_come_with_their_line_and_the_name_of_the_file(self):
        case = tidelock.Case.read(ROOT / "cases" / "obstacle.toml")
        case["fluid.sound_sped_m_s"] = 1.0
        with self.assertRaises(tidelock.CaseRefused) as caught:
            case.check()
        pattern = r"(?s)`fluid.sound_sped_m_s`.*obstacle.toml:\d+.*did you mean `sound_speed_m_s`"
        self.assertRegex(str(caught.exception), pattern)

    def test_an_unknown_entry_names_the_known_ones(self):
        case = tidelock.Case.read(ROOT / "cases" / "obstacle.toml")
        with self.assertRaisesRegex(KeyError, "no entry `tp`; known here: tip, load, clamp"):
            case["probe.tp.at_m"]


@unittest.skipIf(MISSING, MISSING)
class Runs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        case = tidelock.Case.read(ROOT / "cases" / "obstacle.toml")
        # Water that stands against the obstacle, so that forces act from the start.
        case["fluid.region.column.shape.upper_m"] = [0.292, 0.06]
        case["fluid.region.column.start.surface_m"] = 0.06
        case.update({"fluid.particle_spacing_m": 0.006, "time.end_time_s": 0.01, "outputs.snapshot_interval_s": 0.005})
        cls.case = case
        cls.run_ = tidelock.run(case, cls.path / "run", threads=1)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_tables_have_times_and_units(self):
        probes = self.run_.probes
        self.assertAlmostEqual(probes.index[-1], 0.01, places=3)
        self.assertEqual(probes.attrs["units"]["tip_displacement_x_m"], "m")
        self.assertEqual(self.run_.ledger.attrs["units"]["solid_force_x_n_per_m"], "N/m")
        self.assertEqual(self.run_.verdict, "completed")

    def test_all_columns_of_tables_have_a_unit_or_are_numbers(self):
        pure = {"step", "imbalance_force", "imbalance_torque", "most_iterations"}
        for table in [self.run_.probes, self.run_.ledger]:
            bare = {c for c, unit in table.attrs["units"].items() if not unit} - pure
            self.assertEqual({c for c in bare if not c.endswith(("_residual", "_pairs"))}, set())

    def test_frames_hold_the_particles_of_each_side(self):
        frames = self.run_.frames
        self.assertEqual(len(frames), 3)
        frame = frames.at(0.005)
        self.assertAlmostEqual(frame.time, 0.005, places=3)
        # The area of the water, of 48 columns and 10 rows.
        self.assertAlmostEqual(frame.fluid["volume"].sum(), 0.292 * 0.06, delta=2e-4)
        self.assertEqual(set(frame.solid["name"]), {"obstacle"})
        self.assertEqual(frame.fluid.attrs["units"]["pressure"], "Pa")
        # At rest pressure is rho g depth.
        deep = frames[0].fluid.nlargest(20, "pressure")
        self.assertTrue(((deep["pressure"] - 9810 * (0.06 - deep["y"])).abs() < 10).all())

    def test_each_plot_draws(self):
        run = self.run_
        plots = [run.plot_probes, run.plot_forces, run.plot_ledger, run.plot_energy, run.plot_snapshot]
        for plot in [*plots, run.plot_time_step, run.plot_quality]:
            figure = plot()
            # A picture that is not blank.
            self.assertGreater(len(figure._repr_png_()), 5000, plot)
        with self.assertRaisesRegex(KeyError, "no probe column"):
            run.plot_probes("none_*")

    def test_results_are_not_overwritten(self):
        with self.assertRaisesRegex(tidelock.RunFailed, "exit code 3") as caught:
            tidelock.run(self.case, self.path / "run")
        self.assertEqual(caught.exception.exit_code, 3)

    def test_a_run_that_breaks_down_says_so_and_keeps_its_results(self):
        case = self.case.copy()
        case["fluid.sound_speed_m_s"] = 0.5
        with self.assertRaises(tidelock.RunFailed) as caught:
            tidelock.run(case, self.path / "broken", threads=1)
        error = caught.exception
        self.assertEqual((error.exit_code, error.verdict), (5, "failed"))
        self.assertRegex(str(error), "density")
        self.assertEqual(tidelock.open(error.folder).verdict, "failed")

    def test_a_run_without_a_step_has_no_ledger_to_draw(self):
        case = self.case.copy()
        case["body_force.acceleration_m_s2"] = ["1e9*step(t - 1e-9)", 0.0]
        with self.assertRaises(tidelock.RunFailed) as caught:
            tidelock.run(case, self.path / "stepless", threads=1)
        run = tidelock.open(caught.exception.folder)
        self.assertEqual((run.summary["steps"], len(run.ledger)), (0, 0))
        for plot in [run.plot_forces, run.plot_ledger, run.plot_energy, run.plot_time_step]:
            with self.assertRaisesRegex(tidelock.NoResults, "no ledger rows: it stopped before its first step"):
                plot()
        for plot in [run.plot_probes, run.plot_snapshot, run.plot_quality]:
            self.assertGreater(len(plot()._repr_png_()), 5000, plot)

    def test_a_sweep_has_a_row_for_each_member(self):
        key, figure = "solid.body.obstacle.material.young_modulus_pa", "largest tip_displacement_x_m"
        sweep = tidelock.sweep(self.case, {key: [1e6, 4e6]}, self.path / "sweep", figures=[figure], threads=1)
        self.assertEqual(list(sweep.table["state"]), ["finished", "finished"])
        self.assertEqual(list(sweep.table[key]), [1e6, 4e6])
        self.assertEqual(sweep.table[figure].nunique(), 2)
        self.assertEqual([run.verdict for run in sweep.members], ["completed", "completed"])

    def test_a_folder_without_a_run_is_refused(self):
        with self.assertRaisesRegex(tidelock.NoResults, "no results of a run"):
            tidelock.open(self.folder.name)


class Program(unittest.TestCase):
    def test_a_program_that_is_not_there_is_named(self):
        before = os.environ.get("TIDELOCK_PROGRAM")
        os.environ["TIDELOCK_PROGRAM"] = "/no/such/program"
        try:
            with self.assertRaisesRegex(tidelock.ProgramNotFound, "/no/such/program"):
                tidelock.find_program()
        finally:
            del os.environ["TIDELOCK_PROGRAM"]
            if before:
                os.environ["TIDELOCK_PROGRAM"] = before


if __name__ == "__main__":
    unittest.main()
