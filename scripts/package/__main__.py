"""moraine picture | converge [words]: called by the program. The work is done by the Python package, python/moraine.

Exit codes are the program's: 2 the input is wrong, 4 a package is missing or the disk failed.
"""
import importlib
import os
import pathlib
import subprocess
import sys

DEBIAN = "/usr/bin/python3"  # where Debian's packages are, whatever python3 comes first in PATH
#: of each command: its module, what it imports, and what is said and installed where that is missing
COMMANDS = {
    "picture": ("picture_command", "import numpy, h5py, matplotlib, PIL", "pictures need numpy, h5py and matplotlib", "python3-matplotlib python3-h5py"),
    "converge": ("converge_command", "import numpy, h5py\nimport sys\nif sys.version_info < (3, 11): import tomli", "converge needs numpy and h5py",
                 "python3-h5py"),
}


def need_packages(imports, need, packages):
    try:
        exec(imports, {})
    except ImportError as missing:
        if os.path.exists(DEBIAN) and "MORAINE_PYTHON" not in os.environ and sys.executable != DEBIAN and \
                subprocess.run([DEBIAN, "-c", imports], capture_output=True).returncode == 0:
            os.execv(DEBIAN, [DEBIAN, "-B", *sys.argv])
        print(f"moraine: {need} ({sys.executable}: {missing}). Install them by sudo apt-get install {packages}?", file=sys.stderr)
        sys.exit(4)


def main():
    module, *needs = COMMANDS[sys.argv[1]]
    here = pathlib.Path(__file__).resolve().parent
    sys.path[:0] = [str(place) for place in (here.parent / "python", here.parents[1] / "python") if place.is_dir()]
    need_packages(*needs)
    program = here.parent / "moraine"
    if program.is_file():
        os.environ.setdefault("MORAINE_PROGRAM", str(program))
    return importlib.import_module(f"moraine.{module}").main(sys.argv[2:])


if __name__ == "__main__":
    sys.exit(main())
