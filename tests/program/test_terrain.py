"""Terrain as a user meets it: one answer on any number of ranks and after a restart, maps that hold what flowed, and
words for models, areas and maps that are wrong."""
import math

import moraine
from moraine import call, checkpoints, sets, summary

SCENE = """\
dimensions = 3
gravity = [0.0, 0.0, -9.81]
[domain]
min = [0.0, 0.0, 0.0]
max = [24.0, 12.0, 16.0]
cell = 0.5
[time]
end = 1.2
[terrain]
dem = "valley.asc"
contact = { law = "voellmy", friction = 0.2, xi = 500.0 }
[hazard]
cell = 1.0
threshold = 0.2
[[material]]
name = "debris"
law = "drucker-prager"
density = 1800.0
young = 1.0e6
poisson = 0.3
friction_angle = 25.0
[[release]]
name = "scar"
material = "debris"
area = "area.csv"
thickness = 1.0
"""
AREA = "x,y\n2,3\n6,3.5\n6.5,8\n4,9\n2,8.5\n"


def heights(x, y):
    """A chute that bends and runs out on a plain."""
    return 10 * max(0, 1 - x / 20) ** 2 + 1 + 0.05 * (y - 6 - math.sin(x / 4)) ** 2


def grid(columns=13, rows=7, side=2.0, at=heights):
    lines = [f"ncols {columns}", f"nrows {rows}", "xllcenter 0", "yllcenter 0", f"cellsize {side}", "NODATA_value -9999"]
    lines += [" ".join(f"{at(side * i, side * j):.6g}" for i in range(columns)) for j in reversed(range(rows))]
    return "\n".join(lines) + "\n"


def read_map(directory, name):
    lines = (directory / "maps" / f"{name}.asc").read_text().splitlines()
    return [[float(word) for word in line.split()] for line in lines[6:]]


def total(rows):
    return sum(sum(row) for row in rows)


class Terrain(moraine.ProgramTest):
    def setUp(self):
        super().setUp()
        self.write(grid(), "valley.asc")
        self.write(AREA, "area.csv")
        self.scene = self.write(SCENE)

    def run_scene(self, scene, output, *words, **more):
        return super().run_scene(scene, output, *words, "--device", "cpu", **more)

    def maps(self, directory):
        return {path.name: path.read_text() for path in sorted((directory / "maps").iterdir())}

    def test_state_and_maps_are_the_same_on_1_to_4_ranks_and_after_a_restart(self):
        one = self.run_scene(self.scene, "one", *sets(output__checkpoint_interval=0.5))
        self.assertEqual(len(self.maps(one)), 6)
        for ranks in (2, 3, 4):
            many = self.run_scene(self.scene, f"r{ranks}", "--partitioner", "shuffle",
                                  *sets(balance__trigger="every", balance__interval=20), ranks=ranks)
            self.assertEqual(summary(many)["state_hash"], summary(one)["state_hash"])
            self.assertEqual(self.maps(many), self.maps(one))
            self.assertEqual(summary(many)["structures"], summary(one)["structures"])
        again = self.run_scene(self.scene, "again", "--restart", checkpoints(one)[0], ranks=2)
        self.assertEqual(summary(again)["state_hash"], summary(one)["state_hash"])
        self.assertEqual(self.maps(again), self.maps(one))

    def test_the_maps_hold_what_flowed(self):
        directory = self.run_scene(self.scene, "run")
        found = summary(directory)
        start = self.run_scene(self.scene, "start", *sets(time__end=0))
        volume = total(read_map(start, "deposit"))
        self.assertAlmostEqual(volume, found["mass_kg"] / 1800, delta=1e-6 * volume)
        deepest, fastest = read_map(directory, "max_depth"), read_map(directory, "max_speed")
        arrival, deposit = read_map(directory, "arrival"), read_map(directory, "deposit")
        self.assertGreater(total(deposit), 0.9 * volume)
        reached = [(row, column) for row in range(12) for column in range(24) if arrival[row][column] >= 0]
        self.assertTrue(any(arrival[row][column] > 0.3 for row, column in reached))
        for row in range(12):
            for column in range(24):
                self.assertGreaterEqual(deepest[row][column], deposit[row][column])
                self.assertEqual((row, column) in reached, deepest[row][column] >= 0.2)
        top = max(max(row) for row in fastest)
        self.assertGreater(top, 1.0)
        self.assertLess(top, math.sqrt(2 * 9.81 * 11))

    def test_debris_stays_over_the_ground_and_leaves_by_open_sides(self):
        directory = self.run_scene(self.scene, "out", *sets(time__end=4, domain__max="[12.0, 12.0, 16.0]"))
        self.assertGreater(summary(directory)["lost_particles"], 50)

    def test_check_says_what_the_terrain_is(self):
        ended = call("check", self.scene, "--device", "cpu")
        self.assertEqual(ended.code, 0, ended)
        self.assertRegex(ended.out, r"terrain    13 x 7 heights, 2 m apart, from 1\S* to 1\d\S* m")
        self.assertRegex(ended.out, r"release    scar: \S+ m3, 2 cells thick \(4 and more resolve a flow\)")

    def refused(self, text, name="scene.toml"):
        self.write(text, name)
        return self.assert_one_problem(call("check", self.scene, "--device", "cpu"))

    def changed(self, old, new):
        self.assertIn(old, SCENE)
        return self.refused(SCENE.replace(old, new))

    def test_a_wrong_model_is_refused_with_place_and_remedy(self):
        self.assertIn("no such file", self.changed("valley.asc", "absent.asc"))
        self.assertIn("gdal_translate", self.changed("valley.asc", "valley.tif"))
        self.assertIn("terrain.dem is missing", self.changed('dem = "valley.asc"\n', ""))
        self.assertIn("terrain.profile is not used", self.changed('dem = "valley.asc"', 'profile = "valley.csv"'))
        self.assertIn("Did you mean terrain.contact.friction?", self.changed("friction = 0.2", "frction = 0.2"))
        self.assertIn("terrain.contact.xi is missing", self.changed(", xi = 500.0", ""))
        self.write(SCENE)
        self.assertIn("from -1 to 23 along x (the domain from 0 to 24)", self.refused(grid(12), "valley.asc"))
        holes = grid(at=lambda x, y: -9999 if x == 4 and y == 6 else heights(x, y))
        self.assertIn("no height at (4, 6)", self.refused(holes, "valley.asc"))
        self.assertIn("valley.asc:7: the height in row 1, column 2 = \"nan\"",
                      self.refused(grid(at=lambda x, y: math.nan if (x, y) == (2, 12) else 1), "valley.asc"))

    def test_a_wrong_release_is_refused_with_place_and_remedy(self):
        self.assertIn("less than a cell", self.changed("thickness = 1.0", "thickness = 0.3"))
        self.assertIn("release.scar.material", self.changed('material = "debris"', 'material = "mud"'))
        self.assertIn("release.scar without ground",
                      self.refused(SCENE.replace(SCENE[SCENE.index("[terrain]"):SCENE.index("[[material]]")], "")))
        self.write(SCENE)
        self.assertIn("has a corner at (30, 3)", self.refused(AREA.replace("6,3.5", "30,3"), "area.csv"))
        self.assertIn("crosses itself", self.refused("x,y\n2,3\n6,8\n6,3\n2,8\n", "area.csv"))

    def test_a_wrong_map_is_refused_with_place_and_remedy(self):
        self.assertIn("columns would hold single particles", self.changed("cell = 1.0", "cell = 0.2"))
        self.assertIn('hazard.maps has "max_sped"', self.changed("threshold = 0.2", 'maps = ["max_sped"]'))
        terrain = SCENE[SCENE.index("[terrain]"):SCENE.index("[hazard]")]
        self.assertIn("[hazard] without ground", self.refused(SCENE.replace(terrain, "")))


if __name__ == "__main__":
    moraine.main()
