"""One answer, to the bit: on any number of ranks and threads, under any partitioner, and after a restart."""
import re

import moraine
from moraine import INPUTS, call, checkpoints, sets, summary

EVERY_10 = sets(balance__trigger="every", balance__interval=10)
STATIC = ("slabs", "slabs-initial", "cartesian")
DYNAMIC = ("morton", "hilbert", "equal-slabs", "rcb", "hsfc", "phg", "metis")

# A jittered block slides along an axis that closes on itself and falls through an open floor.
LEAKY_SCENE = """\
dimensions = 2
gravity = [0.0, -9.81]
[domain]
min = [0.0, 0.0]
max = [8.0, 4.0]
cell = 0.25
periodic = ["x"]
[time]
end = 0.3
[output]
interval = 0.1
[[material]]
name = "jelly"
law = "neo-hookean"
density = 1000.0
young = 1.0e5
poisson = 0.3
[[body]]
name = "block"
material = "jelly"
shape = "box"
min = [4.5, 0.0]
max = [8.0, 2.0]
seeding = "jittered"
velocity = [6.0, -4.0]
[[wall]]
face = "y-min"
kind = "open"
"""


def built(partitioner):
    """Some need a library that this program may have been built without: it says so, and runs nothing."""
    if partitioner not in built.known:
        ended = call("run", INPUTS / "first_scene.toml", "--partitioner", partitioner, "--output", "/dev/null")
        built.known[partitioner] = not re.search(r"balance\.partitioner = .* built without", ended.err)
    return built.known[partitioner]


built.known = {}


class SameAnswer(moraine.ProgramTest):
    def compare(self, scene, keys, cases):
        """Runs (ranks, partitioner, threads) with forced repartitions; returns the summaries."""
        runs = []
        self.sets_run = getattr(self, "sets_run", 0) + 1
        for ranks, partitioner, threads in cases:
            name = f"{self.sets_run}-{partitioner}-{ranks}-{threads}"
            directory = self.run_scene(scene, name, *EVERY_10, *keys, "--partitioner", partitioner, ranks=ranks,
                                       threads=threads)
            runs.append((name, directory, summary(directory)))
        _, first, expected = runs[0]
        for name, directory, found in runs:
            with self.subTest(name):
                self.assertEqual(found["state_hash"], expected["state_hash"])
                self.assertEqual(found["steps"], expected["steps"])
                self.assertEqual((directory / "history.csv").read_text(), (first / "history.csv").read_text())
                ranks, partitioner = found["ranks"], found["partitioner"]
                if ranks > 1 and partitioner == "shuffle":
                    self.assertGreater(found["migrated_particles"], 0)
                if ranks == 1 or partitioner in STATIC:
                    self.assertEqual(found["migrated_particles"], 0)
        return [found for _, _, found in runs]

    def migrated(self, summaries, partitioner):
        return sum(s["migrated_particles"] for s in summaries if s["partitioner"] == partitioner)

    def test_slurry_runout_in_double_precision(self):
        keys = sets(time__end=0.06 if moraine.SLOW else 0.2, output__interval=0.05)
        cases = [(1, "morton", 1), (1, "morton", 2), (2, "shuffle", 2)]
        cases += [(ranks, partitioner, 1) for ranks in (2, 3, 4) for partitioner in ("morton", "slabs", "shuffle")]
        found = self.compare(INPUTS / "slurry_runout.toml", keys, cases)
        self.assertEqual({s["precision"] for s in found}, {"double"})
        self.assertEqual([s["threads"] for s in found[:3]], [1, 2, 2])
        self.assertGreater(min(s["repartitions"] for s in found if s["partitioner"] == "shuffle"), 0)

    def test_slurry_runout_in_single_precision(self):
        keys = sets(time__end=0.06 if moraine.SLOW else 0.2, numerics__precision="single")
        cases = [(1, "morton", 1), (2, "slabs", 2), (3, "shuffle", 1), (4, "morton", 1)]
        found = self.compare(INPUTS / "slurry_runout.toml", keys, cases)
        self.assertEqual({s["precision"] for s in found}, {"single"})

    def test_slurry_runout_3d_in_both_precisions(self):
        keys = sets(domain__cell=0.4 if moraine.SLOW else 0.2, time__end=0.2)
        cases = [(1, "morton", 2), (2, "morton", 1), (3, "slabs", 1), (4, "shuffle", 1)]
        double = self.compare(INPUTS / "slurry_runout_3d.toml", keys, cases)
        keys += sets(numerics__precision="single")
        single = self.compare(INPUTS / "slurry_runout_3d.toml", keys, [(1, "morton", 1), (3, "shuffle", 1)])
        self.assertNotEqual(single[0]["state_hash"], double[0]["state_hash"])

    def test_slurry_runout_3d_under_every_partitioner(self):
        keys = sets(domain__cell=0.4, domain__max="[8.0, 8.0, 6.0]", time__end=0.1 if moraine.SLOW else 0.3)
        names = [name for name in (*DYNAMIC, *STATIC) if built(name)]
        cases = [(1, "morton", 1)] + [(2 + turn % 3, name, 1) for turn, name in enumerate(names)]
        found = self.compare(INPUTS / "slurry_runout_3d.toml", keys, cases)
        self.assertEqual([s["partitioner"] for s in found[1:]], names)
        sent = [s["halo_bytes"] for s in found]
        self.assertEqual(sent[0], 0)
        self.assertEqual(len(set(sent)), len(sent), sent)  # each its own

    def test_a_block_that_slides_around_a_periodic_axis_under_every_partitioner(self):
        scene = self.write(LEAKY_SCENE)
        cases = [(1, "metis", 1)] + [(3, name, 1) for name in (*DYNAMIC, *STATIC)] + [(7, "phg", 1), (7, "metis", 1)]
        cases = [case for case in cases if built(case[1])]
        found = self.compare(scene, sets(balance__axis="x"), cases)
        for name in filter(built, DYNAMIC):
            self.assertGreater(self.migrated(found, name), 0, name)

    def test_what_leaves_through_an_open_wall_and_a_periodic_axis(self):
        scene = self.write(LEAKY_SCENE)
        for precision in ("double", "single"):
            cases = [(1, "slabs", 1)] if precision == "double" else [(1, "shuffle", 2)]
            cases += [(2, "morton", 1), (2, "shuffle", 1), (3, "slabs", 1), (3, "shuffle", 1), (4, "morton", 1)]
            found = self.compare(scene, sets(numerics__precision=precision), cases)
            lost = {s["lost_particles"] for s in found}
            self.assertEqual(len(lost), 1)
            self.assertGreater(min(lost), 20)
            self.assertEqual({s["particles"] + s["lost_particles"] for s in found}, {14 * 8 * 4})
            self.assertGreater(self.migrated(found, "morton"), 0)
            self.assertGreater(max(s["crossed_particles"] for s in found), 0)

    def test_a_checkpoint_of_2_ranks_restarted_on_3(self):
        scene, end = INPUTS / "slurry_runout.toml", 0.02 if moraine.SLOW else 0.1
        for precision in ("double", "single"):
            keys = sets(time__end=end, numerics__precision=precision, output__interval=end / 4)
            straight = self.run_scene(scene, f"straight-{precision}", *keys)
            halves = self.run_scene(scene, f"halves-{precision}", *keys,
                                    *sets(output__checkpoint_interval=end / 2), ranks=2)
            restarted = self.run_scene(scene, f"restarted-{precision}", *keys, "--partitioner", "shuffle", "--restart",
                                       checkpoints(halves)[0], ranks=3)
            self.assertLess(len((restarted / "history.csv").read_text()), len((straight / "history.csv").read_text()))
            for directory in (halves, restarted):
                self.assertEqual(summary(directory)["state_hash"], summary(straight)["state_hash"])
                last_row = (directory / "history.csv").read_text().splitlines()[-1]
                self.assertEqual(last_row, (straight / "history.csv").read_text().splitlines()[-1])

    def test_checkpoints_between_two_shifts(self):
        scene = self.write(LEAKY_SCENE.replace('"neo-hookean"', '"newtonian"\nviscosity = 10.0').replace(
            "poisson = 0.3", "poisson = 0.45\npressure_smoothing = 0.22\nparticle_shifting = 0.1"))
        self.same_from_every_checkpoint(scene, "shifts", sets(numerics__transfer="aflip"))

    def test_checkpoints_with_substeps(self):
        scene = self.write(LEAKY_SCENE.replace('"neo-hookean"', '"newtonian"\nviscosity = 10.0\nvolumetric = "grid"').replace(
            "poisson = 0.3", "poisson = 0.49\npressure_smoothing = 0.22\nparticle_shifting = 0.1"))
        steps = [self.same_from_every_checkpoint(scene, f"most-{most}", sets(numerics__substeps=most)) for most in (1, 10)]
        self.assertLess(2 * steps[1], steps[0])

    def test_checkpoints_of_clay_with_the_pressure_of_the_grid(self):
        scene = self.write(LEAKY_SCENE.replace('"neo-hookean"', '"tresca"\nsu = 100.0\nvolumetric = "grid"').replace(
            "poisson = 0.3", "poisson = 0.49\npressure_smoothing = 0.22\nparticle_shifting = 0.1"))
        self.same_from_every_checkpoint(scene, "clay", [])

    def same_from_every_checkpoint(self, scene, name, keys):
        """Steps of the run."""
        straight = self.run_scene(scene, f"{name}-straight", *keys)
        parts = self.run_scene(scene, f"{name}-parts", *keys, *sets(output__checkpoint_interval=0.07), ranks=2)
        steps = []
        for checkpoint in checkpoints(parts):
            steps.append(int(re.search(r"(\d+)", checkpoint.stem).group()))
            restarted = self.run_scene(scene, f"{name}-from-{steps[-1]}", *keys, "--restart", checkpoint, ranks=3)
            self.assertEqual(summary(restarted)["state_hash"], summary(straight)["state_hash"])
        self.assertGreater(len({step % 5 for step in steps}), 1, steps)
        return summary(straight)["steps"]

    def test_over_filling_is_in_the_records(self):
        keys = sets(domain__cell=0.5, time__end=1.0, output__interval=0.1)
        directory = self.run_scene(INPUTS / "slurry_runout.toml", "out", *keys)
        lines = (directory / "history.csv").read_text().splitlines()
        column = lines[0].split(",").index("over_filling")
        rows = [float(line.split(",")[column]) for line in lines[1:]]
        self.assertGreater(max(rows), 0)
        self.assertEqual(summary(directory)["over_filling"], max(rows))


if __name__ == "__main__":
    moraine.main()
