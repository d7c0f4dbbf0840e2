"""What a run says when its answer is no longer to be trusted."""
import moraine
from moraine import SMALL_SCENE, call, checkpoints, sets, summary

# A block that is driven into a wall as fast as sound in it: its volume halves, and no step is at fault.
CRUSHED = SMALL_SCENE.replace('material = "jelly"', 'material = "jelly"\nvelocity = [0.0, -60.0]').replace(
    "poisson = 0.3", "poisson = 0.45").replace("young = 1.0e5", "young = 1.0e6")


class Health(moraine.ProgramTest):
    def test_a_crushed_volume_is_said_once_and_stands_in_the_summary(self):
        directory = self.folder / "crushed"
        ended = call("run", self.write(CRUSHED), "--output", directory,
                     *sets(output__interval=0.002, time__end=0.03), ranks=2)
        self.assertEqual(ended.code, 0, ended)
        said = [line for line in ended.lines if line.startswith("Warning:")]
        self.assertIn("may flow at Mach 0.98", said[0])  # the scene itself, before it runs
        hurt = [line for line in said if "changed its volume" in line]
        self.assertEqual(len(hurt), 1, ended)
        self.assertRegex(hurt[0], r"at step \d+ \(t = [\d.]+ s\) a particle at \([\d., ]+\) m .*\. Try .*\?")
        found = [w for w in summary(directory)["warnings"] if w["problem"] == "volume"]
        self.assertEqual(len(found), 1)
        self.assertGreater(found[0]["amount"], 0.693)
        self.assertEqual(len(found[0]["place_m"]), 2)

    def test_a_restart_remembers_what_was_said(self):
        scene, keys = self.write(CRUSHED), {"output__interval": 0.002}
        whole = self.run_scene(scene, "whole", *sets(time__end=0.03, output__checkpoint_interval=0.02, **keys))
        last = checkpoints(whole)[-1]
        directory = self.folder / "on"
        ended = call("run", scene, "--restart", last, "--output", directory, *sets(time__end=0.03, **keys), ranks=1)
        self.assertEqual(ended.code, 0, ended)
        self.assertNotIn("changed its volume", ended.err)
        self.assertEqual(summary(directory)["warnings"], summary(whole)["warnings"])

    def test_a_sound_run_warns_of_nothing(self):
        found = summary(self.run_scene(self.write(SMALL_SCENE), "sound"))["warnings"]
        self.assertEqual([warning for warning in found if warning["problem"] != "scene"], [])  # which check says, too


if __name__ == "__main__":
    moraine.main()
