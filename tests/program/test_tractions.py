"""[[traction]]: a strip on clay, the same bits on any ranks and after a restart within a ramp, stages, and what is refused."""
import math

import moraine
from moraine import SMALL_SCENE, call, checkpoints, sets, summary, table

RAMP = '[[table]]\nname = "ramp"\ntimes = [0.0, 0.08]\nvalues = [0.0, 1.0]\n'
PUSH = '[[traction]]\nname = "push"\nbody = "block"\nside = "y-max"\npressure = 4e3\nshear = [1e3, 0.0]\n'
SLOPE = '[[body]]\nname = "wedge"\nmaterial = "jelly"\nshape = "polygon"\npoints = [[2.0, 0.0], [4.0, 0.0], [4.0, 1.0], [3.0, 1.0]]\n'

GROUND = """\
dimensions = 2
[domain]
min = [0.0, 0.0]
max = [4.0, 2.5]
cell = 0.125
[time]
end = 2.0
[numerics]
damping = 0.3
[output]
interval = 0.25
[[material]]
name = "clay"
law = "tresca"
density = 1600.0
young = 1.0e6
poisson = 0.45
su = 1.0e3
volumetric = "cell"
[[body]]
name = "ground"
material = "clay"
shape = "box"
min = [0.0, 0.0]
max = [4.0, 2.0]
[[wall]]
face = "x-min"
kind = "free-slip"
[[wall]]
face = "x-max"
kind = "free-slip"
[[wall]]
face = "y-min"
kind = "no-slip"
[[table]]
name = "rise"
times = [0.0, 1.0]
values = [0.0, 1.0]
[[traction]]
name = "strip"
body = "ground"
area = [[0.0, 1.0], [0.5, 1.0], [0.5, 3.0], [0.0, 3.0]]
normal = [0.0, 1.0]
table = "rise"
"""


class Tractions(moraine.ProgramTest):
    def speeds(self, factor):
        """Root mean square speeds under a strip of a pressure of (2 + pi) su times this."""
        scene = self.write(GROUND + f"pressure = {factor * (2 + math.pi) * 1e3}\n")
        rows = table(self.run_scene(scene, f"strip-{factor}"), "history.csv")
        return [math.sqrt(2 * row["kinetic_J"] / row["mass_kg"]) for row in rows]

    def test_a_strip_stands_below_its_bearing_capacity_and_sinks_above_it(self):
        stands, sinks = self.speeds(0.95), self.speeds(1.1)
        self.assertLess(stands[-1], 0.1 * max(stands))
        self.assertGreater(sinks[-1], 0.5 * max(sinks))

    def test_the_answer_is_the_same_on_any_ranks_and_after_a_restart_within_the_ramp(self):
        for kind, precision in (("dead", "double"), ("follower", "single")):
            more = sets(output__interval=0.01, output__checkpoint_interval=0.03, numerics__precision=f'"{precision}"')
            scene = self.write(SMALL_SCENE + RAMP + PUSH + f'kind = "{kind}"\ntable = "ramp"\n')
            alone = self.run_scene(scene, precision, *more)
            first, rows = checkpoints(alone)[0], table(alone, "history.csv")
            self.assertGreater(abs(rows[-1]["traction_impulse_y_kg_m_s"]), 100)
            self.assertLess(abs(rows[-1]["momentum_error_y_kg_m_s"]), (1e-9 if precision == "double" else 1e-2))
            for ranks, words in ((2, ("--partitioner", "shuffle")), (3, ()), (4, ()), (1, ("--restart", first)), (3, ("--restart", first))):
                with self.subTest(kind=kind, ranks=ranks, words=words):
                    found = self.run_scene(scene, f"{precision}-{ranks}-{len(words)}", *more, *words, ranks=ranks)
                    self.assertEqual(summary(found)["state_hash"], summary(alone)["state_hash"])
                    self.assertEqual(table(found, "history.csv")[-1], rows[-1])

    def test_stages_switch_a_traction_and_restarts_may_change_it(self):
        stages = '[[stage]]\nname = "still"\nuntil = 0.04\n[[stage]]\nname = "load"\nset = { "traction.push.pressure" = 4e3, "traction.push.shear" = [0, 0] }\n'
        scene = self.write(SMALL_SCENE + PUSH.replace("4e3", "0").replace("[1e3, 0.0]", "[0, 0]") + stages)
        more = sets(output__interval=0.02, output__checkpoint_interval=0.02)
        run = self.run_scene(scene, "stages", *more)
        for row in table(run, "history.csv"):
            after = max(0, row["time_s"] - summary(run)["stages"][1]["begin_s"])
            self.assertAlmostEqual(row["traction_impulse_y_kg_m_s"], -4e3 * after, delta=1e-8)
        for checkpoint in (checkpoints(run)[0], checkpoints(run)[-1]):
            found = self.run_scene(scene, checkpoint.stem, *more, "--restart", checkpoint, ranks=2)
            self.assertEqual(summary(found)["state_hash"], summary(run)["state_hash"])
        plain = self.write(SMALL_SCENE + PUSH, "plain.toml")
        first = checkpoints(self.run_scene(plain, "plain", *more))[0]
        other = self.run_scene(plain, "other", *more, *sets(traction__push__pressure=9e3), "--restart", first, "--allow-change", "traction.push.pressure")
        self.assertNotEqual(summary(other)["state_hash"], summary(self.folder / "plain")["state_hash"])

    def test_a_traction_of_zero_changes_no_place(self):
        none = table(self.run_scene(self.write(SMALL_SCENE), "none"), "history.csv")[-1]
        zero = table(self.run_scene(self.write(SMALL_SCENE + PUSH.replace("4e3", "0").replace("[1e3, 0.0]", "[0, 0]")), "zero"), "history.csv")[-1]
        self.assertEqual({key: zero[key] for key in none}, none)

    def test_check_says_what_is_loaded_and_wrong_ones_are_refused_with_a_place_and_a_remedy(self):
        whole = SMALL_SCENE + PUSH
        self.assertIn("traction   push: 4123 Pa on 1 m of body.block, dead\n", call("check", self.write(whole)).out)
        wedge = whole + SLOPE + '[[traction]]\nname = "face"\nbody = "wedge"\nnormal = [-1.0, 1.0]\npressure = 100\nkind = "follower"\ndepth = 0.3\narea = [[2.2, 0.4], [3.2, 0.4], [3.2, 1.1], [2.2, 1.1]]\n'
        self.assertRegex(call("check", self.write(wedge)).out, r"traction   face: 100 Pa on 0\.8[45]\d* m of body.wedge, follower\n")

        def said(old, new, text=whole, *words):
            self.assertIn(old, text)
            return self.assert_one_problem(call("check", self.write(text.replace(old, new)), *words))

        self.assertRegex(said('body = "block"', 'body = "blok"'), r'traction.push.body = "blok" \(there is no such body\)')
        self.assertIn("leaves the surface", said("[1e3, 0.0]", "[1e3, 5.0]"))
        self.assertIn("has no pressure and no shear", said("pressure = 4e3\nshear = [1e3, 0.0]\n", ""))
        self.assertIn("normal and side are both given", said("pressure", "normal = [0, 1]\npressure"))
        self.assertIn("faces do not look that way", said('side = "y-max"', "normal = [1, 1]"))
        self.assertIn("is along z", said('"y-max"', '"z-max"'))
        self.assertIn("loads nothing", said("pressure", "area = [[5, 0], [6, 0], [6, 1]]\npressure"))
        self.assertIn("is thinner than 2 m", said("pressure", "depth = 2.0\npressure"))
        self.assertIn("particles are 0.125 m apart", said("pressure", "depth = 0.1\npressure"))
        self.assertIn("there is no such table", said("pressure", 'table = "rampe"\npressure'))
        self.assertIn("with numerics.sleep", said("pressure", "pressure", whole, *sets(numerics__sleep="on")))
        newton = whole.replace('"neo-hookean"', '"newtonian"').replace("poisson = 0.3", "poisson = 0.49\nviscosity = 1.0\nvolumetric = \"grid\"")
        self.assertIn('with volumetric = "grid"', said("pressure = ", "pressure = ", newton))
        stages = whole + '[[stage]]\nname = "one"\nuntil = 0.05\n[[stage]]\nname = "two"\nset = { "traction.push.KEY" = 1 }\n'
        self.assertIn("stages change", said("KEY", "depth", stages))
        self.assertIn("no traction", said("push.KEY", "pull.pressure", stages))
        self.assertIn("leaves the surface", said("KEY\" = 1", 'shear" = [0.0, 1.0]', stages))


if __name__ == "__main__":
    moraine.main()
