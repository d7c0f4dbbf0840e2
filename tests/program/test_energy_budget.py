"""output.energy_budget: who took the energy that is unaccounted for. Cases in which each part is known, and one answer on any ranks and after a restart."""
import moraine
from moraine import call, checkpoints, sets, summary, table
from valley import SCENE, ValleyTest

PARTS = ("transfer_J", "shift_J", "wall_J", "contact_J", "damping_J", "lost_J")

HEAD = """\
dimensions = 2
[domain]
min = [0.0, 0.0]
max = [4.0, 2.0]
cell = 0.25
[time]
end = 0.1
[output]
energy_budget = "on"
"""
# Too soft for its stresses to matter where nothing but inertia shall.
SOFT = """\
[[material]]
name = "soft"
law = "linear-elastic"
density = 1000.0
young = 1.0e-6
poisson = 0.0
"""
FLUID = """\
[[material]]
name = "fluid"
law = "newtonian"
density = 1000.0
young = 3.0e4
poisson = 0.49
viscosity = 1.0
volumetric = "particle"
"""
GEL = """\
[[material]]
name = "gel"
law = "linear-elastic"
density = 1000.0
young = 2.0e5
poisson = 0.3
"""


def body(material, low, high, more="", per_cell=2):
    return (f'[[body]]\nname = "{material}"\nmaterial = "{material}"\nshape = "box"\nmin = {list(low)}\nmax = {list(high)}\n'
            f'particles_per_cell = [{per_cell}, {per_cell}]\n{more}')


def wall(face, kind):
    return f'[[wall]]\nface = "{face}"\nkind = "{kind}"\n'


def weight(g):
    return f"gravity = [0.0, {-g}]\n"


COLUMN = weight(9.81) + HEAD + FLUID + body("fluid", (0.0, 0.0), (1.0, 1.5)) + wall("x-min", "free-slip") + wall("x-max", "free-slip") + wall("y-min", "no-slip")
SURFACE = sets(numerics__bed="surface")
CURED = sets(numerics__transfer="apic", material__fluid__volumetric="grid", numerics__substeps=10, material__fluid__pressure_smoothing=0.22, material__fluid__particle_shifting=0.2)


def moved(last, first):
    """The energy that went from one kind to another, to measure others by."""
    return first["potential_J"] + first["kinetic_J"] - last["potential_J"] + last["kinetic_J"]


def rest(row):
    """What the parts leave of the unaccounted energy: the step's error in time."""
    return row["unaccounted_J"] - sum(row[part] for part in PARTS)


class EnergyBudget(moraine.ProgramTest):
    def history(self, text, *words, output="run", **how):
        return table(self.run_scene(self.write(text), output, *words, **how), "history.csv")

    def close(self, row, **known):
        """Of one row: the parts that are named, and zero for the others. In units of `scale`."""
        scale = known.pop("scale")
        for part in PARTS:
            self.assertAlmostEqual(row[part] / scale, known.get(part, 0) / scale, delta=1e-11, msg=f"{part} of {row}")

    def test_a_block_adrift_loses_nothing(self):
        block = HEAD + SOFT + body("soft", (0.5, 0.5), (1.0, 1.0), "velocity = [2.0, 1.0]\n") + wall("x-min", "no-slip")
        for transfer in ("flip", "pic", "apic", "tpic", "aflip"):
            with self.subTest(transfer=transfer):
                last = self.history(block, *sets(numerics__transfer=transfer), output=transfer)[-1]
                self.close(last, scale=last["kinetic_J"])
                self.assertAlmostEqual(last["unaccounted_J"] / last["kinetic_J"], 0, delta=1e-11)

    def test_a_wall_takes_the_normal_motion_of_a_lone_particles_node(self):
        """One step, hats: the node on the wall bears w = 3/4 of the particle, 1/4 h away, and stops; FLIP gives the particle (1 - w) v."""
        lone = HEAD + SOFT + body("soft", (0.0, 0.5), (0.125, 0.625), "velocity = [-2.0, 1.0]\n")
        keys = sets(numerics__shape="linear", numerics__transfer="flip", time__dt=1e-3, time__end=1e-3)
        for kind, speeds in (("free-slip", 4), ("no-slip", 5)):
            with self.subTest(kind=kind):
                first, last = self.history(lone + wall("x-min", kind), *keys, output=kind)
                stopped = first["kinetic_J"] * speeds / 5
                self.assertGreater(stopped, 1)
                self.close(last, scale=stopped, wall_J=0.75 * stopped, transfer_J=0.75 * 0.25 * stopped)
                self.assertAlmostEqual(rest(last) / stopped, 0, delta=1e-9)

    def test_a_structure_takes_the_motion_that_a_wall_would(self):
        stopped = HEAD + SOFT + body("soft", (0.75, 0.5), (1.25, 1.0), "velocity = [-2.0, 0.0]\n")
        box = '[[structure]]\nname = "post"\nshape = "box"\nmin = [0.25, 0.0]\nmax = [0.75, 2.0]\n'
        first, last = self.history(stopped + box, *sets(time__dt=1e-3, time__end=2e-3))
        took = first["kinetic_J"] - last["kinetic_J"]
        self.assertGreater(took, 0.05 * first["kinetic_J"])
        self.assertGreater(last["contact_J"], 0.3 * took)
        self.assertAlmostEqual((last["contact_J"] + last["transfer_J"]) / took, 1, delta=1e-9)
        self.assertEqual(last["wall_J"], 0)

    def test_a_structure_that_pushes_is_not_charged_for_its_work(self):
        """A block that is soft and a post that moves: what contact takes is less than the work that the post does, which unaccounted_J leaves out."""
        pushed = HEAD + SOFT + body("soft", (1.0, 0.5), (1.5, 1.0))
        post = '[[structure]]\nname = "post"\nshape = "box"\nmin = [0.25, 0.0]\nmax = [1.0, 2.0]\nmotion = { kind = "velocity", velocity = [1.0, 0.0] }\n'
        first, last = self.history(pushed + post, *sets(time__dt=1e-3, time__end=2e-3))
        work = -summary(self.folder / "run")["structures"]["post"]["work_J"]
        self.assertGreater(work, 1)
        self.assertAlmostEqual((work - last["kinetic_J"]) / work, (last["contact_J"] + last["transfer_J"]) / work, delta=1e-9)
        self.assertGreater(last["contact_J"], 0.1 * work)
        self.assertLess(last["contact_J"], 0.9 * work)

    def test_damping_takes_its_share_of_a_fall(self):
        falls = weight(10.0) + HEAD + SOFT + body("soft", (1.0, 1.0), (1.5, 1.5))
        first, last = self.history(falls, *sets(time__dt=1e-2, time__end=1e-2, numerics__damping=0.2))
        impulse, speed = 0.2 * last["mass_kg"] * 10.0 * 1e-2, 0.8 * 10.0 * 1e-2
        self.close(last, scale=moved(last, first), damping_J=0.5 * impulse * speed)

    def test_what_is_left_of_a_free_fall_is_the_steps_error_in_time(self):
        """Places go by the velocity of the step's end: m g^2 dt t / 2 too far."""
        falls = weight(10.0) + HEAD + SOFT + body("soft", (1.0, 1.0), (1.5, 1.5))
        for dt in (1e-3, 5e-4):
            with self.subTest(dt=dt):
                first, last = self.history(falls, *sets(time__dt=dt, time__end=0.05), output=str(dt))
                error = 0.5 * last["mass_kg"] * 10.0**2 * dt * last["time_s"]
                self.close(last, scale=moved(last, first))
                self.assertAlmostEqual(rest(last) / error, 1, delta=1e-9)

    def test_what_is_left_falls_with_the_step(self):
        """A block of gel that sags on a rough floor and swings. FLIP, whose losses do not grow as steps get shorter."""
        sags = weight(9.81) + HEAD + GEL + body("gel", (0.5, 0.0), (1.5, 1.5)) + wall("y-min", "no-slip")
        left = []
        for share in (1, 0.5, 0.25):
            first, *_, last = self.history(sags, *sets(time__dt=4e-3 * share, time__end=0.2, numerics__transfer="flip"), output=str(share))
            left.append(abs(rest(last)) / moved(last, first))
            self.assertGreater(last["transfer_J"], 0)
            self.assertGreater(last["wall_J"], 0)
        self.assertLess(left[0], 0.01)
        self.assertLess(left[1], 0.75 * left[0])
        self.assertLess(left[2], 0.75 * left[1])

    def test_a_wall_that_bears_weight_takes_nothing(self):
        """Soil at rest, its stresses those of its weight: in each step the wall stops what the forces gave."""
        rests = weight(9.81) + HEAD + GEL + body("gel", (0.0, 0.0), (4.0, 1.0), "geostatic = { surface = 1.0, k0 = 1.0 }\n") + wall("x-min", "free-slip") + wall("x-max", "free-slip") + wall("y-min", "free-slip")
        last = self.history(rests, *sets(time__end=0.2))[-1]
        self.assertGreater(last["wall_impulse_y_kg_m_s"], 0.19 * 9.81 * last["mass_kg"])
        self.assertAlmostEqual(last["wall_J"] / last["potential_J"], 0, delta=1e-6)

    def test_a_shift_moves_mass_and_nothing_else_moves_places_without_velocities(self):
        """Upwards where it makes space, downwards where it fills the bed."""
        for words in (("numerics__stress_update", "musl"), ("numerics__stress_update", "usf"), ("numerics__transfer", "aflip"), ("numerics__shape", "cubic")):
            with self.subTest(words=words):
                first, *_, last = self.history(COLUMN, *sets(**dict([words]), time__end=0.3), output=words[1])
                self.assertAlmostEqual(last["shift_J"] / moved(last, first), 0, delta=1e-10)
        still = sets(material__fluid__particle_shifting=0)
        first, *_, last = self.history(COLUMN, *CURED, *still, *sets(time__end=0.5), output="still")
        self.assertAlmostEqual(last["shift_J"] / moved(last, first), 0, delta=1e-10)
        first, *_, last = self.history(COLUMN, *CURED, *sets(time__end=0.5), output="shifted")
        self.assertGreater(last["shift_J"], 1e-3 * moved(last, first))
        floor = '[[structure]]\nname = "floor"\nshape = "box"\nmin = [-1.0, -1.0]\nmax = [5.0, 0.0]\n'  # not a bed that is filled
        first, *_, last = self.history(COLUMN + floor, *CURED, *sets(time__end=0.5), output="floor")
        self.assertLess(last["shift_J"], -1e-4 * moved(last, first))
        first, *_, last = self.history(COLUMN, *sets(time__end=0.3, numerics__precision="single"), output="single")
        self.assertAlmostEqual(last["shift_J"] / moved(last, first), 0, delta=1e-4)

    def test_what_is_put_out_of_a_structure_is_contact_and_no_shift(self):
        """A floor between nodes: fluid that lands on it goes in deeper than it may stand."""
        floor = '[[structure]]\nname = "floor"\nshape = "box"\nmin = [-1.0, -1.0]\nmax = [5.0, 0.3]\n'
        falls = weight(9.81) + HEAD + FLUID + body("fluid", (0.0, 0.3), (1.0, 1.75)) + wall("x-min", "free-slip") + wall("x-max", "free-slip")
        first, *_, last = self.history(falls + floor, *sets(time__end=0.6))
        self.assertAlmostEqual(last["shift_J"] / moved(last, first), 0, delta=1e-10)
        self.assertLess(abs(rest(last)), 0.01 * moved(last, first))

    def test_a_surface_takes_the_motion_that_it_stops(self):
        """A post whose face cuts cells in the middle."""
        for words in ("", "motion = { kind = \"velocity\", velocity = [1.0, 0.0] }\n"):
            with self.subTest(motion=words):
                block = HEAD + SOFT + body("soft", (1.0, 0.5), (1.5, 1.0), "" if words else "velocity = [-2.0, 0.0]\n")
                post = '[[structure]]\nname = "post"\nshape = "box"\nmin = [0.25, -1.0]\nmax = [0.97, 3.0]\n' + words
                first, *_, last = self.history(block + post, *SURFACE, *sets(time__dt=1e-3, time__end=0.1), output="moves" if words else "stands")
                work = -summary(self.folder / ("moves" if words else "stands"))["structures"]["post"]["work_J"]
                took = first["kinetic_J"] + work - last["kinetic_J"]
                self.assertGreater(took, 1)
                self.assertGreater(last["contact_J"], 0.1 * took)
                self.assertAlmostEqual((last["contact_J"] + last["slave_J"] + last["transfer_J"]) / took, 1, delta=1e-9)

    def test_a_surface_takes_what_friction_does_along_the_way(self):
        """A slab that slides on a plane between nodes: mu times its weight, times its way."""
        gel = GEL.replace("2.0e5", "2.0e6")
        bed = '[[structure]]\nname = "bed"\nshape = "plane"\npoint = [0.0, 0.33]\nnormal = [0.0, 1.0]\ncontact = { law = "coulomb", friction = 0.2 }\n'
        slides = weight(9.81) + HEAD + gel + body("gel", (0.5, 0.33), (1.5, 0.83), "velocity = [3.0, 0.0]\ngeostatic = { surface = 0.83, k0 = 0.4 }\n") + bed
        first, *_, last = self.history(slides, *SURFACE, *sets(time__end=0.4))
        way = last["centre_x_m"] - first["centre_x_m"]
        due = 0.2 * last["mass_kg"] * 9.81 * way
        self.assertAlmostEqual(last["contact_J"] / due, 1, delta=0.03)
        self.assertLess(abs(rest(last)), 0.01 * due)

    def test_the_budget_closes_beside_surfaces_as_it_does_at_walls(self):
        """A column that falls apart on a smooth bed between nodes, with pressures on cells: what is left of the unaccounted energy."""
        fluid = weight(9.81) + HEAD + FLUID + wall("x-min", "free-slip") + wall("x-max", "free-slip")
        keys = sets(material__fluid__volumetric="grid", numerics__substeps=10, time__end=0.6)
        bed = '[[structure]]\nname = "bed"\nshape = "plane"\npoint = [0.0, 0.33]\nnormal = [0.0, 1.0]\ncontact = { law = "smooth" }\n'
        left = {}
        for name, text, words in (("wall", body("fluid", (0.0, 0.0), (1.0, 1.5)) + wall("y-min", "free-slip"), ()),
                                  ("surface", body("fluid", (0.0, 0.33), (1.0, 1.83)) + bed, SURFACE)):
            first, *_, last = self.history(fluid + text, *keys, *words, output=name)
            left[name] = rest(last) / moved(last, first)
        self.assertLess(abs(left["surface"]), abs(left["wall"]) + 0.002, left)
        self.assertNotEqual(last["pressure_J"], 0)

    def test_what_leaves_takes_its_motion_and_its_height(self):
        rain = weight(10.0) + HEAD + SOFT + body("soft", (1.0, 0.25), (2.0, 0.75), "velocity = [0.5, -2.0]\n") + wall("y-min", "open")
        for shape in ("quadratic", "linear"):  # the end is inside a block, or between two
            with self.subTest(shape=shape):
                first, *_, last = self.history(rain, *sets(time__dt=1e-3, time__end=0.5, numerics__shape=shape), output=shape)
                self.assertEqual(last["particles"], 0)
                took = last["lost_J"]
                self.assertAlmostEqual((took + rest(last)) / (first["kinetic_J"] + first["potential_J"]), 1, delta=1e-9)
                for part in ("shift_J", "wall_J", "transfer_J"):
                    self.assertAlmostEqual(last[part] / took, 0, delta=1e-9)

    def test_it_is_the_same_on_any_ranks_and_partitioners_and_after_a_restart(self):
        post = '[[structure]]\nname = "post"\nshape = "box"\nmin = [2.0, 0.0]\nmax = [2.3, 0.4]\n'
        scene = self.write(COLUMN.replace('kind = "free-slip"\n[[wall]]\nface = "y-min"', 'kind = "open"\n[[wall]]\nface = "y-min"') + post)
        keys = (*CURED, *sets(time__end=1.0, output__interval=0.25, domain__max="[3.0, 2.0]"))
        alone = self.run_scene(scene, "alone", *keys, *sets(output__checkpoint_interval=0.4))
        last = table(alone, "history.csv")[-1]
        for part in ("transfer_J", "wall_J", "contact_J", "lost_J"):
            self.assertGreater(last[part], 0, part)
        self.assertNotEqual(last["shift_J"], 0)
        for ranks, words in ((2, ()), (3, ("--partitioner", "shuffle")), (4, ("--partitioner", "slabs"))):
            with self.subTest(ranks=ranks):
                found = self.run_scene(scene, f"on-{ranks}", *keys, *words, *sets(balance__trigger="every", balance__interval=10), ranks=ranks)
                self.assertEqual((found / "history.csv").read_text(), (alone / "history.csv").read_text())
        for k, checkpoint in enumerate(checkpoints(alone)):
            with self.subTest(checkpoint=checkpoint):
                found = self.run_scene(scene, f"from-{k}", *keys, "--restart", checkpoint, ranks=1 + k % 3)
                self.assertEqual((found / "history.csv").read_text().splitlines()[-1], (alone / "history.csv").read_text().splitlines()[-1])
        off = self.run_scene(scene, "off", *keys, *sets(output__energy_budget="off", output__checkpoint_interval=0.4))
        self.assertEqual(summary(off)["state_hash"], summary(alone)["state_hash"])
        self.assertEqual(set(last) - set(table(off, "history.csv")[-1]), set(PARTS))
        said = self.assert_one_problem(call("run", scene, *keys, "--quiet", "--restart", checkpoints(off)[0], "--output", self.folder / "late"))
        self.assertIn("has no energy budget", said)

    def test_it_is_refused_where_it_cannot_be(self):
        def said(*words, text=COLUMN):
            return self.assert_one_problem(call("check", self.write(text), *words))

        self.assertIn('output.energy_budget = "on" with transfer = "fmpm"', said(*sets(numerics__transfer="fmpm")))
        self.assertIn('output.energy_budget = "on" with numerics.sleep = "on"', said(*sets(numerics__sleep="on")))
        slope = weight(9.81) + HEAD.replace("cell = 0.25", 'cell = 0.25\nperiodic = ["y"]') + FLUID + body("fluid", (0.0, 0.0), (1.0, 1.5))
        self.assertIn('output.energy_budget = "on" with gravity along y, which is periodic', said(text=slope))
        self.assertIn("energy_budget", said(*sets(output__energy_budget="yes")))


class OverTerrain(ValleyTest):
    def test_what_comes_in_is_no_shift_and_what_the_ground_takes_is_contact(self):
        self.write("time,discharge,speed\n0.1,0,2\n0.3,8,4\n0.9,4,3\n", "torrent.csv")
        self.write(SCENE +
                   '[[inflow]]\nname = "torrent"\nmaterial = "debris"\nline = [[1.0, 7.5], [1.0, 4.5]]\ntable = "torrent.csv"\n')
        on = sets(output__energy_budget="on")
        alone = self.run_scene(self.scene, "alone", *on)
        rows = table(alone, "history.csv")
        self.assertGreater(rows[-1]["particles"], rows[0]["particles"])
        for row in rows[1:]:
            scale = abs(row["contact_J"])
            self.assertGreater(row["contact_J"], 0)
            self.assertAlmostEqual(row["shift_J"] / scale, 0, delta=1e-9)
            self.assertGreater(row["transfer_J"], 0)
        many = self.run_scene(self.scene, "many", "--partitioner", "shuffle", *on, *sets(balance__trigger="every", balance__interval=20), ranks=3)
        self.assertEqual((many / "history.csv").read_text(), (alone / "history.csv").read_text())


if __name__ == "__main__":
    moraine.main()
