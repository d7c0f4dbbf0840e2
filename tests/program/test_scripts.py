"""The scripts that build and run, with a cmake that only says when it was there."""
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import time

import moraine
from moraine import INPUTS, sets, summary

SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "scripts"
SCENE = INPUTS / "slurry_runout.toml"
CMAKE = """#!/bin/sh
[ -z "$CMAKE_FAILS" ] || exit 7
echo "begin $*" >>"$LOG"
for _ in $(seq 500); do [ -e "$GO" ] || sleep 0.02; done
echo end >>"$LOG"
"""


class Scripts(moraine.ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "scripts").mkdir()
        shutil.copy(SCRIPTS / "prepare.sh", self.folder / "scripts")
        self.write(CMAKE, "cmake").chmod(0o755)
        self.log, self.go = self.folder / "log", self.folder / "go"
        self.environment = {**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}", "LOG": str(self.log),
                            "GO": str(self.go)}

    def build(self, **more):
        words = ["bash", "-c", "source scripts/prepare.sh && build_preset release moraine && echo built"]
        return subprocess.Popen(words, cwd=self.folder, env={**self.environment, **more}, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)

    def test_a_second_build_into_a_folder_waits_for_the_first(self):
        first = self.build()
        while not self.log.exists():
            self.assertIsNone(first.poll())
        second = self.build()
        for line in second.stderr:
            if "another build into build/release is under way" in line:
                break
        else:
            self.fail("the second did not wait")
        self.assertEqual(len(self.log.read_text().splitlines()), 1)
        self.go.write_text("")
        for build in (first, second):
            self.assertIn("built", build.communicate(timeout=60)[0])
            self.assertEqual(build.returncode, 0)
        words = [line.split()[0] for line in self.log.read_text().splitlines()]
        self.assertEqual(words, ["begin", "end"] * (len(words) // 2))

    def test_a_build_that_fails_keeps_its_exit_code_and_leaves_the_folder_free(self):
        for _ in range(2):
            build = self.build(CMAKE_FAILS="1")
            out, err = build.communicate(timeout=60)
            self.assertEqual((build.returncode, out), (4, ""), err)
            self.assertIn("configuring failed", err)


def take_memory(pid):
    """No more memory for it: an error of one rank in its step, as that of its device is, of which the others know nothing."""
    size = 4096 * int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[0])
    resource.prlimit(pid, resource.RLIMIT_AS, (size, size))


class GoesOn(moraine.ProgramTest):
    """scripts/run --restarts, of which ranks are killed or get no more memory. MORAINE_KILLS: how many."""

    KEYS = sets(time__end=1.0, output__interval=0.1, output__checkpoint_wall_interval=0.1)

    def setUp(self):
        super().setUp()
        for path in (self.folder / "scripts", self.folder / "build" / "release"):
            path.mkdir(parents=True)
        for name in ("run", "prepare.sh"):
            shutil.copy(SCRIPTS / name, self.folder / "scripts")
        (self.folder / "scripts" / "packages.txt").write_text("")
        (self.folder / "build" / "release" / "moraine").symlink_to(moraine.PROGRAM)
        self.write("#!/bin/sh\n", "cmake").chmod(0o755)
        self.environment = {**moraine.environment(), "PATH": f"{self.folder}:{os.environ['PATH']}"}

    def ranks_of(self, output):
        """Process ids of the ranks that run there."""
        pids = []
        for path in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                words = (path / "cmdline").read_bytes().split(b"\0")
                same = os.path.samefile(path / "exe", moraine.PROGRAM)
            except OSError:
                continue
            if same and str(output).encode() in words:
                pids.append(int(path.name))
        return pids

    @staticmethod
    def steps(output, pid):
        """Whether a rank has got as far as a row: MPI that gets no more memory while it starts waits for ever."""
        try:
            return (output / "history.csv").stat().st_mtime > os.stat(f"/proc/{pid}").st_mtime
        except OSError:
            return False

    def run_and_kill(self, name, kills, moments):
        output, done = self.folder / name, 0
        words = ["bash", "scripts/run", "-n", "2", "--restarts", str(kills), str(SCENE), "--output", str(output),
                 "--device", "cpu", "--quiet", *self.KEYS]
        job = subprocess.Popen(words, cwd=self.folder, env=self.environment, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True, stdin=subprocess.DEVNULL)
        while job.poll() is None and done < kills:
            time.sleep(moments.uniform(0.1, 0.8))
            pids = self.ranks_of(output)
            if pids:
                pid, starves = moments.choice(pids), done % 3 == 1
                if starves and not self.steps(output, pid):
                    continue
                take_memory(pid) if starves else os.kill(pid, signal.SIGKILL)
                done += 1
                while set(pids) & set(self.ranks_of(output)):
                    time.sleep(0.01)
        out, err = job.communicate(timeout=300)
        self.assertEqual(job.returncode, 0, err)
        return output, done, err

    def test_a_run_of_which_ranks_are_killed_goes_on_by_itself_to_the_same_answer(self):
        whole = self.run_scene(SCENE, "whole", *self.KEYS, ranks=2)
        wanted, moments, left, number = int(os.environ.get("MORAINE_KILLS", 3)), random.Random(7), 0, 0
        left = wanted
        while left > 0:
            number += 1
            output, done, err = self.run_and_kill(f"killed-{number}", min(left, 5), moments)
            left -= max(done, 1)
            self.assertIn("going on from", err)
            self.assertEqual(summary(output)["state_hash"], summary(whole)["state_hash"])
            self.assertEqual((output / "history.csv").read_text(), (whole / "history.csv").read_text())
            shutil.rmtree(output)

    def test_what_is_no_loss_is_not_tried_again(self):
        words = ["bash", "scripts/run", "--restarts", "3", str(SCENE), "--output", "out", "--device", "cpu", "--set",
                 "domain.cell=-1"]
        done = subprocess.run(words, cwd=self.folder, env=self.environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertNotIn("going on", done.stderr)


if __name__ == "__main__":
    moraine.main()
