"""A checkpoint that is not whole, or of another scene, is refused with exit code 2 and nothing is left behind."""
import struct

import damage
import moraine
from moraine import SMALL_SCENE, call, checkpoints, sets, summary


class BadCheckpoint(moraine.ProgramTest):
    run_before = None  # the files of one run, made by the first test

    def setUp(self):
        super().setUp()
        self.scene = self.write(SMALL_SCENE)
        half = self.folder / "half"
        if BadCheckpoint.run_before is None:
            self.run_scene(self.scene, "half", *sets(output__checkpoint_interval=0.05), ranks=2)
            BadCheckpoint.run_before = {path.name: path.read_bytes() for path in half.iterdir()}
        half.mkdir(exist_ok=True)
        for name, data in self.run_before.items():
            (half / name).write_bytes(data)
        self.good = checkpoints(half)[0]
        self.hash = summary(half)["state_hash"]

    def restart(self, file, *words, ranks=None):
        return call("run", self.scene, "--restart", file, "--output", self.folder / "new", "--quiet", *words,
                    ranks=ranks)

    def assert_refused(self, file, *words, says=(), on=(None, 3)):
        for ranks in on:
            line = self.assert_one_problem(self.restart(file, *words, ranks=ranks))
            for word in says:
                self.assertIn(word, line)
            self.assertFalse((self.folder / "new").exists(), line)

    def damaged(self, data):
        path = self.folder / "damaged.h5"
        path.write_bytes(data)
        return path

    def test_the_good_one_restarts(self):
        ended = self.restart(self.good, ranks=3)
        self.assertEqual(ended.code, 0, ended)
        self.assertEqual(summary(self.folder / "new")["state_hash"], self.hash)

    def test_one_that_is_not_there_or_no_checkpoint_is_refused(self):
        for file in (self.folder / "no.h5", self.folder, self.scene, self.folder / "half" / "history.csv",
                     self.folder / "half" / "particles.vtkhdf"):
            with self.subTest(file):
                self.assert_refused(file, says=[str(file)])

    def test_a_truncated_one_is_refused(self):
        data = self.good.read_bytes()
        for length in (0, 1, 8, 100, len(data) // 2, len(data) - 1):
            with self.subTest(length):
                on = (None, 3) if length == len(data) // 2 else (None,)
                self.assert_refused(self.damaged(data[:length]), says=["damaged.h5"], on=on)
        self.assert_refused(self.damaged(data + b"more"), on=(None,))

    def test_one_with_a_flipped_bit_is_refused(self):
        data = self.good.read_bytes()
        offsets = [0, 8, 40, 96, *range(200, len(data), len(data) // 14), len(data) - 1]
        for n, offset in enumerate(offsets):
            flipped = bytearray(data)
            flipped[offset] ^= 1 << n % 8
            with self.subTest(offset):
                on = (None, 3) if n % 9 == 0 else (None,)
                self.assert_refused(self.damaged(bytes(flipped)), says=["damaged.h5"], on=on)

    def place(self, form, fits):
        """Where the checkpoint has the one list of this form that fits."""
        data = damage.parts(self.good.read_bytes())[0]
        (at,) = [at for at in range(len(data) - struct.calcsize(form)) if fits(struct.unpack_from(form, data, at))]
        return at

    def assert_forgery_refused(self, at, form, *values, says):
        self.assert_refused(self.damaged(damage.forged(self.good.read_bytes(), at, form, *values)),
                            says=["damaged.h5", says], on=(None, 3) if values[0] == 1 << 40 else (None,))

    def test_values_that_no_run_has_are_refused_behind_a_new_seal_as_well(self):
        clock = self.place("<3d", lambda v: 0.05 <= v[0] < 0.06 and 1e-6 < v[1] < 0.05 and v[2] > 1)
        nan, infinite = float("nan"), float("inf")
        self.assertEqual(self.restart(self.damaged(damage.forged(self.good.read_bytes(), clock + 40, "<d", 0))).code, 0)
        (self.folder / "new").rename(self.folder / "old")
        for k, name, values in ((0, "time", (nan, infinite, -1)), (1, "step", (nan, -1)), (2, "signal", (nan, 0, -1)),
                                (3, "nodes", (nan, -1, infinite)), (4, "sums", (nan, 0, 3)), (6, "start", (nan,))):
            for value in values:
                with self.subTest(name, value=value):
                    self.assert_forgery_refused(clock + 8 * k, "<d", value, says=name)

    def test_counts_of_blocks_that_cannot_be_are_refused_behind_a_new_seal_as_well(self):
        # 8 x 8 particles across a corner of four blocks
        counts = self.place("<4q", lambda v: sum(v) == 64 and min(v) > 0 and v[0] * v[3] == v[1] * v[2])
        for value in (1 << 40, -(1 << 40), -1, (1 << 32) + 4):
            with self.subTest(value):
                self.assert_forgery_refused(counts, "<q", value, says="block 0")
                self.assert_forgery_refused(counts, "<2q", value, 64 - value, says="block 0")

    def test_one_of_another_scene_is_refused_by_the_key(self):
        for key, value in (("material.jelly.density", "1200"), ("domain.cell", "0.5"), ("gravity", "[0, -9]"),
                           ("numerics.precision", '"single"'), ("numerics.shape", '"linear"'), ("time.cfl", "0.4"),
                           ("body.block.velocity", "[1, 0]"), ("wall.y-min.kind", '"free-slip"'), ("seed", "2")):
            with self.subTest(key):
                on = (None, 3) if key == "material.jelly.density" else (None,)
                self.assert_refused(self.good, "--set", f"{key}={value}", says=[key, str(self.good)], on=on)

    def test_kinds_that_differ_are_named_by_their_words(self):
        for key, value, words in (("numerics.shape", '"linear"', "numerics.shape is linear and was quadratic"),
                                  ("numerics.transfer", '"flip"', "numerics.transfer is flip and was apic"),
                                  ("numerics.precision", '"single"', "numerics.precision is single and was double"),
                                  ("numerics.stress_update", '"musl"', "numerics.stress_update is musl and was usl"),
                                  ("numerics.light_nodes", '"free"', "numerics.light_nodes is free and was limited"),
                                  ("numerics.boundary", '"plain"', "numerics.boundary is plain and was spline"),
                                  ("material.jelly.volumetric", '"cell"', "material.jelly.volumetric is cell and was particle"),
                                  ("body.block.seeding", '"jittered"', "body.block.seeding is jittered and was lattice"),
                                  ("wall.y-min.kind", '"free-slip"', "wall.y-min.kind is free-slip and was no-slip")):
            with self.subTest(key):
                self.assert_refused(self.good, "--set", f"{key}={value}", says=[f"({words})"], on=(None,))

    def test_a_transfer_that_differs_is_named_and_not_the_step_that_follows_from_it(self):
        self.scene = self.write(SMALL_SCENE.replace("cfl = 0.5\n", ""))
        self.run_scene(self.scene, "free", *sets(output__checkpoint_interval=0.05))
        good = checkpoints(self.folder / "free")[0]
        for key, value in (("transfer", "flip"), ("shape", "cubic")):
            with self.subTest(key):
                self.assert_refused(good, "--set", f'numerics.{key}="{value}"', says=[f"(numerics.{key} is {value} and was "], on=(None,))

    def test_end_output_balance_and_ranks_may_change(self):
        keys = sets(time__end=0.2, output__interval=0.01, output__fields='["pressure"]', balance__partitioner="shuffle",
                    balance__trigger="every", balance__interval=1)
        ended = self.restart(self.good, *keys, ranks=3)
        self.assertEqual(ended.code, 0, ended)
        straight = self.run_scene(self.scene, "straight", *sets(time__end=0.2))
        self.assertEqual(summary(self.folder / "new")["state_hash"], summary(straight)["state_hash"])

    def test_a_run_is_not_harmed_by_a_bad_checkpoint(self):
        before = {path: path.read_bytes() for path in self.good.parent.iterdir()}
        half = self.good.parent
        broken = self.damaged(self.good.read_bytes()[:-1])
        for words in ((), ("--overwrite",)):
            self.assert_one_problem(call("run", self.scene, "--restart", broken, "--output", half, *words))
            self.assertEqual({path: path.read_bytes() for path in half.iterdir()}, before)


if __name__ == "__main__":
    moraine.main()
