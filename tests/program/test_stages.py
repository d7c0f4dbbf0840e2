"""[[stage]]: one run in parts: the same on any ranks and after a restart in any stage; strengths that fall; what is refused."""
import moraine
from moraine import call, checkpoints, sets, summary, table

# A cut of clay 1 m high, 8 cells: a vertical cut stands while density g H / su < 3.77.
CUT = """\
dimensions = 2
gravity = [0.0, -10.0]
[domain]
min = [0.0, 0.0]
max = [4.0, 1.5]
cell = 0.125
[time]
end = 2.0
[[material]]
name = "clay"
law = "tresca"
density = 1000.0
young = 1.0e6
poisson = 0.45
su = 1.0e4
[[body]]
name = "ground"
material = "clay"
shape = "box"
min = [0.0, 0.0]
max = [2.0, 1.0]
[[body]]
name = "cut"
material = "clay"
shape = "box"
min = [2.0, 0.0]
max = [3.0, 1.0]
[[body]]
name = "fill"
material = "clay"
shape = "box"
min = [2.25, 0.0]
max = [2.75, 0.5]
[[wall]]
face = "x-min"
kind = "free-slip"
[[wall]]
face = "y-min"
kind = "no-slip"
[[wall]]
face = "x-max"
kind = "free-slip"
[[stage]]
name = "settle"
until = 0.2
[[stage]]
name = "dig"
until = 0.4
remove = ["cut"]
[[stage]]
name = "fill"
until = 0.6
add = ["fill"]
set = { "wall.x-max.kind" = "open" }
[[stage]]
name = "weak"
set = { "material.clay.su" = 5.0e2 }
"""
PLAIN = CUT[:CUT.index("[[stage]]")].replace(CUT[CUT.index('[[body]]\nname = "fill"'):CUT.index("[[wall]]")], "")
SETTLED = '[[stage]]\nname = "settle"\nuntil = "rest"\ndamping = 0.7\n'


class Stages(moraine.ProgramTest):
    def test_a_run_in_stages_is_one_on_any_ranks_and_after_a_restart_in_any_stage(self):
        scene = self.write(CUT)
        more = sets(time__end=0.8, output__interval=0.1, output__checkpoint_interval=0.1)
        alone = self.run_scene(scene, "alone", *more)
        found, rows = summary(alone), table(alone, "history.csv")
        self.assertEqual([s["name"] for s in found["stages"]], ["settle", "dig", "fill", "weak"])
        self.assertEqual([s["removed_mass_kg"] for s in found["stages"]], [0, 1000, 0, 0])
        self.assertEqual([round(s["added_mass_kg"], 6) for s in found["stages"]], [0, 0, 250, 0])
        for begin, until in zip(found["stages"][1:], (0.2, 0.4, 0.6)):
            self.assertAlmostEqual(begin["begin_s"], until, delta=0.01)
        self.assertEqual(sorted({row["stage"] for row in rows}), [1, 2, 3, 4])
        self.assertEqual({round(row["mass_kg"]) for row in rows}, {3000, 2000, 2250})
        for row in rows:
            self.assertLess(abs(row["momentum_error_y_kg_m_s"]), 1e-6)
        self.assertGreater(rows[-1]["kinetic_J"], 3 * rows[-3]["kinetic_J"], "the weak cut runs")
        kept = checkpoints(alone)
        self.assertGreaterEqual(len(kept), 7)
        every = sets(balance__trigger="every", balance__interval=7)
        for ranks, words in ((2, ("--partitioner", "shuffle", *every)), (3, ()), (4, every), *((1 + k % 4, ("--restart", path)) for k, path in enumerate(kept))):
            with self.subTest(ranks=ranks, words=words):
                again = self.run_scene(scene, f"{ranks}-{len(words)}-{str(words)[-12:-6]}", *more, *words, ranks=ranks)
                self.assertEqual(summary(again)["state_hash"], found["state_hash"])
                self.assertEqual(summary(again)["stages"], found["stages"])
                self.assertEqual(table(again, "history.csv")[-1], rows[-1])

    def test_a_table_of_particles_that_comes_with_a_stage_is_the_one_of_the_start_in_restarts(self):
        rows = "x,y\n" + "".join(f"{2.3125 + 0.0625 * i},{0.03125 + 0.0625 * j}\n" for i in range(6) for j in range(6))
        scene = self.write(CUT.replace('shape = "box"\nmin = [2.25, 0.0]\nmax = [2.75, 0.5]', 'shape = "table"\nfile = "fill.csv"'))
        self.write(rows, "fill.csv")
        more = sets(time__end=0.5, output__checkpoint_interval=0.1)
        whole = self.run_scene(scene, "whole", *more)
        first = checkpoints(whole)[0]
        self.assertEqual(summary(self.run_scene(scene, "same", *more, "--restart", first))["state_hash"], summary(whole)["state_hash"])
        self.write(rows.replace("2.3125", "2.3"), "fill.csv")
        line = self.assert_one_problem(call("run", scene, *more, "--restart", first, "--output", self.folder / "other"))
        self.assertIn("body.fill.file.bytes is ", line)
        self.assertFalse((self.folder / "other").exists())

    def test_stages_that_change_nothing_change_no_bit(self):
        plain = self.run_scene(self.write(PLAIN, "plain.toml"), "plain", *sets(time__end=0.3))
        parts = PLAIN + '[[stage]]\nname = "one"\nuntil = 0.1\n[[stage]]\nname = "two"\n'
        self.assertEqual(summary(plain)["state_hash"], summary(self.run_scene(self.write(parts), "parts", *sets(time__end=0.3)))["state_hash"])

    def test_a_run_may_end_before_its_stages(self):
        found = summary(self.run_scene(self.write(CUT), "short", *sets(time__end=0.3)))
        self.assertEqual([s["name"] for s in found["stages"]], ["settle", "dig"])
        self.assertEqual(found["ended_by"], "end")

    def test_a_strength_that_falls_leaves_a_cut_at_rest_or_lets_it_run(self):
        ended = {}
        for su in (3200.0, 1500.0):  # 1.2 and 0.57 of what stands
            cut = PLAIN + SETTLED + '[[stage]]\nname = "dig"\nuntil = "rest"\ndamping = 0.7\nremove = ["cut"]\n'
            cut += f'[[stage]]\nname = "weak"\nuntil = "rest"\nset = {{ material.clay.su = {su} }}\n'
            found = self.run_scene(self.write(cut, f"{su}.toml"), str(su), *sets(time__end=10.0))
            stages = summary(found)["stages"]
            self.assertEqual([s["name"] for s in stages], ["settle", "dig", "weak"])
            fronts = [row["max_x_m"] for row in table(found, "history.csv") if row["time_s"] >= stages[2]["begin_s"]]
            ended[su] = summary(found)["ended_by"], fronts[-1] - fronts[0]
        self.assertEqual(ended[3200.0][0], "rest")
        self.assertLess(ended[3200.0][1], 0.05)
        self.assertGreater(ended[1500.0][1], 0.25)

    def test_a_damped_stage_that_ends_at_rest_lets_the_next_one_begin(self):
        found = summary(self.run_scene(self.write(PLAIN + SETTLED + '[[stage]]\nname = "on"\n'), "settled", *sets(time__end=5.0)))
        self.assertEqual(found["ended_by"], "end")
        self.assertLess(found["stages"][1]["begin_s"], 4)
        last = self.run_scene(self.write(PLAIN + SETTLED), "last", *sets(time__end=5.0))
        self.assertEqual(summary(last)["ended_by"], "rest")

    def test_check_tells_the_stages_and_wrong_ones_are_refused_with_a_place_and_a_remedy(self):
        report = call("check", self.write(CUT)).out
        self.assertIn("stage      1 settle: until 0.2 s\n", report)
        self.assertIn("stage      3 fill: until 0.6 s; wall.x-max.kind='open', fill comes", report)

        def said(old, new, *words):
            self.assertIn(old, CUT)
            return self.assert_one_problem(call("check", self.write(CUT.replace(old, new)), *words))

        self.assertIn("the stage before ends at 0.2 s", said("until = 0.4", "until = 0.1"))
        self.assertIn("stage.dig.until is missing", said("until = 0.4\n", ""))
        self.assertIn("the last stage ends at time.end", said('name = "weak"\n', 'name = "weak"\nuntil = 1.0\n'))
        self.assertIn('must be a time [s] or "rest"', said("until = 0.4", 'until = "calm"'))
        self.assertRegex(said('["cut"]', '["cutt"]'), 'there is no such body.*Did you mean "?cut')
        self.assertIn("it is gone already", said('add = ["fill"]', 'remove = ["cut"]'))
        self.assertIn("it is not there before", said('remove = ["cut"]', 'remove = ["fill"]'))
        self.assertIn("it comes twice", said('add = ["fill"]', 'add = ["fill", "fill"]'))
        self.assertIn("is there from the start", said("until = 0.2", 'until = 0.2\nadd = ["fill"]'))
        self.assertIn("overlaps", said('remove = ["cut"]\n', ""))
        self.assertIn("stages change strengths", said("material.clay.su", "material.clay.young"))
        self.assertIn("stages change strengths", said("material.clay.su", "domain.cell"))
        self.assertIn("material", said("material.clay.su", "material.cla.su"))
        self.assertRegex(said("5.0e2 }", "-5.0e2 }"), r"stage\.weak\.set material\.clay\.su=.*su")
        self.assertIn("is not used", said("material.clay.su", "material.clay.cohesion"))
        self.assertIn("each particle keeps the su over depth", said("su = 1.0e4", "su = { surface = 1.0e4, gradient = 1.0e3 }"))
        self.assertIn("is damped until a time", said("until = 0.2", "until = 0.2\ndamping = 0.5"))
        self.assertIn("with stages", said("end = 2.0", 'end = 2.0\nstop = "rest"'))
        self.assertIn("stages with numerics.sleep", said("", "", *sets(numerics__sleep="on")))
        self.assertIn("is there twice", said('name = "dig"', 'name = "settle"'))


if __name__ == "__main__":
    moraine.main()
