"""[water]: a saturated bed at rest, the same bits on any ranks and after a restart, and what is refused."""
import math

import moraine
from moraine import call, checkpoints, sets, summary, table

BED = """\
dimensions = 2
gravity = [0.0, -10.0]
[domain]
min = [0.0, 0.0]
max = [2.0, 1.5]
cell = 0.125
[time]
end = 0.05
[output]
interval = 0.025
fields = ["stress", "pore_pressure", "porosity", "darcy_velocity"]
[water]
table = 1.0
bulk = 5.0e7
[[material]]
name = "sand"
law = "drucker-prager"
density = 2000.0
young = 1.0e7
poisson = 0.3
friction_angle = 33.0
porosity = 0.4
conductivity = 1.0e-3
[[body]]
name = "bed"
material = "sand"
shape = "box"
min = [0.0, 0.0]
max = [2.0, 1.0]
[body.geostatic]
surface = 1.0
k0 = 0.45
[[wall]]
face = "y-min"
kind = "no-slip"
[[wall]]
face = "x-min"
kind = "free-slip"
[[wall]]
face = "x-max"
kind = "free-slip"
"""
# What flows: a column that falls apart and slides, half of it dry.
COLUMN = BED.replace('kind = "no-slip"', 'kind = "friction"\nfriction = 0.3').replace("max = [2.0, 1.0]\n[body.geostatic]\nsurface = 1.0\nk0 = 0.45\n", "max = [0.6, 1.0]\n") + """\
[[material]]
name = "dust"
law = "drucker-prager"
density = 1600.0
young = 1.0e6
poisson = 0.3
friction_angle = 25.0
[[body]]
name = "cap"
material = "dust"
shape = "box"
min = [0.0, 1.0]
max = [0.6, 1.25]
"""


class Water(moraine.ProgramTest):
    def said(self, old, new, text=BED, *words):
        self.assertIn(old, text)
        return self.assert_one_problem(call("check", self.write(text.replace(old, new)), *words))

    def test_the_answer_is_the_same_on_any_ranks_and_after_a_restart(self):
        for precision in ("double", "single"):
            more = sets(output__checkpoint_interval=0.02, output__energy_budget='"on"', numerics__precision=f'"{precision}"')
            scene = self.write(COLUMN)
            alone = self.run_scene(scene, precision, *more)
            first = checkpoints(alone)[0]
            last = table(alone, "history.csv")[-1]
            self.assertGreater(last["kinetic_J"], 5e-3 * last["mass_kg"])  # it falls
            self.assert_budgets_close(last, 1e-11 if precision == "double" else 1e-5)
            for ranks, words in ((2, ("--partitioner", "shuffle")), (3, ()), (4, ()), (1, ("--restart", first)), (3, ("--restart", first))):
                with self.subTest(precision=precision, ranks=ranks, words=words):
                    found = self.run_scene(scene, f"{precision}-{ranks}-{len(words)}", *more, *words, ranks=ranks)
                    self.assertEqual(summary(found)["state_hash"], summary(alone)["state_hash"])
                    self.assertEqual(table(found, "history.csv")[-1], last)

    def assert_budgets_close(self, row, share):
        for axis in "xy":
            self.assertLess(abs(row[f"momentum_error_{axis}_kg_m_s"]), share * abs(row["gravity_impulse_y_kg_m_s"]))
        known = sum(row[f"{name}_J"] for name in ("transfer", "shift", "wall", "contact", "damping", "lost"))
        self.assertLess(abs(row["unaccounted_J"] - known), 0.01 * row["kinetic_J"])
        self.assertGreater(row["drag_J"], 0)

    def test_a_level_bed_stays(self):
        for words in (sets(), sets(water__outside='"submerged"', water__table=3.0)):
            rows = table(self.run_scene(self.write(BED), f"bed{len(words)}", *words), "history.csv")
            self.assertLess(math.sqrt(2 * rows[-1]["kinetic_J"] / rows[-1]["mass_kg"]), 1e-3)

    def test_what_cannot_be_is_refused_with_a_key_and_a_remedy(self):
        self.assertIn("must be in (0, 1)", self.said("porosity = 0.4", "porosity = 1.0"))
        self.assertIn("must be >= 0", self.said("bulk = 5.0e7", "bulk = 5.0e7\ncavitation = -1.0"))
        self.assertIn("must be > 0", self.said("conductivity = 1.0e-3", "conductivity = 0.0"))
        self.assertIn("has a porosity and no conductivity", self.said("conductivity = 1.0e-3\n", ""))
        self.assertIn("material.sand.conductivity without porosity", self.said("porosity = 0.4\n", ""))
        self.assertIn("material.sand.porosity without [water]", self.said("[water]\ntable = 1.0\nbulk = 5.0e7\n", ""))
        self.assertIn("without a material that has a porosity", self.said("porosity = 0.4\nconductivity = 1.0e-3\n", ""))
        self.assertIn("grains would have 666.7 kg/m3", self.said("density = 2000.0", "density = 800.0"))
        self.assertIn("reaches 1 m, above water.table = 0.5", self.said("table = 1.0", "table = 0.5"))
        self.assertIn('Use outside = "submerged"?', self.said("table = 1.0", "table = 1.2"))
        self.assertIn("without a table", self.said("table = 1.0", 'outside = "submerged"'))
        self.assertIn("straight down an axis", self.said("[0.0, -10.0]", "[1.0, -10.0]"))
        self.assertIn("its strength is of total stress", self.said('law = "drucker-prager"', 'law = "tresca"', BED.replace("friction_angle = 33.0", "su = 1e4")))
        self.assertIn("material.sand.volumetric with porosity", self.said("young", 'volumetric = "cell"\nyoung'))
        self.assertIn("quadratic splines", self.said("[water]", '[numerics]\nshape = "gimp"\n[water]'))
        self.assertIn("numerics.damping", self.said("[water]", "[numerics]\ndamping = 0.1\n[water]"))
        self.assertIn("numerics.sleep", self.said("[water]", '[numerics]\nsleep = "on"\n[water]'))
        self.assertIn("substeps are for fluids", self.said("[water]", "[numerics]\nsubsteps = 4\n[water]"))
        self.assertIn("it knows one wave", self.said('face = "x-min"\nkind = "free-slip"', 'face = "x-min"\nkind = "absorbing"'))
        plane = '[[structure]]\nname = "plane"\nshape = "plane"\npoint = [0, -0.1]\nnormal = [0, 1]\n[[wall]]\nface = "y-min"'
        self.assertIn("pore pressure as effective stress", self.said('[[wall]]\nface = "y-min"', plane))
        self.assertIn("[water] with [[stage]]", self.said("[water]", '[[stage]]\nname = "one"\nuntil = 0.02\n[[stage]]\nname = "two"\n[water]'))
        mud = '[[material]]\nname = "mud"\nlaw = "newtonian"\ndensity = 1e3\nyoung = 1e5\npoisson = 0.49\nviscosity = 1.0\nvolumetric = "grid"\n[[body]]'
        self.assertIn("that is the water's", self.said("[[body]]", mud))
        dry = BED.replace("[water]\ntable = 1.0\nbulk = 5.0e7\n", "").replace("porosity = 0.4\nconductivity = 1.0e-3\n", "")
        dry = dry.replace('fields = ["stress", "pore_pressure", "porosity", "darcy_velocity"]\n', "")
        self.assertIn("there is no water to drain", self.said('kind = "no-slip"', 'kind = "no-slip"\ndrainage = "open"', dry))
        self.assertIn("no such field", self.said("interval = 0.025", 'interval = 0.025\nfields = ["porosity"]', dry))


if __name__ == "__main__":
    moraine.main()
