"""Releases with a start and inflows as a user meets them: their volume, one answer on any number of ranks and after a
restart, words for tables that are wrong, and what is as thin as a cell or thinner on a slope of 45 degrees."""
import math

import moraine
from moraine import call, checkpoints, sets, summary, table
from valley import SCENE, ValleyTest, grid, read_map, total

TABLE = "time,discharge,speed\n0.1,0,2\n0.3,8,4\n0.9,4,3\n"
INFLOW = """\
[[inflow]]
name = "torrent"
material = "debris"
line = [[1.0, 7.5], [1.0, 4.5]]
table = "torrent.csv"
"""
LATE = SCENE.replace("thickness = 1.0", "thickness = 1.0\nstart = 0.35")


class Supply(ValleyTest):
    def setUp(self):
        super().setUp()
        self.write(TABLE, "torrent.csv")

    def test_an_inflow_brings_the_volume_of_its_table_within_a_thousandth(self):
        self.write(SCENE[:SCENE.index("[[release]]")] + INFLOW)
        directory = self.run_scene(self.scene, "run")
        volume = summary(directory)["mass_kg"] / 1800
        self.assertAlmostEqual(volume / (0.8 + 3.6), 1, delta=1e-3)
        # the map has the volume of now: the soil is pressed together by its weight
        self.assertAlmostEqual(total(read_map(directory, "deposit")) / volume, 1, delta=5e-3)
        last = table(directory, "history.csv")[-1]
        self.assertLess(abs(last["momentum_error_x_kg_m_s"]), 1e-6 * volume * 1800)

    def test_state_and_maps_are_the_same_on_1_to_4_ranks_and_after_a_restart(self):
        self.write(LATE + INFLOW)
        one = self.run_scene(self.scene, "one", *sets(output__checkpoint_interval=0.3))
        for ranks in (2, 3, 4):
            many = self.run_scene(self.scene, f"r{ranks}", "--partitioner", "shuffle",
                                  *sets(balance__trigger="every", balance__interval=20), ranks=ranks)
            self.assertEqual(summary(many)["state_hash"], summary(one)["state_hash"])
            self.assertEqual(self.maps(many), self.maps(one))
        for number, checkpoint in enumerate(checkpoints(one)[:3]):
            again = self.run_scene(self.scene, f"again{number}", "--restart", checkpoint, ranks=2)
            self.assertEqual(summary(again)["state_hash"], summary(one)["state_hash"])
            self.assertEqual(self.maps(again), self.maps(one))

    def test_a_release_with_a_start_is_not_there_before(self):
        self.write(LATE)
        self.assertEqual(summary(self.run_scene(self.scene, "early", *sets(time__end=0.3)))["particles"], 0)
        ended = call("check", self.scene, "--device", "cpu")
        self.assertRegex(ended.out, r"release    scar: \S+ m3 at 0.35 s, 2 cells thick")
        late = self.run_scene(self.scene, "late", *sets(time__end=0.4))
        self.assertGreater(summary(late)["particles"], 0)

    STEEP = SCENE.replace('law = "voellmy", friction = 0.2, xi = 500.0', 'law = "coulomb", friction = 0.2').replace(
        "16.0]", "28.0]")

    def slide(self, area, thickness, end, **body):
        """Path over that of a point mass on 45 degrees, and the least height over the ground of all outputs, both of
        the centre of what is released there."""
        self.write(grid(at=lambda x, y: 25 - x), "valley.asc")
        self.write("x,y\n" + area, "area.csv")
        keys = "".join(f"\n{key} = {value}" for key, value in body.items())
        self.write(self.STEEP.replace("thickness = 1.0", f"thickness = {thickness}{keys}"))
        directory = self.run_scene(self.scene, "steep", "--overwrite", *sets(time__end=end, output__interval=0.05))
        rows, root = table(directory, "history.csv"), math.sqrt(0.5)
        self.assertEqual(rows[-1]["lost_particles"], 0)
        path = root * sum(sign * (rows[-1][f"centre_{axis}_m"] - rows[0][f"centre_{axis}_m"])
                          for axis, sign in (("x", 1), ("z", -1)))
        exact = 0.5 * 9.81 * root * (1 - 0.2) * rows[-1]["time_s"] ** 2
        return path / exact, min((row["centre_z_m"] - 25 + row["centre_x_m"]) * root for row in rows)

    def test_a_particle_alone_slides_on_45_degrees_as_a_point_mass_and_stays_on_the_ground(self):
        path, above = self.slide("3,3\n3.5,3\n3.5,3.5\n3,3.5\n", 0.5, 2.0, particles_per_cell=1)
        self.assertAlmostEqual(path, 1, delta=0.02)
        self.assertGreater(above, -0.1 * 0.5)

    def test_films_of_a_cell_and_of_one_and_a_half_slide_on_45_degrees_as_a_point_mass(self):
        for thickness in (0.5, 0.75):
            path, above = self.slide("2,3\n6,3\n6,9\n2,9\n", thickness, 1.0)
            self.assertAlmostEqual(path, 1, delta=0.03)
            self.assertGreater(above, 0.05 * 0.5)

    def test_a_release_may_meet_the_edge_of_the_crop_also_where_the_ground_falls_away_from_it(self):
        self.write("x,y\n2,2\n20,2\n20,10\n2,10\n", "crop.csv")
        self.write("x,y\n2,3\n6,3\n6,9\n2,9\n", "area.csv")
        domain = SCENE[SCENE.index("min = "):SCENE.index("cell = 0.5")]
        self.write(SCENE.replace(domain, "").replace("[hazard]", 'crop = "crop.csv"\n[hazard]'))
        volume = 4 * 6 * math.sqrt(2)
        for height in (lambda x, y: 25 - x, lambda x, y: 1 + x):
            self.write(grid(at=height), "valley.asc")
            directory = self.run_scene(self.scene, "meets", "--overwrite", *sets(time__end=0))
            self.assertAlmostEqual(summary(directory)["mass_kg"] / 1800 / volume, 1, delta=1e-6)
            self.assertAlmostEqual(total(read_map(directory, "deposit")) / volume, 1, delta=1e-6)

    def test_an_inflow_that_is_wrong_is_refused_with_file_and_reason(self):
        scene = SCENE + INFLOW

        def with_table(text):
            self.write(text, "torrent.csv")
            return self.refused(scene)

        self.assertIn("torrent.csv: 1 rows (an inflow begins and ends)", with_table("time,discharge,speed\n0,1,1\n"))
        self.assertIn("times rise from 0 s on", with_table("time,discharge,speed\n1,1,1\n1,1,1\n"))
        self.assertIn("discharge = -1 in row 2", with_table("time,discharge,speed\n0,1,1\n1,-1,1\n"))
        self.assertIn("speed = 0 in row 1 (must be > 0", with_table("time,discharge,speed\n0,1,0\n1,1,1\n"))
        self.assertIn("must be time,discharge,speed", with_table("t,q,v\n0,1,1\n1,1,1\n"))
        self.assertIn("discharge is 0 in all rows", with_table("time,discharge,speed\n0,0,1\n1,0,1\n"))
        self.assertIn("the first time is 5 s (the run ends at 1.2 s)", with_table("time,discharge,speed\n5,1,1\n6,1,1\n"))
        self.write(TABLE, "torrent.csv")
        self.assertIn("has 1 points", self.refused(scene.replace("[1.0, 4.5]", "[1.0, 7.5]")))
        self.assertIn("has a point at (1, 99)", self.refused(scene.replace("[1.0, 4.5]", "[1.0, 99]")))
        self.assertIn("no such file", self.refused(scene.replace("torrent.csv", "none.csv")))


if __name__ == "__main__":
    moraine.main()
