"""The script for QGIS' toolbox, where a Python has QGIS."""
import os
import subprocess
import unittest

from runs_for_tests import ROOT, PackageTest, folder
from test_way import slope

PYTHON = "/usr/bin/python3"  # that QGIS is for


def has_qgis():
    return os.path.exists(PYTHON) and subprocess.run([PYTHON, "-c", "import qgis.core"], capture_output=True).returncode == 0


@unittest.skipUnless(has_qgis(), "no QGIS")
class Qgis(PackageTest):
    def test_the_script_runs_a_scene_and_loads_its_maps_with_their_styles(self):
        scene = slope("qgis")
        done = subprocess.run([PYTHON, str(ROOT / "tests/python/qgis_script.py"), str(scene), str(folder("qgis-run"))], capture_output=True, text=True,
                              env={**os.environ, "QT_QPA_PLATFORM": "offscreen"})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        layers = dict(line.split(" ", 1) for line in done.stdout.splitlines())
        for name in ("max_depth", "max_speed", "max_pressure", "arrival", "deposit"):
            self.assertRegex(layers[name], r"singlebandpseudocolor [1-8]$" if name == "arrival" else r"singlebandpseudocolor [2-8]$")
        self.assertEqual(layers["outline"], "vector 1")


if __name__ == "__main__":
    unittest.main()
