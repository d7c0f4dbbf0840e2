"""moraine report: one page about runs that opens offline, its plots as files, and what it refuses."""
import csv
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import unittest.mock
import xml.etree.ElementTree
from html.parser import HTMLParser

import chromium
import moraine
import valley
from moraine import INPUTS, call, sets, summary, table

SCENE = INPUTS / "slurry_runout.toml"
END = 0.02 if moraine.SLOW else 0.1
ASK = "import matplotlib, h5py"
SHOTS = os.environ.get("MORAINE_SCREENSHOTS")  # a folder to keep screenshots in, to look at them


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
        if tag not in ("meta", "link", "br", "img", "input"):
            self.open.append(tag)
        if tag in ("link", "iframe"):
            self.fetched.append(tag)
        for name in ("href", "xlink:href", "src"):
            if not found.get(name, "#").startswith(("#", "data:image/png;base64,")):
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
    @classmethod
    def setUpClass(cls):
        cls.kept = tempfile.TemporaryDirectory(prefix="moraine-")
        cls.addClassCleanup(cls.kept.cleanup)

    def run_once(self, scene, name, *words, ranks=1):
        """A run that several tests look at is made once; each has a copy of its own. One name, one run."""
        made = pathlib.Path(self.kept.name) / name
        if not made.exists():
            self.run_scene(scene, name, *words, ranks=ranks).rename(made)
        return pathlib.Path(shutil.copytree(made, self.folder / name))

    def runs(self):
        keys = sets(time__end=END, balance__interval=10, output__block_loads="on")
        return [self.run_once(SCENE, name, "--partitioner", name.split("-")[0], *keys, ranks=int(name[-1]))
                for name in ("slabs-2", "morton-2", "morton-3")]

    def report(self, *words, code=0):
        ended = call("report", *words, folder=self.folder)
        self.assertEqual(ended.code, code, ended)
        return ended

    @unittest.skipUnless(has_matplotlib(), "no matplotlib")
    def test_one_page_holds_everything(self):
        runs = self.runs()
        self.assertEqual(call("replay", runs[1], "--ranks", "4,16").code, 0)
        def as_if(**changes):  # whatever else the machine does
            for run in runs:
                found = summary(run)
                (run / "summary.json").write_text(json.dumps({**found, "imbalance_time_mean": found["imbalance_mean"], **changes}))
        as_if(stepping_s=0.5)
        self.report(*runs, "--output", "page.html", "--times", f"0,{END}")
        text = (self.folder / "page.html").read_text()
        self.assertNotIn("Strong scaling", Page(text).headings)  # runs of less than a second tell nothing of speed
        self.assertIn("(less than 1 s)", text)
        as_if(stepping_s=10.0)
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
        self.assertEqual(len([figure for figure in figures if "xmlns" in figure]), 5)  # of matplotlib; charts are of the page
        for figure in figures:
            xml.etree.ElementTree.fromstring(figure)
        self.assertLess(page.headings.index("The flow"), page.headings.index("Where the time went"))
        self.assertEqual(len([heading for heading in page.headings if heading.startswith("The flow")]), 1)  # one answer, one flow
        self.assertIn("The same flow, shared out in several ways", page.headings)
        quick, slow = sorted(found[:2], key=lambda s: -s["particle_steps_per_s"])
        ratio = quick["particle_steps_per_s"] / slow["particle_steps_per_s"]
        self.assertIn(f"is {ratio:.2f} times as fast", text)
        self.assertIn(f"On 2 ranks {quick['partitioner']}-2 (", text)
        self.assertNotIn("Side by side", page.headings)  # they did the same
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
        run = self.run_scene(SCENE, "plain", *sets(time__end=END), ranks=2)
        self.report(run)
        text = (self.folder / "report.html").read_text()
        self.assertIn("output.block_loads=on", text)
        self.assertNotIn("Who held which block", text)

    def structure_run(self, *words, name="pipe"):
        """A pipe that is pushed into clay, on one rank."""
        keys = sets(domain__cell=0.2, time__end=0.4, output__interval=0.1)
        run = self.run_scene if words else self.run_once
        return run(INPUTS / "pipe_penetration.toml", name, *keys, *words)

    @unittest.skipUnless(has_matplotlib(), "no matplotlib")
    def test_the_flow_comes_first_with_pictures_structures_and_a_slider(self):
        self.report(self.structure_run())
        text = (self.folder / "report.html").read_text()
        page = Page(text)
        self.assertEqual((page.open, page.fetched), ([], []))
        for heading in ("Depth along x", "Energies", "Energy budget", "Force on pipe", "Largest speed", "Move through the run"):
            self.assertIn(f"<h3>{heading}</h3>", text)
        stills = text.split('class="stills')[1].split("movie")[0]
        self.assertEqual(stills.count("<img "), 5)
        self.assertEqual(stills.count(">pipe</b>"), 5)  # its name stands in each picture
        self.assertIn("speed [m/s]", text)
        frames = json.loads(re.search(r'<script type="application/json">(.*?)</script>', text, re.S).group(1))
        self.assertEqual([f"{float(time):.1f}" for time in frames["times"]], ["0.0", "0.1", "0.2", "0.3", "0.4"])
        self.assertEqual([len(views) for views in frames["frames"]], [1] * 5)
        self.assertLess(len(text), 300_000)
        for name in ("Imbalance over time", "Halo volume", "Migration volume", "Decisions of the trigger", "Where the time went"):
            self.assertNotIn(name, page.headings)  # one rank: these would say nothing
        self.assertRegex(text, r"s on one rank, of which \d+ % computing")
        with open(self.folder / "report_files/force_0_0.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 2 * len((self.folder / "pipe/structures.csv").read_text().splitlines()[1:]))

    @unittest.skipUnless(has_matplotlib(), "no matplotlib")
    def test_methods_stand_side_by_side_with_what_differs_and_what_it_changed(self):
        runs = [self.structure_run(*sets(numerics__transfer=name, time__cfl=0.5), name=name) for name in ("apic", "flip")]
        self.report(*runs)
        text = (self.folder / "report.html").read_text()
        page = Page(text)
        self.assertEqual((page.open, page.fetched, len(page.ids)), ([], [], len(set(page.ids))))
        self.assertEqual(page.headings[1:4], ["Side by side", "The flow of apic", "The flow of flip"])
        table_text = text.split("<h2>Side by side</h2>")[1].split("</table>")[0]
        self.assertEqual(re.findall(r'<th [^>]*>([^<]*)</th>', table_text), ["run", "numerics.transfer", "largest speed [m/s]", "force on pipe [kN]", "wall [s]"])
        rows = [re.findall("<td>([^<]*)</td>", row) for row in table_text.split("<tr>")[2:]]
        self.assertEqual([row[:2] for row in rows], [["apic", "apic"], ["flip", "flip"]])
        for run, row in zip(runs, rows):
            force = max((r["force_x_N"] ** 2 + r["force_y_N"] ** 2) ** 0.5 for r in table(run, "structures.csv"))
            self.assertAlmostEqual(float(row[3]), force / 1e3, delta=1e-3 * force / 1e3)
        beside = text.split("<h3>At the same times</h3>")[1].split('class="charts"')[0]
        self.assertEqual(re.findall(r"<h4>(\w+), t = ([\d.]+) s</h4>", beside), [(name, time) for time in ("0.1", "0.3", "0.4") for name in ("apic", "flip")])
        self.assertEqual(beside.count("<img "), 6)
        with open(self.folder / "report_files/forces_0.csv", newline="") as file:
            self.assertEqual({row["line"] for row in csv.DictReader(file)}, {"apic", "flip"})
        levels = [runs[0], self.structure_run(*sets(domain__cell=0.1), name="fine")]
        (levels[1] / "scene.json").unlink()  # of an older version: then only what summary.json says is compared
        self.assertEqual(self.report(*levels).err, "")
        self.assertIn("<h2>Side by side</h2>", (self.folder / "report.html").read_text())

    def valley_run(self):
        self.write(valley.grid(), "valley.asc"), self.write(valley.AREA, "area.csv")
        return self.run_scene(self.write(valley.SCENE), "valley", "--device", "cpu", *sets(time__end=0.6, output__interval=0.15))

    @unittest.skipUnless(has_matplotlib(), "no matplotlib")
    def test_hazard_maps_lie_over_the_ground_with_scale_and_legend(self):
        run = self.valley_run()
        self.report(run)
        text = (self.folder / "report.html").read_text()
        page = Page(text)
        self.assertEqual((page.open, page.fetched), ([], []))
        shown = text.split("<h3>Hazard maps</h3>")[1]
        names = {path.stem for path in (run / "maps").iterdir() if path.suffix in (".tif", ".asc")}
        self.assertEqual(set(re.findall(r'id="map-(\w+)-valley"', shown)), names)
        for words in ("reached by the flow", "height of the ground, every", '<b class="scaled">5 m</b>', "largest depth [m]", "linear-gradient"):
            self.assertIn(words, shown)
        self.assertNotIn("The ground is not shown", shown)
        (self.folder / "valley.asc").rename(self.folder / "gone.asc")
        self.report(run)
        self.assertIn("The ground is not shown", (self.folder / "report.html").read_text())
        for path in (run / "maps").glob("max_depth.*"):
            path.write_bytes(path.read_bytes()[:40])
        self.assertEqual(self.report(run).err, "")
        text = (self.folder / "report.html").read_text()
        self.assertIn("Hazard maps of valley: ", text.split("Not on this page")[1])
        self.assertIn("<h3>Energies</h3>", text)

    @unittest.skipUnless(has_matplotlib(), "no matplotlib")
    def test_the_first_page_of_a_run_over_terrain_says_what_was_asked_and_what_came(self):
        self.write("name,x,y\nroad,9.5,6.5\n", "gauges.csv"), self.write("name,x,y\nneck,7,10\nneck,7,2\n", "lines.csv")
        self.valley_run()
        keys = sets(time__end=0.6, hazard__gauges="gauges.csv", hazard__sections="lines.csv", output__fields='["velocity"]')
        one, two = (self.run_scene(self.folder / "scene.toml", name, "--device", "cpu", *keys, *sets(terrain__contact__friction=friction))
                    for name, friction in (("one", 0.2), ("two", 0.05)))
        self.report(one)
        first = (self.folder / "report.html").read_text().split("<h2>")[1]
        for words in ("scar is 2 cells thick", "2 cells (TOO FEW", "drucker-prager: density 1800", "voellmy: friction 0.2, xi 500", "valley.asc (", "<td>road</td>",
                      "<td>neck</td>", "travel angle", "particles counted alike", "left the domain", "moraine converge</code> of this scene tells", "Nothing is taken up from the bed"):
            self.assertIn(words, first)
        self.report(one, two)
        self.assertIn("Largest depth: one less two", (self.folder / "report.html").read_text())
        text = (self.folder / "report.html").read_text()
        self.assertIn("friction of the bed, and the rest", text)
        self.assertNotIn(">unaccounted<", text)
        self.assert_one_problem(call("report", one, "--errors", self.folder, folder=self.folder))
        self.assert_one_problem(call("report", one, "--with", self.folder / "none.csv", folder=self.folder))

    @unittest.skipUnless(has_matplotlib(), "no matplotlib")
    def test_names_that_would_lie_over_each_other_on_a_phone_go_below_their_place(self):
        words = ("import numpy, hazards\nfrom moraine.grids import Grid\nsheet = hazards.Sheet(Grid(numpy.zeros((60, 130)), (1.0, 1.0), 2.0), None)\n"
                 "print(sheet.labels([('head', (30, 66)), ('channel', (50, 68)), ('neck', (56, 85))]))")
        python = next(p for p in ("python3", "/usr/bin/python3") if subprocess.run([p, "-c", ASK], capture_output=True).returncode == 0)
        done = subprocess.run([python, "-c", words], capture_output=True, text=True, env={**os.environ, "PYTHONPATH": f"{INPUTS.parent}/scripts/report:{INPUTS.parent}/python"})
        self.assertEqual(re.findall(r"([+-]) 1.1rem\)\">(\w+)", done.stdout), [("-", "head"), ("+", "channel"), ("-", "neck")], done.stderr)

    @unittest.skipUnless(has_matplotlib() and chromium.PROGRAM, "no matplotlib or chromium")
    def test_the_page_is_printed_as_pdf(self):
        self.report(self.structure_run(), "--pdf")
        self.assertEqual((self.folder / "report.pdf").read_bytes()[:5], b"%PDF-")

    @unittest.skipUnless(has_matplotlib(), "no matplotlib")
    def test_warnings_and_numbers_that_are_none_are_shown_without_a_traceback(self):
        run = self.structure_run()
        found = summary(run)
        found.update(over_filling=0.081, warnings=[
            {"problem": "filling", "amount": 0.081, "step": 120, "time_s": 0.3, "place_m": [1.5, 0.25]},
            {"problem": "energy", "amount": None, "step": 130, "time_s": None, "place_m": None}, "no warning at all"])
        (run / "summary.json").write_text(json.dumps(found))
        for name in ("history.csv", "structures.csv"):
            header, *rows = (run / name).read_text().splitlines()
            words = header.split(",")
            for k, row in enumerate(rows):
                values = row.split(",")
                keep = ("step", "structure", "time_s") if k % 2 else words
                rows[k] = ",".join(value if word in keep else "nan" for word, value in zip(words, values))
            (run / name).write_text("\n".join([header, *rows]) + "\n")
        self.assertEqual(self.report(run).err, "")
        text = (self.folder / "report.html").read_text()
        self.assertIn("fronts fall short by it (8.1 %), first at t = 0.3 s, step 120, near (1.5, 0.25) m", text)
        self.assertIn("there was more energy than there had been, first at t = not known s", text)
        self.assertIn("<dd>8.1 %</dd>", text)
        self.assertNotRegex(text, r'points="[^"]*nan')
        self.assertIn(">pipe</b>", text)
        columns = [k for k, word in enumerate(words) if word not in ("step", "structure", "time_s")]
        rows = [",".join("nan" if k in columns else value for k, value in enumerate(row.split(","))) for row in rows]
        (run / name).write_text("\n".join([header, *rows]) + "\n")
        self.assertEqual(self.report(run).err, "")
        self.assertIn("The records of it hold no numbers", (self.folder / "report.html").read_text())

    @unittest.skipUnless(has_matplotlib(), "no matplotlib")
    def test_a_run_that_was_killed_is_shown_as_far_as_it_is(self):
        whole, killed = self.structure_run(), self.folder / "killed"
        killed.mkdir()
        for name in ("history.csv", "structures.csv", "scene.json", "particles.vtkhdf"):
            (killed / name).write_bytes((whole / name).read_bytes())
        with open(killed / "history.csv", "a") as file:
            file.write("17,0.4,")  # a torn line
        last = table(whole, "history.csv")[-1]
        for words in ([killed], [killed, whole]):
            self.assertEqual(self.report(*words).err, "")
            text = (self.folder / "report.html").read_text()
            self.assertEqual(Page(text).open, [])
            self.assertIn("This run has not ended", text)
            self.assertIn(f"its last output, at t = {last['time_s']:.4g} s", text)
            for words in ("<h3>Energies</h3>", "<h3>Force on pipe</h3>", "killed, not ended", "it has no summary.json yet", "<img"):
                self.assertIn(words, text)
        (killed / "history.csv").write_text((killed / "history.csv").read_text().splitlines()[0] + "\n")
        self.assertIn("history.csv has no row", self.assert_one_problem(call("report", killed, folder=self.folder)))

    @unittest.skipUnless(has_matplotlib(), "no matplotlib")
    def test_a_run_without_particles_has_a_page_without_pictures(self):
        self.report(self.structure_run("--no-particles"))
        text = (self.folder / "report.html").read_text()
        self.assertIn("Did the run have --no-particles?", text)
        self.assertIn("<h3>Force on pipe</h3>", text)
        self.assertNotIn("<img", text)

    @unittest.skipUnless(has_matplotlib() and chromium.PROGRAM, "no matplotlib, or no Chromium")
    def test_chromium_shows_it_at_three_widths_light_and_dark(self):
        runs = [self.structure_run(), *self.runs()[:2]]
        for name, words in (("one", runs[:1]), ("many", runs), ("maps", [self.valley_run()])):
            self.report(*words, "--output", f"{name}.html")
        with chromium.Browser() as browser:
            for name in ("one", "many", "maps"):
                for width in (390, 768, 1400):
                    for dark in (False, True):
                        with self.subTest(f"{name} {width} {dark}"):
                            browser.open(self.folder / f"{name}.html", width, dark)
                            self.check_shown(browser, width, dark)
                            if SHOTS:
                                browser.screenshot(f"{SHOTS}/{name}-{width}-{'dark' if dark else 'light'}.png")
            self.check_slider(browser)
            self.assertEqual(browser.messages, [])

    def check_shown(self, browser, width, dark):
        """Nothing wider than the window, no text below 11 pixels, ink that is far from the paper, all pictures there."""
        self.assertLessEqual(browser.value("document.documentElement.scrollWidth"), width)
        small = browser.value("""(() => {
            const found = [], walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
            while (walk.nextNode()) {
              const at = walk.currentNode.parentElement;
              if (!walk.currentNode.data.trim() || at.closest("script, style, title, defs") || !at.getClientRects().length) continue;
              const svg = at.closest("svg");
              const size = parseFloat(getComputedStyle(at).fontSize) * (svg ? Math.hypot(at.getScreenCTM().a, at.getScreenCTM().b) : 1);
              if (size < 10.99) found.push(size.toFixed(1) + " " + walk.currentNode.data.trim());
            }
            return found; })()""")
        self.assertEqual(small, [])
        ink, paper = (browser.value(f"getComputedStyle(document.body).{name}") for name in ("color", "backgroundColor"))
        ink, paper = (sum(map(int, re.findall(r"\d+", colour)[:3])) / 3 for colour in (ink, paper))
        self.assertGreater((ink - paper) * (1 if dark else -1), 150)
        self.assertTrue(browser.value("[...document.images].length > 4 && [...document.images].every(i => i.complete && i.naturalWidth > 0)"))

    def check_slider(self, browser):
        """It moves picture and time; Play goes to the end."""
        before = browser.value("document.querySelector('.movie img').src")
        browser.value("(() => { const r = document.querySelector('.movie input'); r.value = 2; r.dispatchEvent(new Event('input')); })()")
        self.assertNotEqual(browser.value("document.querySelector('.movie img').src"), before)
        time = browser.value("document.querySelector('.movie output').textContent")
        self.assertRegex(time, r"^t = \d.* s$")
        browser.value("document.querySelector('.movie button').click()")
        browser.value("new Promise(done => { const wait = setInterval(() => { if (document.querySelector('.movie button').textContent === 'Play') "
                      "{ clearInterval(wait); done(1); } }, 20); })")
        self.assertEqual(browser.value("(r => r.value === r.max)(document.querySelector('.movie input'))"), True)

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

    def test_without_packages_there_is_a_page_that_says_what_to_install(self):
        python = self.folder / "python"
        python.write_text('#!/bin/sh\nexec python3 -S "$@"\n')
        python.chmod(0o755)
        run = self.structure_run()
        with unittest.mock.patch.dict(os.environ, MORAINE_PYTHON=str(python)):
            self.assertIn("apt-get install python3-numpy python3-matplotlib python3-h5py", self.report(run).err)
            self.assert_one_problem(call("report", "nowhere"))
        text = (self.folder / "report.html").read_text()
        self.assertEqual(Page(text).open, [])
        for words in ("<h3>Energies</h3>", "<h3>Force on pipe</h3>", "The computation", "sudo apt-get install python3-numpy"):
            self.assertIn(words, text)
        self.assertNotIn("<img", text)
        self.assertTrue((self.folder / "report_files/energies_0.csv").exists())
        with unittest.mock.patch.dict(os.environ, MORAINE_PYTHON=str(self.folder / "none")):
            self.assertIn("Install python3", self.assert_one_problem(call("report", "nowhere"), 4))


if __name__ == "__main__":
    moraine.main()
