"""The scripts that build and run, with a cmake that only says when it was there."""
import os
import pathlib
import shutil
import subprocess

import moraine

SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "scripts"
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


if __name__ == "__main__":
    moraine.main()
