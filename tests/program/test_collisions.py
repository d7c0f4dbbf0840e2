"""Structures that meet: among soil, one answer on any number of ranks and after a restart, a scene, and words for wrong ones."""
import moraine
from moraine import INPUTS, SMALL_SCENE, call, checkpoints, sets, summary, table
from test_turning import leaning

# A block of jelly lands on a plank on two posts of different kinds, beside a ball that rolls off a ramp against a wall.
SCENE = SMALL_SCENE.replace('kind = "none"', 'kind = "no-slip"').replace("end = 0.1", "end = 0.3") + """
[output]
structure_interval = 0.02
[[structure]]
name = "plank"
shape = "box"
min = [0.8, 0.3]
max = [2.4, 0.4]
contact = { law = "coulomb", friction = 0.4 }
collision = { friction = 0.4 }
motion = { kind = "free", density = 900.0, turns = true }
[[structure]]
name = "post"
shape = "polygon"
points = [[1.0, 0.0], [1.2, 0.0], [1.1, 0.3]]
[[structure]]
name = "stone"
shape = "sphere"
center = [2.0, 0.15]
radius = 0.15
collision = { friction = 0.6, restitution = 0.2 }
motion = { kind = "free", density = 2000.0 }
[[structure]]
name = "ball"
shape = "sphere"
center = [0.21, 1.0]
radius = 0.2
collision = { friction = 0.5, restitution = 0.5 }
motion = { kind = "free", density = 2000.0, turns = true, velocity = [-1.0, 0.0], angular_velocity = [2.0] }
[[structure]]
name = "ramp"
shape = "plane"
point = [0.0, 0.45]
normal = [0.4, 1.0]
clear = true
motion = { kind = "velocity", velocity = [0.0, -0.1] }
"""
FREE = 'collision = { friction = 0.5 }\nmotion = { kind = "free", mass = 1.0 }\n'
BALL = '[[structure]]\nname = "ball"\nshape = "sphere"\ncenter = [3.0, 0.8]\nradius = 0.1\n'
BLOCK = '[[structure]]\nname = "block"\nshape = "box"\nmin = [2.5, 1.2]\nmax = [2.8, 1.5]\n'
ROD = '[[structure]]\nname = "rod"\nshape = "capsule"\nfrom = [2.5, 0.8]\nto = [2.8, 0.8]\nradius = 0.05\n'
HOOK = '[[structure]]\nname = "hook"\nshape = "polygon"\npoints = [[2.5, 0.0], [3.5, 0.0], [3.5, 0.5], [3.4, 0.1], [2.5, 0.1]]\n'
CUT = '[[stage]]\nname = "one"\nuntil = 0.05\n[[stage]]\nname = "two"\nset = { "wall.y-min.kind" = "open" }\n'


class Collisions(moraine.ProgramTest):
    def test_state_and_records_are_the_same_on_1_to_4_ranks_under_any_owner(self):
        scene = self.write(SCENE)
        for bed in ("nodes", "surface"):
            one = self.run_scene(scene, f"one-{bed}", *sets(numerics__bed=bed))
            rows = table(one, "structures.csv")
            self.assertGreater(rows[-5]["displacement_y_m"], -0.05)  # the plank, on its post and stone
            self.assertGreater(max(row["velocity_x_m_s"] for row in rows if row["structure"] == "ball"), 0.2)  # back from the wall
            for ranks in (2, 3, 4):
                many = self.run_scene(scene, f"{bed}-{ranks}", "--partitioner", "shuffle",
                                      *sets(numerics__bed=bed, balance__trigger="every", balance__interval=7), ranks=ranks)
                self.assertEqual(summary(many)["state_hash"], summary(one)["state_hash"])
                self.assertEqual(table(many, "structures.csv"), rows)

    def test_a_restart_goes_on_with_what_they_give_each_other(self):
        whole = self.run_scene(self.write(SCENE), "whole", *sets(output__checkpoint_interval=0.1))
        again = self.run_scene(self.write(SCENE), "again", "--restart", checkpoints(whole)[1], ranks=2)
        self.assertEqual(summary(again)["state_hash"], summary(whole)["state_hash"])
        rows = table(again, "structures.csv")
        self.assertEqual(rows, table(whole, "structures.csv")[-len(rows):])

    def test_single_precision_moves_what_meets_no_soil_alike(self):
        one, other = (table(self.run_scene(self.write(SCENE.replace("cfl = 0.5", "dt = 2e-4")), name, *sets(numerics__precision=name)), "structures.csv")
                      for name in ("double", "single"))
        balls = [[row for row in rows if row["structure"] == "ball"] for rows in (one, other)]
        self.assertEqual(*balls)

    def test_a_barrier_falls_over_its_kerb_unless_it_is_heavy(self):
        falls, stands = (table(self.run_scene(INPUTS / "falling_barrier.toml", name, "--no-particles", *sets(structure__barrier__motion__density=density)), "structures.csv")
                         for name, density in (("falls", 2400), ("stands", 20000)))
        barrier = [[row for row in rows if row["structure"] == "barrier"] for rows in (falls, stands)]
        self.assertAlmostEqual(barrier[0][-1]["angle_rad"], -1.74, delta=0.1)  # over its kerb
        self.assertGreater(min(row["displacement_y_m"] for row in barrier[0]), -0.61)  # no corner of it is in the ground
        self.assertLess(max(abs(row["angle_rad"]) for row in barrier[1]), 0.02)

    def test_a_flow_carries_a_boulder_that_rolls_on_the_ground(self):
        scene = (INPUTS / "falling_barrier.toml").read_text()
        boulder = ('[[structure]]\nname = "boulder"\nshape = "sphere"\ncenter = [5.0, 0.4]\nradius = 0.4\ncontact = { law = "coulomb", friction = 0.3 }\n'
                   'collision = { friction = 0.5 }\nmotion = { kind = "free", density = 2400.0, turns = true }\n')
        scene = scene[:scene.index("[[structure]]")] + boulder + scene[scene.index("[[wall]]"):]
        rows = table(self.run_scene(self.write(scene), "boulder", "--no-particles", *sets(time__end=2.5)), "structures.csv")
        self.assertGreater(rows[-1]["displacement_x_m"], 2)
        self.assertLess(rows[-1]["angle_rad"], -2)
        self.assertGreater(min(row["displacement_y_m"] for row in rows), -1e-5)

    def test_a_pile_stands_on_a_bed_that_bears_all_of_it(self):
        pile = "[[structure]]\nname = ".join([""] + [
            f'"box-{k}"\nshape = "box"\nmin = [1.5, {0.3 + 0.3 * k:.1f}]\nmax = [2.1, {0.6 + 0.3 * k:.1f}]\ncontact = {{ law = "coulomb", friction = 0.9 }}\n'
            'collision = { friction = 0.5 }\nmotion = { kind = "free", density = 2000.0, turns = true }\n' for k in range(4)])
        for bed in ("nodes", "surface"):
            scene = leaning(0, 1.0, bed, "").partition("[[structure]]")[0] + pile
            last = table(self.run_scene(self.write(scene), f"pile-{bed}", "--no-particles"), "structures.csv")[-4:]
            self.assertAlmostEqual(last[0]["force_y_N"], 4 * 0.18 * 2000 * 9.81, delta=0.01 * 14126)
            for row in last:
                self.assertAlmostEqual(row["displacement_y_m"], last[0]["displacement_y_m"], delta=1e-7)
                self.assertLess(abs(row["angle_rad"]) + abs(row["displacement_x_m"]), 1e-4)

    def test_what_cannot_meet_is_refused(self):
        device = call("run", self.write(SMALL_SCENE + BALL + FREE), "--device", "cuda")
        self.assertIn("structure.ball, which meets others (devices do not have it)", self.assert_one_problem(device))
        cases = {
            BALL + "collision = { friction = 0.5 }\n": "no free structure has it",
            BALL + 'collision = { }\nmotion = { kind = "free", mass = 1.0 }\n': "friction",
            BALL + FREE.replace("0.5", "-0.5"): "friction",
            ROD + FREE: "structure.rod cannot meet others",
            ROD + BLOCK + FREE: "structure.block cannot meet structure.rod (cylinders and capsules are met by spheres alone)",
            HOOK + BALL + FREE: "structure.hook has a corner that points inwards",
            BALL.replace("0.8]", "0.09]") + FREE: "structure.ball begins inside wall.y-min (they overlap by 0.01 m",
            BLOCK + BALL.replace("3.0, 0.8", "2.89, 1.3") + FREE: "begins inside structure.",
            BALL + FREE + CUT: "stage.two changes wall.y-min",
        }
        for text, said in cases.items():
            with self.subTest(said):
                self.assertIn(said, self.assert_one_problem(call("check", self.write(SMALL_SCENE + text))))
        for text in (BALL + FREE, ROD + BALL + FREE, ROD + BLOCK + FREE.replace('collision = { friction = 0.5 }\n', "")):
            report = call("check", self.write(SMALL_SCENE + text))
            self.assertEqual(report.code, 0, report)
        self.assertIn("structure  ball: sphere, free, smooth, meets others", call("check", self.write(SMALL_SCENE + BALL + FREE)).out)


if __name__ == "__main__":
    moraine.main()
