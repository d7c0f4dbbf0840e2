"""time.stop = "rest": a run ends once it has come to rest, at the same step on any ranks and after a restart."""
import moraine
from moraine import call, checkpoints, sets, summary

# A heap of stiff mud slumps within half a second: 400 particles, some 5000 steps to rest.
HEAP = """\
dimensions = 2
gravity = [0.0, -9.81]
[domain]
min = [0.0, 0.0]
max = [2.0, 1.0]
cell = 0.05
[time]
end = 20.0
stop = "rest"
[output]
interval = 0.3
[[material]]
name = "mud"
law = "bingham"
density = 1500.0
young = 5.0e4
poisson = 0.45
viscosity = 50.0
yield_stress = 500.0
[[body]]
name = "heap"
material = "mud"
shape = "box"
min = [0.0, 0.0]
max = [0.5, 0.5]
particles_per_cell = 2
geostatic = { surface = 0.5 }
[[wall]]
face = "x-min"
kind = "free-slip"
[[wall]]
face = "y-min"
kind = "no-slip"
"""


class Rest(moraine.ProgramTest):
    def test_a_run_ends_at_rest_at_the_same_step_on_any_ranks_and_after_any_checkpoint(self):
        scene = self.write(HEAP)
        ended = call("run", scene, "--output", self.folder / "alone", *sets(output__checkpoint_interval=0.35))
        self.assertEqual(ended.code, 0, ended)
        alone = summary(self.folder / "alone")
        self.assertEqual(alone["ended_by"], "rest")
        self.assertLess(alone["simulated_time_s"], 10)
        self.assertGreater(alone["front_m"], 0.6)
        self.assertRegex(ended.err, r"At rest: in 3 intervals of [0-9.]+ s in turn 99\.9 % of the mass and more moved less than")
        self.assertIn("Ended by rest at t = ", ended.err)
        first, middle, last = (checkpoints(self.folder / "alone")[k] for k in (0, len(checkpoints(self.folder / "alone")) // 2, -1))
        every = sets(balance__trigger="every", balance__interval=10)
        for ranks, words in ((2, ()), (3, ("--partitioner", "shuffle", *every)), (4, ("--restart", first)), (2, ("--restart", middle)),
                             (1, ("--restart", last))):
            with self.subTest(ranks=ranks, words=words):
                directory = self.run_scene(scene, f"{ranks}-{len(words)}-{str(words)[-20:-6].replace('/', '-')}", *words, ranks=ranks)
                found = summary(directory)
                for key in ("ended_by", "steps", "simulated_time_s", "state_hash"):
                    self.assertEqual(found[key], alone[key], key)
        self.assertEqual((self.folder / "alone" / "history.csv").read_text().splitlines()[-1].split(",")[0], str(alone["steps"]))

        on = self.run_scene(scene, "on", *sets(time__stop="end", time__end=repr(alone["simulated_time_s"])))
        for key in ("steps", "state_hash"):
            self.assertEqual(summary(on)[key], alone[key], "to look who has moved changes nothing")
        self.assertEqual(summary(on)["ended_by"], "end")

    def test_a_run_that_is_to_end_before_it_rests_ends_there(self):
        found = summary(self.run_scene(self.write(HEAP), "short", *sets(time__end=0.2)))
        self.assertEqual(found["ended_by"], "end")
        self.assertGreaterEqual(found["simulated_time_s"], 0.2)

    def test_a_restart_from_a_run_that_did_not_look_begins_to(self):
        scene = self.write(HEAP)
        looked = self.run_scene(scene, "looked", *sets(time__end=0.5, time__stop="end", output__checkpoint_interval=0.3))
        found = summary(self.run_scene(scene, "on", "--restart", checkpoints(looked)[0]))
        self.assertEqual(found["ended_by"], "rest")

    def test_rest_is_refused_where_it_makes_no_sense(self):
        def said(*words, text=HEAP):
            return self.assert_one_problem(call("check", self.write(text), *words))

        self.assertIn('time.stop = "rest" without gravity', said(*sets(gravity="[0.0, 0.0]"),
                                                                  text=HEAP.replace("geostatic = { surface = 0.5 }", "")))
        pipe = '[[structure]]\nname = "pipe"\nshape = "sphere"\ncenter = [1.5, 0.8]\nradius = 0.1\n'
        moves = 'motion = { kind = "velocity", velocity = [0.0, -0.1] }\n'
        self.assertIn('time.stop = "rest" with structure.pipe, which moves', said(text=HEAP + pipe + moves))
        self.assertIn("rest       may end it: 99.9 % of the mass within 0.0025 m for 3 times 0.1428 s", call("check", self.write(HEAP + pipe)).out)
        self.assertIn("rest.mass", said(*sets(rest__mass=1.5)))
        self.assertIn("rest.interval", said(*sets(rest__interval=0)))


if __name__ == "__main__":
    moraine.main()
