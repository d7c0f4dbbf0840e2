"""Structures that turn: what they do on soil, one answer on any number of ranks and after a restart, and words for wrong ones."""
import math

import moraine
from moraine import SMALL_SCENE, call, checkpoints, sets, summary, table

# A block of jelly lands on a plank that is free, beside a wheel that turns as it is told.
SCENE = SMALL_SCENE.replace('kind = "no-slip"', 'kind = "none"') + """
[output]
structure_interval = 0.02
[[structure]]
name = "plank"
shape = "polygon"
points = [[0.8, 0.2], [2.4, 0.3], [2.4, 0.45], [0.8, 0.45]]
contact = { law = "coulomb", friction = 0.4 }
motion = { kind = "free", density = 900.0, turns = true, angular_velocity = [-1.0] }
[[structure]]
name = "wheel"
shape = "box"
min = [2.0, 0.7]
max = [2.6, 1.3]
clear = true
contact = { law = "rough" }
motion = { kind = "velocity", velocity = [-0.2, 0.0], angular_velocity = [6.0], ramp = 0.02 }
[[structure]]
name = "lid"
shape = "plane"
point = [1.0, 1.9]
normal = [0.0, -1.0]
"""
# A bed of rubber on a floor without slip, periodic along x; gravity leans by an angle.
BED = """
dimensions = 2
gravity = [GX, GY]
[domain]
min = [0.0, 0.0]
max = [4.0, 2.0]
cell = 0.05
periodic = ["x"]
[time]
end = END
[numerics]
bed = "BEDS"
[[material]]
name = "rubber"
law = "linear-elastic"
density = 2000.0
young = 2.0e7
poisson = 0.3
[[body]]
name = "bed"
material = "rubber"
shape = "box"
min = [0.0, 0.0]
max = [4.0, 0.3]
[[wall]]
face = "y-min"
kind = "no-slip"
[[wall]]
face = "y-max"
kind = "open"
[[structure]]
name = "it"
STRUCTURE
"""
BAD = """
[[structure]]
name = "pipe"
"""
PIPE = 'shape = "sphere"\ncenter = [3.0, 1.0]\nradius = 0.1\n'


def leaning(angle, end, bed, structure):
    """BED under gravity that leans by an angle [rad] towards x."""
    scene = BED.replace("GX", repr(9.81 * math.sin(angle))).replace("GY", repr(-9.81 * math.cos(angle)))
    return scene.replace("END", str(end)).replace("BEDS", bed).replace("STRUCTURE", structure)


class Turning(moraine.ProgramTest):
    def last(self, scene, name, *keys):
        return table(self.run_scene(self.write(scene), name, "--no-particles", *keys), "structures.csv")[-1]

    def test_a_disk_rolls_down_a_slope_at_two_thirds_of_what_slides(self):
        """Its bed of rubber brakes both alike: what slides without friction comes to 0.8 g sin (surface), 0.66 (nodes)."""
        disk = ('shape = "sphere"\ncenter = [0.5, 0.7]\nradius = 0.4\ncontact = { CONTACT }\n'
                'motion = { kind = "free", density = 500.0, turns = true }')
        for bed, grip in (("nodes", 0.2), ("surface", 0.02)):
            rolls, slides = (self.last(leaning(math.radians(10), 0.6, bed, disk.replace("CONTACT", law)), f"disk-{bed}-{k}")
                             for k, law in enumerate(('law = "coulomb", friction = 0.6', 'law = "smooth"')))
            self.assertAlmostEqual(rolls["velocity_x_m_s"] / slides["velocity_x_m_s"], 2 / 3, delta=0.05)
            self.assertAlmostEqual(rolls["angular_velocity_rad_s"] * 0.4 / -rolls["velocity_x_m_s"], 1, delta=grip)
            self.assertLess(abs(slides["angular_velocity_rad_s"] * 0.4), 0.02 * slides["velocity_x_m_s"])

    def test_a_block_topples_above_the_slope_of_its_diagonal_and_stands_below(self):
        """Its toe sinks into a cell, so it stands up to less than the whole slope; gravity comes within 0.5 s."""
        block = ('shape = "box"\nmin = [1.0, 0.3]\nmax = [1.4, 1.1]\ncontact = { law = "coulomb", friction = 0.9 }\n'
                 'motion = { kind = "free", density = 1000.0, turns = true }\n'
                 '[[table]]\nname = "rise"\ntimes = [0.0, 0.5]\nvalues = [0.0, 1.0]')
        for bed, below in (("nodes", 0.6), ("surface", 0.85)):
            stands, falls = (self.last(leaning(math.atan(0.5 * share), 1.0, bed, block).replace("[domain]", 'gravity_table = "rise"\n[domain]'),
                                       f"block-{bed}-{share}")["angle_rad"] for share in (below, 1.1))
            self.assertLess(abs(stands), 0.02)
            self.assertLess(falls, -0.5)

    def on_turned_bed(self, turn):
        """A disk on rubber on a plane; all of it is turned in the grid, particles and gravity with it: its speed along the bed, and its angle."""
        c, s, step = math.cos(turn), math.sin(turn), 0.025
        def at(x, y):
            return [round(c * x - s * y + 2, 9), round(s * x + c * y + 1, 9)]
        rows = ("{},{},{}\n".format(*at(-1.6 + (i + 0.5) * step, (j + 0.5) * step), 2000 * step ** 2) for j in range(12) for i in range(128))
        (self.folder / "rubber.csv").write_text("x,y,mass\n" + "".join(rows))
        text = leaning(math.radians(10) + turn, 0.5, "surface", (
            f'shape = "sphere"\ncenter = {at(-1.2, 0.7)}\nradius = 0.4\ncontact = {{ law = "coulomb", friction = 0.6 }}\n'
            'motion = { kind = "free", density = 500.0, turns = true }\n[[structure]]\nname = "floor"\nshape = "plane"\n'
            f'point = {[2.0, 1.0]}\nnormal = {[-s, c]}\ncontact = {{ law = "rough" }}'))
        text = text.replace('shape = "box"\nmin = [0.0, 0.0]\nmax = [4.0, 0.3]', f'shape = "table"\nfile = "{self.folder}/rubber.csv"')
        text = text.replace('periodic = ["x"]', "").replace("max = [4.0, 2.0]", "max = [4.0, 3.0]")
        rows = table(self.run_scene(self.write(text), f"turned-{turn}", "--no-particles"), "structures.csv")
        last = next(row for row in reversed(rows) if row["structure"] == "it")
        return last["velocity_x_m_s"] * c + last["velocity_y_m_s"] * s, last["angle_rad"]

    def test_a_bed_that_is_turned_carries_a_disk_alike(self):
        speed, angle = self.on_turned_bed(0.0)
        for degrees in (7, 20):
            found = self.on_turned_bed(math.radians(degrees))
            self.assertAlmostEqual(found[0] / speed, 1, delta=0.04)
            self.assertAlmostEqual(found[1] / angle, 1, delta=0.1)

    def test_state_and_records_are_the_same_on_1_to_4_ranks_under_any_owner(self):
        scene = self.write(SCENE)
        for bed in ("nodes", "surface"):
            one = self.run_scene(scene, f"one-{bed}", *sets(numerics__bed=bed))
            rows = table(one, "structures.csv")
            self.assertLess(rows[-3]["angle_rad"], -0.05)
            self.assertAlmostEqual(rows[-2]["angle_rad"], 6 * (rows[-2]["time_s"] - 0.01), delta=1e-9)
            self.assertEqual(rows[-1]["angle_rad"], 0)
            said = summary(one)["structures"]
            self.assertEqual(said["plank"]["angle_rad"], [rows[-3]["angle_rad"]])
            self.assertNotIn("angle_rad", said["lid"])
            weight = summary(one)["mass_kg"] * 9.81 * 0.1
            self.assertLess(max(map(abs, summary(one)["momentum_error"])), 1e-12 * weight)
            for ranks in (2, 3, 4):
                many = self.run_scene(scene, f"{bed}-{ranks}", "--partitioner", "shuffle",
                                      *sets(numerics__bed=bed, balance__trigger="every", balance__interval=7), ranks=ranks)
                self.assertEqual(summary(many)["state_hash"], summary(one)["state_hash"])
                self.assertEqual(table(many, "structures.csv"), rows)

    def test_a_restart_goes_on_with_how_they_were_turned(self):
        for bed in ("nodes", "surface"):
            whole = self.run_scene(self.write(SCENE), f"whole-{bed}", *sets(numerics__bed=bed, output__checkpoint_interval=0.05))
            again = self.run_scene(self.write(SCENE), f"again-{bed}", "--restart", checkpoints(whole)[0], *sets(numerics__bed=bed), ranks=2)
            self.assertEqual(summary(again)["state_hash"], summary(whole)["state_hash"])
            rows = table(again, "structures.csv")
            self.assertEqual(rows, table(whole, "structures.csv")[-len(rows):])

    def test_in_single_precision_and_at_map_coordinates_they_turn_alike(self):
        """The plank that jelly pushes, 600 km east and 4900 km north, where a place has 1e-9 m."""
        def far(*points):
            return str([[x + 6e5, y + 4.9e6] for x, y in points]) if len(points) > 1 else str([points[0][0] + 6e5, points[0][1] + 4.9e6])
        keys = {"domain__min": far((0.0, 0.0)), "domain__max": far((4.0, 2.0)), "body__block__min": far((1.0, 0.5)),
                "body__block__max": far((2.0, 1.5)), "structure__lid__point": far((1.0, 1.9)),
                "structure__plank__points": far((0.8, 0.2), (2.4, 0.3), (2.4, 0.45), (0.8, 0.45)),
                "structure__wheel__min": far((2.0, 0.7)), "structure__wheel__max": far((2.6, 1.3))}
        for bed in ("nodes", "surface"):
            here, single, there = (table(self.run_scene(self.write(SCENE.replace("cfl = 0.5", "dt = 2e-4")), f"{name}-{bed}", *sets(numerics__bed=bed, **more)), "structures.csv")[-3]
                                   for name, more in (("here", {}), ("single", {"numerics__precision": "single"}), ("there", keys)))
            self.assertLess(here["angle_rad"], -0.05)
            for key in ("angle_rad", "angular_velocity_rad_s", "displacement_x_m", "displacement_y_m"):
                self.assertAlmostEqual(single[key], here[key], delta=1e-4 * abs(here["angular_velocity_rad_s"]))
                self.assertAlmostEqual(there[key], here[key], delta=1e-6 * abs(here["angular_velocity_rad_s"]))

    def test_a_turned_box_is_a_polygon_of_its_corners(self):
        """Contact and cut cells of one that was turned are those of one that was made so."""
        at = [[math.cos(0.4) * x - math.sin(0.4) * y + 1.5, math.sin(0.4) * x + math.cos(0.4) * y - 0.05]
              for x, y in ((-0.6, -0.3), (0.6, -0.3), (0.6, 0.3), (-0.6, 0.3))]
        begin = SCENE[:SCENE.index("[[structure]]")]
        made = begin + f'[[structure]]\nname = "it"\nshape = "polygon"\npoints = {at}\n'
        turned = begin + ('[[table]]\nname = "turn"\ntimes = [0.0, 0.001, 0.002]\nvalues = [0.0, 1.0, 0.0]\n[[structure]]\nname = "it"\nshape = "box"\n'
                          'min = [0.9, -0.35]\nmax = [2.1, 0.25]\nmotion = { kind = "table", velocity = [0.0, 0.0], angular_velocity = [400.0], table = "turn" }\n')
        for bed in ("nodes", "surface"):
            forces = [self.last(scene, f"{name}-{bed}", *sets(numerics__bed=bed)) for name, scene in (("made", made), ("turned", turned))]
            for key in ("impulse_x_N_s", "impulse_y_N_s"):
                self.assertAlmostEqual(forces[1][key], forces[0][key], delta=2e-3 * abs(forces[0]["impulse_y_N_s"]))
            self.assertGreater(abs(forces[0]["impulse_y_N_s"]), 10)

    def test_where_structures_do_not_turn_they_are_refused(self):
        asleep = call("check", self.write(SCENE), *sets(numerics__sleep="on", numerics__transfer="apic"))
        self.assertIn("structure.plank, which turns", self.assert_one_problem(asleep))
        cases = {
            PIPE + 'motion = { kind = "free", turns = true }': "mass is missing",
            PIPE + 'motion = { kind = "free", mass = 1.0, density = 2.0 }': "density beside its mass",
            PIPE + 'motion = { kind = "free", mass = 1.0, inertia = [1.0] }': "does not turn",
            PIPE + 'motion = { kind = "free", mass = 1.0, angular_velocity = [1.0] }': "does not turn",
            PIPE + 'motion = { kind = "free", mass = 1.0, turns = true, inertia = [0.0] }': "inertia has 0",
            PIPE + 'motion = { kind = "free", mass = 1.0, turns = true, inertia = [1.0, 1.0, 1.0] }': "has 3 numbers",
            PIPE + 'motion = { kind = "velocity", velocity = [0.0, 0.0], angular_velocity = [1.0, 0.0] }': "has 2 numbers",
            PIPE + 'motion = { kind = "sinusoid", amplitude = [0.1, 0.0], period = 1.0, angular_velocity = [1.0] }': "angular_velocity",
            'shape = "plane"\npoint = [0.0, 0.1]\nnormal = [0.0, 1.0]\nmotion = { kind = "free", density = 1.0 }': "of a plane",
            'shape = "plane"\npoint = [0.0, 0.1]\nnormal = [0.0, 1.0]\nmotion = { kind = "free", mass = 1.0, turns = true }': "a plane that turns",
        }
        for text, said in cases.items():
            ended = call("check", self.write(SMALL_SCENE + BAD + text + "\n"))
            self.assertIn(said, self.assert_one_problem(ended))
        solid = SMALL_SCENE.replace("dimensions = 2", "dimensions = 3").replace("[0.0, -9.81]", "[0.0, -9.81, 0.0]")
        for key in ("min = [0.0, 0.0]", "max = [4.0, 2.0]", "min = [1.0, 0.5]", "max = [2.0, 1.5]"):
            solid = solid.replace(key, key[:-1] + (", 0.0]" if key.startswith("min") else ", 1.0]"))
        ball = solid + BAD + ('shape = "sphere"\ncenter = [3.0, 1.0, 0.5]\nradius = 0.1\n'
                              'motion = { kind = "free", mass = 1.0, turns = true, inertia = [1.0, 1.0, 2.5] }\n')
        self.assertIn("inertia has 2.5", self.assert_one_problem(call("check", self.write(ball))))
        report = call("check", self.write(ball.replace("2.5]", "2.0]")))
        self.assertEqual(report.code, 0, report)
        self.assertIn("structure  pipe: sphere, free and turns, smooth", report.out)


if __name__ == "__main__":
    moraine.main()
