"""moraine report: one page about runs that opens offline, its plots as files, and what it refuses."""
import csv
import json
import os
import re
import subprocess
import unittest
import unittest.mock
import xml.etree.ElementTree
from html.parser import HTMLParser

import moraine
from moraine import INPUTS, call, sets, summary, table

SCENE = INPUTS / "slurry_runout.toml"
END = 0.02 if moraine.SLOW else 0.1
ASK = "import matplotlib"


def has_matplotlib():
    return any(subprocess.run([python, "-c", ASK], capture_output=True).returncode == 0
               for python in ("python3", "/usr/bin/python3"))


class Page(HTMLParser):
    """Headings, words of tables, and whatever would be fetched from elsewhere."""

    def __init__(self, text):
        super().__init__()
        self.open, self.headings, self.cells, self.fetched, self.ids = [], [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        if tag not in ("meta", "link", "br", "img"):
            self.open.append(tag)
        if tag in ("script", "link", "img", "iframe"):
            self.fetched.append(tag)
        for name in ("href", "xlink:href", "src"):
            if not found.get(name, "#").startswith("#"):
                self.fetched.append(found[name])
        if "id" in found:
            self.ids.append(found["id"])

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if self.open and self.open[-1] == tag:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-3:]}"
        self.open.pop()

    def handle_data(self, data):
        if self.open and self.open[-1] in ("h1", "h2"):
            self.headings.append(data)
        if self.open and self.open[-1] == "td":
            self.cells.append(data)


class Report(moraine.ProgramTest):
    def runs(self):
        keys = sets(time__end=END, balance__interval=10, output__block_loads="on")
        return [self.run_scene(SCENE, name, "--partitioner", name.split("-")[0], *keys, ranks=int(name[-1]))
                for name in ("slabs-2", "morton-2", "morton-3")]

    def report(self, *words, code=0):
        ended = call("report", *words, folder=self.folder)
        self.assertEqual(ended.code, code, ended)
        return ended

    @unittest.skipUnless(has_matplotlib(), "no matplotlib")
    def test_one_page_holds_everything(self):
        runs = self.runs()
        self.assertEqual(call("replay", runs[1], "--ranks", "4,16").code, 0)
        self.report(*runs, "--output", "page.html", "--times", f"0,{END}")
        text = (self.folder / "page.html").read_text()
        page = Page(text)
        self.assertEqual(page.open, [])
        self.assertEqual(page.fetched, [])
        self.assertEqual(len(page.ids), len(set(page.ids)))
        self.assertNotRegex(text, r"url\((?!#)|@import|https?://(?!www\.w3\.org/)")
        for heading in ("Strong scaling", "Where the time went", "Imbalance over time", "Who held which block",
                        "Halo volume", "Migration volume", "Decisions of the trigger", "Predictions (moraine replay)",
                        "Machine and commit"):
            self.assertIn(heading, page.headings)
        found = [summary(run) for run in runs]
        for words in ("slabs-2", "morton-3", found[0]["commit"], found[0]["machine"], found[0]["state_hash"]):
            self.assertIn(words, page.cells)
        self.assertIn("Nothing in this plot was measured", text)
        figures = re.findall(r"<svg .*?</svg>", text, re.S)
        self.assertEqual(len(figures), 8)
        for figure in figures:
            xml.etree.ElementTree.fromstring(figure)
        self.check_files(runs)

    def check_files(self, runs):
        folder = self.folder / "page_files"
        names = {path.stem for path in folder.iterdir()}
        for name in names:
            self.assertEqual({path.suffix for path in folder.glob(name + ".*")}, {".csv", ".svg", ".png"})
        with open(folder / "imbalance.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        expected = [row["imbalance"] for run in runs for row in table(run, "balance.csv")]
        self.assertEqual([float(row["imbalance"]) for row in rows], expected)
        with open(folder / "lost_time.csv", newline="") as file:
            rows = [row for row in csv.DictReader(file) if row["run"] == "slabs-2"]
        self.assertAlmostEqual(sum(float(row["seconds"]) for row in rows), summary(runs[0])["wall_s"], delta=1e-6)
        picture = (folder / "owners.svg").read_text()
        self.assertEqual([f"rank {rank}" in picture for rank in range(4)], [True, True, True, False])
        with open(folder / "owners.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        for run in ("slabs-2", "morton-2", "morton-3"):
            start = [row for row in rows if row["run"] == run and float(row["time_s"]) == 0]
            self.assertEqual(sum(int(row["particles"]) for row in start), 20000)
            self.assertTrue(all(-0.2 <= float(row["x_m"]) <= 10.2 for row in start))

    @unittest.skipUnless(has_matplotlib(), "no matplotlib")
    def test_runs_without_block_loads_make_a_page_that_says_what_is_missing(self):
        run = self.run_scene(SCENE, "plain", *sets(time__end=END))
        self.report(run)
        text = (self.folder / "report.html").read_text()
        self.assertIn("output.block_loads=on", text)
        self.assertNotIn("Who held which block", text)

    @unittest.skipUnless(has_matplotlib(), "no matplotlib")
    def test_wrong_use_is_refused(self):
        for words in ([], ["nowhere"], [self.folder], ["nowhere", "--output", "page.pdf"], ["nowhere", "--times", "a"]):
            self.assert_one_problem(call("report", *words, folder=self.folder))

    @unittest.skipUnless(has_matplotlib(), "no matplotlib")
    def test_damaged_records_are_refused_and_named(self):
        run = self.run_scene(SCENE, "plain", *sets(time__end=END, balance__interval=10))
        header, first, *rest = (run / "balance.csv").read_text().splitlines()
        values = first.split(",")
        for name, value in (("repartitioned", "nan"), ("step", "inf"), ("halo_bytes", "many"), ("time_s", "nan")):
            values[header.split(",").index(name)] = value
            (run / "balance.csv").write_text("\n".join([header, ",".join(values), *rest]) + "\n")
            with self.subTest(name):
                self.assertIn("balance.csv", self.assert_one_problem(call("report", run, folder=self.folder)))
            values = first.split(",")
        (run / "balance.csv").write_text("\n".join([header, first, *rest]) + "\n")
        good = json.loads((run / "summary.json").read_text())
        for name, value in (("ranks", None), ("ranks", 0), ("wall_s", "long"), ("times_s", []), ("scene", 7)):
            (run / "summary.json").write_text(json.dumps({**good, name: value}))
            with self.subTest(name):
                self.assertIn("summary.json", self.assert_one_problem(call("report", run, folder=self.folder)))
        self.assertFalse((self.folder / "report.html").exists())

    def test_without_matplotlib_it_says_what_to_install(self):
        python = self.folder / "python"
        python.write_text('#!/bin/sh\nexec python3 -S "$@"\n')
        python.chmod(0o755)
        with unittest.mock.patch.dict(os.environ, MORAINE_PYTHON=str(python)):
            self.assertIn("apt-get install python3-matplotlib", self.assert_one_problem(call("report", "nowhere"), 4))
        with unittest.mock.patch.dict(os.environ, MORAINE_PYTHON=str(self.folder / "none")):
            self.assertIn("Install python3", self.assert_one_problem(call("report", "nowhere"), 4))


if __name__ == "__main__":
    moraine.main()
