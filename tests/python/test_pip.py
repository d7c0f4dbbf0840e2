"""`pip install .` of a clean copy, without network; and the package's types by mypy."""
import importlib.util
import os
import shutil
import subprocess
import sys
import unittest

from runs_for_tests import ROOT, PackageTest, folder

HAS_PIP = all(importlib.util.find_spec(name) for name in ("pip", "setuptools", "wheel"))


class Pip(PackageTest):
    @unittest.skipUnless(HAS_PIP, "no pip, setuptools and wheel")
    def test_what_pip_installs_is_the_package_and_its_version(self):
        copy, target = folder("copy"), folder("installed")
        left_out = shutil.ignore_patterns("__pycache__", "*.egg-info", "build")
        shutil.copytree(ROOT / "python", copy / "python", ignore=left_out)
        shutil.copy(ROOT / "pyproject.toml", copy)
        done = subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-index", "--no-deps",
                               "--no-build-isolation", "--target", target, copy], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        wanted = {path.name for path in (ROOT / "python/moraine").iterdir() if path.suffix in (".py", ".typed")}
        self.assertEqual({path.name for path in (target / "moraine").iterdir() if path.is_file()}, wanted)
        asked = "import importlib.metadata, moraine; print(moraine.__file__, importlib.metadata.version('moraine'))"
        done = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, cwd=folder("."), env={**os.environ, "PYTHONPATH": str(target)})
        self.assertEqual(done.stdout.split(), [str(target / "moraine/__init__.py"), (ROOT / "python/VERSION").read_text().strip()], done.stderr)

    @unittest.skipUnless(importlib.util.find_spec("mypy"), "no mypy")
    def test_types_are_strict(self):
        done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--config-file", ROOT / "pyproject.toml", "--cache-dir", folder("mypy"), ROOT / "python/moraine"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout[-3000:] + done.stderr)


if __name__ == "__main__":
    unittest.main()
