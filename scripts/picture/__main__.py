"""moraine picture RUN_DIR [options]: called by the program. The work is done by the Python package, python/moraine.

Exit codes are the program's: 2 the input is wrong, 4 a package is missing or the disk failed.
"""
import os
import pathlib
import subprocess
import sys

DEBIAN = "/usr/bin/python3"  # where Debian's packages are, whatever python3 comes first in PATH
NEEDS = "import numpy, h5py, matplotlib, PIL"


def need_packages():
    try:
        exec(NEEDS)
    except ImportError as missing:
        if os.path.exists(DEBIAN) and "MORAINE_PYTHON" not in os.environ and sys.executable != DEBIAN and \
                subprocess.run([DEBIAN, "-c", NEEDS], capture_output=True).returncode == 0:
            os.execv(DEBIAN, [DEBIAN, "-B", *sys.argv])
        print(f"moraine: pictures need numpy, h5py and matplotlib ({sys.executable}: {missing}). Install them by "
              "sudo apt-get install python3-matplotlib python3-h5py?", file=sys.stderr)
        sys.exit(4)


def main():
    here = pathlib.Path(__file__).resolve().parent
    sys.path[:0] = [str(place) for place in (here.parent / "python", here.parents[1] / "python") if place.is_dir()]
    need_packages()
    from moraine import picture
    return picture.main()


if __name__ == "__main__":
    sys.exit(main())
