"""numerics.sleep: blocks at rest are left out of the step; one answer on any ranks, threads and partitioners, and after a restart."""
import csv
import subprocess

import damage
import moraine
from moraine import INPUTS, call, checkpoints, sets, summary

# A bed of sand whose right edge fails, and a block that falls on its left end.
BED = """\
dimensions = 2
gravity = [0.0, -9.81]
[domain]
min = [0.0, 0.0]
max = [6.4, 1.6]
cell = 0.1
[time]
cfl = 0.5
end = 0.6
[numerics]
sleep = "on"
[sleep]
displacement = 0.01
wake = 4.0
[output]
interval = 0.1
[[material]]
name = "sand"
law = "drucker-prager"
density = 1500.0
young = 5.0e5
poisson = 0.3
friction_angle = 30.0
[[body]]
name = "bed"
material = "sand"
shape = "box"
min = [0.0, 0.0]
max = [5.0, 0.6]
geostatic = { surface = 0.6, k0 = 0.6 }
[[body]]
name = "block"
material = "sand"
shape = "box"
min = [0.8, 1.0]
max = [1.1, 1.3]
[[wall]]
face = "x-min"
kind = "free-slip"
[[wall]]
face = "y-min"
kind = "no-slip"
"""

# What stands on the bed does not move.
POST = '[[structure]]\nname = "post"\nshape = "box"\nmin = [3.0, 0.6]\nmax = [3.3, 0.9]\n'

# It goes down into the bed once that sleeps.
PLATE = """\
[[structure]]
name = "plate"
shape = "box"
min = [2.0, 0.61]
max = [2.4, 0.9]
motion = { kind = "table", velocity = [0.0, -0.2], times = [0.3, 0.35], factors = [0.0, 1.0] }
"""


def moraine_can_draw():
    return any(subprocess.run([python, "-c", "import matplotlib, h5py"], capture_output=True).returncode == 0 for python in ("python3", "/usr/bin/python3"))


def rows(directory, name="history"):
    with open(directory / f"{name}.csv") as file:
        return list(csv.DictReader(file))


class Sleep(moraine.ProgramTest):
    def test_a_checkpoint_with_sleepers_and_a_flipped_bit_anywhere_in_its_rows_is_refused(self):
        scene = self.write(BED)
        directory = self.run_scene(scene, "whole", *sets(output__checkpoint_interval=0.3))
        content = checkpoints(directory)[-1].read_bytes()
        bad = self.folder / "bad.h5"
        for number, (at, length) in enumerate(damage.parts(content)[1]):
            for offset in (1, length // 2 | 1, length - 1):  # also high bytes of indices of 16 bits
                flipped = bytearray(content)
                flipped[at + offset] ^= 1 << (number + offset) % 8
                bad.write_bytes(flipped)
                with self.subTest(region=number, offset=offset):
                    ended = call("run", scene, "--restart", bad, "--output", self.folder / "again", "--quiet",
                                 "--device", "cpu")
                    self.assertIn("bad.h5", self.assert_one_problem(ended))
                    self.assertFalse((self.folder / "again").exists())

    def test_it_is_the_same_on_any_ranks_threads_and_partitioners_and_after_any_checkpoint(self):
        scene = self.write(BED)
        alone = self.run_scene(scene, "alone", *sets(output__checkpoint_interval=0.13))
        asleep = [int(float(row["asleep"])) for row in rows(alone)]
        self.assertGreater(max(asleep), asleep[-1] + 100, asleep)  # some woke
        self.assertGreater(asleep[-1], 100)
        every = sets(balance__trigger="every", balance__interval=10)
        cases = [(1, 2, ()), (2, 1, ()), (3, 1, ("--partitioner", "shuffle")), (4, 1, ("--partitioner", "rcb")), (3, 2, ("--partitioner", "slabs"))]
        for ranks, threads, words in cases:
            with self.subTest(ranks=ranks, words=words):
                found = self.run_scene(scene, f"{ranks}-{threads}", *words, *every, ranks=ranks, threads=threads)
                self.assertEqual(summary(found)["state_hash"], summary(alone)["state_hash"])
                self.assertEqual((found / "history.csv").read_text(), (alone / "history.csv").read_text())
        for k, checkpoint in enumerate(checkpoints(alone)):
            with self.subTest(checkpoint=checkpoint):
                found = self.run_scene(scene, f"from-{k}", "--restart", checkpoint, ranks=1 + k % 4)
                self.assertEqual(summary(found)["state_hash"], summary(alone)["state_hash"])
                self.assertEqual((found / "history.csv").read_text().splitlines()[-1], (alone / "history.csv").read_text().splitlines()[-1])

    def test_a_report_shows_who_sleeps(self):
        if not moraine_can_draw():
            self.skipTest("no Python with matplotlib and h5py")
        self.run_scene(self.write(BED), "drawn", *sets(time__end=0.3))
        ended = call("report", self.folder / "drawn", "--output", self.folder / "page.html")
        self.assertEqual(ended.code, 0, ended)
        self.assertIn("Asleep and awake", (self.folder / "page.html").read_text())
        with open(self.folder / "page_files" / "asleep.csv", newline="") as file:
            shares = [float(row["share [%]"]) for row in csv.DictReader(file) if row["line"] == "asleep"]
        self.assertEqual(shares, [100 * float(row["asleep"]) / 1236 for row in rows(self.folder / "drawn")])
        self.assertIn("Where it slept: of runs with <code>--set output.block_loads=on</code>", (self.folder / "page.html").read_text())

    def test_a_report_shows_where_and_when_particle_steps_were_saved(self):
        if not moraine_can_draw():
            self.skipTest("no Python with matplotlib and h5py")
        run = self.run_scene(self.write(BED), "drawn", *sets(time__end=0.4, output__block_loads="on", balance__interval=2))
        ended = call("report", run, "--output", self.folder / "page.html")
        self.assertEqual(ended.code, 0, ended)
        text = (self.folder / "page.html").read_text()
        self.assertIn("<h2>Where it slept</h2>", text)
        self.assertNotIn("Where it slept: of runs", text)
        share = summary(run)["sleep"]["share_of_particle_steps"]
        with open(self.folder / "page_files" / "where_it_slept.csv", newline="") as file:
            places = [{name: float(row[name]) for name in ("x_m", "particle_steps", "slept")} for row in csv.DictReader(file)]
        self.assertAlmostEqual(sum(row["slept"] for row in places) / sum(row["particle_steps"] for row in places), share, delta=0.01)
        struck = max(row["slept"] / row["particle_steps"] for row in places if 0.5 <= row["x_m"] <= 1.1)
        self.assertLess(struck, max(row["slept"] / row["particle_steps"] for row in places if 2 <= row["x_m"] <= 3))
        with open(self.folder / "page_files" / "particle_steps.csv", newline="") as file:
            last = {row["line"]: float(row["particle-steps [million]"]) for row in csv.DictReader(file)}
        self.assertAlmostEqual(last["saved"] / (last["made"] + last["saved"]), share, delta=0.01)
        self.assertAlmostEqual(1e6 * (last["made"] + last["saved"]), 1236 * summary(run)["steps"], delta=1236 * 4)

    def test_sleepers_cost_less_and_change_little(self):
        scene = self.write(BED.replace("[[body]]\nname = \"block\"", "[[body]]\nname = \"stone\"").replace("min = [0.8, 1.0]\nmax = [1.1, 1.3]", "min = [0.8, 0.6]\nmax = [1.1, 0.8]"))
        on, off = (self.run_scene(scene, word, *sets(numerics__sleep=word)) for word in ("on", "off"))
        self.assertGreater(summary(on)["sleep"]["share_of_particle_steps"], 0.2)
        self.assertNotIn("sleep", summary(off))
        self.assertNotIn("asleep", rows(off)[0])
        a, b = summary(on), summary(off)
        self.assertAlmostEqual(a["front_m"], b["front_m"], delta=0.1)
        self.assertAlmostEqual(a["energies_J"]["potential"], b["energies_J"]["potential"], delta=1e-3 * b["energies_J"]["potential"])
        for row in rows(on):
            self.assertLess(abs(float(row["momentum_error_y_kg_m_s"])), 1e-8)

    def test_balance_counts_what_is_awake(self):
        keys = sets(balance__interval=5, balance__threshold=1.02)
        directory = self.run_scene(self.write(BED), "balance", *keys, ranks=2)
        last = rows(directory, "balance")[-1]
        self.assertEqual(float(last["awake"]) + float(last["asleep"]), 1236)
        self.assertGreater(float(last["particles_max"]), 1.05 * float(last["particles_mean"]))
        self.assertLess(float(last["imbalance"]), 1.25)

    def test_it_is_refused_where_it_cannot_be(self):
        def said(*words, text=BED):
            return self.assert_one_problem(call("check", self.write(text), *words))

        self.assertIn('numerics.sleep = "on" without gravity', said(*sets(gravity="[0.0, 0.0]"), text=BED.replace("geostatic = { surface = 0.6, k0 = 0.6 }", "")))
        for transfer in ("flip", "fmpm", "aflip"):
            self.assertIn('numerics.sleep = "on" with this numerics.transfer', said(*sets(numerics__transfer=transfer)))
        self.assertIn('numerics.sleep = "on" with this numerics.stress_update', said(*sets(numerics__stress_update="musl")))
        self.assertIn("sleep      blocks may: less than 0.001 m in", call("check", self.write(BED + POST)).out)
        wakes = self.assert_one_problem(call("check", self.write(BED), *sets(sleep__wake=0.5)))
        self.assertIn("sleep.wake", wakes)

    def test_a_structure_that_stands_on_sleepers_feels_the_same(self):
        scene = self.write(BED + POST.replace("min = [3.0, 0.6]", "min = [3.0, 0.3]") + "clear = true\n")
        alone = self.run_scene(scene, "alone", ranks=1)
        self.assertGreater(summary(alone)["sleep"]["asleep"], 100)
        shared = self.run_scene(scene, "shared", "--partitioner", "shuffle", *sets(balance__trigger="every", balance__interval=10), ranks=3)
        self.assertEqual(summary(shared)["state_hash"], summary(alone)["state_hash"])
        self.assertEqual((shared / "structures.csv").read_text(), (alone / "structures.csv").read_text())
        awake = self.run_scene(scene, "awake", *sets(numerics__sleep="off"), ranks=1)
        forces = [[float(row["force_y_N"]) for row in rows(run, "structures")] for run in (alone, awake)]
        for asleep, other in zip(*forces):
            self.assertAlmostEqual(asleep, other, delta=0.1 * max(map(abs, forces[1])))

    def test_a_bed_that_acts_on_its_surface_bears_sleepers(self):
        """A rough plane between nodes in place of the wall; a stone falls on the bed and wakes it."""
        plane = '[[structure]]\nname = "ground"\nshape = "plane"\npoint = [0.0, 0.03]\nnormal = [0.0, 1.0]\ncontact = { law = "rough" }\n'
        text = BED.replace('[[wall]]\nface = "y-min"\nkind = "no-slip"\n', plane).replace('sleep = "on"', 'sleep = "on"\nbed = "surface"')
        text = text.replace("min = [0.0, 0.0]\nmax = [5.0, 0.6]\ngeostatic = { surface = 0.6,", "min = [0.0, 0.03]\nmax = [5.0, 0.63]\ngeostatic = { surface = 0.63,")
        scene = self.write(text)
        alone = self.run_scene(scene, "alone", *sets(output__checkpoint_interval=0.25))
        asleep = [int(float(row["asleep"])) for row in rows(alone)]
        self.assertGreater(max(asleep), asleep[-1] + 100, asleep)  # some woke
        self.assertGreater(asleep[-1], 0)  # a block lies out of the reach of waves
        every = sets(balance__trigger="every", balance__interval=10)
        for ranks, words in ((2, ("--partitioner", "shuffle")), (3, ("--partitioner", "shuffle")), (4, ("--partitioner", "rcb"))):
            with self.subTest(ranks=ranks):
                found = self.run_scene(scene, f"on-{ranks}", *words, *every, ranks=ranks)
                self.assertEqual(summary(found)["state_hash"], summary(alone)["state_hash"])
                self.assertEqual((found / "history.csv").read_text(), (alone / "history.csv").read_text())
        again = self.run_scene(scene, "again", "--restart", checkpoints(alone)[0], ranks=2)
        self.assertEqual(summary(again)["state_hash"], summary(alone)["state_hash"])
        for row in rows(alone):
            for axis in "xy":
                self.assertLess(abs(float(row[f"momentum_error_{axis}_kg_m_s"])), 1e-8)
        awake = self.run_scene(scene, "awake", *sets(numerics__sleep="off"))
        a, b = summary(alone), summary(awake)
        self.assertGreater(a["sleep"]["share_of_particle_steps"], 0.15)
        self.assertAlmostEqual(a["front_m"], b["front_m"], delta=0.1)
        self.assertAlmostEqual(a["energies_J"]["potential"], b["energies_J"]["potential"], delta=1e-3 * b["energies_J"]["potential"])

    def test_a_structure_that_moves_is_borne_as_by_ground_that_is_awake(self):
        scene = self.write(BED.replace("[[body]]\nname = \"block\"", "[[body]]\nname = \"stone\"").replace("min = [0.8, 1.0]\nmax = [1.1, 1.3]", "min = [4.4, 0.6]\nmax = [4.7, 0.7]").replace("wake = 4.0", "wake = 2.0") + PLATE)
        self.assertIn("sleep      blocks may: less than 0.0005048 m in", call("check", scene).out)  # the plate is slow
        keys = sets(output__structure_interval=0.01, output__checkpoint_interval=0.13)
        on, off = (self.run_scene(scene, word, *keys, *sets(numerics__sleep=word)) for word in ("on", "off"))
        self.assertGreater(summary(on)["sleep"]["share_of_particle_steps"], 0.2)
        loads = [[float(row["force_y_N"]) for row in rows(run, "structures")] for run in (on, off)]
        self.assertGreater(loads[1][-1], 500)
        for asleep, awake in zip(*loads):
            self.assertAlmostEqual(asleep, awake, delta=0.01 * max(loads[1]))
        shared = self.run_scene(scene, "shared", "--partitioner", "shuffle", *sets(balance__trigger="every", balance__interval=10), *keys, ranks=3, threads=2)
        self.assertEqual(summary(shared)["state_hash"], summary(on)["state_hash"])
        self.assertEqual((shared / "structures.csv").read_text(), (on / "structures.csv").read_text())
        for k, checkpoint in enumerate(checkpoints(on)):
            with self.subTest(checkpoint=checkpoint):
                found = self.run_scene(scene, f"moved-{k}", "--restart", checkpoint, ranks=1 + k % 2)
                self.assertEqual(summary(found)["state_hash"], summary(on)["state_hash"])


if __name__ == "__main__":
    moraine.main()
