"""Walls with laws of structures: undrained and voellmy, on lower and upper faces, for films and thick slabs."""
import csv
import math
import unittest

import moraine
from moraine import checkpoints, sets, summary

CELL, DENSITY, GRAVITY = 0.25, 1900.0, 9.81


def slab(cells, slope, speed, wall, upper=False):
    """A periodic slab on the wall y-min, or upside down under y-max, gravity turned by the slope."""
    depth, height = cells * CELL, CELL * math.ceil(cells + 2)
    side, low = (-1, height - depth) if upper else (1, 0.0)
    return f"""dimensions = 2
gravity = [{GRAVITY * math.sin(slope)!r}, {-side * GRAVITY * math.cos(slope)!r}]
[domain]
min = [0.0, 0.0]
max = [4.0, {height!r}]
cell = {CELL}
periodic = ["x"]
[time]
end = 0.5
[output]
interval = 0.1
[[material]]
name = "soil"
law = "linear-elastic"
density = {DENSITY}
young = 1e7
poisson = 0.3
[[body]]
name = "slab"
material = "soil"
shape = "box"
min = [0.0, {low!r}]
max = [4.0, {low + depth!r}]
velocity = [{speed!r}, 0.0]
[[wall]]
face = "{'y-max' if upper else 'y-min'}"
{wall}
"""


class WallLaws(moraine.ProgramTest):
    def ended(self, scene, name, **keys):
        """Time, mean speed and summary at the end."""
        directory = self.run_scene(self.write(scene), name, *keys.pop("words", ()), **keys)
        with open(directory / "history.csv", newline="") as file:
            last = list(csv.DictReader(file))[-1]
        found = summary(directory)
        return float(last["time_s"]), float(last["momentum_x_kg_m_s"]) / found["mass_kg"], found

    def test_a_slab_has_the_speed_of_voellmys_law(self):
        slope, mu, xi = math.radians(24), 0.1, 500.0
        for cells, upper, precision in ((0.5, False, "double"), (1, True, "double"), (2, False, "single"), (4, False, "double"), (4, True, "double")):
            with self.subTest(cells=cells, upper=upper):
                drive = math.sin(slope) - mu * math.cos(slope)
                steady = math.sqrt(xi * cells * CELL * drive)
                scene = slab(cells, slope, 0.8 * steady, f'kind = "voellmy"\nfriction = {mu}\nxi = {xi}', upper)
                time, speed, _ = self.ended(scene, f"voellmy-{cells}-{upper}", words=sets(numerics__precision=precision))
                exact = steady * math.tanh(GRAVITY * drive / steady * time + math.atanh(0.8))
                self.assertAlmostEqual(speed / exact, 1, delta=1e-3)  # it bounces a little: no geostatic start

    def test_the_normal_force_is_the_weight_for_as_long_as_it_slides(self):
        slope = math.radians(20)
        scene = slab(2, slope, 1.0, 'kind = "voellmy"\nfriction = 0.15\nxi = 50.0').replace("end = 0.5", "end = 3.0")
        scene = scene.replace("max = [4.0, 0.5]", "max = [2.0, 0.5]")  # a block, which may turn
        self.ended(scene, "long", words=sets(domain__cell=0.1, material__soil__young=1e6))
        with open(self.folder / "long" / "structures.csv", newline="") as file:
            impulse = [(float(row["time_s"]), float(row["impulse_y_N_s"])) for row in csv.DictReader(file)]
        weight = DENSITY * 2.0 * 2 * CELL * GRAVITY * math.cos(slope)
        for (before, first), (after, second) in zip(impulse[5::5], impulse[10::5]):
            self.assertAlmostEqual(-(second - first) / (after - before) / weight, 1, delta=0.05)

    def test_a_wall_lets_go(self):
        scene = slab(2, 0.0, 0.0, 'kind = "voellmy"\nfriction = 0.15\nxi = 50.0', upper=True)
        scene = scene.replace(f"{GRAVITY!r}]", f"{-GRAVITY!r}]", 1).replace("end = 0.5", "end = 0.1")
        directory = self.run_scene(self.write(scene), "off")
        with open(directory / "history.csv", newline="") as file:
            last = list(csv.DictReader(file))[-1]
        mass = summary(directory)["mass_kg"]
        self.assertAlmostEqual(float(last["momentum_y_kg_m_s"]) / mass, -GRAVITY * float(last["time_s"]), delta=1e-6)

    def test_an_undrained_wall_bears_alpha_su_where_soil_touches(self):
        for cells in (0.5, 2, 4):
            with self.subTest(cells=cells):
                scene = slab(cells, 0.0, 8.0, 'kind = "undrained"\nalpha = 0.5\nsu = 4000.0')
                time, speed, _ = self.ended(scene, f"undrained-{cells}", words=sets(time__end=0.25))
                exact = 8.0 - 0.5 * 4000.0 / (DENSITY * cells * CELL) * time
                self.assertAlmostEqual(speed, exact, delta=1e-3 * (8.0 - exact))

    def test_one_answer_on_any_ranks_and_after_a_restart(self):
        scene = slab(2, math.radians(24), 5.0, 'kind = "voellmy"\nfriction = 0.1\nxi = 500.0')
        alone = self.ended(scene, "alone")[2]
        self.assertGreater(alone["steps"], 100)
        for ranks in (2, 3, 4):
            self.assertEqual(self.ended(scene, f"on-{ranks}", ranks=ranks)[2]["state_hash"], alone["state_hash"])
        self.ended(scene, "parts", words=sets(output__checkpoint_interval=0.2), ranks=2)
        restarted = self.ended(scene, "restarted", words=["--restart", checkpoints(self.folder / "parts")[0]], ranks=3)[2]
        self.assertEqual(restarted["state_hash"], alone["state_hash"])

    def test_what_is_wrong_is_said(self):
        for wall, words in (('kind = "voellmy"\nfriction = 0.1', "wall.y-min.xi is missing"),
                            ('kind = "undrained"\nalpha = 0.5', "wall.y-min.su is missing"),
                            ('kind = "friction"\nfriction = 0.1\nxi = 500.0', "wall.y-min.xi"),
                            ('kind = "undrained"\nalpha = 1.5\nsu = 1.0', "wall.y-min.alpha"),
                            ('kind = "voellmy"\nfriction = 0.1\nxi = 500.0\n[[structure]]\nname = "wall-y-min"\nshape = "sphere"\n'
                             'center = [1.0, 5.0]\nradius = 0.1', "structure.wall-y-min is there twice"),
                            ('kind = "voellmy"\nfriction = 0.1\nxi = 500.0\n[[material]]\nname = "other"\nlaw = "linear-elastic"\n'
                             'density = 1000.0\nyoung = 1e7\npoisson = 0.3', "wall.y-min.density is missing")):
            with self.subTest(words=words):
                ended = moraine.call("check", self.write(slab(1, 0.1, 0.0, wall)))
                self.assertEqual(ended.code, 2, ended.err)
                self.assertIn(words, ended.err)
                self.assertTrue(ended.err.rstrip().endswith("?"), ended.err)


if __name__ == "__main__":
    moraine.main()
