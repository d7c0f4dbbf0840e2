"""Documents are true: doctests of the modules, every block of docs/python.md, and the example."""
import contextlib
import doctest
import importlib
import io
import os
import pathlib
import pkgutil
import re
import subprocess
import sys
import unittest

import moraine
from runs_for_tests import ROOT, PackageTest, folder, program

try:
    import matplotlib  # noqa: F401
    NO_MATPLOTLIB = False
except ImportError:
    NO_MATPLOTLIB = True

PAGE = ROOT / "docs/python.md"
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "benchmarks").rglob("*.md"))]


class Documents(PackageTest):
    def test_examples_in_docstrings_are_true(self):
        tried = 0
        for module in pkgutil.iter_modules(moraine.__path__, "moraine."):
            if module.name in ("moraine.frames", "moraine.panels", "moraine.animation", "moraine.map_figure") and NO_MATPLOTLIB:
                continue
            found = doctest.testmod(importlib.import_module(module.name))
            self.assertEqual(found.failed, 0, module.name)
            tried += found.attempted
        self.assertGreater(tried, 15)

    def test_modules_stay_small_and_every_public_name_says_what_it_is(self):
        for path in pathlib.Path(moraine.__path__[0]).glob("*.py"):
            self.assertLess(len(path.read_text().splitlines()), 150, path)
        for name in moraine.__all__:
            if name != "Table":
                self.assertTrue(getattr(moraine, name).__doc__, name)
        self.assertTrue((pathlib.Path(moraine.__path__[0]) / "py.typed").exists())

    def workplace(self, name):
        """A folder in which the page's paths hold: inputs, python and build/release/moraine."""
        place = folder(name)
        (place / "build/release").mkdir(parents=True)
        for link in ("inputs", "python"):
            (place / link).symlink_to(ROOT / link)
        (place / "build/release/moraine").symlink_to(program.PROGRAM)
        return place

    @unittest.skipIf(NO_MATPLOTLIB, "no matplotlib")
    def test_every_block_of_the_page_runs(self):
        blocks = re.findall(r"^```(\w+)([^\n]*)\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)
        self.assertEqual({kind for kind, _, _ in blocks}, {"sh", "python"})
        place = self.workplace("page")
        here, names = os.getcwd(), {}
        os.chdir(place)
        self.addCleanup(os.chdir, here)
        for kind, remark, text in blocks:
            if "install" in remark and os.environ.get("MORAINE_TEST_INSTALL") != "1":
                continue  # it needs the network
            if kind == "python":
                with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                    exec(compile(text, str(PAGE), "exec"), names)
                continue
            words = text.replace("python3 -m moraine", f"{sys.executable} -m moraine")
            done = subprocess.run(["bash", "-ec", words], capture_output=True, text=True, env={**os.environ, "MORAINE_PYTHON": sys.executable})
            self.assertEqual(done.returncode, 0, text + done.stderr)
        self.assertTrue((place / "runs/slurry/pictures/speed.gif").exists())

    def test_paragraphs_of_the_page_are_short(self):
        text = re.sub(r"^```.*?^```$", "", PAGE.read_text(), flags=re.MULTILINE | re.DOTALL)
        for paragraph in re.split(r"\n\s*\n", text):
            if not paragraph.startswith("|"):
                self.assertLess(len(paragraph), 500, paragraph)

    @unittest.skipIf(NO_MATPLOTLIB, "no matplotlib")
    def test_the_example_runs(self):
        place = self.workplace("example")
        done = subprocess.run([sys.executable, "python/examples/compare_runouts.py", "--end", "1"], cwd=place, capture_output=True,
                              text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(re.findall(r"^ *\d+ Pa +\d+\.\d+ m", done.stdout, re.MULTILINE)), 3, done.stdout)
        self.assertTrue((place / "runs/compare_runouts/fronts.png").exists())


def prose_of(page):
    """Paragraphs and entries of lists, without code and tables."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    for paragraph in re.split(r"\n\s*\n", text):
        for entry in re.split(r"\n(?=\s*(?:[*-]|\d+\.) )", paragraph):
            lines = [line for line in entry.splitlines() if not line.lstrip().startswith("|")]
            yield " ".join(" ".join(lines).split())


class Rules(unittest.TestCase):
    def test_pages_and_paragraphs_are_short(self):
        self.assertGreater(len(PAGES), 90)
        for page in PAGES:
            with self.subTest(str(page.relative_to(ROOT))):
                self.assertLess(len(page.read_text().splitlines()), 200)
                self.assertLessEqual(max(map(len, prose_of(page))), 500)
                self.assertNotRegex(page.read_text(), r"\bGATE\b|\bTARGETS?\b|\bissue \d|\basked:")

    def test_the_change_log_has_releases_of_short_entries(self):
        lines = (ROOT / "CHANGELOG.md").read_text().splitlines()
        self.assertGreaterEqual(sum(line.startswith("## ") for line in lines), 2)
        self.assertLess(len(lines), 200)
        entries = [line for line in lines if line.startswith("* ")]
        self.assertGreater(len(entries), 50)
        for line in lines:
            self.assertLessEqual(len(line), 230, line)
            self.assertTrue(not line or line[0] != " ", "an entry is one line: " + line)

    def test_pages_speak_of_problems_by_plain_names(self):
        """Codes stand in commands, between backquotes, and behind links."""
        sys.path.insert(0, str(ROOT / "benchmarks"))
        self.addCleanup(sys.path.remove, str(ROOT / "benchmarks"))
        names = importlib.import_module("plain_names")
        for page in PAGES:
            with self.subTest(str(page.relative_to(ROOT))):
                self.assertEqual(page.read_text(), names.in_words(page.read_text()))
        self.assertEqual(names.in_words("S6 and [E1](E1.md): `run S6`"), "energy over many periods and [vibrating bar](E1.md): `run S6`")
