"""All tests of the Python package, its doctests too. Exit code 77: no Python with numpy and h5py, nothing was tested.

The environment is that of tests/program/moraine.py. Words, if any, name tests, as of unittest.
"""
import os
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
PACKAGE = HERE.parents[1] / "python"
OTHER = "/usr/bin/python3"  # where Debian's packages are, when python3 is another


def has(python):
    return subprocess.run([python, "-c", "import numpy, h5py"], capture_output=True).returncode == 0


def main():
    if not has(sys.executable):
        if os.path.exists(OTHER) and has(OTHER):
            os.execv(OTHER, [OTHER, *sys.argv])
        print("SKIPPED: no numpy and h5py. apt install python3-h5py, or -DMORAINE_PYTHON=<a python that has them>?")
        return 77
    sys.path[:0] = [str(PACKAGE), str(HERE)]
    os.environ["PYTHONPATH"] = str(PACKAGE)
    os.environ.setdefault("OMPI_ALLOW_RUN_AS_ROOT", "1")
    os.environ.setdefault("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
    sys.stdout.reconfigure(line_buffering=True)
    import unittest
    words = sys.argv[1:] or ["discover", "-s", str(HERE), "-t", str(HERE)]
    return 0 if unittest.main(None, argv=["run_all.py", *words], verbosity=2, exit=False).result.wasSuccessful() else 1


sys.exit(main())
