"""Small runs for the tests of the package, made once each, and what tests/program has for tests of the program."""
import functools
import importlib.util
import json
import os
import pathlib
import re
import tempfile
import unittest

import moraine

ROOT = pathlib.Path(__file__).resolve().parents[2]


def _program_tests():
    """tests/program/moraine.py under another name, for the package has that one."""
    spec = importlib.util.spec_from_file_location("program_tests", ROOT / "tests/program/moraine.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


program = _program_tests()
os.environ["MORAINE_PROGRAM"] = program.PROGRAM
INPUTS = program.INPUTS
FOLDER = tempfile.TemporaryDirectory(prefix="moraine-")
PROBLEM = re.compile(program.PROBLEM.pattern.replace("moraine: ", ""))
SLURRY = {"domain.cell": 0.25, "time.end": 0.3, "output.interval": 0.1, "output.fields": ["velocity", "pressure", "mass"]}

# A block of jelly flies out of the domain, so that the outputs have different numbers of particles, while a rod falls.
JELLY = {
    "title": "a block that leaves", "dimensions": 2, "gravity": [0.0, -9.81],
    "domain": {"min": [0.0, 0.0], "max": [4.0, 2.0], "cell": 0.25},
    "time": {"end": 0.12, "cfl": 0.5},
    "output": {"interval": 0.02, "fields": ["velocity", "stress", "mass"], "structure_interval": 0.01,
               "checkpoint_interval": 0.05},
    "material": [{"name": "jelly", "law": "neo-hookean", "density": 1000.0, "young": 1.0e5, "poisson": 0.3}],
    "body": [{"name": "block", "material": "jelly", "shape": "box", "min": [1.0, 0.5], "max": [2.0, 1.5],
              "velocity": [20.0, 0.0]}],
    "wall": [{"face": "y-min", "kind": "no-slip"}, {"face": "x-max", "kind": "open"}],
    "structure": [{"name": "rod", "shape": "capsule", "from": [0.3, 1.7], "to": [0.7, 1.6], "radius": 0.08,
                   "motion": {"kind": "velocity", "velocity": [0.5, -3.0]}},
                  {"name": "shelf", "shape": "box", "min": [0.2, 0.1], "max": [0.6, 0.2]}],
}


def folder(name):
    return pathlib.Path(FOLDER.name) / name


@functools.lru_cache(maxsize=None)
def jelly():
    return moraine.run(JELLY, folder("jelly"), progress=False)


@functools.lru_cache(maxsize=None)
def slurry():
    return moraine.run(INPUTS / "slurry_runout.toml", folder("slurry"), sets=SLURRY, ranks=2, progress=False)


@functools.lru_cache(maxsize=None)
def slurry_3d():
    return moraine.run(INPUTS / "slurry_runout_3d.toml", folder("slurry_3d"), sets={**SLURRY, "domain.cell": 0.5}, progress=False)


class PackageTest(unittest.TestCase):
    maxDiff = None

    def problem(self, call, *words, code=2, **more):
        """The message of the Error that the call raises, which is of the form problem (why). suggestion?"""
        with self.assertRaises(moraine.Error) as raised:
            call(*words, **more)
        self.assertRegex(str(raised.exception), "^" + PROBLEM.pattern + "$")
        self.assertEqual(raised.exception.code, code)
        return str(raised.exception)

    def refuses_damage(self, file, places, call):
        """A record of a study with another text, or a word at any of these places (keys, one behind the other), is refused in words and stays."""
        whole = file.read_text()
        texts = ["", "null", "[]", "{}", whole[:-9]]
        for place in places:
            inner = found = json.loads(whole)
            for key in place[:-1]:
                inner = inner[key]
            inner[place[-1]] = "x"
            texts.append(json.dumps(found))
        for text in texts:
            with self.subTest(text=text[:200]):
                file.write_text(text)
                self.assertIn("is damaged", self.problem(call))
                self.assertEqual(file.read_text(), text)
        file.write_text(whole)
