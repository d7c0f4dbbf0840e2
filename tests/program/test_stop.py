"""A run that is killed, or stopped by a signal, goes on from its last checkpoint to the same answer."""
import os
import random
import shutil
import signal
import subprocess
import time
import unittest.mock

import moraine
from moraine import INPUTS, Job, checkpoints, sets, summary

SCENE = INPUTS / "slurry_runout.toml"
END = 0.1 if moraine.SLOW else 1.0
KEYS = sets(time__end=END, output__interval=END / 10)


# A system that gives no thread to who asks through std::thread.
THREADLESS = """
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <string.h>
typedef int create(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*), void* argument) {
    Dl_info who;
    if (dladdr(__builtin_return_address(0), &who) && strstr(who.dli_fname, "libstdc++")) return EAGAIN;
    return ((create*)dlsym(RTLD_NEXT, "pthread_create"))(thread, attributes, start, argument);
}
"""


class Stop(moraine.ProgramTest):
    @classmethod
    def setUpClass(cls):
        cls.undisturbed = None

    def start(self, name, *words, ranks):
        job = Job("run", SCENE, "--output", self.folder / name, "--quiet", *KEYS, *words, ranks=ranks)
        self.addCleanup(job.stop)
        return job

    def assert_goes_on(self, name, ranks):
        """In the same directory, to the answer and the records of a run that nobody disturbed."""
        if Stop.undisturbed is None:
            directory = self.run_scene(SCENE, "undisturbed", *KEYS, ranks=2)
            Stop.undisturbed = summary(directory)["state_hash"], (directory / "history.csv").read_text()
        last = checkpoints(self.folder / name)[-1]
        (self.folder / name / "checkpoint-999999999.h5.partial").write_text("cut short")
        directory = self.run_scene(SCENE, name, *KEYS, "--restart", last, ranks=ranks)
        self.assertEqual((summary(directory)["state_hash"], (directory / "history.csv").read_text()), Stop.undisturbed)
        self.assertEqual(sorted(directory.glob("*.partial")), [])

    def test_a_killed_rank_ends_the_job_and_the_last_checkpoint_restarts_it(self):
        moments = random.Random(3)
        for ranks, victim in ((2, 0), (3, 1)):
            with self.subTest(ranks=ranks, victim=victim):
                name = f"killed-{ranks}"
                job = self.start(name, *sets(output__checkpoint_interval=END / 30), ranks=ranks)
                job.wait_for(self.folder / name, "checkpoint-*.h5")
                time.sleep(moments.uniform(0, 0.3))
                pids = job.ranks()
                self.assertEqual(len(pids), ranks)
                os.kill(pids[victim], signal.SIGKILL)
                ended = job.end(limit=30)
                self.assertNotEqual(ended.code, 0, ended)
                self.assertFalse((self.folder / name / "summary.json").exists(), "killed in mid-run")
                self.assert_goes_on(name, ranks=5 - ranks)

    def check_stop(self, name, tell, ranks):
        job = self.start(name, ranks=ranks)
        job.wait_for(self.folder / name, "history.csv")
        time.sleep(0.2)
        self.assertEqual(len(job.ranks()), ranks)
        tell(job)
        ended = job.end()
        line = self.assert_one_problem(ended, code=5)
        (left,) = checkpoints(self.folder / name)
        self.assertIn(str(left), line)
        stopped = summary(self.folder / name)
        self.assertFalse((self.folder / name / "run.lock").exists())
        self.assertEqual(left.name, f"checkpoint-{stopped['steps']:09d}.h5")
        self.assertLess(stopped["simulated_time_s"], END)
        self.assert_goes_on(name, ranks=5 - ranks)

    def test_sigterm_to_one_rank_writes_a_checkpoint(self):
        self.check_stop("terminated", lambda job: os.kill(job.ranks()[1], signal.SIGTERM), ranks=3)

    def test_sigusr1_to_mpirun_writes_a_checkpoint(self):
        self.check_stop("warned", lambda job: job.started.send_signal(signal.SIGUSR1), ranks=2)

    def test_a_run_of_which_a_rank_is_lost_ends_by_its_watchdog(self):
        name, limit = "lost", 4 if moraine.SLOW else 1
        job = self.start(name, *sets(run__watchdog=limit, output__checkpoint_interval=END / 30), ranks=3)
        job.wait_for(self.folder / name, "checkpoint-*.h5")
        os.kill(job.ranks()[1], signal.SIGSTOP)  # its peers see what a dead link shows: nothing comes
        ended = job.end(limit=60)
        self.assertEqual(ended.code, 4, ended)
        for rank in (0, 2):
            self.assertRegex(ended.err, rf"rank {rank}: no step was finished for {limit} s "
                                        r"\(it is (in [a-z0-9]+|between phases), after step \d+\)\. Is .+\?")
        self.assert_goes_on(name, ranks=2)

    def test_a_rank_that_is_lost_before_the_scene_is_read_is_missed(self):
        """All ranks wait for the text of the scene, which comes through a pipe, when one is stopped."""
        os.mkfifo(self.folder / "fifo.toml")
        words = ("run", self.folder / "fifo.toml", "--output", self.folder / "missed", "--quiet", *sets(run__watchdog=0.5))
        job = Job(*words, ranks=3)
        self.addCleanup(job.stop)
        with open(self.folder / "fifo.toml", "w") as pipe:  # rank 0 has opened it, so all have started
            time.sleep(0.5)
            os.kill(job.ranks()[1], signal.SIGSTOP)
            pipe.write(SCENE.read_text())
        ended = job.end(limit=60)
        self.assertEqual(ended.code, 4, ended)
        for rank in (0, 2):
            self.assertRegex(ended.err, rf"rank {rank}: no step was finished for 0.5 s \(it is before its first phase, after step 0\)")

    def test_without_a_thread_for_the_watchdog_no_run_begins(self):
        if not shutil.which("cc"):
            self.skipTest("cc is missing. apt install gcc?")
        library = self.folder / "threadless.so"
        subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-x", "c", "-", "-o", library], input=THREADLESS, text=True, check=True)
        for ranks in (None, 2):
            with unittest.mock.patch.dict(os.environ, LD_PRELOAD=str(library)):
                ended = moraine.call("run", SCENE, "--output", self.folder / "none", "--quiet", *KEYS, ranks=ranks)
            line = self.assert_one_problem(ended, code=4)
            self.assertIn("rank 0 has no thread for the watchdog (Resource temporarily unavailable). Raise the limits", line)
            self.assertFalse((self.folder / "none").exists())

    def test_a_suspended_run_is_not_ended_by_its_watchdog(self):
        job = self.start("suspended", *sets(run__watchdog=1), ranks=2)
        job.wait_for(self.folder / "suspended", "history.csv")
        ranks = job.ranks()
        for tell, pause in ((signal.SIGSTOP, 2), (signal.SIGCONT, 0)):
            for pid in ranks:
                os.kill(pid, tell)
            time.sleep(pause)
        self.assertEqual(job.end(limit=60).code, 0)

    def test_ctrl_c_of_a_run_without_mpirun_writes_a_checkpoint(self):
        job = self.start("alone", ranks=None)
        job.wait_for(self.folder / "alone", "history.csv")
        job.started.send_signal(signal.SIGINT)
        line = self.assert_one_problem(job.end(), code=5)
        self.assertIn(str(checkpoints(self.folder / "alone")[0]), line)
        self.assert_goes_on("alone", ranks=2)

    def test_runs_without_mpirun_share_no_folder(self):
        """Open MPI's of such runs have one name, and who ends first would remove it from under who begins."""
        temporary = self.folder / "tmp"
        temporary.mkdir()
        with unittest.mock.patch.dict(os.environ, TMPDIR=str(temporary)):
            job = self.start("shares", ranks=None)
        job.wait_for(self.folder / "shares", "history.csv")
        self.assertEqual(list(temporary.iterdir()), [])
        self.assertEqual(job.end().code, 0)

    def test_what_is_no_run_yet_ends_at_once(self):
        os.mkfifo(self.folder / "fifo.toml")
        for tell in (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1):
            job = Job("check", self.folder / "fifo.toml", ranks=None)
            self.addCleanup(job.stop)
            time.sleep(0.5)
            self.assertIsNone(job.started.poll())
            job.started.send_signal(tell)
            self.assertEqual(job.end(limit=10).code, -tell)

    def test_a_second_run_into_a_directory_is_refused_until_the_first_has_ended_in_any_way(self):
        directory = self.folder / "one"
        first = self.start("one", *sets(time__end=60), ranks=2)
        first.wait_for(directory, "history.csv")
        words = ("run", SCENE, "--output", directory, "--quiet", "--overwrite", *KEYS)
        for ranks in (None, 2):
            line = self.assert_one_problem(moraine.call(*words, ranks=ranks))
            self.assertIn(f"another run writes into {directory} (process {first.ranks()[0]} on ", line)
        for pid in first.ranks():
            os.kill(pid, signal.SIGKILL)
        first.end()
        ended = moraine.call(*words, *sets(time__end=END / 30))
        self.assertEqual(ended.code, 0, ended)
        self.assertFalse((directory / "run.lock").exists())

    def test_overwriting_the_checkpoint_to_go_on_from_is_refused(self):
        keys = sets(time__end=END / 10, output__checkpoint_interval=END / 20)
        directory = self.run_scene(SCENE, "own", *keys)
        link = self.folder / "link.h5"
        link.symlink_to(checkpoints(directory)[0])
        before = {path: path.read_bytes() for path in directory.iterdir()}
        for source in (checkpoints(directory)[0], link):
            ended = moraine.call("run", SCENE, "--output", directory, "--quiet", "--overwrite", "--restart", source, *keys)
            self.assertIn("--overwrite would remove", self.assert_one_problem(ended))
            self.assertEqual({path: path.read_bytes() for path in directory.iterdir()}, before)
        self.run_scene(SCENE, "other", "--overwrite", "--restart", checkpoints(directory)[0], *keys)


if __name__ == "__main__":
    moraine.main()
