"""The slurry as a case of OpenFOAM: what is written holds the scene, and what is read and lifted keeps it. OpenFOAM is not needed."""
import pathlib
import re
import sys
import unittest

import numpy
from runs_for_tests import folder

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "benchmarks/validation"))

import openfoam_case  # noqa: E402

SCENE = {"density": 1500.0, "viscosity": 50.0, "yield_stress": 500.0, "width": 10.0, "height": 5.0}
CHOICES = {"creep_viscosity": 1.5e5, "air_density": 1.0, "air_viscosity": 0.05, "courant": 0.4, "compression": 1.0, "outer": 1, "end": 8.0, "interval": 0.5, "lift": 0}


class Case(unittest.TestCase):
    def test_the_case_holds_the_block_and_its_law(self):
        for h, rise in ((0.4, 1.0), (0.2, 2.0), (0.1, 4.0)):
            place, mesh = folder(f"openfoam-{h}-{rise:g}"), openfoam_case.Mesh(h, 62.0, rise)
            openfoam_case.write(place, mesh, SCENE, CHOICES)
            x, y, high = mesh.cells()
            self.assertAlmostEqual(h * high.sum(), 20 * 6 + 42 * 2.4, 9)
            alpha = openfoam_case.read(place / "0/alpha.slurry")
            self.assertAlmostEqual((alpha * h * high).sum(), h * 5 * round(10 / h), 4)
            self.assertLess(high[y == 0].max(), 1.1 * h / rise)
            said = dict(re.findall(r"(nu0|tau0|k) ([\d.e+-]+);", (place / "constant/transportProperties").read_text()))
            for key, value in (("nu0", 1.5e5), ("tau0", 500.0), ("k", 50.0)):
                self.assertAlmostEqual(1500 * float(said[key]), value, 6)

    def test_cells_that_do_not_fit_are_refused(self):
        self.assertRaises(ValueError, openfoam_case.Mesh, 0.3, 60.0, 1.0)

    def test_vectors_are_read_as_rows(self):
        path = folder("openfoam-vector") / "U"
        path.parent.mkdir()
        path.write_text("internalField   nonuniform List<vector> \n2\n(\n(1 2 0)\n(-3e-1 4 0)\n)\n;\n\nboundaryField\n{\n}\n")
        self.assertEqual(openfoam_case.read(path).tolist(), [[1, 2, 0], [-0.3, 4, 0]])

    def test_trapped_air_goes_up_and_columns_keep_their_volume(self):
        mesh = openfoam_case.Mesh(0.4, 60.0, 2.0)
        x, y, high = mesh.cells()
        alpha = numpy.where((y < 1.0) & (x < 30), 1.0, 0.0)
        alpha[y == 0] *= 0.8
        after, columns = openfoam_case.lifted(alpha, mesh), numpy.round(x / 0.4).astype(int)
        numpy.testing.assert_allclose(numpy.bincount(columns, after * high), numpy.bincount(columns, alpha * high), atol=1e-12)
        self.assertTrue((after[(y == 0) & (x < 28)] == 1).all())
        self.assertTrue((after[(y == 0) & (x > 29.5)] <= 0.8).all())


if __name__ == "__main__":
    unittest.main()
