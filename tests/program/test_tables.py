"""[[table]]: gravity and motions over time, the same on any ranks and after a restart within a ramp; what is refused."""
import moraine
from moraine import SMALL_SCENE, call, checkpoints, sets, summary, table

RAMP = 'gravity_table = "ramp"\n' + SMALL_SCENE + '[[table]]\nname = "ramp"\ntimes = [0.0, 0.06]\nvalues = [0.2, 1.5]\n'
PIPE = '[[structure]]\nname = "pipe"\nshape = "sphere"\ncenter = [3.0, 0.6]\nradius = 0.2\n'


class Tables(moraine.ProgramTest):
    def test_a_ramp_of_gravity_is_the_same_on_any_ranks_and_after_a_restart_within_it(self):
        scene = self.write(RAMP + PIPE + 'motion = { kind = "free", mass = 200.0 }\n')
        more = sets(output__interval=0.01, output__checkpoint_interval=0.02, output__energy_budget="on")
        alone = self.run_scene(scene, "alone", *more)
        rows = table(alone, "history.csv")
        self.assertIn("gravity_work_J", rows[0])
        self.assertEqual(rows[0]["gravity_work_J"], 0)
        self.assertGreater(rows[-1]["gravity_work_J"], 0)
        self.assertAlmostEqual(rows[-1]["gravity_impulse_y_kg_m_s"], -9.81 * 1000 * (0.85 * 0.06 + 1.5 * (rows[-1]["time_s"] - 0.06)), delta=1e-7)
        self.assertNotEqual(summary(alone)["state_hash"], summary(self.run_scene(self.write(SMALL_SCENE, "constant.toml"), "constant"))["state_hash"])
        first = checkpoints(alone)[0]
        for ranks, words in ((2, ("--partitioner", "shuffle")), (3, ()), (4, ()), (1, ("--restart", first)), (3, ("--restart", first))):
            with self.subTest(ranks=ranks, words=words):
                found = self.run_scene(scene, f"{ranks}-{len(words)}", *more, *words, ranks=ranks)
                self.assertEqual(summary(found)["state_hash"], summary(alone)["state_hash"])
                self.assertEqual(table(found, "history.csv")[-1], rows[-1])

    def test_a_table_of_ones_is_the_same_as_none(self):
        ones = self.write(RAMP.replace("[0.2, 1.5]", "[1.0, 1.0]"))
        self.assertEqual(summary(self.run_scene(ones, "ones"))["state_hash"], summary(self.run_scene(self.write(SMALL_SCENE, "none.toml"), "none"))["state_hash"])

    def test_a_motion_by_a_table_a_file_or_its_own_rows_is_one(self):
        (self.folder / "push.csv").write_text("# a push\ntime,value\n0.0,0.0\n0.05,1.0\n")
        rows = "times = [0.0, 0.05], factors = [0.0, 1.0]"
        tables = '[[table]]\nname = "push"\ntimes = [0.0, 0.05]\nvalues = [0.0, 1.0]\n[[table]]\nname = "file"\nfile = "push.csv"\n'
        hashes = set()
        for number, said in enumerate((rows, 'table = "push"', 'table = "file"')):
            motion = f'motion = {{ kind = "table", velocity = [-3.0, 0.0], {said} }}\n'
            scene = self.write(SMALL_SCENE + tables + PIPE.replace("0.6]", "1.0]").replace("[3.0", "[2.3") + motion, f"{number}.toml")
            hashes.add(summary(self.run_scene(scene, str(number)))["state_hash"])
        self.assertEqual(len(hashes), 1)

    def test_a_geostatic_start_is_by_the_gravity_of_the_start(self):
        start = 'geostatic = { surface = 1.5 }\n[[wall]]\nface = "y-min"'
        half = self.write(RAMP.replace('[[wall]]\nface = "y-min"', start).replace("[0.2, 1.5]", "[0.5, 0.5]"))
        light = self.write(SMALL_SCENE.replace('[[wall]]\nface = "y-min"', start).replace("-9.81", "-4.905"), "light.toml")
        self.assertEqual(summary(self.run_scene(half, "half"))["state_hash"], summary(self.run_scene(light, "light"))["state_hash"])

    def test_rest_is_not_looked_for_before_gravity_stays(self):
        scene = self.write(RAMP.replace("[0.0, 0.06]", "[3.0, 3.1]").replace("[0.2, 1.5]", "[0.0, 0.0]").replace('[time]', '[time]\nstop = "rest"'))
        directory = self.run_scene(scene, "late", *sets(time__end=20.0, numerics__damping=0.5))
        self.assertEqual(summary(directory)["ended_by"], "rest")
        self.assertGreater(summary(directory)["simulated_time_s"], 3.1)

    def test_check_says_the_table_and_wrong_ones_are_refused_with_a_place_and_a_remedy(self):
        self.assertIn("gravity    by a table: 0.2 of it until 0 s, 1.5 from 0.06 s on, at most 1.5", call("check", self.write(RAMP)).out)

        def said(old, new, text=RAMP, *words):
            return self.assert_one_problem(call("check", self.write(text.replace(old, new)), *words))

        self.assertRegex(said('gravity_table = "ramp"', 'gravity_table = "rampe"'), 'scene.toml:1: .*there is no such table.*Did you mean "?ramp')
        self.assertIn("table.ramp has 2 times and 1 values", said("[0.2, 1.5]", "[0.2]"))
        self.assertIn("table.ramp.times has 0 s as number 2", said("[0.0, 0.06]", "[0.0, 0.0]"))
        self.assertIn("table.ramp has 0 times and 0 values", said("times = [0.0, 0.06]\nvalues = [0.2, 1.5]\n", ""))
        self.assertIn("table.ramp.times has -1 s", said("[0.0, 0.06]", "[-1.0, 0.06]"))
        self.assertIn("gravity_table without gravity", said("gravity = [0.0, -9.81]\n", ""))
        self.assertIn("gravity_table with numerics.sleep", said("", "", RAMP, *sets(numerics__sleep="on")))
        file = 'file = "ramp.csv"\n'
        self.assertIn("table.ramp.times beside table.ramp.file", said("times =", file + "times ="))
        self.assertIn("ramp.csv", said("times = [0.0, 0.06]\nvalues = [0.2, 1.5]\n", file))
        for text, problem in (("time,value\n0,1\n1,2\n1,3\n", "ramp.csv:4: time = 1"), ("time,value\n0,one\n", "ramp.csv:2"), ("time,value\n", "no rows"),
                              ("t,v\n0,1\n", "ramp.csv:1: the header")):
            (self.folder / "ramp.csv").write_text(text)
            self.assertIn(problem, said("times = [0.0, 0.06]\nvalues = [0.2, 1.5]\n", file))
        motion = 'motion = { kind = "table", velocity = [-3.0, 0.0], table = "ramp", times = [0.0], factors = [1.0] }\n'
        self.assertIn("motion.times beside structure.pipe.motion.table", said("", "", RAMP + PIPE + motion))


if __name__ == "__main__":
    moraine.main()
