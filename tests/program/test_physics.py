"""When the physics goes wrong the run ends with exit code 3, names the first particle at fault and keeps the last state."""
import re

import moraine
from moraine import SMALL_SCENE, call, sets, summary, table

INVERTED = SMALL_SCENE.replace("cfl = 0.5", "dt = 2.0e-2\n[numerics]\ntransfer = \"flip\"\nlight_nodes = \"free\"").replace("end = 0.1", "end = 10.0") \
    .replace("max = [2.0, 1.5]", "max = [2.0, 1.5]\nvelocity = [0.0, -5.0]")
OVERFLOWING = SMALL_SCENE.replace("-9.81", "1.0e300")
LEAVING = SMALL_SCENE.replace('"no-slip"', '"none"').replace("end = 0.1", "end = 1.0")


class PhysicsGoesWrong(moraine.ProgramTest):
    def fail(self, text, what, ranks):
        """Returns the message, the same on any number of ranks."""
        scene, directory = self.write(text), self.folder / f"out-{ranks}"
        ended = call("run", scene, "--output", directory, "--quiet", *sets(balance__partitioner="slabs"), ranks=ranks)
        line = self.assert_one_problem(ended, code=3)
        self.assertRegex(line, r"^moraine: step \d+: particle \d+ at \(\S+, \S+\) m ")
        self.assertIn(what, line)
        self.assert_last_state(directory, int(re.search(r"step (\d+)", line)[1]))
        return line

    def assert_last_state(self, directory, step):
        last = summary(directory)
        self.assertEqual(last["particles"], 64)
        self.assertIn(last["steps"], (step, step + 1))
        self.assertGreater(last["steps"], 0)
        self.assertEqual(table(directory, "history.csv")[-1]["step"], last["steps"])
        self.assertGreater((directory / "particles.vtkhdf").stat().st_size, 0)

    def test_a_particle_turned_inside_out_is_named(self):
        self.assertEqual(*(self.fail(INVERTED, "inside out", ranks) for ranks in (1, 3)))

    def test_a_velocity_that_is_not_a_number_is_named(self):
        self.assertEqual(*(self.fail(OVERFLOWING, "is not a number", ranks) for ranks in (1, 3)))

    def test_a_particle_that_leaves_a_closed_domain_is_named(self):
        messages = [self.fail(LEAVING, "left the closed domain", ranks) for ranks in (1, 3)]
        self.assertEqual(*messages)


if __name__ == "__main__":
    moraine.main()
