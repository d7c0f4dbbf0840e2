"""Surfaces that act where they are (numerics.bed = "surface"): at any place between nodes and at an angle, on any ranks."""
import math
import unittest

import moraine
from moraine import call, checkpoints, sets, summary, table

GRAVITY, CELL = 9.81, 0.1
OPEN = "".join(f'[[wall]]\nface = "{face}"\nkind = "open"\n' for face in ("x-min", "x-max", "y-min", "y-max"))
FLUID = """[[material]]
name = "soil"
law = "newtonian"
density = 1000.0
young = 1e6
poisson = 0.49
viscosity = 10.0
volumetric = "grid"
"""


def scene(gravity, size, material, body, bed, contact, end, walls, periodic="", numerics=""):
    return f"""dimensions = 2
gravity = [{gravity[0]!r}, {gravity[1]!r}]
[domain]
min = [0.0, 0.0]
max = [{size[0]}, {size[1]}]
cell = {CELL}
{periodic}
[time]
end = {end}
[numerics]
bed = "surface"
{numerics}
[output]
interval = 0.1
{material}
{body}
[[structure]]
name = "bed"
shape = "plane"
{bed}
contact = {{ {contact} }}
{walls}"""


class Beds(moraine.ProgramTest):
    def film(self, offset):
        """A Newtonian film of 3 cells at its exact profile, over a plane that stands `offset` cells over nodes."""
        slope, depth, low = math.radians(10), 3 * CELL, (2 + offset) * CELL
        pull = GRAVITY * math.sin(slope)
        rows = "".join(f"{(i + 0.5) * CELL / 2!r},{low + v!r},{1000 * pull * (depth * v - v * v / 2) / 10!r},2.5\n"
                       for v in ((j + 0.5) * CELL / 2 for j in range(6)) for i in range(24))
        (self.folder / "film.csv").write_text("x,y,vx,mass\n" + rows)
        body = f'[[body]]\nname = "film"\nmaterial = "soil"\nshape = "table"\nfile = "{self.folder}/film.csv"\n'
        return scene((pull, -GRAVITY * math.cos(slope)), (1.2, 1.2), FLUID, body, f"point = [0.0, {low!r}]\nnormal = [0.0, 1.0]",
                     'law = "rough"', 1.2, "".join(f'[[wall]]\nface = "{f}"\nkind = "open"\n' for f in ("y-min", "y-max")),
                     'periodic = ["x"]', 'transfer = "aflip"\nflip = 1.0\nsubsteps = "auto"'), 1000 * pull * depth ** 2 / 30

    def test_a_film_has_its_speed_wherever_the_bed_lies_between_nodes(self):
        for offset in (0.3, 0.5):
            with self.subTest(offset=offset):
                text, exact = self.film(offset)
                rows = [row for row in table(self.run_scene(self.write(text), f"film{offset}"), "history.csv") if row["time_s"] > 0.59]
                speed = sum(row["momentum_x_kg_m_s"] for row in rows) / len(rows) / rows[0]["mass_kg"]
                self.assertAlmostEqual(speed / exact, 1, delta=0.06)

    def lake(self, rise):
        rows = "".join(f"{x!r},{y!r},2.5\n" for j in range(20) for i in range(40)
                       for x, y in [((i + 0.5) * CELL / 2, (j + 0.5) * CELL / 2)] if y > 0.33 + rise * (x - 1))
        (self.folder / "lake.csv").write_text("x,y,mass\n" + rows)
        body = (f'[[body]]\nname = "lake"\nmaterial = "soil"\nshape = "table"\nfile = "{self.folder}/lake.csv"\n'
                "geostatic = { surface = 1.0 }\n")
        walls = OPEN.replace('x-min"\nkind = "open"', 'x-min"\nkind = "free-slip"').replace('x-max"\nkind = "open"', 'x-max"\nkind = "free-slip"')
        return scene((0.0, -GRAVITY), (2.0, 1.6), FLUID, body, f"point = [1.0, 0.33]\nnormal = [{-rise}, 1.0]", 'law = "smooth"', 2.0, walls,
                     numerics='substeps = "auto"')

    def test_still_water_stays_on_an_inclined_bed(self):
        rows = table(self.run_scene(self.write(self.lake(0.1)), "lake"), "history.csv")
        self.assertAlmostEqual((rows[0]["centre_y_m"] - rows[-1]["centre_y_m"]) / CELL, 0, delta=0.01)

    def test_still_water_rests_in_the_corner_of_a_wall_and_a_slope_of_one(self):
        """Elements threw light nodes out of such a bed, and the water followed."""
        low = 2.3 * CELL
        rows = "".join(f"{x!r},{y!r},2.5\n" for j in range(20) for i in range(40)
                       for x, y in [((i + 0.5) * CELL / 2, (j + 0.5) * CELL / 2)] if y > low + x)
        (self.folder / "corner.csv").write_text("x,y,mass\n" + rows)
        body = (f'[[body]]\nname = "lake"\nmaterial = "soil"\nshape = "table"\nfile = "{self.folder}/corner.csv"\n'
                "geostatic = { surface = 1.0 }\n")
        text = scene((0.0, -GRAVITY), (2.0, 1.6), FLUID + "pressure_smoothing = 0.22\nparticle_shifting = 0.2\n", body,
                     f"point = [0.0, {low!r}]\nnormal = [-1.0, 1.0]", 'law = "smooth"', 4.0,
                     OPEN.replace('x-min"\nkind = "open"', 'x-min"\nkind = "free-slip"'), numerics='substeps = "auto"')
        history = table(self.run_scene(self.write(text), "corner"), "history.csv")
        self.assertLess(max(row["kinetic_J"] for row in history), 5e-4 * GRAVITY * CELL * history[0]["mass_kg"])

    def dam(self, offset, fluid, law, end, numerics=""):
        """A dam, 10 cells high and 20 wide, on a plane that stands `offset` cells over nodes."""
        low = (2 + offset) * CELL
        rows = "".join(f"{3 + (i + 0.5) * CELL / 2!r},{low + (j + 0.5) * CELL / 2!r},2.5\n" for j in range(20) for i in range(40))
        (self.folder / "dam.csv").write_text("x,y,mass\n" + rows)
        body = f'[[body]]\nname = "dam"\nmaterial = "soil"\nshape = "table"\nfile = "{self.folder}/dam.csv"\n'
        text = scene((0.0, -GRAVITY), (8.0, 2.0), fluid, body, f"point = [0.0, {low!r}]\nnormal = [0.0, 1.0]", f'law = "{law}"', end, OPEN,
                     numerics=numerics)
        return text, low

    def test_a_front_goes_as_far_wherever_the_bed_lies_between_nodes(self):
        """A film at a front gets as thin as it may: nothing holds nodes that stand over the surface or in it."""
        heights = []
        for offset in (0, 0.3, 0.5, 0.8):
            text, low = self.dam(offset, FLUID.replace('volumetric = "grid"\n', ""), "smooth", 0.6)
            heights.append(table(self.run_scene(self.write(text), f"dam{offset}"), "history.csv")[-1]["centre_y_m"] - low)
        for height in heights:
            self.assertAlmostEqual(height / heights[0], 1, delta=0.01, msg=heights)

    def test_no_air_stays_under_a_front(self):
        """A cell at the bed with soil in its upper half alone is not full: as if it were, a front slid on its lower half."""
        ways = []
        for offset in (0, 0.5):
            text, _ = self.dam(offset, FLUID.replace("viscosity = 10.0", "viscosity = 100.0"), "rough", 0.9, 'substeps = "auto"')
            ways.append(table(self.run_scene(self.write(text), f"front{offset}"), "history.csv")[-1]["max_x_m"] - 5)
        self.assertAlmostEqual(ways[1] / ways[0], 1, delta=0.04, msg=ways)

    def test_fluids_take_surfaces_and_cells_by_themselves(self):
        keys = {"": "aflip, usl; structures act on their surfaces; soil: pressures on cells, smoothed, shifted",
                'bed = "nodes"': "apic, usl; structures act at nodes"}
        fluid = FLUID.replace('volumetric = "grid"\n', "")
        for key, method in keys.items():
            text, _ = self.dam(0.5, fluid, "rough", 0.9)
            checked = call("check", self.write(text.replace('bed = "surface"', key)))
            self.assertIn(f"method     quadratic shapes, {method}\n", checked.out)

    def test_clay_takes_them_but_beside_friction(self):
        """With pressures on cells a wave of them grew on such beds, and held clay by up to five times its friction."""
        clay = '[[material]]\nname = "soil"\nlaw = "von-mises"\ndensity = 1000.0\nyoung = 1e6\npoisson = 0.49\nsu = 5e3\n'
        cells, nodes = "aflip, usl; structures act on their surfaces; soil: pressures on cells", "apic, usl; structures act at nodes"
        for contact, method in (('"rough"', cells), ('"coulomb", friction = 0.2', nodes), ('"voellmy", friction = 0.2, xi = 500.0', nodes)):
            text, _ = self.dam(0.5, clay, "rough", 0.9)
            checked = call("check", self.write(text.replace('bed = "surface"', "").replace('"rough"', contact)))
            self.assertIn(f"method     quadratic shapes, {method}\n", checked.out)

    def test_a_front_by_the_default_goes_as_far_wherever_the_bed_lies(self):
        """At nodes, with pressures of particles, these go 1.6, 2.1 and 1.1 heights."""
        ways = []
        for offset in (0, 0.3, 0.5):
            text, _ = self.dam(offset, FLUID.replace('volumetric = "grid"\n', ""), "rough", 0.9)
            ways.append(table(self.run_scene(self.write(text.replace('bed = "surface"', "")), f"by-default{offset}"), "history.csv")[-1]["max_x_m"] - 5)
        self.assertLess(max(ways) / min(ways), 1.06, ways)

    def test_an_elastic_body_in_a_bowl_comes_to_rest(self):
        """Where a surface bends several slaves follow one node; each by its own answer, they gave more energy than the body had height."""
        (self.folder / "bowl.csv").write_text("x,z\n" + "".join(f"{x / 2},{2 + (x / 2 - 10) ** 2 / 100!r}\n" for x in range(41)))
        text = """dimensions = 2
gravity = [0.0, -9.81]
[domain]
min = [0.0, 0.0]
max = [20.0, 8.0]
cell = 0.5
[time]
end = 20.0
[numerics]
bed = "surface"
[terrain]
profile = "bowl.csv"
clear = true
contact = { law = "coulomb", friction = 0.4 }
[output]
energy_budget = "on"
[[material]]
name = "rubber"
law = "neo-hookean"
density = 1800.0
young = 2e6
poisson = 0.3
[[body]]
name = "block"
material = "rubber"
shape = "box"
min = [6.0, 1.0]
max = [14.0, 4.5]
"""
        last = table(self.run_scene(self.write(text), "bowl"), "history.csv")[-1]
        self.assertGreater(last["slave_J"], 0)
        self.assertLess(math.sqrt(2 * last["kinetic_J"] / last["mass_kg"]), 1e-3)

    def test_one_particle_slides_as_due(self):
        material = '[[material]]\nname = "soil"\nlaw = "linear-elastic"\ndensity = 1000.0\nyoung = 1e6\npoisson = 0.3\n'
        (self.folder / "one.csv").write_text("x,y,mass\n2.013,1.337,2.5\n")
        body = f'[[body]]\nname = "one"\nmaterial = "soil"\nshape = "table"\nfile = "{self.folder}/one.csv"\n'
        for angle, friction in ((0, 0.1), (7, 0.1), (20, 0.1), (20, 0.3)):
            with self.subTest(angle=angle, friction=friction):
                t, slope = math.radians(angle), math.radians(20)
                along, normal = (math.cos(t), math.sin(t)), (-math.sin(t), math.cos(t))
                pull, press = GRAVITY * math.sin(slope), GRAVITY * math.cos(slope)
                gravity = [pull * a - press * n for a, n in zip(along, normal)]
                foot = [x - 0.025 * n for x, n in zip((2.013, 1.337), normal)]  # a gap of nothing under half its side
                text = scene(gravity, (6.0, 4.0), material, body, f"point = {foot}\nnormal = {list(normal)}",
                             f'law = "coulomb", friction = {friction}', 0.5, OPEN)
                last = table(self.run_scene(self.write(text), f"one{angle}-{friction}"), "history.csv")[-1]
                speed = [last[f"momentum_{a}_kg_m_s"] / last["mass_kg"] for a in "xy"]
                drag = pull - sum(v * a for v, a in zip(speed, along)) / last["time_s"]
                self.assertAlmostEqual(drag / (friction * press), 1, delta=0.03)

    def test_a_disk_rolls(self):
        """Of rings of particles, 16 cells over its radius: one sweep of elements stops its mean motion, and it would sink in and stick."""
        radius, low, end, slope = 16 * CELL, 2.3 * CELL, 0.75, math.radians(10)
        rows, mass, inertia = [], 0.0, 0.0
        for k in range(32):
            count, r = max(1, round(2 * math.pi * (k + 0.5))), (k + 0.5) * CELL / 2
            each = 1000 * math.pi * (2 * k + 1) * CELL * CELL / 4 / count
            mass, inertia = mass + each * count, inertia + each * count * r * r
            turns = [2 * math.pi * (i + 0.37 * k) / count for i in range(count)]
            rows += [f"{2.15 + r * math.cos(t)!r},{low + radius + r * math.sin(t)!r},{each!r}\n" for t in turns]
        (self.folder / "disk.csv").write_text("x,y,mass\n" + "".join(rows))
        body = f'[[body]]\nname = "disk"\nmaterial = "soil"\nshape = "table"\nfile = "{self.folder}/disk.csv"\n'
        material = '[[material]]\nname = "soil"\nlaw = "linear-elastic"\ndensity = 1000.0\nyoung = 4e7\npoisson = 0.3\n'
        text = scene((GRAVITY * math.sin(slope), -GRAVITY * math.cos(slope)), (4.8, 4.0), material, body,
                     f"point = [0.0, {low!r}]\nnormal = [0.0, 1.0]", 'law = "coulomb", friction = 0.3', end, OPEN)
        history = table(self.run_scene(self.write(text), "disk"), "history.csv")
        first, last = history[0], history[-1]
        due = 0.5 * GRAVITY * math.sin(slope) / (1 + inertia / (mass * radius ** 2)) * last["time_s"] ** 2
        self.assertAlmostEqual((last["centre_x_m"] - first["centre_x_m"]) / due, 1, delta=0.03)
        self.assertLess(first["centre_y_m"] - last["centre_y_m"], 0.15 * CELL)

    def slab(self, angle, law, slope=20):
        """An elastic block of 5 cells by 30 on a bed turned by `angle`, gravity inclined to it."""
        t, tilt = math.radians(angle), math.radians(slope)
        along, normal = (math.cos(t), math.sin(t)), (-math.sin(t), math.cos(t))
        pull, press = GRAVITY * math.sin(tilt), GRAVITY * math.cos(tilt)
        gravity = [pull * a - press * n for a, n in zip(along, normal)]
        foot = (1.017, 0.533)
        corners = [[f + u * a + v * n for f, a, n in zip(foot, along, normal)] for u, v in ((0, 0), (3, 0), (3, 0.5), (0, 0.5))]
        material = '[[material]]\nname = "soil"\nlaw = "linear-elastic"\ndensity = 1000.0\nyoung = 1e6\npoisson = 0.3\n'
        body = f'[[body]]\nname = "slab"\nmaterial = "soil"\nshape = "polygon"\npoints = {corners}\nvelocity = [{2 * along[0]!r}, {2 * along[1]!r}]\n'
        return scene(gravity, (6.0, 4.0), material, body, f"point = [{foot[0]}, {foot[1]}]\nnormal = [{normal[0]!r}, {normal[1]!r}]", law, 0.4, OPEN), along

    def test_friction_brakes_as_it_should_at_an_angle(self):
        for angle in (0, 20):
            with self.subTest(angle=angle):
                text, along = self.slab(angle, 'law = "coulomb", friction = 0.3')
                rows = table(self.run_scene(self.write(text), f"slab{angle}"), "history.csv")
                mass, time = rows[-1]["mass_kg"], rows[-1]["time_s"]
                speed = sum(rows[-1][f"momentum_{a}_kg_m_s"] * c for a, c in zip("xy", along)) / mass
                drag = 2 + GRAVITY * math.sin(math.radians(20)) * time - speed
                self.assertAlmostEqual(drag / (0.3 * GRAVITY * math.cos(math.radians(20)) * time), 1, delta=0.02)
                for axis in "xy":
                    self.assertAlmostEqual(rows[-1][f"momentum_error_{axis}_kg_m_s"], 0, delta=1e-9 * mass)

    def test_one_answer_on_any_ranks_and_after_a_restart(self):
        text = self.lake(0.4).replace('law = "smooth"', 'law = "coulomb", friction = 0.3')
        path = self.write(text)
        keys = sets(time__end=0.3, output__energy_budget="on")
        one = self.run_scene(path, "one", *keys, *sets(output__checkpoint_interval=0.15))
        for ranks in (2, 3, 4):
            many = self.run_scene(path, f"r{ranks}", "--partitioner", "shuffle", *keys, *sets(balance__trigger="every", balance__interval=7), ranks=ranks)
            self.assertEqual(summary(many)["state_hash"], summary(one)["state_hash"])
            self.assertEqual(summary(many)["structures"], summary(one)["structures"])
            self.assertEqual((many / "history.csv").read_text(), (one / "history.csv").read_text())
        again = self.run_scene(path, "again", "--restart", checkpoints(one)[0], *keys, ranks=2)
        self.assertEqual(summary(again)["state_hash"], summary(one)["state_hash"])
        self.assertEqual((again / "history.csv").read_text().splitlines()[-1], (one / "history.csv").read_text().splitlines()[-1])
        off = self.run_scene(path, "off", *sets(time__end=0.3))
        self.assertEqual(summary(off)["state_hash"], summary(one)["state_hash"])

    def test_one_answer_over_terrain_in_3_d(self):
        """Cut cells of blocks without soil need nodes that only another rank's soil touches."""
        hashes = {summary(self.run_scene(moraine.INPUTS / "valley.toml", f"valley{ranks}", "--partitioner", "shuffle", "--no-particles",
                                         *sets(time__end=0.1, numerics__bed="surface"), ranks=ranks))["state_hash"] for ranks in (1, 2, 3)}
        self.assertEqual(len(hashes), 1, hashes)

    def test_a_restart_knows_where_a_structure_has_moved(self):
        """What surfaces cut is kept from step to step, but not where one moves."""
        scene, keys = moraine.INPUTS / "pipe_penetration.toml", ("--no-particles", *sets(time__end=0.06, numerics__bed="surface"))
        one = self.run_scene(scene, "moves", *keys, *sets(output__checkpoint_interval=0.03))
        again = self.run_scene(scene, "moved", "--restart", checkpoints(one)[0], *keys)
        self.assertEqual(summary(again)["state_hash"], summary(one)["state_hash"])

    def test_a_symmetric_jet_on_a_symmetric_wedge_pushes_it_straight(self):
        body = '[[body]]\nname = "jet"\nmaterial = "soil"\nshape = "box"\nmin = [1.6, 1.8]\nmax = [2.4, 2.6]\nvelocity = [0.0, -2.0]\n'
        for turn in range(3):
            corners = [[1.0, 0.6], [2.0, 1.6], [3.0, 0.6]]
            text = scene((0.0, -GRAVITY), (4.0, 4.0), FLUID, body, "", 'law = "coulomb", friction = 0.3', 0.2, OPEN, numerics='substeps = "auto"')
            text = text.replace('shape = "plane"', f'shape = "polygon"\npoints = {corners[turn:] + corners[:turn]}')
            last = table(self.run_scene(self.write(text), f"wedge{turn}"), "structures.csv")[-1]
            self.assertLess(last["impulse_y_N_s"], -1)
            self.assertAlmostEqual(last["impulse_x_N_s"] / last["impulse_y_N_s"], 0, delta=1e-10)

    def test_what_it_cannot_do_with_is_said(self):
        for numerics, words in (('shape = "cubic"', "quadratic"), ('stress_update = "musl"', "usl")):
            with self.subTest(numerics=numerics):
                text = self.slab(0, 'law = "smooth"')[0].replace('bed = "surface"', 'bed = "surface"\n' + numerics)
                ended = call("check", self.write(text))
                self.assertEqual(ended.code, 2, ended.err)
                self.assertIn(words, ended.err)


if __name__ == "__main__":
    moraine.main()
