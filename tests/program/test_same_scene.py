"""Ranks whose hosts have different files run one scene, or none: a rank with a folder of its own stands for a host."""
import subprocess

import moraine
from moraine import MPIEXEC, PROGRAM, SMALL_SCENE, Ended, sets, summary

TABLE = SMALL_SCENE.replace('shape = "box"\nmin = [1.0, 0.5]\nmax = [2.0, 1.5]',
                            'shape = "table"\nfile = "grains.csv"')
GRAINS = "x,y\n1.0,1.0\n1.25,1.0\n"
SOFT, STIFF = "young = 1.0e5", "young = 4.0e5"


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


if __name__ == "__main__":
    moraine.main()
