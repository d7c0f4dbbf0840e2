"""moraine converge as a user has it: an exact problem, going on after an interruption, budgets, several methods, refusals."""
import dataclasses
import json
import math
import os
import signal
import subprocess
import time
import unittest
import xml.etree.ElementTree as tree

import moraine
from moraine.levels import fit
from moraine.quantity import parse_quantities
from moraine.results import Run
from moraine.study import LevelRun, Variant
from runs_for_tests import INPUTS, JELLY, PROBLEM, PackageTest, folder, program

# An elastic bar, one end fixed, a quarter of its first mode: u = V / w sin(b x) sin(w t). Ten cells of 1 m and a half period.
LENGTH, SPEED, V = 12.0, 10.0, 1e-4
BAR = {"dimensions": 2, "domain": {"min": [0.0, 0.0], "max": [14.0, 4.0], "cell": 0.5}, "time": {"end": 2.0},
       "output": {"interval": 0.02},
       "material": [{"name": "bar", "law": "linear-elastic", "density": 1.0, "young": 100.0, "poisson": 0.0}],
       "body": [{"name": "bar", "material": "bar", "shape": "box", "min": [0.0, 0.0], "max": [LENGTH, 4.0],
                 "wave": {"velocity": [V, 0.0], "axis": "x", "wavelength": 4 * LENGTH}}],
       "wall": [{"face": "x-min", "kind": "no-slip"}, {"face": "y-min", "kind": "free-slip"}, {"face": "y-max", "kind": "free-slip"}]}


def exact_energy(t):
    w = math.pi / (2 * LENGTH) * SPEED
    return 0.25 * LENGTH * 4.0 * (V * math.cos(w * t))**2


def converge(scene, name, *words, **more):
    said = []
    study = moraine.converge(scene, *words, output=folder(name), told=said.append, options=["--device", "cpu"], **more)
    return study, "\n".join(said)


class Converge(PackageTest):
    def command(self, *words):
        done = subprocess.run([program.PROGRAM, "converge", *map(str, words)], capture_output=True, text=True, cwd=folder("."), env=self.environment())
        return done.returncode, done.stdout, done.stderr

    def environment(self):
        import sys
        return {**os.environ, "MORAINE_PYTHON": sys.executable, "OMP_NUM_THREADS": "1"}

    def test_the_error_bar_of_an_exact_problem_holds_its_error(self):
        study, said = converge(BAR, "bar", "kinetic_J@1.1")
        found = study.variants[0].estimate(study.quantities[0])
        self.assertEqual([level.cell for level in study.variants[0].levels], [1.0, 2 / 3, 0.5])
        self.assertEqual(found.verdict, "converges", said)
        self.assertLessEqual(abs(found.finest - exact_energy(1.1)), found.error)
        self.assertIn("level 3: cell 0.5 m, 768 particles", said)
        self.assertRegex(said, r"(?s)level 1: .*the next level: cell 0.666667 m, .*level 2: .*the next level: cell 0.5 m, 768 particles, about \d+ steps .*level 3: ")
        self.assertIn("the next level: cell 0.333333 m, 1728 particles, about ", said)
        kept = json.loads((study.path / "converge.json").read_text())
        self.assertEqual(kept["estimates"][0]["error"], found.error)
        self.assertEqual(len((study.path / "converge.csv").read_text().splitlines()), 4)
        picture = tree.parse(study.path / "error-kinetic_J_1.1.svg").getroot()
        self.assertEqual(len(picture.findall("{http://www.w3.org/2000/svg}circle")), 3)
        self.assertFalse(list(study.path.glob("*/checkpoint*")) + list(study.path.glob("*/particles.vtkhdf")))

    def test_it_goes_on_where_it_was_and_ranks_give_the_same(self):
        converge(BAR, "on", "kinetic_J@1.1")
        start = time.monotonic()
        study, said = converge(BAR, "on", "kinetic_J@1.1,centre_x_m", levels=4, ranks=2)
        self.assertIn("level 4: cell 0.333333 m", said)
        alone, _ = converge(BAR, "alone", "kinetic_J@1.1,centre_x_m", levels=4)
        self.assertEqual([level.values for level in study.variants[0].levels], [level.values for level in alone.variants[0].levels])
        self.assertGreater(study.spent_s, 0)
        self.assertLess(time.monotonic() - start, 600)
        self.assertIn("another study", self.problem(converge, BAR, "on", "kinetic_J", sets={"time.cfl": 0.4}))
        again, _ = converge(BAR, "on", "kinetic_J", sets={"time.cfl": 0.4}, overwrite=True)
        self.assertNotEqual(again.variants[0].levels[0].steps, study.variants[0].levels[0].steps)

    def test_overwrite_removes_what_a_study_made_and_nothing_else(self):
        study = folder("mixed")
        for name in ("victim", "mixed/notes", "mixed/cell-0.5", "mixed/apic-cell-0.25"):
            (study.parent / name).mkdir(parents=True, exist_ok=True)
        (study / "cell-1").symlink_to(study.parent / "victim")
        for text in (json.dumps({"runs": {"../victim": 1.0, str(study.parent / "victim"): 1.0, "notes": 1.0}}), "", "[]", "null"):
            (study / "converge.json").write_text(text)
            if not text.startswith("{"):
                self.assertIn("damaged", self.problem(converge, BAR, "mixed", "kinetic_J"))
            self.problem(converge, BAR, "mixed", "kinetic_J", overwrite=True, budget=1e-9)
            self.assertTrue((study.parent / "victim").is_dir() and (study / "notes").is_dir())
        self.assertFalse((study / "cell-0.5").exists() or (study / "apic-cell-0.25").exists())

    def test_an_interrupted_study_goes_on_from_its_checkpoint_to_the_same_values(self):
        words = [INPUTS / "slurry_runout.toml", "--set", "time.end=0.5", "--coarsest", 0.5, "--ratio", "1:2", "--quantity", "max_x_m", "--device", "cpu",
                 "--set", "output.checkpoint_wall_interval=0.05"]
        job = subprocess.Popen([program.PROGRAM, "converge", *map(str, words), "--output", str(folder("torn"))], env=self.environment(),
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        last = folder("torn") / "cell-0.125"
        while not list(last.glob("checkpoint-*.h5")) and job.poll() is None:
            time.sleep(0.02)
        job.send_signal(signal.SIGTERM)
        _, said = job.communicate()
        self.assertEqual(job.returncode, 5, said)
        self.assertIn("Go on by the same command?", said)
        code, out, said = self.command(*words, "--output", folder("torn"))
        self.assertEqual(code, 0, said)
        self.assertIn("cell-0.25 is there", said)
        self.assertIn("cell-0.125 goes on from checkpoint-", said)
        code, whole, said = self.command(*words, "--output", folder("whole"))
        self.assertEqual(code, 0, said)
        values = [json.loads((folder(name) / "converge.json").read_text())["variants"][0]["levels"] for name in ("torn", "whole")]
        self.assertEqual(*[[level["values"] for level in levels] for levels in values])

    def test_levels_go_on_to_the_end_where_the_scene_would_stop_at_rest(self):
        always = {"time.stop": "rest", "rest.displacement": 1000.0, "rest.interval": 0.02}
        study, _ = converge({**JELLY, "structure": []}, "rest", "centre_y_m", sets=always)
        for level in study.variants[0].levels:
            self.assertEqual(moraine.Run(study.path / level.directory).summary["ended_by"], "end")

    def test_methods_are_compared_and_what_does_not_converge_is_said(self):
        splash = {**JELLY, "structure": [], "wall": JELLY["wall"] + [{"face": "x-min", "kind": "no-slip"}], "output": {"interval": 0.02}}
        study, said = converge(splash, "methods", "max_speed_m_s@max,centre_x_m", set_each={"numerics.transfer": ["apic", "flip"]}, coarsest=0.25)
        self.assertEqual([(v.name, len(v.levels)) for v in study.variants], [("apic", 3), ("flip", 3)])
        verdicts = {e["verdict"] for e in study.estimates()}
        self.assertTrue(verdicts & {"oscillates", "diverges", "stalls"}, verdicts)
        for estimate in study.estimates():
            self.assertEqual(estimate["error"] is None, estimate["verdict"] not in ("converges", "equal"))
        self.assertIn("so there is no error bar", said)
        self.assertIn("apic: level 3", said)

    def test_it_stops_when_the_error_is_reached_or_the_budget_would_not_do(self):
        study, said = converge(BAR, "reached", "centre_x_m", error="1%")
        self.assertIn("the wanted error is reached", said)
        self.assertEqual((study.variants[0].reached, len(study.variants[0].levels)), (True, 4))  # the fourth confirms
        self.assertIn("(by three levels alone, which can be chance: a fourth confirms it or not)", said)
        self.assertRegex(said, r"the bar of the level before, 6\.0\d+ \+- \S+, holds it")
        study, said = converge(BAR, "budget", "kinetic_J@1.1", error=1e-6, budget=0.02)
        self.assertIn("the next level would go over the budget", said)
        self.assertEqual(len(study.variants[0].levels), 1)
        self.assertIsNotNone(study.variants[0].next_level["seconds"])

    def test_a_budget_far_below_the_first_level_is_refused_before_anything_is_begun(self):
        code, out, said = self.command(INPUTS / "submarine_slide.toml", "--budget", "1s", "--device", "cpu", "--output", folder("far"))
        self.assertEqual((code, out), (2, ""), said)
        self.assertRegex(said, rf"^moraine: {PROBLEM.pattern}$")
        self.assertRegex(said, r"--budget 1 s \(the first level, cell 0\.5 m, takes about \d+ s by moraine check\)\. A larger --coarsest, or --budget \d\S*s\?")
        self.assertFalse(folder("far").exists())
        converge(BAR, "begun", "kinetic_J@1.1", error=1e-6, budget=0.02)
        study, said = converge(BAR, "begun", "kinetic_J@1.1", error=1e-6, budget=1e-6)  # one that has begun is gone on with
        self.assertIn("the next level would go over the budget", said)

    def test_a_bar_that_the_next_level_leaves_is_said_and_no_error_is_reached_by_it(self):
        quantity, = parse_quantities("front")
        levels = [LevelRun(h, "", {}, [], 1, 1, 1.0, "", {"front": value})
                  for h, value in zip((0.5, 1 / 3, 0.25, 1 / 6), (55.4298, 55.9327, 56.1026, 56.9022))]  # of slurry_runout
        variant = Variant("", {}, levels)
        self.assertIs(variant.is_confirmed(quantity), False)
        self.assertIsNone(Variant("", {}, levels[:3]).is_confirmed(quantity))
        self.assertTrue(Variant("", {}, levels[:3] + [dataclasses.replace(levels[3], values={"front": 56.2})]).is_confirmed(quantity))

    def test_a_level_that_fails_leaves_the_others(self):
        closed = {**JELLY, "wall": JELLY["wall"][:1]}  # the block leaves where no wall is
        study, said = converge(closed, "failed", "centre_x_m")
        self.assertIn("failed: ", said)
        self.assertEqual(study.variants[0].failed, 3)

    def test_what_does_not_fit_whole_cells_moves_or_is_said(self):
        level = fit(moraine.read_scene(INPUTS / "slurry_runout.toml"), 4 / 3)
        self.assertEqual(level.sets["domain.max"], [100.0, 8.0])
        self.assertIn("body.reservoir ends between nodes at x = 10 m, y = 5 m", level.remarks)
        self.assertIn("body.reservoir is 3.75 cells over its least side (fewer than 4)", level.remarks)
        closed = {"dimensions": 2, "domain": {"min": [0, 0], "max": [4, 1], "cell": 0.1}, "time": {"dt": 0.01},
                  "wall": [{"face": f"{axis}-{end}", "kind": "no-slip"} for axis in "xy" for end in ("min", "max")]}
        level = fit(closed, 0.19)
        self.assertEqual((level.cell, level.sets["domain.cell"]), (0.2, 0.2))
        self.assertNotIn("domain.max", level.sets)
        self.assertAlmostEqual(level.sets["time.dt"], 0.02)
        self.assertIn("Try --ratio 1:2", self.problem(fit, {**closed, "domain": {"min": [0, 0], "max": [4, 0.1], "cell": 0.1}}, 0.4))
        periodic = {**closed, "wall": [], "domain": {**closed["domain"], "max": [4, 2], "periodic": ["x"]}}
        self.assertEqual(fit(periodic, 0.3).cell, 1 / 3)  # twelve cells along x are whole blocks of 4
        terrain = {"dimensions": 3, "domain": {"cell": 2.0}, "terrain": {"dem": "valley.asc"}, "time": {"dt": 0.01}}
        self.assertEqual(fit(terrain, 1.0).sets, {"domain.cell": 1.0, "time.dt": 0.005})

    def test_refusals_say_what_and_why_and_what_would_do(self):
        bar = folder("bar.toml")
        moraine.write_scene(BAR, bar)
        (folder("taken")).mkdir(exist_ok=True)
        (folder("taken") / "mine.txt").write_text("mine")
        for words in (["none.toml"], [bar, "--quantity", "frnt"], [bar, "--quantity", "structure.pipe.force_x"], [bar, "--quantity", "kinetic_J@later"],
                      [bar, "--quantity", "kinetic_J@9"], [bar, "--error", "0"], [bar, "--error", "two"], [bar, "--budget", "30"], [bar, "--levels", "2"], [bar, "--levels", "0"],
                      [bar, "--ratio", "4:3"], [bar, "--coarsest", "0"], [bar, "--set", "time.ned=1"], [bar, "--set", "time"], [bar, "--ranks", "0"],
                      [bar, "--set-each", "numerics.transfer=apic,apic"], [bar, "--set-each", "numerics.transfer=apci"], [bar, "--output", "taken"],
                      [INPUTS / "reference.toml"], [bar, "--levles", "3"], [bar, "--device", "tpu"], []):
            code, out, said = self.command("--quiet", *words)
            self.assertEqual(code, 2, (words, out, said))
            self.assertRegex(said.strip().splitlines()[-1], f"^moraine: {PROBLEM.pattern}$", words)
        self.assertFalse((folder("runs") / "converge-bar").exists())
        self.assertEqual(self.command("--help")[0], 0)

    def test_under_mpirun_it_says_ranks(self):
        done = subprocess.run([program.PROGRAM, "converge", "bar.toml"], capture_output=True, text=True,
                              env={**self.environment(), "OMPI_COMM_WORLD_SIZE": "2"})
        self.assertEqual(done.returncode, 2)
        self.assertIn("say --ranks N?", done.stderr)

    def test_a_front_and_a_depth_are_read_from_particles(self):
        study, _ = converge(moraine.read_scene(INPUTS / "slurry_runout.toml"), "slurry-levels", "front,depth@0,front@max", sets={"time.end": 0.3, "output.interval": 0.1},
                            coarsest=1.0, ratio="1:2")
        run = Run(study.path / "cell-0.25")
        values = study.variants[0].levels[-1].values
        self.assertIn("mass", run.particles.fields)
        self.assertAlmostEqual(values["depth@0"], 5.0)
        self.assertAlmostEqual(values["front"], float(sorted(run.particles[-1].position[:, 0])[int(0.995 * 3200) - 1]), delta=0.05)
        self.assertGreaterEqual(values["front@max"], values["front"])


if __name__ == "__main__":
    unittest.main()
