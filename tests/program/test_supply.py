"""Releases with a start and inflows as a user meets them: their volume, one answer on any number of ranks and after a
restart, and words for tables that are wrong."""

import moraine
from moraine import call, checkpoints, sets, summary, table
from valley import SCENE, ValleyTest, read_map, total

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
