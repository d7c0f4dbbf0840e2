"""Ranks whose hosts have different files run one scene, or none: a rank with a folder of its own stands for a host."""
import os
import shutil
import subprocess
import unittest

import moraine
import valley
from moraine import MPIEXEC, PROGRAM, SMALL_SCENE, Ended, checkpoints, sets, summary

TABLE = SMALL_SCENE.replace('shape = "box"\nmin = [1.0, 0.5]\nmax = [2.0, 1.5]',
                            'shape = "table"\nfile = "grains.csv"')
GRAINS = "x,y\n1.0,1.0\n1.25,1.0\n"
SOFT, STIFF = "young = 1.0e5", "young = 4.0e5"

# A clock that is a year and a day ahead, and a process that believes the host to be up for as long.
OTHER_CLOCK = """
#define _GNU_SOURCE
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
enum { ahead = 366 * 86400 };
int clock_gettime(clockid_t clock, struct timespec* t) {
    int code = (int)syscall(SYS_clock_gettime, clock, t);
    if (clock <= CLOCK_MONOTONIC) t->tv_sec += ahead;
    return code;
}
int gettimeofday(struct timeval* t, void* zone) {
    (void)zone;
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    t->tv_sec = now.tv_sec, t->tv_usec = now.tv_nsec / 1000;
    return 0;
}
time_t time(time_t* t) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (t) *t = now.tv_sec;
    return now.tv_sec;
}
"""


def call_apart(words, folders, stdin=None):
    """One rank in each folder, with the same words or, if `words` is a list of lists, with its own."""
    each = words if isinstance(words[0], list) else [words] * len(folders)
    line = [MPIEXEC[0], "-q", *MPIEXEC[1:-1]]
    for number, (folder, own) in enumerate(zip(folders, each)):
        line += [":"] * (number > 0) + ["-wdir", str(folder), MPIEXEC[-1], "1", PROGRAM, *map(str, own)]
    done = subprocess.run(line, env=moraine.environment(), capture_output=True, text=True, input=stdin or "",
                          timeout=60)
    return Ended(done.returncode, done.stdout, done.stderr)


class SameScene(moraine.ProgramTest):
    def hosts(self, *files, called="host"):
        """A folder for each rank, with these files."""
        folders = []
        for number, texts in enumerate(files):
            folder = self.folder / f"{called}-{number}"
            folder.mkdir()
            for name, text in texts.items():
                (folder / name).write_text(text)
            folders.append(folder)
        return folders

    def run_words(self, scene="s.toml"):
        return ["run", scene, "--quiet", "--output", self.folder / "out"]

    def test_all_ranks_run_the_scene_of_rank_0(self):
        whole = self.run_scene(self.write(SMALL_SCENE), "alone", ranks=2)
        others = ({"s.toml": SMALL_SCENE.replace(SOFT, STIFF)}, {})  # an old copy; none at all
        for number, other in enumerate(others):
            with self.subTest(other=list(other)):
                folders = self.hosts({"s.toml": SMALL_SCENE}, other, called=f"host-{number}")
                output = self.folder / f"out-{number}"
                ended = call_apart(["run", "s.toml", "--quiet", "--output", output], folders)
                self.assertEqual(ended.code, 0, ended)
                self.assertEqual(summary(output)["state_hash"], summary(whole)["state_hash"])

    def test_a_scene_may_come_through_a_pipe(self):
        ended = call_apart(self.run_words("/dev/stdin"), [self.folder, self.folder], stdin=SMALL_SCENE)
        self.assertEqual(ended.code, 0, ended)

    @unittest.skipUnless(valley.GDAL, "a build without GDAL")
    def test_what_lies_behind_a_file_that_all_have_is_agreed_on_by_its_values(self):
        mosaic = ('<VRTDataset rasterXSize="13" rasterYSize="7"><GeoTransform>-1, 2, 0, 13, 0, -2</GeoTransform>'
                  '<VRTRasterBand dataType="Float32" band="1"><SimpleSource><SourceFilename relativeToVRT="1">part.asc'
                  '</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>')
        good = {"s.toml": valley.SCENE.replace("valley.asc", "valley.vrt").replace("end = 1.2", "end = 0.01"),
                "valley.vrt": mosaic, "part.asc": valley.grid(), "area.csv": valley.AREA}
        other = {**good, "part.asc": valley.grid(at=lambda x, y: valley.heights(x, y) + 0.01)}
        line = self.assert_one_problem(call_apart(self.run_words(), self.hosts(good, other)))
        for word in ("rank 0 and rank 1", "structure.terrain.heights", "old copy"):
            self.assertIn(word, line)
        self.assertFalse((self.folder / "out").exists())
        ended = call_apart(self.run_words(), self.hosts(good, good, called="same"))
        self.assertEqual(ended.code, 0, ended)

    def test_rasters_that_lie_elsewhere_are_other_rasters(self):
        """The same values half a cell further: their file is the same below its head."""
        scene = valley.SCENE.replace('law = "drucker-prager"', 'law = "tresca"').replace("friction_angle = 25.0", 'su = { surface = "su.asc" }').replace("end = 1.2", "end = 0.01")
        strength = valley.grid(at=lambda x, y: 1000 + 100 * x)
        good = {"s.toml": scene, "valley.asc": valley.grid(), "area.csv": valley.AREA, "su.asc": strength}
        bad = {**good, "su.asc": strength.replace("xllcenter 0\n", "xllcenter 0.5\n")}
        self.assertNotEqual(bad, good)
        line = self.assert_one_problem(call_apart(self.run_words(), self.hosts(good, bad)))
        self.assertIn("rank 0 and rank 1 differ in material.debris.su.surface.raster", line)

    def test_tables_that_differ_between_ranks_are_refused_by_name(self):
        good = {"s.toml": TABLE, "grains.csv": GRAINS}
        bad = {"s.toml": TABLE, "grains.csv": GRAINS.replace("1.25", "1.50")}
        line = self.assert_one_problem(call_apart(self.run_words(), self.hosts(good, good, bad)))
        for word in ("rank 0 and rank 2", "grains.csv", "old copy"):
            self.assertIn(word, line)
        self.assertFalse((self.folder / "out").exists())

    def test_ranks_with_other_words_behind_set_are_refused(self):
        folders = self.hosts({"s.toml": SMALL_SCENE}, {"s.toml": SMALL_SCENE})
        words = [self.run_words() + sets(time__end=0.05), self.run_words() + sets(time__end=0.06)]
        line = self.assert_one_problem(call_apart(words, folders))
        self.assertIn("rank 0 and rank 1 differ in what --set says", line)

    def german(self):
        """Variables of a locale whose numbers have commas: made here, since few machines have it."""
        if not shutil.which("localedef") or not os.path.exists("/usr/share/i18n/locales/de_DE"):
            self.skipTest("localedef or the sources of locales are missing. apt install locales?")
        subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", self.folder / "de_DE.UTF-8"], check=True, capture_output=True)
        variables = {"LOCPATH": str(self.folder), "LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8"}
        told = subprocess.run(["locale", "decimal_point"], env={**os.environ, **variables}, capture_output=True, text=True)
        self.assertEqual(told.stdout, ",\n")
        return variables

    def another_clock(self):
        if not shutil.which("cc"):
            self.skipTest("there is no C compiler for another clock")
        library = self.folder / "clock.so"
        self.write(OTHER_CLOCK, "clock.c")
        subprocess.run(["cc", "-shared", "-fPIC", "-o", library, self.folder / "clock.c"], check=True)
        return {"LD_PRELOAD": library, "TZ": "Pacific/Kiritimati"}

    def call_under(self, variables, words):
        """A rank under each of these lists of variables."""
        line = [MPIEXEC[0], "-q", *MPIEXEC[1:-1]]
        for number, own in enumerate(variables):
            line += [":"] * (number > 0) + [MPIEXEC[-1], "1", "env", *(f"{k}={v}" for k, v in own.items()), PROGRAM, *map(str, words)]
        done = subprocess.run(line, env=moraine.environment(), capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=60)
        return Ended(done.returncode, done.stdout, done.stderr)

    def test_hosts_of_other_locales_and_clocks_write_the_same_files(self):
        grains = "x,y\n" + "".join(f"{1.0625 + 0.125 * i},{0.5625 + 0.125 * j}\n" for i in range(8) for j in range(8))
        self.write(grains, "grains.csv")
        scene = self.write(TABLE)
        german, clock = self.german(), self.another_clock()
        said = subprocess.run(["date", "+%Y"], env={**os.environ, **{k: str(v) for k, v in clock.items()}}, capture_output=True, text=True)
        here = subprocess.run(["date", "+%Y"], capture_output=True, text=True)
        self.assertEqual(int(said.stdout), int(here.stdout) + 1, "the clock is another one")
        keys = sets(output__interval=0.02, output__checkpoint_interval=0.05, balance__interval=5, balance__trigger="every")
        whole = self.run_scene(scene, "whole", *keys, ranks=3)
        names = ["history.csv", "particles.vtkhdf", *(path.name for path in checkpoints(whole))]
        for name, variables in (("german", [german, {}, {}]), ("clock", [{}, clock, {}]), ("both", [clock, german, {}])):
            for restart in ([], ["--restart", self.folder / name / names[-1]]):
                with self.subTest(name, restart=restart):
                    words = ["run", scene, "--quiet", "--output", self.folder / name, *keys, *restart]
                    ended = self.call_under(variables, words)
                    self.assertEqual(ended.code, 0, ended)
                    self.assertEqual(summary(self.folder / name)["state_hash"], summary(whole)["state_hash"])
                    for file in names if not restart else names[:1]:
                        self.assertEqual((self.folder / name / file).read_bytes(), (whole / file).read_bytes(), file)
        words = ["check", scene]
        self.assertEqual(self.call_under([german], words).out, moraine.call(*words).out)


if __name__ == "__main__":
    moraine.main()
