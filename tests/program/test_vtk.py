"""particles.vtkhdf of a real run, as VTK's own reader sees it. Skipped (77) without a Python that has vtk."""
import os
import signal
import sys

import moraine
from moraine import INPUTS, SMALL_SCENE, checkpoints, sets, summary, table
from valley import SCENE, ValleyTest, heights

try:
    import numpy as np
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError as missing:
    print(f"SKIPPED: {missing}. `pip install vtk numpy`, and -DMORAINE_PYTHON=<that python>?")
    sys.exit(77)


class Series:
    """A series opened anew: times, and each step's points and fields by name."""

    def __init__(self, directory, name="particles.vtkhdf"):
        self.reader = vtk.vtkHDFReader()
        self.reader.SetFileName(str(directory / name))
        self.reader.UpdateInformation()
        self.times = list(self.reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS()))

    def step(self, k):
        self.reader.UpdateTimeStep(self.times[k])
        data = vtk.vtkPolyData.SafeDownCast(self.reader.GetOutputAsDataSet())
        fields = data.GetPointData()
        arrays = {fields.GetArrayName(a): vtk_to_numpy(fields.GetArray(a)) for a in range(fields.GetNumberOfArrays())}
        assert data.GetNumberOfVerts() == data.GetNumberOfPoints()
        return vtk_to_numpy(data.GetPoints().GetData()).astype(float), arrays


class Vtk(moraine.ProgramTest):
    def compare(self, directory, axes, fields, tolerance):
        """Every step against the row of history.csv of its time; all particles have one mass."""
        series, rows = Series(directory), table(directory, "history.csv")
        self.assertEqual(series.times, [row["time_s"] for row in rows])
        for k in (*range(len(rows)), 0):
            points, arrays = series.step(k)
            self.assertEqual(set(arrays), {"id", "rank", "block_key", *fields})
            self.assertEqual(len(points), rows[k]["particles"])
            self.assertEqual(len(np.unique(arrays["id"])), len(points))
            self.assertTrue((np.diff(arrays["block_key"].astype(np.int64)) >= 0).all(), "blocks along the curve")
            for a, axis in enumerate(axes):
                self.assertAlmostEqual(points[:, a].mean(), rows[k][f"centre_{axis}_m"], delta=tolerance)
            self.assertAlmostEqual(points[:, 0].max(), rows[k]["max_x_m"], delta=tolerance)
            speed = np.linalg.norm(arrays["velocity"].astype(float), axis=1).max()
            self.assertAlmostEqual(speed, rows[k]["max_speed_m_s"], delta=tolerance)
        fresh = Series(directory).reader  # as docs/python.md asks PyVista's reader, which wraps it
        fresh.SetStep(1)
        fresh.Update()
        self.assertEqual(fresh.GetOutputDataObject(0).GetNumberOfPoints(), rows[1]["particles"])
        points = vtk_to_numpy(fresh.GetOutputDataObject(0).GetPoints().GetData())
        self.assertAlmostEqual(points[:, 0].astype(float).mean(), rows[1]["centre_x_m"], delta=tolerance)
        return arrays, len(rows)

    def test_a_slurry_runout_in_double_precision_on_3_ranks(self):
        keys = sets(time__end=0.1, output__interval=0.02)
        directory = self.run_scene(INPUTS / "slurry_runout.toml", "out", *keys, ranks=3)
        arrays, steps = self.compare(directory, "xy", ["velocity", "pressure"], 1e-6)
        self.assertEqual(steps, 6)
        self.assertEqual(set(arrays["rank"]), {0, 1, 2})
        self.assertTrue(np.isclose(arrays["pressure"].max(), 1500 * 9.81 * 5, rtol=0.05), "at the foot, at the start")

    def test_a_3d_runout_in_single_precision_with_every_field(self):
        fields = ["velocity", "stress", "pressure", "density", "ln_J", "mass", "volume", "body"]
        keys = sets(domain__cell=0.4, time__end=0.25, output__interval=0.1, numerics__precision="single",
                    output__fields=str(fields).replace("'", '"'))
        directory = self.run_scene(INPUTS / "slurry_runout_3d.toml", "out", *keys, ranks=2)
        arrays, steps = self.compare(directory, "xyz", fields, 1e-4)
        self.assertEqual(steps, 4)
        self.assertEqual(arrays["stress"].shape[1], 6)
        self.assertTrue(np.allclose(arrays["pressure"], -arrays["stress"][:, :3].mean(axis=1), rtol=1e-4, atol=1))
        self.assertTrue(np.allclose(arrays["density"] * arrays["volume"], arrays["mass"], rtol=1e-5))
        self.assertTrue(np.isclose(arrays["mass"].sum(dtype=float), summary(directory)["mass_kg"], rtol=1e-6))

    def test_a_series_that_a_restart_continues_or_a_fault_ends(self):
        scene = self.write(SMALL_SCENE)
        keys = sets(output__interval=0.02, output__fields='["velocity"]')
        directory = self.run_scene(scene, "out", *keys, *sets(output__checkpoint_interval=0.05), ranks=2)
        before = Series(directory).times
        keys += sets(output__compression="deflate")  # from there on
        self.run_scene(scene, "out", *keys, *sets(time__end=0.2), "--restart", checkpoints(directory)[0], ranks=3)
        self.compare(directory, "xy", ["velocity"], 1e-6)
        self.assertEqual(Series(directory).times[:5], before[:5])
        self.assertEqual(len(Series(directory).times), 11)
        leaving = self.write(SMALL_SCENE.replace('"no-slip"', '"none"').replace("end = 0.1", "end = 1.0"))
        directory = self.run_scene(leaving, "fault", *keys, ranks=2, code=3)
        self.compare(directory, "xy", ["velocity"], 1e-6)

    def test_outputs_that_were_under_way_when_a_run_was_killed_are_there_after_its_restart(self):
        scene, name = INPUTS / "slurry_runout.toml", self.folder / "killed"
        keys = sets(time__end=1.0, output__interval=0.01, output__asynchronous="on", output__compression="deflate",
                    output__fields='["velocity"]', output__checkpoint_interval=0.25)
        job = moraine.Job("run", scene, "--output", name, "--quiet", *keys, ranks=2)
        self.addCleanup(job.stop)
        job.wait_for(name, "checkpoint-*.h5")
        os.kill(job.ranks()[0], signal.SIGKILL)
        job.end(limit=30)
        self.assertGreaterEqual(len(Series(name).times), 25)
        self.run_scene(scene, name, *keys, "--restart", checkpoints(name)[-1], ranks=3)
        self.assertEqual(self.compare(name, "xy", ["velocity"], 1e-6)[1], 101)

    def test_cells_instead_of_particles_are_the_same_on_any_ranks_and_after_a_restart(self):
        scene, files = INPUTS / "slurry_runout.toml", []
        keys = sets(time__end=0.2, output__interval=0.05, output__fields_on="cells", output__fields='["velocity", "mass"]',
                    output__labels="[]", output__checkpoint_interval=0.1, balance__trigger="every", balance__interval=10)
        for ranks in (1, 2, 3, 4):
            directory = self.run_scene(scene, f"on-{ranks}", *keys, ranks=ranks)
            self.assertFalse((directory / "particles.vtkhdf").exists())
            files.append((directory / "cells.vtkhdf").read_bytes())
        self.assertEqual(len(set(files)), 1)
        before = self.cells_of(directory)
        self.run_scene(scene, "on-4", *keys, "--restart", checkpoints(directory)[0], ranks=2)
        after, rows = self.cells_of(directory), table(directory, "history.csv")
        self.assertEqual([time for time, *_ in after], [row["time_s"] for row in rows])
        for (_, points, arrays), (_, points_before, arrays_before), row in zip(after, before, rows):
            self.assertTrue((points == points_before).all())
            for name, values in arrays.items():
                self.assertTrue((values == arrays_before[name]).all(), name)
            self.assertAlmostEqual(arrays["mass"].sum() / row["mass_kg"], 1, places=12)
            for a, axis in enumerate("xy"):
                momentum = (arrays["mass"] * arrays["velocity"][:, a]).sum()
                self.assertAlmostEqual(momentum, row[f"momentum_{axis}_kg_m_s"], delta=1e-9 * 75000 * 7)

    def cells_of(self, directory):
        series = Series(directory, "cells.vtkhdf")
        return [(time, *series.step(k)) for k, time in enumerate(series.times)]


class Surroundings(ValleyTest):
    STRUCTURES = """
[[structure]]
name = "house"
shape = "box"
min = [16.0, 3.0, 0.0]
max = [18.0, 6.0, 4.0]
contact = { law = "smooth" }
[[structure]]
name = "pillar"
shape = "cylinder"
from = [14.0, 9.0, 0.0]
to = [14.0, 9.0, 5.0]
radius = 0.5
contact = { law = "smooth" }
[[structure]]
name = "ball"
shape = "sphere"
center = [20.0, 9.0, 3.0]
radius = 1.0
contact = { law = "smooth" }
[[structure]]
name = "back"
shape = "plane"
point = [0.5, 0.0, 0.0]
normal = [1.0, 0.0, 0.0]
contact = { law = "smooth" }
[[structure]]
name = "gate"
shape = "box"
min = [22.0, 0.0, 0.0]
max = [22.5, 12.0, 8.0]
contact = { law = "smooth" }
motion = { kind = "velocity", velocity = [0.0, 0.0, 1.0] }
"""

    def test_terrain_and_what_stands_still_are_surfaces_of_their_size_beside_the_series(self):
        self.write(SCENE + self.STRUCTURES)
        directory = self.run_scene(self.scene, "run", *sets(time__end=0))
        reader = vtk.vtkHDFReader()
        reader.SetFileName(str(directory / "surroundings.vtkhdf"))
        reader.Update()
        data = vtk.vtkPolyData.SafeDownCast(reader.GetOutputAsDataSet())
        points = vtk_to_numpy(data.GetPoints().GetData())
        structure = vtk_to_numpy(data.GetCellData().GetArray("structure"))
        self.assertEqual(sorted(set(structure)), [0, 1, 2, 3, 4])
        area, seen = [0.0] * 5, [[] for _ in range(5)]
        for k in range(data.GetNumberOfCells()):
            numbers = data.GetCell(k).GetPointIds()
            x = points[[numbers.GetId(i) for i in range(numbers.GetNumberOfIds())]]
            fan = np.cross(x[1:-1] - x[0], x[2:] - x[0]).sum(axis=0)
            area[structure[k]] += np.linalg.norm(fan) / 2
            seen[structure[k]].extend(x)
        ground = np.array(seen[0])
        self.assertEqual(sum(structure == 0), 12 * 6)
        for x, y, z in ground[::7]:
            self.assertAlmostEqual(z, heights(x, y), delta=1e-4)
        self.assertAlmostEqual(area[1], 2 * (2 * 3 + 2 * 4 + 3 * 4), places=9)
        self.assertAlmostEqual(area[2] / (np.pi * (5 + 0.5)), 1, delta=0.01)
        self.assertAlmostEqual(area[3] / (4 * np.pi), 1, delta=0.01)
        self.assertAlmostEqual(area[4], 12 * 16, places=9)
        self.assertEqual([np.min(np.array(seen[3])[:, a]).round(3) for a in range(3)], [19, 8, 2])

    def assert_moved_with(self, directory, name, number, displacement, length):
        """Each time of the particles, in turn and back: the surface is that of the start, moved by what is told."""
        reader = vtk.vtkHDFReader()
        reader.SetFileName(str(directory / "structures.vtkhdf"))
        reader.UpdateInformation()
        times = list(reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS()))
        self.assertEqual(times, Series(directory).times)
        start = None
        for time in (*times, times[1], times[0]):
            reader.UpdateTimeStep(time)
            data = vtk.vtkPolyData.SafeDownCast(reader.GetOutputAsDataSet())
            of_cell = vtk_to_numpy(data.GetCellData().GetArray("structure"))
            self.assertEqual(set(of_cell), {number})
            points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
            start = points.copy() if start is None else start
            for a in range(3):
                moved = displacement(time)[a] - displacement(times[0])[a]
                self.assertLess(abs(points - start - moved)[:, a].max(), 1e-5 * length, f"{name} at {time}")
        return start, times

    def test_structures_that_move_are_where_they_are_at_each_output_also_after_a_restart(self):
        self.write(SCENE + self.STRUCTURES)
        keys = sets(time__end=0.4, output__interval=0.1)
        directory = self.run_scene(self.scene, "run", *keys, *sets(output__checkpoint_interval=0.2), ranks=2)
        start, times = self.assert_moved_with(directory, "gate", 5, lambda t: np.array([0, 0, t]), 8)
        self.assertEqual(len(times), 5)
        self.assertEqual([list(start.min(axis=0)), list(start.max(axis=0))], [[22, 0, 0], [22.5, 12, 8]])
        keys += sets(time__end=0.6)
        self.run_scene(self.scene, "run", *keys, "--restart", checkpoints(directory)[0], ranks=3)
        self.assertEqual(len(self.assert_moved_with(directory, "gate", 5, lambda t: np.array([0, 0, t]), 8)[1]), 7)
        directory = self.run_scene(self.scene, "new", *keys, "--restart", checkpoints(directory)[0])
        start, times = self.assert_moved_with(directory, "gate", 5, lambda t: np.array([0, 0, t]), 8)
        self.assertAlmostEqual(start[:, 2].min(), times[0], delta=1e-6)
        self.assertTrue(Series(directory).times[0] > 0.2)

    def test_lines_in_2d(self):
        keys = sets(time__end=0.5, domain__cell=0.1, output__structure_interval=0)
        directory = self.run_scene(INPUTS / "pipe_penetration.toml", "run", *keys)
        self.assertFalse((directory / "surroundings.vtkhdf").exists(), "its pipe moves")
        rows = {row["time_s"]: row["displacement_y_m"] for row in table(directory, "structures.csv")}
        self.assert_moved_with(directory, "pipe", 0, lambda t: np.array([0, rows[t], 0]), 1)
        directory = self.run_scene(INPUTS / "sliding_block.toml", "block", *sets(time__end=0))
        reader = vtk.vtkHDFReader()
        reader.SetFileName(str(directory / "surroundings.vtkhdf"))
        reader.Update()
        self.assertEqual(vtk.vtkPolyData.SafeDownCast(reader.GetOutputAsDataSet()).GetNumberOfLines(), 1)


if __name__ == "__main__":
    moraine.main()
