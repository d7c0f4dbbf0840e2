"""Absorbing walls and [shaking]: one run on any ranks and after a restart in either stage; what is refused."""
import moraine
from moraine import call, checkpoints, sets, summary, table

# Clay on rock: at rest between smooth walls, then shaken on ends that absorb.
GROUND = """\
dimensions = 2
gravity = [0.0, -9.81]
[domain]
min = [0.0, 0.0]
max = [4.0, 3.0]
cell = 0.25
[time]
end = 0.3
[[material]]
name = "clay"
law = "tresca"
density = 1700.0
young = 4.0e6
poisson = 0.4
su = 1.0e4
[[material]]
name = "rock"
law = "linear-elastic"
density = 2400.0
young = 1.0e8
poisson = 0.25
[[body]]
name = "ground"
material = "clay"
shape = "box"
min = [0.0, 0.0]
max = [4.0, 2.0]
geostatic = { surface = 2.0, k0 = 0.6667 }
[[wall]]
face = "x-min"
kind = "free-slip"
[[wall]]
face = "x-max"
kind = "free-slip"
[[wall]]
face = "y-min"
kind = "no-slip"
"""
STAGES = """\
[[stage]]
name = "still"
until = 0.05
[[stage]]
name = "shake"
set = { "wall.x-max.kind" = "absorbing", "wall.y-min.kind" = "absorbing", "wall.y-min.material" = "rock" }
"""
SHAKING = """\
[shaking]
table = "quake"
quantity = "velocity"
direction = [1.0, 0.0]
motion = "outcrop"
stage = "shake"
[[table]]
name = "quake"
times = [0.0, 0.05, 0.15, 0.2]
values = [0.0, 0.1, -0.1, 0.0]
"""
SHAKEN = GROUND + STAGES + SHAKING
ABSORBING = GROUND.replace('"no-slip"', '"absorbing"')


class Shaking(moraine.ProgramTest):
    def test_shaken_ground_on_absorbing_ends_is_one_on_any_ranks_and_after_a_restart(self):
        scene = self.write(SHAKEN)
        for precision in ("double", "single"):
            more = sets(numerics__precision=precision, output__interval=0.05, output__checkpoint_interval=0.06, output__energy_budget="on")
            alone = self.run_scene(scene, precision, *more)
            found, rows = summary(alone), table(alone, "history.csv")
            for row in rows:
                self.assertLess(abs(row["momentum_error_x_kg_m_s"]), 1e-6 if precision == "double" else 0.5)
            self.assertEqual(rows[0]["base_velocity_m_s"], 0)
            self.assertEqual(rows[-1]["base_velocity_m_s"], 0)
            self.assertGreater(max(row["base_velocity_m_s"] for row in rows), 0.05)
            self.assertAlmostEqual(rows[-1]["wall_J"] / rows[-1]["unaccounted_J"], 1, delta=0.15)  # ends take energy
            kept = checkpoints(alone)
            self.assertGreaterEqual(len(kept), 4)
            every = sets(balance__trigger="every", balance__interval=7)
            restarts = [(1 + k % 4, ("--restart", path)) for k, path in enumerate(kept)]
            for ranks, words in ((2, ("--partitioner", "shuffle", *every)), (3, ()), (4, every), *restarts):
                with self.subTest(precision=precision, ranks=ranks, words=words):
                    again = self.run_scene(scene, f"{precision}-{ranks}-{len(words)}-{str(words)[-12:-6]}", *more, *words, ranks=ranks)
                    self.assertEqual(summary(again)["state_hash"], found["state_hash"])
                    self.assertEqual(table(again, "history.csv")[-1], rows[-1])

    def test_ground_at_rest_stays_on_ends_that_absorb(self):
        still = self.run_scene(self.write(GROUND + STAGES), "still", *sets(time__end=2.0))
        self.assertLess(table(still, "history.csv")[-1]["max_speed_m_s"], 1e-3)

    def test_check_tells_the_shaking_and_wrong_ones_are_refused_with_a_place_and_a_remedy(self):
        self.assertIn("shaking    for 0.2 s from the begin of stage shake, at most 0.1 m/s", call("check", self.write(SHAKEN)).out)

        def said(old, new, text=SHAKEN, *words):
            self.assertIn(old, text)
            return self.assert_one_problem(call("check", self.write(text.replace(old, new)), *words))

        loose = ABSORBING.replace("geostatic = { surface = 2.0, k0 = 0.6667 }\n", "")
        self.assertIn("body.ground begins without stress", said("", "", loose))
        self.assertIn("there is no such material", said('"rock" }', '"rok" }'))
        self.assertIn('numerics.boundary = "plain"', said("", "", ABSORBING, *sets(numerics__boundary="plain")))
        self.assertIn("numerics.sleep", said("", "", ABSORBING, *sets(numerics__sleep="on")))
        top = '[[body]]\nname = "top"\nmaterial = "clay"\nshape = "box"\nmin = [1.0, 2.0]\nmax = [2.0, 2.5]\n'
        later = STAGES.replace('"shake"\n', '"shake"\nuntil = 0.2\n') + '[[stage]]\nname = "more"\nadd = ["top"]\n'
        self.assertIn("absorbs before body.top is there", said("", "", GROUND + top + later))
        self.assertIn("waves go out there", said('motion = "outcrop"\n', ""))
        self.assertIn("which is rigid", said(', "wall.y-min.kind" = "absorbing", "wall.y-min.material" = "rock"', ""))
        self.assertIn("there is no such stage", said('stage = "shake"', 'stage = "shook"'))
        self.assertIn("which ends at rest", said('"shake"\nset', '"shake"\nuntil = "rest"\nset'))
        self.assertIn("there is no such table", said('table = "quake"', 'table = "quak"'))
        self.assertIn("has no length", said("[1.0, 0.0]", "[0.0, 0.0]"))
        self.assertIn("the base ends with 0.05 m/s", said("-0.1, 0.0]", "-0.1, 0.05]"))
        self.assertIn("shaking with numerics.sleep", said("", "", GROUND + SHAKING.replace('motion = "outcrop"\nstage = "shake"\n', ""), *sets(numerics__sleep="on")))


if __name__ == "__main__":
    moraine.main()
