"""What the package reads is what the run wrote: particles against history.csv, records, and what is missing."""
import json
import shutil

import moraine
import numpy
from runs_for_tests import PackageTest, folder, jelly, program, slurry, slurry_3d


class Results(PackageTest):
    def agree(self, run, fields):
        """Sums over the particles of every output are its row of history.csv."""
        history = run.history
        self.assertEqual(run.particles.times.tolist(), history["time_s"].tolist())
        self.assertEqual(len(run.particles), len(history["step"]))
        axes = "xyz"[: run.dimensions]
        for k, particles in enumerate(run.particles):
            self.assertEqual(len(particles), history["particles"][k])
            self.assertEqual(particles.position.shape, (len(particles), run.dimensions))
            self.assertEqual(set(particles.fields), {"id", "rank", "block_key", *fields})
            self.assertEqual(len(numpy.unique(particles["id"])), len(particles))
            if len(particles) == 0:
                continue
            mass = particles["mass"]
            total = mass.sum()
            numpy.testing.assert_allclose(total, history["mass_kg"][k], rtol=1e-12)
            momentum = (mass[:, None] * particles["velocity"]).sum(axis=0)
            centre = (mass[:, None] * particles.position).sum(axis=0) / total
            size = 1e-9 * total * (1 + particles.speed().max())
            for a, axis in enumerate(axes):
                numpy.testing.assert_allclose(momentum[a], history[f"momentum_{axis}_kg_m_s"][k], atol=size)
                numpy.testing.assert_allclose(centre[a], history[f"centre_{axis}_m"][k], rtol=1e-9)
            numpy.testing.assert_allclose(particles.speed().max(), history["max_speed_m_s"][k], rtol=1e-12)
            numpy.testing.assert_allclose(particles.position[:, 0].max(), history["max_x_m"][k], rtol=1e-12)

    def test_particles_agree_with_the_history_while_their_number_falls(self):
        run = jelly()
        self.agree(run, {"velocity", "stress", "mass"})
        self.assertEqual(run.particles[0]["stress"].shape, (64, 4))
        self.assertEqual(run.particles[0]["velocity"].shape, (64, 2))
        self.assertLess(run.history["particles"][-1], 64)

    def test_particles_agree_with_the_history_over_several_chunks_and_ranks(self):
        run = slurry()
        self.assertGreater(len(run.particles[0]), 3 * 1024)
        self.assertEqual(sorted(set(run.particles[-1]["rank"].tolist())), [0, 1])
        self.agree(run, {"velocity", "pressure", "mass"})

    def test_particles_agree_with_the_history_in_3d(self):
        self.assertEqual(slurry_3d().dimensions, 3)
        self.agree(slurry_3d(), {"velocity", "pressure", "mass"})

    def test_an_output_is_found_by_time_and_from_the_end_with_the_fields_that_are_wanted(self):
        series = slurry().particles
        self.assertEqual(series[-1].time, series.times[-1])
        found = series.at(0.21, ["pressure"])
        self.assertEqual((found.time, list(found.fields), found.units), (series.times[2], ["pressure"], {"pressure": "Pa"}))
        with self.assertRaises(IndexError):
            series[len(series)]
        self.assertIn("'stress' (", self.problem(series.read, 0, ["stress"]))
        self.assertIn("'stress' (", self.problem(series[0].__getitem__, "stress"))

    def test_records_are_those_of_the_files(self):
        run = jelly()
        self.assertEqual(run.summary, json.loads((run.path / "summary.json").read_text()))
        for name, found in (("history.csv", run.history), ("balance.csv", run.balance)):
            rows = program.table(run.path, name)
            for column in found:
                self.assertEqual(found[column].shape, (len(rows),))
                for mine, row in zip(found[column].tolist(), rows):
                    self.assertTrue(mine == row[column] or mine != mine, (column, mine, row[column]))
        rows = program.table(run.path, "structures.csv")
        self.assertEqual(list(run.structures), ["rod", "shelf"])
        for name in run.structures:
            mine = [row["displacement_y_m"] for row in rows if row["structure"] == name]
            self.assertEqual(run.structures[name]["displacement_y_m"].tolist(), mine)
        self.assertEqual(slurry().structures, {})
        self.assertEqual([path.name[:11] for path in run.checkpoints], ["checkpoint-"] * 2)

    def test_depth_of_a_reservoir_is_its_height_and_falls_where_it_flows(self):
        first, last = slurry().particles[0], slurry().particles[-1]
        self.assertAlmostEqual(moraine.spacing(first.position), 0.125)
        x, depth = moraine.depth_profile(first.position)
        numpy.testing.assert_allclose(depth, 5.0)
        numpy.testing.assert_allclose((x[0], x[-1]), (0.25, 9.75))
        self.assertGreater(moraine.depth_profile(last.position)[0][-1], 10)

    def test_what_is_no_run_is_said(self):
        self.assertIn("no such directory", self.problem(moraine.Run, folder("nowhere")))
        self.assertIn("no history.csv", self.problem(moraine.Run, folder(".")))
        copy = folder("broken")
        shutil.copytree(jelly().path, copy)
        for name in ("summary.json", "particles.vtkhdf", "balance.csv"):
            (copy / name).unlink()
        run = moraine.Run(copy)
        self.assertIn("Has the run ended?", self.problem(lambda: run.summary))
        self.assertIn("--no-particles", self.problem(lambda: run.particles))
        self.assertIn("balance.csv", self.problem(lambda: run.balance))
        (copy / "particles.vtkhdf").write_text("not HDF5")
        self.assertIn("is no series of particles", self.problem(lambda: run.particles))
        (copy / "summary.json").write_text('{"steps": ')
        self.assertIn("stopped while it wrote", self.problem(lambda: run.summary))
        (copy / "history.csv").write_bytes(b"time_s,front_m\n0,\xff\n")
        self.assertIn("history.csv is damaged", self.problem(lambda: moraine.Run(copy).history))
        self.assertIn("broken", repr(run))

    def test_particles_go_to_pyvista_or_its_absence_is_said(self):
        particles = jelly().particles[0]
        try:
            import pyvista  # noqa: F401
        except ImportError:
            self.assertIn("pip install pyvista", self.problem(moraine.to_pyvista, particles))
            return
        cloud = moraine.to_pyvista(particles)
        self.assertEqual((cloud.n_points, cloud.point_data["velocity"].shape), (64, (64, 3)))
        numpy.testing.assert_array_equal(cloud.points[:, :2], particles.position.astype(cloud.points.dtype))
