"""The guide is true and readable: links hold, pages and paragraphs are short, its scenes are good, its commands are known.

scripts/docs builds the site of it, with warnings as errors.
"""
import re
import subprocess

import moraine
from runs_for_tests import ROOT, PackageTest, folder, program

PAGES = sorted((ROOT / "docs/guide").rglob("*.md")) + sorted((ROOT / "docs/theory").glob("*.md")) + [ROOT / "docs/gallery.md"]


def blocks_of(page):
    return re.findall(r"^```(\w*)[^\n]*\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)


def text_of(page):
    return re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)


def anchors_of(page):
    """As browsers and repositories name the headings of a page."""
    headings = re.findall(r"^#+ (.*)$", text_of(page), re.MULTILINE)
    named = set(re.findall(r'<a id="([^"]+)"></a>', page.read_text()))
    return named | {re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", heading.lower()).strip()) for heading in headings}


class Guide(PackageTest):
    def test_pages_and_paragraphs_are_short_and_speak_of_no_codes(self):
        self.assertGreaterEqual(len(PAGES), 9)
        for page in PAGES:
            with self.subTest(page.name):
                self.assertLess(len(page.read_text().splitlines()), 200)
                for paragraph in re.split(r"\n\s*\n", text_of(page)):
                    if not paragraph.lstrip().startswith("|"):
                        longest = max(map(len, re.split(r"\n(?=\* )", paragraph)))  # entries of a list are paragraphs
                        self.assertLess(longest, 500, paragraph)
                self.assertNotRegex(text_of(page), r"\basked\b|\bissue \d|\bGATE\b|\bTARGET\b")

    def test_every_link_of_the_documents_holds(self):
        pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "benchmarks").rglob("*.md"), ROOT / "python/README.md"]
        for page in pages:
            for link in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`\n]*`", "", text_of(page))):
                if re.match(r"\w+:", link):
                    continue
                path, _, anchor = link.partition("#")
                target = (page.parent / path).resolve() if path else page
                with self.subTest(f"{page.relative_to(ROOT)}: {link}"):
                    self.assertTrue(target.exists())
                    if anchor and target.suffix == ".md":
                        self.assertIn(anchor, anchors_of(target))

    def test_the_scene_of_the_guide_is_good(self):
        scenes = [text for kind, text in blocks_of(ROOT / "docs/guide/own-scene.md") if kind == "toml"]
        self.assertEqual(len(scenes), 1)
        path = folder("barrier.toml")
        path.write_text(scenes[0])
        found = moraine.check(path)
        said = [text for kind, text in blocks_of(ROOT / "docs/guide/own-scene.md") if text.startswith("barrier.toml: good")]
        self.assertIn(f"particles  {found.particles}\n", said[0])
        self.assertRegex(said[0], rf"steps      {found.steps}( of \d+ substeps)? to")

    def test_the_law_of_the_tutorial_is_good(self):
        page = ROOT / "docs/guide/tutorials/own-law.md"
        blocks = {kind: text for kind, text in blocks_of(page) if kind}
        before, _, after = (ROOT / "inputs/first_scene.toml").read_text().partition("[[material]]")
        scene = folder("healing.toml")
        (scene.parent / "my_clay.hpp").write_text(blocks["cpp"])
        scene.write_text(before.replace('"pressure"', '"remoulding"') + blocks["toml"] + after[after.index("[[body]]"):])
        found = moraine.check(scene, options=["--allow-code", "--kernel-cache", "none"])
        self.assertRegex(found.values["law"][0], 'clay: my_clay.hpp:[0-9a-f]{16}, "thixotropic-clay"')

    def test_commands_of_the_guide_name_scenes_and_keys_that_are_there(self):
        """Each `moraine run` and `moraine check` of a shipped scene is checked with its --set."""
        tried = 0
        for page in PAGES:
            for kind, text in blocks_of(page):
                for words in re.findall(r"build/release/moraine (?:run|check|converge) (inputs/\S+)([^\n]*)", text if not kind else ""):
                    keys = [key.strip("'") for key in re.findall(r"--set (\S+)", words[1])]
                    done = subprocess.run([program.PROGRAM, "check", str(ROOT / words[0]), "--device", "cpu", *(w for key in keys for w in ("--set", key))],
                                          capture_output=True, text=True)
                    self.assertEqual(done.returncode, 0, f"{page.name}: {words}: {done.stderr}")
                    tried += 1
        self.assertGreater(tried, 7)
