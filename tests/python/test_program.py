"""Scenes as dicts, and calls of the program: check, run, progress, refusals, interruption."""
import math
import os
import signal
import threading
import unittest

import moraine
import numpy
from moraine.toml_text import value_text
from runs_for_tests import INPUTS, JELLY, PackageTest, folder, jelly

try:
    import tomllib
except ImportError:
    tomllib = None


class Program(PackageTest):
    @unittest.skipIf(tomllib is None, "TOML is read from Python 3.11 on")
    def test_every_scene_comes_through_a_dict_unchanged(self):
        scenes = sorted(INPUTS.glob("*.toml"))
        self.assertGreater(len(scenes), 10)
        for scene in scenes:
            as_dict = moraine.read_scene(scene)
            self.assertEqual(tomllib.loads(moraine.to_toml(as_dict)), as_dict, scene)

    @unittest.skipIf(tomllib is None, "TOML is read from Python 3.11 on")
    def test_awkward_values_come_through_toml(self):
        hard = {"text": 'a "b" \\ \t\n\x7f\x01 \u00e9 \U0001f600', "odd key": 1, "tiny": 5e-324, "third": 1 / 3, "no": False,
                "empty": [], "mixed": [1, "a", [2.5]], "infinite": math.inf, "table": {"sub table": {"x": -1e300}},
                "rows": [{"a": {"b": 1}}, {"a": {"b": 2}, "rows": [{"c": 3}]}]}
        self.assertEqual(tomllib.loads(moraine.to_toml(hard)), hard)
        numbers = {"x": numpy.float64(0.1), "n": numpy.int32(3), "v": numpy.array([1.0, 2.0]), "yes": numpy.bool_(True)}
        self.assertEqual(tomllib.loads(moraine.to_toml(numbers)), {"x": 0.1, "n": 3, "v": [1.0, 2.0], "yes": True})
        self.assertEqual(value_text({"law": "rough"}, "x"), '{ law = "rough" }')

    def test_what_toml_cannot_hold_is_said_with_its_key(self):
        self.assertIn("domain.cell cannot be written", self.problem(moraine.to_toml, {"domain": {"cell": None}}))
        self.assertIn("is no key", self.problem(moraine.to_toml, {1: 2}))

    def test_a_scene_that_cannot_be_read_is_said(self):
        self.assertIn("Is the path right", self.problem(moraine.read_scene, folder("none.toml")))
        bad = folder("bad.toml")
        bad.write_text("a = b")
        self.assertIn("is no TOML", self.problem(moraine.read_scene, bad))

    def test_check_tells_the_size_of_a_scene(self):
        found = moraine.check(JELLY)
        self.assertEqual((found.particles, found.values["title"]), (64, ["a block that leaves"]))
        self.assertGreater(found.steps, 10)
        self.assertIn("particles  64", found.text)
        self.assertEqual(moraine.check(JELLY, sets={"domain.cell": 0.125}).particles, 256)
        self.assertEqual(moraine.check(INPUTS / "slurry_runout.toml").particles, 20000)

    def test_a_wrong_scene_raises_the_words_of_the_program(self):
        wrong = {**JELLY, "time": {"end": 0.1, "clf": 0.5}}
        said = self.problem(moraine.check, wrong)
        self.assertRegex(said, r"scene\.toml:\d+: time\.clf is not a key")
        self.assertIn("time.clf is not a key", self.problem(moraine.run, wrong, folder("wrong"), progress=False))
        self.assertFalse(folder("wrong").exists())
        self.assertIn("time.end", self.problem(moraine.check, JELLY, sets={"time.end": "late"}))

    def test_a_program_that_is_not_there_is_said(self):
        self.assertIn("no such program", self.problem(moraine.check, JELLY, program=folder("moraine")))

    def test_a_directory_that_is_taken_is_refused_and_replaced_when_that_is_asked_for(self):
        jelly()
        self.assertIn("jelly", self.problem(moraine.run, JELLY, folder("jelly"), progress=False))
        first = moraine.run(JELLY, folder("again"), sets={"time.end": 0.02}, progress=False)
        second = moraine.run(JELLY, folder("again"), sets={"time.end": 0.04}, progress=False, overwrite=True)
        self.assertEqual((first.summary["scene"], second.path), ("scene", folder("again")))
        self.assertGreater(second.summary["steps"], first.summary["steps"] / 2)

    def test_physics_that_goes_wrong_raises_with_its_exit_code(self):
        closed = {**JELLY, "wall": JELLY["wall"][:1]}  # the block leaves where no wall is
        self.problem(moraine.run, closed, folder("gone"), progress=False, code=3)

    def test_ranks_give_the_same_answer_and_progress_is_told(self):
        seen = []
        run = moraine.run(JELLY, folder("two"), ranks=2, progress=seen.append)
        self.assertEqual(run.summary["ranks"], 2)
        self.assertEqual(run.summary["state_hash"], jelly().summary["state_hash"])
        self.assertEqual((seen[-1].step, seen[-1].end, seen[-1].share), (run.summary["steps"], 0.12, 1.0))

    def test_an_interruption_ends_the_run_with_a_checkpoint(self):
        long = {"time.end": 1000.0, "domain.cell": 0.25}
        for ranks in (None, 2):
            output = folder(f"stopped-{ranks}")
            ended = threading.Event()

            def interrupt():
                while not (output / "history.csv").exists() and not ended.wait(0.01):
                    pass
                if not ended.is_set():
                    os.kill(os.getpid(), signal.SIGINT)

            other = threading.Thread(target=interrupt)
            other.start()
            try:
                with self.assertRaises(KeyboardInterrupt):
                    moraine.run(INPUTS / "slurry_runout.toml", output, sets=long, ranks=ranks, progress=False)
            finally:
                ended.set()
                other.join()
            self.assertEqual(len(moraine.Run(output).checkpoints), 1)
