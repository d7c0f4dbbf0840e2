"""moraine converge SCENE.toml [options]: called by the program. The work is done by the Python package, python/moraine.

Exit codes are the program's: 2 the input is wrong, 4 a package is missing or the disk failed.
"""
import os
import pathlib
import subprocess
import sys

DEBIAN = "/usr/bin/python3"  # where Debian's packages are, whatever python3 comes first in PATH
NEEDS = "import numpy, h5py\nimport sys\nif sys.version_info < (3, 11): import tomli"


def need_packages():
    try:
        exec(NEEDS)
    except ImportError as missing:
        if os.path.exists(DEBIAN) and "MORAINE_PYTHON" not in os.environ and sys.executable != DEBIAN and \
                subprocess.run([DEBIAN, "-c", NEEDS], capture_output=True).returncode == 0:
            os.execv(DEBIAN, [DEBIAN, "-B", *sys.argv])
        print(f"moraine: converge needs numpy and h5py ({sys.executable}: {missing}). Install them by "
              "sudo apt-get install python3-h5py?", file=sys.stderr)
        sys.exit(4)


def main():
    here = pathlib.Path(__file__).resolve().parent
    sys.path[:0] = [str(place) for place in (here.parent / "python", here.parents[1] / "python") if place.is_dir()]
    need_packages()
    program = here.parent / "moraine"
    if program.is_file():
        os.environ.setdefault("MORAINE_PROGRAM", str(program))
    from moraine import converge_command
    return converge_command.main()


if __name__ == "__main__":
    sys.exit(main())
