"""Runs the program as a user does, and reads what it writes. For the tests in this folder.

The environment names the program and how to start it on several ranks:
MORAINE_PROGRAM, MORAINE_MPIEXEC (a command, with its options and the flag before the number of ranks), and
MORAINE_SLOW=1 for builds (sanitizers, debug) that no limit of time is meant for.
"""
import csv
import json
import os
import pathlib
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = os.path.abspath(os.environ.get("MORAINE_PROGRAM", "build/release/moraine"))
MPIEXEC = shlex.split(os.environ.get("MORAINE_MPIEXEC", "mpirun --oversubscribe --bind-to none -n"))
SLOW = os.environ.get("MORAINE_SLOW", "0") == "1"
INPUTS = pathlib.Path(__file__).resolve().parents[2] / "inputs"

PROBLEM = re.compile(r"moraine: .+ \(.+\)\. .+\?")  # problem (why). suggestion?

# 64 particles in a tenth of a second: a block of jelly that falls on a rough floor between smooth walls.
SMALL_SCENE = """\
dimensions = 2
gravity = [0.0, -9.81]
[domain]
min = [0.0, 0.0]
max = [4.0, 2.0]
cell = 0.25
[time]
end = 0.1
cfl = 0.5
[[material]]
name = "jelly"
law = "neo-hookean"
density = 1000.0
young = 1.0e5
poisson = 0.3
[[body]]
name = "block"
material = "jelly"
shape = "box"
min = [1.0, 0.5]
max = [2.0, 1.5]
[[wall]]
face = "y-min"
kind = "no-slip"
[[wall]]
face = "x-min"
kind = "free-slip"
"""


class Ended:
    """What is left of a process: its exit code and its words."""

    def __init__(self, code, out, err):
        self.code, self.out, self.err = code, out, err
        self.lines = [line for line in err.splitlines() if line.strip()]

    def __repr__(self):
        return f"exit code {self.code}\n{self.out}{self.err}"


def environment(threads=1):
    extra = {"OMP_NUM_THREADS": str(threads), "GOMP_SPINCOUNT": "1000"}
    return {**os.environ, **extra}


def command(words, ranks=None):
    """Without a number of ranks the program is started without mpirun."""
    words = [str(word) for word in words]
    if ranks is None:
        return [PROGRAM, *words]
    return [MPIEXEC[0], "-q", *MPIEXEC[1:], str(ranks), PROGRAM, *words]


def sets(**keys):
    """sets(time__end=0.1) is --set time.end=0.1."""
    return [word for key, value in keys.items() for word in ("--set", f"{key.replace('__', '.')}={value}")]


def call(*words, ranks=None, threads=1, folder=None):
    done = subprocess.run(command(words, ranks), cwd=folder, env=environment(threads), capture_output=True,
                          text=True, stdin=subprocess.DEVNULL, timeout=600)
    return Ended(done.returncode, done.stdout, done.stderr)


class Job:
    """A parallel run that is not waited for."""

    def __init__(self, *words, ranks):
        self.started = subprocess.Popen(command(words, ranks), env=environment(), stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True, stdin=subprocess.DEVNULL)

    def ranks(self):
        """Process ids of the ranks."""
        return [pid for pid in map(int, filter(str.isdigit, os.listdir("/proc"))) if self._is_rank(pid)]

    def _is_rank(self, pid):
        try:
            parent = int(pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[1])
            return parent == self.started.pid and os.path.samefile(f"/proc/{pid}/exe", PROGRAM)
        except OSError:
            return False

    def wait_for(self, path, pattern):
        """Until a file of the run is there; returns its path."""
        for _ in range(60000):
            for found in sorted(pathlib.Path(path).glob(pattern)):
                return found
            if self.started.poll() is not None:
                raise AssertionError(f"ended before it wrote {pattern}: {self.started.stderr.read()}")
            time.sleep(0.002)
        raise AssertionError(f"no {pattern} in two minutes")

    def end(self, limit=30):
        """Exit code and words; fails if it goes on for longer than the limit [s]."""
        try:
            out, err = self.started.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            self.stop()
            raise AssertionError(f"the job went on for {limit} s") from None
        return Ended(self.started.returncode, out, err)

    def stop(self):
        if self.started.poll() is None:
            for pid in self.ranks():
                os.kill(pid, signal.SIGKILL)
            self.started.kill()
            self.started.communicate()


def summary(directory):
    return json.loads((pathlib.Path(directory) / "summary.json").read_text())


def table(directory, name):
    """Rows of history.csv or balance.csv, by column; numbers but for the columns that hold words."""
    words = ("reason", "plan", "structure")
    with open(pathlib.Path(directory) / name, newline="") as file:
        return [{key: value if key in words else float(value) for key, value in row.items()}
                for row in csv.DictReader(file)]


def checkpoints(directory):
    return sorted(pathlib.Path(directory).glob("checkpoint-*.h5"))


class ProgramTest(unittest.TestCase):
    """A test with a folder of its own, gone afterwards."""

    maxDiff = None

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="moraine-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, text, name="scene.toml"):
        path = self.folder / name
        path.write_text(text)
        return path

    def run_scene(self, scene, output, *words, ranks=1, threads=1, code=0):
        """Runs into self.folder/output and returns that directory."""
        directory = self.folder / output
        ended = call("run", scene, "--output", directory, "--quiet", *words, ranks=ranks, threads=threads)
        self.assertEqual(ended.code, code, ended)
        return directory

    def assert_one_problem(self, ended, code=2):
        """One message, said once, in the form problem (why). suggestion? Returns it."""
        self.assertEqual(ended.code, code, ended)
        self.assertEqual(len(ended.lines), 1, ended)
        self.assertRegex(ended.lines[0], "^" + PROBLEM.pattern + "$")
        self.assertEqual(ended.out, "")
        return ended.lines[0]


def allow_root():
    os.environ.setdefault("OMPI_ALLOW_RUN_AS_ROOT", "1")
    os.environ.setdefault("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")


def main():
    allow_root()
    sys.stdout.reconfigure(line_buffering=True)
    unittest.main(verbosity=2)
