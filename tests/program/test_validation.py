"""benchmarks/validation: a level is run, read and judged; orders and Richardson values of a ladder are those it was made with."""
import json
import pathlib
import subprocess
import sys
import unittest

import moraine

RUN = pathlib.Path(__file__).resolve().parents[2] / "benchmarks/validation/run"


def has_numpy():
    return any(subprocess.run([python, "-c", "import numpy"], capture_output=True).returncode == 0 for python in ("python3", "/usr/bin/python3"))


def slurry_line(level, front):
    figures = {"front 99.5 % [m]": front, "noise [%]": 1.5, "creep [% of H0]": 0.2}
    return {"case": "slurry", "variant": "FLIP", "level": level, "command": "none", "machine": "m", "device": "host", "precision": "double",
            "commit": "c", "particles": 1, "steps": 1, "wall_s": 1.0, "figures": figures, "curves": {"front": [[0], [1]], "depth": [[0], [1]]}}


@unittest.skipUnless(has_numpy(), "no numpy")
class Validation(moraine.ProgramTest):
    def validation(self, *words):
        done = subprocess.run([sys.executable, str(RUN), *words, "--results", str(self.folder / "results")], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.folder / "results"

    def test_a_level_is_run_and_its_particles_are_read(self):
        folder = self.validation("slurry", "--levels", "25", "--variants", "FLIP", "--set", "time.end=0.002", "--no-plots", "--program",
                                 moraine.PROGRAM, "--runs", str(self.folder / "runs"))
        line, = [json.loads(text) for text in (folder / "results.jsonl").read_text().splitlines()]
        self.assertAlmostEqual(line["figures"]["front 99.5 % [m]"], 9.95, delta=0.01)
        self.assertLess(line["figures"]["noise [%]"], 4)  # hydrostatic still, less a depth that is of whole bins
        x, h = line["curves"]["depth"]
        self.assertAlmostEqual(h[3], 5, delta=1e-6)
        self.assertAlmostEqual(sum(h) * (x[1] - x[0]), 50, delta=1e-3)

    def test_the_page_finds_order_and_richardson_value_again(self):
        lines = [slurry_line(n, 60 - 8 * (25 / n)**1.5) for n in (25, 50, 100)]
        made = self.folder / "made.jsonl"
        made.write_text("".join(json.dumps(line) + "\n" for line in lines))
        pages = self.validation("page", "--add", str(made))
        self.assertIn("| [slurry](slurry.md) | Runout of a Bingham slurry after a dam break | 3 of 5 |", (pages / "results.md").read_text())
        text = (pages / "slurry.md").read_text()
        self.assertIn("| FLIP: order of the runout, H0/25 to H0/100 | 1.50 | >= 0.8 | met |", text)
        error = 100 * (-8 * 0.5**1.5) / 50
        self.assertIn(f"| FLIP: runout at H0/50 against the Richardson value | {error:+.2f} % | 1 % | **missed** |", text)

    def test_an_unknown_case_is_named(self):
        done = subprocess.run([sys.executable, str(RUN), "landslide"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("no case landslide (there are cantilever, flume, footing, ", done.stderr)


if __name__ == "__main__":
    moraine.main()
