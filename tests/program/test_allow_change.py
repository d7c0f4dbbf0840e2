"""--allow-change: a restart that changes a strength or the damping says so, is the same on any ranks, and nothing else may change."""
import moraine
from moraine import call, checkpoints, sets, summary

# A bank of sand that stands, 250 particles.
BANK = """\
dimensions = 2
gravity = [0.0, -9.81]
[domain]
min = [0.0, 0.0]
max = [2.0, 1.0]
cell = 0.1
[time]
end = 0.2
[numerics]
damping = 0.7
[output]
interval = 0.1
checkpoint_interval = 0.1
[[material]]
name = "sand"
law = "drucker-prager"
density = 2000.0
young = 1.0e6
poisson = 0.3
friction_angle = 40.0
cohesion = 2.0e3
[[body]]
name = "bank"
material = "sand"
shape = "box"
min = [0.0, 0.0]
max = [0.9, 0.7]
[[wall]]
face = "x-min"
kind = "free-slip"
[[wall]]
face = "y-min"
kind = "friction"
friction = 0.8
"""
WEAK = ("--set", "material.sand.cohesion=100.0", "--set", "numerics.damping=0.0")
ALLOWED = ("--allow-change", "material.sand.cohesion", "--allow-change", "numerics.damping")
LONGER = ("--set", "time.end=0.4")


class AllowChange(moraine.ProgramTest):
    def setUp(self):
        super().setUp()
        self.scene = self.write(BANK)
        self.settled = self.run_scene(self.scene, "settled", ranks=2)
        self.checkpoint = checkpoints(self.settled)[-1]

    def restart(self, name, *words, ranks=None):
        return call("run", self.scene, "--restart", self.checkpoint, "--output", self.folder / name, "--quiet", *words, ranks=ranks)

    def test_values_that_stay_leave_the_bits(self):
        for name, words in (("plain", LONGER), ("allowed", (*LONGER, *ALLOWED))):
            self.assertEqual(self.restart(name, *words).code, 0)
        plain, allowed = (summary(self.folder / name) for name in ("plain", "allowed"))
        self.assertEqual(plain["state_hash"], allowed["state_hash"])
        self.assertNotIn("changes", allowed)

    def test_a_change_that_is_not_allowed_is_refused_and_named(self):
        for ranks in (None, 3):
            line = self.assert_one_problem(self.restart("no", *WEAK, *ALLOWED[2:], ranks=ranks))
            self.assertIn("material.sand.cohesion is 100 and was 2000", line)
            self.assertIn("or say --allow-change material.sand.cohesion?", line)
        self.assertIn("young", self.assert_one_problem(self.restart("no", "--set", "material.sand.young=2e6", *ALLOWED)))
        for words, says in ((("--allow-change", "domain.cell"), "strengths of laws"), (("--allow-change", "material.sand.cohesiv"), "Did you mean"),
                            (("--allow-change", "material.sand.young"), "material.sand.cohesion")):
            self.assertIn(says, self.assert_one_problem(self.restart("no", *words, ranks=2)))
        self.assertIn("--restart", self.assert_one_problem(call("run", self.scene, "--output", self.folder / "no", *ALLOWED)))
        self.assertFalse((self.folder / "no").exists())

    def test_changes_are_taken_recorded_and_the_same_on_any_ranks(self):
        hashes = set()
        for ranks in (None, 2, 3, 4):
            ended = self.restart(f"weak-{ranks}", *LONGER, *WEAK, *ALLOWED, ranks=ranks)
            self.assertEqual(ended.code, 0, ended)
            found = summary(self.folder / f"weak-{ranks}")
            hashes.add(found["state_hash"])
        self.assertEqual(len(hashes), 1)
        self.assertEqual(self.restart("strong", *LONGER).code, 0)
        self.assertNotIn(summary(self.folder / "strong")["state_hash"], hashes)
        told = {change["key"]: (change["was"], change["is"]) for change in found["changes"]}
        self.assertEqual(told, {"numerics.damping": ("0.7", "0"), "material.sand.cohesion": ("2000", "100")})
        self.assertAlmostEqual(found["changes"][0]["time_s"], 0.2, delta=0.01)

    def test_what_goes_on_from_a_changed_run_needs_no_leave_and_remembers(self):
        weak = self.folder / "weak"
        self.assertEqual(self.restart("weak", *LONGER, *WEAK, *ALLOWED).code, 0)
        whole = summary(weak)
        for ranks in (None, 3):
            ended = call("run", self.scene, "--restart", checkpoints(weak)[0], "--output", self.folder / f"on-{ranks}", "--quiet", *LONGER, *WEAK, ranks=ranks)
            self.assertEqual(ended.code, 0, ended)
            on = summary(self.folder / f"on-{ranks}")
            self.assertEqual((on["state_hash"], on["changes"]), (whole["state_hash"], whole["changes"]))

    def test_rest_begins_again_with_a_change(self):
        rest = ("--set", "time.stop=rest", "--set", "time.end=10")
        settled = self.run_scene(self.scene, "rest", *rest, *sets(output__checkpoint_interval=0.05))
        self.assertEqual(summary(settled)["ended_by"], "rest")
        self.checkpoint = checkpoints(settled)[-1]
        self.assertEqual(self.restart("on", *rest, *WEAK, *ALLOWED).code, 0)
        went = summary(self.folder / "on")["simulated_time_s"] - summary(settled)["simulated_time_s"]
        self.assertGreater(went, 3 * 2 * (0.1 / 9.81) ** 0.5 - 0.05)  # three intervals


if __name__ == "__main__":
    moraine.main()
