"""`cmake --install`: what is installed works from where it is, and nothing else is."""
import os
import pathlib
import shutil
import subprocess
import unittest

import moraine
from moraine import INPUTS
from test_report import has_matplotlib

ROOT = INPUTS.parent
BUILD = pathlib.Path(os.environ.get("MORAINE_BUILD", ROOT / "build/release"))


class Install(moraine.ProgramTest):
    def installed(self):
        done = subprocess.run(["cmake", "--install", BUILD, "--prefix", "/usr"], env={**os.environ, "DESTDIR": str(self.folder / "root")},
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.folder / "root/usr"

    def call(self, prefix, *words, code=0):
        """In a folder that has nothing to do with the sources, without what the tests know of the program."""
        kept = {name: value for name, value in moraine.environment().items() if not name.startswith("MORAINE_")}
        done = subprocess.run([prefix / "bin/moraine", *map(str, words)], cwd=self.folder, env=kept, capture_output=True, text=True, stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    @unittest.skipUnless(shutil.which("cmake"), "no cmake")
    def test_program_scripts_and_scenes_work_from_where_they_are_installed(self):
        prefix = self.installed()
        self.assertEqual({str(path.relative_to(prefix)) for path in prefix.glob("*/*")}, {"bin/moraine", "share/moraine", "share/doc"})
        self.assertEqual({path.name for path in (prefix / "share/moraine/inputs").iterdir() if path.suffix == ".toml"}, {path.name for path in INPUTS.glob("*.toml")})
        self.assertEqual({path.name for path in (prefix / "share/doc/moraine").iterdir()}, {"README.md", "CHANGELOG.md", "CITATION.cff", "copyright"})
        for folder in ("scripts/report", "scripts/package", "python/moraine"):
            there = prefix / "share/moraine" / folder.replace("scripts/", "")
            self.assertEqual({path.name for path in there.iterdir()}, {path.name for path in (ROOT / folder).iterdir() if path.suffix in (".py", ".typed")})
        self.assertRegex(self.call(prefix, "--version"), rf"^moraine {(ROOT / 'python/VERSION').read_text().strip()} \(")
        scene = prefix / "share/moraine/inputs/first_scene.toml"
        self.call(prefix, "run", scene, "--set", "time.end=0.02", "--output", "first", "--quiet")
        self.assertIn("The report is", self.call(prefix, "report", "first"))
        if has_matplotlib():
            self.call(prefix, "picture", "first", "--times", "0", "--no-animation")
            self.assertTrue((self.folder / "first/pictures/speed-0.png").exists())
            study = self.call(prefix, "converge", scene, "--set", "time.end=0.02", "--quantity", "max_speed_m_s", "--output", "study")  # it starts the program
            self.assertIn("max_speed_m_s", study)
        shutil.move(prefix / "bin/moraine", self.folder / "moraine")
        (self.folder / "bin").mkdir()
        shutil.move(self.folder / "moraine", self.folder / "bin/moraine")
        self.assertRegex(self.call(self.folder, "report", "first", code=4), moraine.PROBLEM)

    @unittest.skipUnless(shutil.which("cpack") and shutil.which("dpkg-deb") and shutil.which("dpkg-shlibdeps"), "no cpack or dpkg-deb")
    def test_the_debian_package_has_what_is_installed_and_names_version_and_libraries(self):
        made = subprocess.run(["cpack", "-G", "DEB", "-B", self.folder / "deb"], cwd=BUILD, capture_output=True, text=True)
        self.assertEqual(made.returncode, 0, made.stdout + made.stderr)
        package, = (self.folder / "deb").glob("*.deb")
        version = (ROOT / "python/VERSION").read_text().strip()
        self.assertRegex(package.name, rf"^moraine_{version}_\w+\.deb$")
        told = subprocess.run(["dpkg-deb", "--field", package, "Package", "Version", "Depends"], capture_output=True, text=True).stdout
        self.assertIn(f"Package: moraine\nVersion: {version}\n", told)
        self.assertRegex(told, r"Depends: .*\blibhdf5")
        subprocess.run(["dpkg-deb", "--extract", package, self.folder / "unpacked"], check=True)
        unpacked, prefix = self.folder / "unpacked/usr", self.installed()
        self.assertEqual(*[{str(path.relative_to(place)) for path in place.rglob("*")} for place in (unpacked, prefix)])
        self.assertRegex(self.call(unpacked, "--version"), rf"^moraine {version} \(")

    @unittest.skipUnless(shutil.which("git") and (ROOT / ".git").exists(), "no git")
    def test_an_archive_of_the_sources_knows_its_commit(self):
        text = subprocess.run(["git", "archive", "HEAD", "cmake/commit.txt"], cwd=ROOT, capture_output=True).stdout
        head = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True).stdout.strip()
        self.assertIn(head, text)


if __name__ == "__main__":
    moraine.main()
