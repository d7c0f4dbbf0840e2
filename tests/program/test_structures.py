"""Rigid structures as a user meets them: one answer on any number of ranks and after a restart, and words for wrong ones."""
import moraine
from moraine import SMALL_SCENE, call, checkpoints, sets, summary, table

# A block of jelly lands on a slope and on a heavy disk that is free; a rod sweeps over it.
SCENE = SMALL_SCENE.replace('kind = "no-slip"', 'kind = "none"') + """
[output]
structure_interval = 0.02
[[structure]]
name = "slope"
shape = "plane"
point = [1.0, 0.45]
normal = [0.1, 1.0]
contact = { law = "coulomb", friction = 0.3 }
[[structure]]
name = "disk"
shape = "sphere"
center = [2.1, 0.8]
radius = 0.3
clear = true
contact = { law = "rough" }
motion = { kind = "free", mass = 400.0 }
[[structure]]
name = "rod"
shape = "capsule"
from = [0.8, 1.7]
to = [1.4, 1.6]
radius = 0.08
motion = { kind = "velocity", velocity = [0.5, -3.0], ramp = 0.02 }
"""
BAD = """
[[structure]]
name = "pipe"
"""


# An elastic block on a slope of 1:2 whose surface runs through nodes, and sand on a level floor that does.
SLIDE = """
dimensions = 2
gravity = [0.0, -9.81]
[domain]
min = [0.0, -1.0]
max = [4.0, 5.0]
cell = 0.05
[time]
end = 0.2
[[material]]
name = "rubber"
law = "linear-elastic"
density = 1000.0
young = 1.0e6
poisson = 0.2
[[body]]
name = "block"
material = "rubber"
shape = "polygon"
points = [[0.71643618, 1.644017978], [1.253092495, 1.375689821], [1.387256573, 1.644017978], [0.8506002586, 1.912346135]]
[[structure]]
name = "slope"
STRUCTURE
""" + "".join(f'[[wall]]\nface = "{face}"\nkind = "open"\n' for face in ("x-min", "x-max", "y-min", "y-max"))
FLOOR = """
dimensions = 2
gravity = [0.0, -9.81]
[domain]
min = [0.0, 0.0]
max = [6.0, 1.6]
cell = 0.04
[time]
end = 0.3
[[material]]
name = "sand"
law = "drucker-prager"
density = 1600.0
young = 1.0e6
poisson = 0.3
friction_angle = 30.0
[[body]]
name = "column"
material = "sand"
shape = "box"
min = [1.6, 0.32]
max = [2.0, 0.8]
[[structure]]
name = "floor"
STRUCTURE
""" + "".join(f'[[wall]]\nface = "{face}"\nkind = "open"\n' for face in ("x-min", "x-max", "y-min", "y-max"))


class Structures(moraine.ProgramTest):
    def centre(self, scene, structure, name):
        """Of mass, at the end."""
        last = table(self.run_scene(self.write(scene.replace("STRUCTURE", structure)), name), "history.csv")[-1]
        return last["centre_x_m"], last["centre_y_m"]

    def test_a_block_slides_on_the_edge_of_a_polygon_as_on_a_plane(self):
        plane = 'shape = "plane"\npoint = [0.0, 2.0]\nnormal = [0.5, 1.0]\n'
        polygon = 'shape = "polygon"\npoints = [[0.0, 2.0], [4.0, 0.0], [4.0, -1.0], [0.0, -1.0]]\n'
        for law in ('law = "smooth"', 'law = "coulomb"\nfriction = 0.2'):
            contact = f"[structure.contact]\n{law}\n"
            on_plane = self.centre(SLIDE, plane + contact, f"plane{len(law)}")
            on_polygon = self.centre(SLIDE, polygon + contact, f"polygon{len(law)}")
            for one, other in zip(on_plane, on_polygon):
                self.assertAlmostEqual(one, other, delta=1e-5)

    def test_a_level_floor_of_a_polygon_does_not_push_sideways(self):
        smooth = '[structure.contact]\nlaw = "smooth"\n'
        for turn in (0, 2):
            corners = [[0.12, 0.2], [3.88, 0.2], [3.88, 0.32], [0.12, 0.32]]
            corners = corners[turn:] + corners[:turn]
            x, _ = self.centre(FLOOR, f'shape = "polygon"\npoints = {corners}\n' + smooth, f"floor{turn}")
            self.assertAlmostEqual(x, 1.8, delta=1e-6)

    def test_forces_and_state_are_the_same_on_1_to_4_ranks_under_any_owner(self):
        scene = self.write(SCENE)
        one = self.run_scene(scene, "one")
        rows = table(one, "structures.csv")
        self.assertEqual(len(rows), 3 * 5)
        for name in ("slope", "disk", "rod"):
            mine = [row for row in rows if row["structure"] == name]
            self.assertLess(mine[-1]["impulse_y_N_s"] * (1 if name != "rod" else -1), -1, mine)
        for ranks in (2, 3, 4):
            many = self.run_scene(scene, f"r{ranks}", "--partitioner", "shuffle",
                                  *sets(balance__trigger="every", balance__interval=7), ranks=ranks)
            self.assertEqual(summary(many)["state_hash"], summary(one)["state_hash"])
            self.assertEqual(table(many, "structures.csv"), rows)
            self.assertEqual(summary(many)["structures"], summary(one)["structures"])

    def test_a_restart_goes_on_with_the_structures_as_they_were(self):
        scene = self.write(SCENE)
        whole = self.run_scene(scene, "whole", *sets(output__checkpoint_interval=0.05))
        again = self.run_scene(scene, "again", "--restart", checkpoints(whole)[0], ranks=2)
        self.assertEqual(summary(again)["state_hash"], summary(whole)["state_hash"])
        rows = table(again, "structures.csv")
        self.assertEqual(rows, table(whole, "structures.csv")[-len(rows):])

    def test_what_the_soil_lost_is_what_the_structures_felt(self):
        directory = self.run_scene(self.write(SCENE), "balance")
        found = summary(directory)
        weight = found["mass_kg"] * 9.81 * 0.1
        self.assertLess(max(map(abs, found["momentum_error"])), 1e-12 * weight)

    def test_the_summary_says_of_each_structure_what_it_felt_and_did(self):
        directory = self.run_scene(self.write(SCENE), "told", *sets(output__structure_interval=1e-9))
        found, rows = summary(directory), table(directory, "structures.csv")
        self.assertEqual(list(found["structures"]), ["slope", "disk", "rod"])
        for name, said in found["structures"].items():
            mine = [row for row in rows if row["structure"] == name]
            for key, unit in (("displacement", "m"), ("velocity", "m_s"), ("impulse", "N_s")):
                self.assertEqual(said[f"{key}_{unit}"], [mine[-1][f"{key}_{a}_{unit}"] for a in "xy"])
            for force, impulse in zip(said["mean_force_N"], said["impulse_N_s"]):
                self.assertAlmostEqual(force * found["simulated_time_s"], impulse)
            self.assertEqual(len(mine), found["steps"])  # a row a step
            times = [0] + [row["time_s"] for row in mine]
            work = sum((times[k + 1] - times[k]) * (row["force_x_N"] * row["velocity_x_m_s"] + row["force_y_N"] * row["velocity_y_m_s"])
                       for k, row in enumerate(mine))
            self.assertAlmostEqual(said["work_J"], work, delta=1e-9 * (1 + abs(work)))
        self.assertEqual(found["structures"]["slope"]["work_J"], 0)  # it stands
        self.assertLess(found["structures"]["rod"]["work_J"], -1)  # it drives the soil
        self.assertNotIn("structures", summary(self.run_scene(self.write(SMALL_SCENE), "none")))

    def test_a_structure_in_the_soil_is_refused_or_leaves_its_particles_out(self):
        inside = SMALL_SCENE + BAD + 'shape = "sphere"\ncenter = [1.5, 1.0]\nradius = 0.2\n'
        said = self.assert_one_problem(call("check", self.write(inside)))
        self.assertIn("scene.toml:29: structure.pipe begins inside body.block", said)
        report = call("check", self.write(inside + "clear = true\n"))
        self.assertEqual(report.code, 0, report)
        self.assertIn("particles  52", report.out)
        self.assertIn("structure  pipe: sphere, fixed, smooth", report.out)

    def test_wrong_structures_are_named_with_line_and_cause(self):
        cases = {
            'shape = "ball"': "scene.toml:31: structure.pipe.shape",
            'shape = "sphere"\ncenter = [3.0, 1.0]': "structure.pipe.radius is missing",
            'shape = "sphere"\ncenter = [3.0, 1.0]\nradius = -1.0': "scene.toml:33: structure.pipe.radius = -1",
            'shape = "sphere"\ncenter = [3.0, 1.0]\nradius = 0.1\nnormal = [0.0, 1.0]': "scene.toml:34: structure.pipe.normal",
            'shape = "plane"\npoint = [0.0, 0.1]\nnormal = [0.0, 0.0]': "scene.toml:33: structure.pipe.normal is zero",
            'shape = "cylinder"\nfrom = [3.0, 1.0]\nto = [3.5, 1.0]\nradius = 0.1': "the scene has 2 dimensions",
            'shape = "capsule"\nfrom = [3.0, 1.0]\nto = [3.0, 1.0]\nradius = 0.1': "structure.pipe has no length",
            'shape = "box"\nmin = [3.0, 1.0]\nmax = [2.9, 1.2]': "scene.toml:33: structure.pipe has no length along x",
            'shape = "polygon"\npoints = [[3.0, 1.0], [3.5, 1.5], [3.5, 1.0], [3.0, 1.5]]': "structure.pipe crosses itself",
            'shape = "polygon"\npoints = [[3.0, 1.0], [3.5, 1.5], [3.5, 1.0]]\nz = [0.0, 1.0]': "structure.pipe.z is not used",
            'shape = "plane"\npoint = [0.0, 0.1]\nnormal = [0.0, 1.0]\ncontact = { law = "coulomb" }': "friction is missing",
            'shape = "plane"\npoint = [0.0, 0.1]\nnormal = [0.0, 1.0]\nmotion = { kind = "free" }': "mass is missing",
            'shape = "plane"\npoint = [0.0, 0.1]\nnormal = [0.0, 1.0]\nclear = 1': "scene.toml:34: structure.pipe.clear",
            'shape = "plane"\npoint = [0.0, 0.1]\nnormal = [0.0, 1.0]\n'
            'motion = { kind = "table", velocity = [1.0, 0.0], times = [0.0, 1.0], factors = [1.0] }': "2 times and 1 factors",
            'shape = "plane"\npoint = [0.0, 0.1]\nnormal = [0.0, 1.0]\n'
            'motion = { kind = "table", velocity = [1.0, 0.0], times = [1.0, 0.0], factors = [1.0, 1.0] }': "do not rise",
        }
        for text, said in cases.items():
            ended = call("check", self.write(SMALL_SCENE + BAD + text + "\n"))
            self.assertIn(said, self.assert_one_problem(ended))


if __name__ == "__main__":
    moraine.main()
