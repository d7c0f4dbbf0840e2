"""Properties over depth: a slope in which all depths yield at once, a footing on soil that gets stronger, interfaces that follow the soil, and what is refused."""
import math
import subprocess

import bearing
import moraine
import valley
from moraine import call, checkpoints, sets, summary, table

BETA, GAMMA = math.radians(10), 1600 * 9.81
SLOPE = f"""\
dimensions = 2
gravity = [{9.81 * math.sin(BETA)}, {-9.81 * math.cos(BETA)}]
[domain]
min = [0.0, 0.0]
max = [1.0, 4.5]
cell = 0.25
periodic = ["x"]
[time]
end = 4.0
[output]
interval = 0.5
fields = ["velocity", "su"]
checkpoint_interval = 1.0
[[material]]
name = "clay"
law = "tresca"
density = 1600.0
young = 1.0e6
poisson = 0.45
su = {{ surface = 0.0, gradient = GRADIENT }}
[[body]]
name = "slope"
material = "clay"
shape = "box"
min = [0.0, 0.0]
max = [1.0, 4.0]
geostatic = {{ surface = 4.0 }}
[[wall]]
face = "y-min"
kind = "no-slip"
"""
SAND = 'law = "drucker-prager"\ndensity = 1600.0\nyoung = 1.0e6\npoisson = 0.3\nfriction_angle = PHI\ncohesion = '


def slope(factor=1.0):
    """Of this factor of safety, 2 k / (gamma sin 2 beta)."""
    return SLOPE.replace("GRADIENT", f"{factor * GAMMA * math.sin(2 * BETA) / 2:.6f}")


LOWEST = """
import sys, h5py
frames = h5py.File(sys.argv[1])["VTKHDF"]
first = int(frames["Steps/PointOffsets"][-1])
end = first + int(frames["NumberOfPoints"][-1])
height, strength = frames["Points"][first:end, 1], frames["PointData/strength"][first:end]
print(strength[height < height.min() + 0.06].mean())
"""


def strength_of_lowest_row(run):
    """At the end [Pa]; None without h5py."""
    for python in ("python3", "/usr/bin/python3"):
        done = subprocess.run([python, "-c", LOWEST, run / "particles.vtkhdf"], capture_output=True, text=True)
        if done.returncode == 0:
            return float(done.stdout)
    return None


class Strength(moraine.ProgramTest):
    def speeds(self, factor, end):
        """Times and root mean square speeds; the load comes at once, so that every slope first slides."""
        rows = table(self.run_scene(self.write(slope(factor)), f"slope-{factor}", *sets(time__end=end)), "history.csv")
        return [(row["time_s"], math.sqrt(2 * row["kinetic_J"] / (1600 * 4.0))) for row in rows]

    def test_an_infinite_slope_stands_just_above_and_runs_just_below_its_factor(self):
        stands = [speed for _, speed in self.speeds(1.03, 8.5)]
        self.assertEqual(stands[1:], sorted(stands[1:], reverse=True))
        self.assertGreater(stands[1], 0.2)
        self.assertLess(stands[-1], 0.005)
        for factor in (0.97, 0.9):
            runs = self.speeds(factor, 4)
            (t0, v0), (t1, v1) = runs[2], runs[-1]
            found = 1 - (v1 - v0) / (t1 - t0) / (9.81 * math.sin(BETA))
            self.assertAlmostEqual(found, factor, delta=0.01)

    def footing(self, cells, *words):
        """Load over B su0 of a stiff, smooth footing with so many cells over B, in the mean over settlements of 0.0075 B and more."""
        stiff = sets(domain__cell=1 / cells, domain__max="[4,1]", time__end=0.9, material__clay__young=1e7,
                     structure__footing__contact='{law="smooth"}', output__interval=0)
        run = self.run_scene(moraine.INPUTS / "strip_footing.toml", "footing", "--overwrite", *stiff, *words)
        loads = [2 * row["force_y_N"] / 1000 for row in table(run, "structures.csv") if -row["displacement_y_m"] > 0.0075]
        return sum(loads) / len(loads)

    def test_a_footing_on_soil_that_gets_stronger_bears_what_davis_and_booker_say(self):
        """With four times su0 more at a depth of B the load is 16 % too high at B/8 and 8.9 % at B/16."""
        self.assertAlmostEqual(self.footing(8) / bearing.bearing_pressure(1, 0, 1), 1, delta=0.03)
        exact = bearing.bearing_pressure(1, 4, 1)
        coarse, fine = (self.footing(cells, *sets(material__clay__su="{surface=1e3,gradient=4e3}")) / exact - 1 for cells in (8, 16))
        self.assertLess(fine, 0.10)
        self.assertLess(fine, 0.6 * coarse)

    def test_check_says_what_the_strength_is(self):
        ended = call("check", self.write(slope(1).replace("surface = 0.0", "surface = 500.0").replace(", gradient", ", from = 2.0, gradient")))
        deepest = 500 + (2 - 0.0625) / math.cos(BETA) * GAMMA * math.sin(2 * BETA) / 2
        self.assertIn(f"profile    body.slope: su from 500 to {deepest:.4g} Pa\n", ended.out)

    def hash_of(self, output, *words, ranks=1, scene=None):
        directory = self.run_scene(scene or self.scene, output, *words, ranks=ranks)
        return summary(directory)["state_hash"]

    def test_ranks_and_restarts_give_the_same_bits(self):
        self.scene = self.write(slope(0.9))
        short = sets(time__end=2)
        expected = self.hash_of("whole", *short)
        for ranks in (2, 3, 4):
            self.assertEqual(self.hash_of(f"on-{ranks}", *short, *sets(balance__partitioner="shuffle"), ranks=ranks), expected)
        first = checkpoints(self.folder / "whole")[0]
        self.assertEqual(self.hash_of("again", *short, "--restart", first, ranks=2), expected)
        line = self.assert_one_problem(call("run", self.scene, "--output", self.folder / "other", "--restart", first,
                                            *sets(material__clay__su__gradient=3000)))
        self.assertRegex(line, r"material\.clay\.su\.gradient is 3000(\.0)? and was 24")
        self.assertFalse((self.folder / "other").exists())

    def test_what_is_one_number_everywhere_is_that_number(self):
        self.scene = self.write(slope())
        short = sets(time__end=0.5, output__fields='["velocity"]')
        expected = self.hash_of("number", *short, *sets(material__clay__su=2000))
        for profile in ("{surface=2000}", "{surface=2000,gradient=0,from=2}", "{depth=[0,3],value=[2000,2000]}"):
            self.assertEqual(self.hash_of("profile", "--overwrite", *short, *sets(material__clay__su=profile)), expected)
        column = self.hash_of("column", *short, *sets(material__clay__su="{depth=[0,8,9],value=[2000,2000,9000]}"))
        self.assertNotEqual(column, expected)  # it has the column
        rows = [table(self.folder / name, "history.csv") for name in ("number", "column")]
        self.assertEqual(*rows)

    def refused(self, text, *words):
        ended = call("check", self.write(text), *words)
        return self.assert_one_problem(ended)

    def test_profiles_that_are_wrong_are_refused(self):
        text = slope()

        def su(profile, *words):
            return self.refused(text, "--set", f"material.clay.su={profile}", *words)

        self.assertIn("material.clay.su is -", su("{surface=2000,gradient=-600}"))
        self.assertIn("(must be > 0)", su("{surface=2000,gradient=-600}"))
        self.assertIn("material.clay.su is 0 Pa at (", su("{surface=0,gradient=600,from=3}"))
        self.assertIn("material.clay.su.surface = 0 (must be > 0 where nothing is added with depth)", su("{surface=0}"))
        self.assertIn("material.clay.su.surface is missing", su("{gradient=600}"))
        self.assertIn("material.clay.su.surface = -1 (must be >= 0)", su("{surface=-1}"))
        self.assertIn("material.clay.su.slope is not a key", su("{surface=1,slope=2}"))
        self.assertIn("are both given (a profile is a line or a table)", su("{surface=1,depth=[0,1],value=[1,2]}"))
        self.assertIn("has 2 numbers and value 1", su("{depth=[0,1],value=[1]}"))
        self.assertIn("material.clay.su.depth does not rise", su("{depth=[0,1,1],value=[1,2,3]}"))
        self.assertIn("material.clay.su.value = 0 (must be > 0)", su("{depth=[0,1],value=[0,3]}"))
        self.assertIn("is a raster (rasters are over terrain in 3-D)", su('{surface="su.asc"}'))
        self.assertIn("material.clay.poisson is a table", self.refused(text, "--set", "material.clay.poisson={surface=0.3}"))
        self.assertIn("material.clay.cohesion is not used", self.refused(text, "--set", "material.clay.cohesion={surface=1}"))
        sand = text[:text.index('law = "tresca"')] + SAND + "{ surface = 0.0, gradient = 10.0, from = 2.0 }\n" + text[text.index("[[body]]"):]
        sand = sand.replace('"su"', '"cohesion"')
        self.assertEqual(call("check", self.write(sand.replace("PHI", "30.0"))).code, 0)
        self.assertIn("no strength at all", self.refused(sand.replace("PHI", "0.0")))
        self.write("x,y\n0.5,0.5\n0.6,0.7\n", "points.csv")
        loose = text[:text.index('shape = "box"')] + 'shape = "table"\nfile = "points.csv"\n' + text[text.index("[[wall]]"):]
        self.assertIn("counts depth from the surface of body.slope (a table of particles", self.refused(loose))

    def test_profiles_of_other_properties_that_are_wrong_are_refused(self):
        text = slope()
        self.assertEqual(call("check", self.write(text), *sets(material__clay__young="{surface=1e6,gradient=2e5}", material__clay__density="{surface=1500,gradient=20}")).code, 0)
        self.assertIn("material.clay.density is -", self.refused(text, *sets(material__clay__density="{surface=1500,gradient=-600}")))
        self.assertIn("material.clay.density.surface = 0 (must be > 0", self.refused(text, *sets(material__clay__density="{surface=0}")))
        self.assertIn('volumetric = "grid" with material.clay.young over depth', self.refused(text, *sets(material__clay__young="{surface=1e6,gradient=1}", material__clay__volumetric='"grid"')))
        self.assertIn("material.clay.young over depth with pressure_smoothing", self.refused(text, *sets(material__clay__young="{surface=1e6,gradient=1}", material__clay__pressure_smoothing=0.2)))
        mud = text[:text.index('law = "tresca"')] + 'law = "newtonian"\ndensity = { surface = 1000.0, gradient = 1.0 }\nyoung = 1e6\npoisson = 0.4\nviscosity = 1.0\n' + text[text.index("[[body]]"):]
        self.assertIn("material.clay.density is a table (law newtonian has one density)", self.refused(mud.replace(', "su"', "")))
        sand = text[:text.index('law = "tresca"')] + SAND + "0.0\n" + text[text.index("[[body]]"):].replace('"su"', '"friction_angle"')
        friction = sand.replace(', "su"', ', "friction_angle"').replace("PHI", "{ surface = 30.0, gradient = GRADIENT }")
        self.assertEqual(call("check", self.write(friction.replace("GRADIENT", "-2.0"))).code, 0)
        self.assertIn("material.clay.friction_angle is up to 1", self.refused(friction.replace("GRADIENT", "20.0")))
        self.assertIn("no strength at all", self.refused(friction.replace("surface = 30.0, gradient = GRADIENT", "depth = [0.0, 3.0], value = [30.0, 0.0]")))
        self.assertIn("dilation_angle is above friction_angle", self.refused(friction.replace("GRADIENT", "-5.0"), *sets(material__clay__dilation_angle=20)))

    def interface(self, output, *words, su='"soil"', alpha=0.5, cap=1, ranks=1):
        """Time and shear force per m2 of a wall of law undrained under the slope, which is dragged along it by its weight."""
        scene = self.write(slope(1).replace('kind = "no-slip"', f'kind = "undrained"\nalpha = {alpha}\nsu = {su}'))
        run = self.run_scene(scene, output, *words, ranks=ranks)
        return run, [(row["time_s"], row["force_x_N"] / cap) for row in table(run, "structures.csv")]

    def test_an_interface_follows_the_su_of_the_soil_that_lies_on_it(self):
        profile = sets(material__clay__su="{surface=500,gradient=400}", time__end=0.5, output__interval=0.05, numerics__transfer='"flip"')
        lowest = 500 + 400 * (4 - 0.0625) / math.cos(BETA)
        for bed in ("nodes", "surface"):
            rows = self.interface(f"on-{bed}", *profile, *sets(numerics__bed=f'"{bed}"'))[1]
            for _, force in rows[2:]:
                self.assertAlmostEqual(force / (0.5 * lowest), 1, delta=0.01)
        ended = call("check", self.folder / "scene.toml", *profile)
        self.assertIn("contact    structure.wall-y-min: 0.5 of the soil's own su, as it is at the time\n", ended.out)

    def test_soil_of_one_su_is_that_number_to_the_bit(self):
        short = sets(material__clay__su=2000, time__end=0.3, output__fields='["velocity"]')
        expected = summary(self.interface("number", *short, su=2000.0)[0])["state_hash"]
        self.assertEqual(summary(self.interface("soil", *short)[0])["state_hash"], expected)
        self.assertNotEqual(summary(self.interface("weaker", *short, su=1990.0)[0])["state_hash"], expected)

    def test_an_interface_follows_softening_and_rate_on_any_ranks_and_after_a_restart(self):
        keys = sets(material__clay__su="{surface=100,gradient=150}", material__clay__sensitivity=4, material__clay__xi95=0.01, time__end=1.5, output__fields='["velocity", "strength", "su"]')
        lowest = 100 + 150 * (4 - 0.0625) / math.cos(BETA)
        at_nodes = self.interface("nodes", *keys, *sets(numerics__bed='"nodes"'), alpha=1.0)[1]
        self.assertGreater(max(force for _, force in at_nodes), 0.4 * lowest)
        self.assertAlmostEqual(at_nodes[-1][1] / (0.25 * lowest), 1, delta=0.01, msg="remoulded")
        whole, rows = self.interface("whole", *keys, alpha=1.0)  # slips before its lowest row has lost all
        self.assertLess(rows[-1][1], 0.9 * max(force for _, force in rows))
        if (strength := strength_of_lowest_row(whole)) is not None:
            self.assertAlmostEqual(rows[-1][1] / strength, 1, delta=0.01)
        expected = summary(whole)["state_hash"]
        for ranks in (2, 3):
            self.assertEqual(summary(self.interface(f"on-{ranks}", *keys, *sets(balance__partitioner="shuffle"), alpha=1.0, ranks=ranks)[0])["state_hash"], expected)
        again = self.run_scene(self.folder / "scene.toml", "again", *keys, "--restart", checkpoints(whole)[0], ranks=2)
        self.assertEqual(summary(again)["state_hash"], expected)
        hard = sets(material__clay__sensitivity=1, output__fields='["su"]', output__structure_interval=0.02, time__end=0.5)
        rate = sets(material__clay__rate_log=0.2, material__clay__rate_reference=0.001)
        slow, fast = (max(force for _, force in self.interface(name, *keys, *hard, *more, alpha=1.0)[1]) for name, more in (("slow", ()), ("fast", rate)))
        self.assertAlmostEqual(slow / lowest, 1, delta=0.01)
        self.assertGreater(fast, 1.1 * slow)  # while the soil beside it still shears

    def test_interfaces_that_cannot_follow_are_refused(self):
        text = slope().replace('kind = "no-slip"', 'kind = "undrained"\nalpha = 0.5\nsu = "clay"')
        self.assertIn('must be a number [Pa] or "soil"', self.refused(text))
        sand = text[:text.index('law = "tresca"')] + SAND.replace("PHI", "30.0") + "0.0\n" + text[text.index("[[body]]"):]
        line = self.refused(sand.replace(', "su"', "").replace('"clay"\nfriction', '"soil"').replace('su = "clay"', 'su = "soil"'))
        self.assertIn('wall.y-min.su = "soil" beside body.slope of law "drucker-prager" (such soil has no undrained strength)', line)

    def test_several_properties_over_depth_give_one_answer_on_any_ranks_and_after_a_restart(self):
        self.scene = self.write(slope(0.9))
        keys = sets(time__end=1.5, material__clay__young="{surface=5e5,gradient=2e5}", material__clay__density="{depth=[1,2],value=[1500,1700]}",
                    output__fields='["su", "young", "initial_density"]')
        expected = self.hash_of("whole", *keys)
        for ranks in (2, 4):
            self.assertEqual(self.hash_of(f"on-{ranks}", *keys, *sets(balance__partitioner="shuffle"), ranks=ranks), expected)
        self.assertEqual(self.hash_of("again", *keys, "--restart", checkpoints(self.folder / "whole")[0], ranks=3), expected)
        line = self.assert_one_problem(call("run", self.scene, "--output", self.folder / "other", "--restart", checkpoints(self.folder / "whole")[0], *keys,
                                            *sets(material__clay__young__gradient=3e5)))
        self.assertRegex(line, r"material\.clay\.young\.gradient is 300000(\.0)? and was 200000")

    def test_rasters_of_strength_cover_what_they_are_for(self):
        scene = valley.SCENE.replace('law = "drucker-prager"', 'law = "tresca"').replace("friction_angle = 25.0", 'su = { surface = "su.asc", gradient = 500.0 }')
        self.write(valley.grid(), "valley.asc")
        self.write(valley.AREA, "area.csv")
        self.write(valley.grid(at=lambda x, y: 1000 + 100 * y), "su.asc")
        run = self.run_scene(self.write(scene), "raster", *sets(time__end=0.1, output__fields='["su"]'))
        self.assertEqual(summary(run)["ended_by"], "end")
        self.write(valley.grid(at=lambda x, y: 1000 if y > 5 else -9999), "su.asc")
        self.assertRegex(self.refused(scene), r"material\.debris\.su is not known at \(.*\) in release\.scar \(the raster has no data there\)")
        self.write(valley.grid(at=lambda x, y: 1000 * (y - 6)), "su.asc")
        self.assertRegex(self.refused(scene), r"material\.debris\.su is -.* in release\.scar \(must be > 0\)")
        self.assertIn("no such file", self.refused(scene.replace("su.asc", "none.asc")))


if __name__ == "__main__":
    moraine.main()
