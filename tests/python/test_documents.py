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

    def test_the_api_page_of_the_site_has_every_public_name(self):
        sys.path.insert(0, str(ROOT / "docs/site"))
        self.addCleanup(sys.path.remove, str(ROOT / "docs/site"))
        page = importlib.import_module("api_pages").python_page()
        self.assertLessEqual(set(moraine.__all__) | {"picture.draw"}, set(re.findall(r"^::: moraine\.([\w.]+)$", page, re.M)))

    def workplace(self, name):
        """A folder in which the page's paths hold: inputs, python and build/release/moraine."""
        place = folder(name)
        (place / "build/release").mkdir(parents=True)
        for link in ("inputs", "python", "pyproject.toml"):
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

    @unittest.skipIf(NO_MATPLOTLIB, "no matplotlib")
    def test_the_gallery_script_makes_every_picture_of_the_pages(self):
        place = self.workplace("gallery")
        (place / "docs").symlink_to(ROOT / "docs")
        script = [sys.executable, "python/examples/gallery.py", "--quick"]
        done = subprocess.run(script, cwd=place, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        pictures = {path.name for path in (place / "runs/gallery/pictures").iterdir() if path.stat().st_size > 1000}
        self.assertEqual(pictures, {path.name for path in (ROOT / "docs/pictures").iterdir() if path.suffix != ".md"})
        shown = re.findall(r"\]\(pictures/([\w.]+)\)", (ROOT / "docs/gallery.md").read_text())
        self.assertGreater(len(shown), 9)
        self.assertLessEqual({name for name in shown if name != "README.md"}, pictures)
        self.assertIn("(../python/examples/gallery.py)", (ROOT / "docs/gallery.md").read_text())
        done = subprocess.run([*script, "--only", "slury"], cwd=place, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr.count("One of slurry, ")), (2, 1), done.stderr)


def prose_of(page):
    """Paragraphs and entries of lists, without code and tables."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    for paragraph in re.split(r"\n\s*\n", text):
        for entry in re.split(r"\n(?=\s*(?:[*-]|\d+\.) )", paragraph):
            lines = [line for line in entry.splitlines() if not line.lstrip().startswith("|")]
            yield " ".join(" ".join(lines).split())


def cells_of(page):
    """Cells of tables, without code blocks; a bar behind a backslash divides nothing."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    for line in text.splitlines():
        if line.lstrip().startswith("|"):
            yield from (cell.strip() for cell in re.split(r"(?<!\\)\|", line))


class Rules(unittest.TestCase):
    def test_pages_and_paragraphs_are_short(self):
        self.assertGreater(len(PAGES), 90)
        for page in PAGES:
            with self.subTest(str(page.relative_to(ROOT))):
                self.assertLess(len(page.read_text().splitlines()), 200)
                self.assertLessEqual(max(map(len, prose_of(page))), 500)
                self.assertLessEqual(max(map(len, cells_of(page)), default=0), 500)
                self.assertNotRegex(page.read_text(), r"\bGATE\b|\bTARGETS?\b|\bissue \d|\basked:|\bAsked\b")

    def test_the_first_page_begins_with_two_pictures_and_is_short(self):
        text = (ROOT / "README.md").read_text()
        self.assertLessEqual(len(text.splitlines()), 100)
        self.assertEqual(len(re.findall(r"!\[[^\]]+\]\(docs/pictures/", text.split("## ")[0])), 2)
        for part in ("Two commands", "What it is for, and what not", "How fast", "How exact", "Requirements"):
            self.assertIn(f"\n## {part}\n", text)
        fast = text.split("## How fast")[1].split("## Requirements")[0]
        for entry in re.findall(r"^\* (?:.+\n(?: +.+\n)*)", fast, re.M):  # each figure leads to its page, and names its commit
            self.assertRegex(" ".join(entry.split()), r"\]\([\w/-]+\.md\).*[0-9a-f]{7}\b.*\)\.")

    def test_the_change_log_has_releases_of_short_entries(self):
        lines = (ROOT / "CHANGELOG.md").read_text().splitlines()
        self.assertGreaterEqual(sum(line.startswith("## ") for line in lines), 2)
        self.assertLess(len(lines), 200)
        entries = [line for line in lines if line.startswith("* ")]
        self.assertGreater(len(entries), 50)
        for line in lines:
            self.assertLessEqual(len(line), 230, line)
            self.assertTrue(not line or line[0] != " ", "an entry is one line: " + line)

    def test_the_release_is_the_same_everywhere(self):
        """python/VERSION is the version; the latest release of CHANGELOG, its notes and CITATION.cff are of it."""
        version = (ROOT / "python/VERSION").read_text().strip()
        latest, dated = re.search(r"^## (\d[\d.]*)\n\nOf (\d{4}-\d\d-\d\d)\b", (ROOT / "CHANGELOG.md").read_text(), re.M).groups()
        self.assertEqual(latest, version)
        citation = (ROOT / "CITATION.cff").read_text()
        self.assertIn(f"\nversion: {version}\n", citation)
        self.assertIn(f'\ndate-released: "{dated}"\n', citation)
        self.assertTrue((ROOT / f"docs/releases/{version}.md").read_text().startswith(f"# Release {version}\n\nOf {dated}."))

    def test_pages_speak_of_problems_by_plain_names(self):
        """Codes stand in commands, between backquotes, and behind links."""
        sys.path.insert(0, str(ROOT / "benchmarks"))
        self.addCleanup(sys.path.remove, str(ROOT / "benchmarks"))
        names = importlib.import_module("plain_names")
        for page in PAGES:
            with self.subTest(str(page.relative_to(ROOT))):
                self.assertEqual(page.read_text(), names.in_words(page.read_text()))
        self.assertEqual(names.in_words("S6 and [E1](E1.md): `run S6`"), "energy over many periods and [vibrating bar](E1.md): `run S6`")


class Evidence(unittest.TestCase):
    """One page per problem in docs/evidence: statement, sketch, result, plot, verdict, command; its figures are those of the pages it names."""

    FOLDER = ROOT / "docs/evidence"

    def pages(self):
        found = sorted(set(self.FOLDER.glob("*.md")) - {self.FOLDER / "README.md"})
        self.assertGreater(len(found), 20)
        return [(page, page.read_text()) for page in found]

    def test_each_page_has_all_parts_in_order(self):
        parts = (r"^# \S.*\n\n(<a id=\"[\w-]+\"></a>)+\n\n\S", r"!\[Sketch of the problem\]\({name}\.svg\)", r"^## Result\n\n\| what \| measured \| (goal|limit) \| verdict \|",
                 r"!\[[^\]]+\]\([^)]+\.svg\)\n\n[A-Z]", r"^## Verdict\n\n(Met|Missed)\b", r"^## Repeat\n\n```\n\S", r"^Details: \[")
        for page, text in self.pages():
            at = 0
            for part in parts:
                with self.subTest(f"{page.name}: {part}"):
                    found = re.compile(part.replace("{name}", page.stem), re.M).search(text, at)
                    self.assertTrue(found)
                    at = found.end()
            for row in self.results(text):
                self.assertRegex(row[3], r"^(met$|missed|of at most)", page.name)
            if "| missed" in text:
                self.assertRegex(" ".join(text.split("## Verdict")[1].split()), "(?i)miss|not monotone|10 % of|changes by", page.name)

    @staticmethod
    def results(text):
        lines = [line for line in text.split("## Result")[1].split("##")[0].splitlines() if line.startswith("|")]
        return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]

    def test_figures_are_those_of_the_pages_that_are_named(self):
        for page, text in self.pages():
            named = [(page.parent / link.split("#")[0]).resolve() for link in re.findall(r"\]\(([^)]+\.md[^)]*)\)", text.split("Details:")[1])]
            words = " ".join(path.read_text() for path in named)
            for what, measured, *_ in self.results(text):
                with self.subTest(f"{page.name}: {what}"):
                    for figure in re.findall(r"\d+(?:\.\d+)?(?:e-?\d+)?", measured):
                        self.assertTrue(re.search(rf"(?<![\d.]){re.escape(figure)}(?![\d])", words), f"{figure} is not there")

    def test_pages_are_listed_and_their_drawings_and_commands_are_there(self):
        index, site = (self.FOLDER / "README.md").read_text(), (ROOT / "docs/site/mkdocs.yml").read_text()
        for page, text in self.pages():
            with self.subTest(page.name):
                self.assertIn(f"]({page.name})", index)
                self.assertIn(f"docs/evidence/{page.name}", site)
                for picture in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text):
                    self.assertTrue((page.parent / picture).is_file(), picture)
                for script in re.findall(r"^(benchmarks/\S+)", text.split("## Repeat")[1], re.M):
                    self.assertTrue(os.access(ROOT / script, os.X_OK), script)
                for name in re.findall(r"-R verification\.(test_\w+)", text):
                    self.assertTrue((ROOT / f"tests/verification/{name}.cpp").is_file(), name)

    def test_drawings_are_those_that_the_script_makes(self):
        sys.path.insert(0, str(ROOT / "docs/site"))
        self.addCleanup(sys.path.remove, str(ROOT / "docs/site"))
        drawn = importlib.import_module("draw_evidence").pictures()
        self.assertEqual({path.name for path in self.FOLDER.glob("*.svg")}, set(drawn))
        for name, text in drawn.items():
            self.assertEqual((self.FOLDER / name).read_text(), text, name + ": run docs/site/draw_evidence.py")
