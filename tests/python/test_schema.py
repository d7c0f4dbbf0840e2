"""moraine schema: editors know from it what a scene may hold. All scenes of inputs are valid; what the reader refuses is not."""
import copy
import json
import subprocess
import unittest

import moraine
from runs_for_tests import INPUTS, PackageTest, program

try:
    import jsonschema
except ImportError:
    jsonschema = None


def schema():
    done = subprocess.run([program.PROGRAM, "schema"], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, ""), done
    return json.loads(done.stdout)


class Schema(PackageTest):
    def test_it_has_every_table_and_the_words_of_the_reference(self):
        found = schema()
        self.assertEqual(found["required"], ["dimensions", "domain", "time"])
        for name in ("reference.toml", "reference_terrain.toml", "reference_water.toml"):
            for key, value in moraine.read_scene(INPUTS / name).items():
                self.assertIn(key, found["properties"])
                if isinstance(value, dict):
                    self.assertLessEqual(set(value), set(found["properties"][key]["properties"]), key)
        end = found["properties"]["time"]["properties"]["end"]
        self.assertEqual(end, {"description": "A number [s] >= 0; required. Simulated time.", "type": "number", "minimum": 0})
        fields = found["properties"]["output"]["properties"]["fields"]
        self.assertEqual(fields["default"], ["velocity", "stress"])
        self.assertIn("void_ratio", fields["items"]["enum"])  # of modified Cam Clay

    def test_words_after_it_are_refused(self):
        done = subprocess.run([program.PROGRAM, "schema", "scene.toml"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr.strip(), program.PROBLEM)

    @unittest.skipIf(jsonschema is None, "no jsonschema")
    def test_every_scene_of_inputs_is_valid(self):
        jsonschema.Draft7Validator.check_schema(schema())
        check = jsonschema.Draft7Validator(schema())
        scenes = sorted(INPUTS.glob("*.toml"))
        self.assertGreater(len(scenes), 10)
        for scene in scenes:
            with self.subTest(scene.name):
                self.assertEqual([wrong.message for wrong in check.iter_errors(moraine.read_scene(scene))], [])

    @unittest.skipIf(jsonschema is None, "no jsonschema")
    def test_a_law_in_a_file_has_keys_of_its_own(self):
        check, good = jsonschema.Draft7Validator(schema()), moraine.read_scene(INPUTS / "first_scene.toml")
        good["material"][0].update(law="file", source="my_law.hpp", healing=10.0)
        self.assertEqual([wrong.message for wrong in check.iter_errors(good)], [])
        good["material"][0].pop("source")
        self.assertNotEqual(list(check.iter_errors(good)), [])

    @unittest.skipIf(jsonschema is None, "no jsonschema")
    def test_a_strength_is_a_number_or_a_profile(self):
        check, good = jsonschema.Draft7Validator(schema()), moraine.read_scene(INPUTS / "reference.toml")
        silt = next(material for material in good["material"] if material["name"] == "silt")
        good["output"]["fields"] = ["su", "cohesion"]
        for su in (2.0e3, {"surface": 1.0}, {"surface": "su.tif", "from": 2.0}, {"depth": [0.0, 1.0], "value": [1.0, 2.0]}):
            silt["su"] = su
            self.assertTrue(check.is_valid(good), su)
        for su in (0.0, "2e3", {"surface": 1.0, "slope": 2.0}, {"surface": -1.0}):
            silt["su"] = su
            self.assertFalse(check.is_valid(good), su)

    @unittest.skipIf(jsonschema is None, "no jsonschema")
    def test_what_the_reader_refuses_is_not_valid(self):
        check, good = jsonschema.Draft7Validator(schema()), moraine.read_scene(INPUTS / "reference.toml")
        faults = {
            "a misspelled key": lambda s: s["domain"].update(cel=1.0),
            "a misspelled table": lambda s: s.update(bodies=[]),
            "a key that is missing": lambda s: s["time"].pop("end"),
            "a number below its range": lambda s: s["domain"].update(cell=0.0),
            "a word that is no choice": lambda s: s["numerics"].update(shape="cubik"),
            "a number in quotes": lambda s: s["time"].update(end="2"),
            "a name with blanks": lambda s: s["material"][0].update(name="my clay"),
            "a misspelled key of a material": lambda s: s["material"][0].update(yuong=1.0),
            "a key of another law": lambda s: s["material"][0].update(friction_angle=30.0),
            "a law without its parameter": lambda s: s["material"][0].pop("young"),
            "a key of another shape": lambda s: s["structure"][0].update(points=[[0, 0], [1, 0], [0, 1]]),
            "a wall without its friction": lambda s: s["wall"][0].update(kind="friction"),
            "a field that no law has": lambda s: s["output"].update(fields=["colour"]),
            "a list in place of a table": lambda s: s.update(time=[{"end": 1.0}]),
        }
        good["material"] = [m for m in good["material"] if m["law"] == "linear-elastic"] or good["material"]
        good["structure"] = [s for s in good["structure"] if s["shape"] == "sphere"]
        good["wall"] = [{"face": "z-min", "kind": "no-slip"}]
        self.assertEqual(list(check.iter_errors(good)), [])
        for name, change in faults.items():
            with self.subTest(name):
                scene = copy.deepcopy(good)
                change(scene)
                self.assertNotEqual(list(check.iter_errors(scene)), [])
