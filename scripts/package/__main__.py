"""moraine picture | converge | study | calibrate | stability [words]: called by the program. The work is done by the Python package, python/moraine.

Exit codes are the program's: 2 the input is wrong, 4 a package is missing or the disk failed.
"""
import importlib
import os
import pathlib
import subprocess
import sys

DEBIAN = "/usr/bin/python3"  # where Debian's packages are, whatever python3 comes first in PATH
HERE = pathlib.Path(__file__).resolve().parent


def others():
    """Pythons that may have the packages: the .venv that docs/python.md makes, in this folder or where the program was built, and Debian's."""
    found = [str(place / ".venv/bin/python3") for place in (pathlib.Path.cwd(), HERE.parent, *HERE.parents[1:4])]
    return [python for python in dict.fromkeys([*found, DEBIAN]) if os.path.exists(python) and python != sys.executable]

#: of each command: its module, what it imports, and what is said and installed where that is missing
COMMANDS = {
    "picture": ("picture_command", "import numpy, h5py, matplotlib, PIL", "pictures need numpy, h5py and matplotlib", "python3-matplotlib python3-h5py"),
    "converge": ("converge_command", "import numpy, h5py\nimport sys\nif sys.version_info < (3, 11): import tomli", "converge needs numpy and h5py",
                 "python3-h5py"),
    "study": ("scenario_command", "import numpy, h5py\nimport sys\nif sys.version_info < (3, 11): import tomli", "study needs numpy and h5py", "python3-h5py"),
    "stability": ("stability_command", "import numpy, h5py\nimport sys\nif sys.version_info < (3, 11): import tomli", "stability needs numpy and h5py",
                  "python3-h5py"),
    "calibrate": ("calibration_command", "import numpy, h5py, scipy, emcee", "calibrate needs numpy, h5py, scipy and emcee",
                  "python3-h5py python3-scipy python3-emcee"),
}


def need_packages(imports, need, packages):
    try:
        exec(imports, {})
    except ImportError as missing:
        for python in others() if "MORAINE_PYTHON" not in os.environ and "MORAINE_SECOND_TRY" not in os.environ else []:
            if subprocess.run([python, "-c", imports], capture_output=True).returncode == 0:
                os.environ["MORAINE_SECOND_TRY"] = "1"
                os.execv(python, [python, "-B", *sys.argv])
        print(f"moraine: {need} ({sys.executable}: {missing}). Install them by sudo apt-get install {packages}?", file=sys.stderr)
        sys.exit(4)


def main():
    module, *needs = COMMANDS[sys.argv[1]]
    sys.path[:0] = [str(place) for place in (HERE.parent / "python", HERE.parents[1] / "python") if place.is_dir()]
    need_packages(*needs)
    program = HERE.parent / "moraine"
    if program.is_file():
        os.environ.setdefault("MORAINE_PROGRAM", str(program))
    return importlib.import_module(f"moraine.{module}").main(sys.argv[2:])


if __name__ == "__main__":
    sys.exit(main())
