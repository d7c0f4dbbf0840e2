"""A law in a file of the user's is a law like others: the same bits, on ranks and after restarts; and it is not run unasked."""
import os
import pathlib
import re

import moraine
from moraine import SMALL_SCENE, call, checkpoints, sets, summary

SHIPPED = pathlib.Path(__file__).resolve().parents[2] / "src/core/material"
CLAY = "young = 1.0e5\npoisson = 0.3\nsu = 500.0\nsensitivity = 2.0\nxi95 = 1.0\nrate_log = 0.1\nrate_reference = 1.0\n"
OUTPUT = '[output]\ninterval = 0.05\nfields = ["plastic_shear_strain"]\ncheckpoint_interval = 0.05\n'
ALLOWED = "--allow-code"


def with_law(law, keys=CLAY):
    """The small scene with another law, and on the floor, where it yields at once."""
    scene = SMALL_SCENE.replace("min = [1.0, 0.5]", "min = [1.0, 0.0]").replace('law = "neo-hookean"', law).replace("young = 1.0e5\npoisson = 0.3\n", keys)
    return scene.replace("[[material]]", OUTPUT + "[[material]]", 1) if keys == CLAY else scene


def copy_of(header, struct, folder, name="my_law.hpp", change=("", "")):
    """A law of the program as a file of the user's."""
    text = (SHIPPED / header).read_text()
    text = re.sub(rf"\b{struct}\b", "Law", text).replace(*change)
    (folder / name).write_text(text)


class LawInFile(moraine.ProgramTest):
    def setUp(self):
        super().setUp()
        os.environ["MORAINE_KERNEL_CACHE"] = str(self.folder / "cache")
        copy_of("von_mises.hpp", "VonMises", self.folder)
        self.scene = self.write(with_law('law = "file"\nsource = "my_law.hpp"'))

    def run_hash(self, scene, output, *options, ranks=None):
        ended = call("run", scene, "--output", self.folder / output, "--device", "cpu", *options, ranks=ranks)
        self.assertEqual(ended.code, 0, ended)
        return summary(self.folder / output)["state_hash"]

    def refused(self, *words, ranks=None):
        ended = call(*words, ranks=ranks)
        self.assertEqual(ended.code, 2, ended)
        return ended.err

    def test_a_copy_of_a_shipped_law_gives_its_bits(self):
        shipped = self.write(with_law('law = "von-mises"'), "shipped.toml")
        for precision in ("single", "double"):
            with self.subTest(precision=precision):
                options = sets(numerics__precision=f'"{precision}"')
                expected = self.run_hash(shipped, f"shipped-{precision}", *options)
                self.assertEqual(self.run_hash(self.scene, f"mine-{precision}", ALLOWED, *options), expected)
                self.assertEqual(self.run_hash(self.scene, f"two-{precision}", ALLOWED, *options, ranks=2), expected)
        copy_of("von_mises.hpp", "VonMises", self.folder, change=("yield / tau)", "Real(0.999) * yield / tau)"))
        self.assertNotEqual(self.run_hash(self.scene, "other", ALLOWED), expected)

    def test_a_law_that_keeps_a_stretch_gives_the_bits_in_3d_of_the_shipped_one(self):
        copy_of("neo_hookean.hpp", "NeoHookean", self.folder, "rubber.hpp")
        keys = "young = 1.0e5\npoisson = 0.3\n"
        deep = [("dimensions = 2", "dimensions = 3"), ("-9.81]", "-9.81, 0.0]"), ("max = [4.0, 2.0]", "max = [4.0, 2.0, 1.0]"),
                ("min = [0.0, 0.0]", "min = [0.0, 0.0, 0.0]"), ("min = [1.0, 0.0]", "min = [1.0, 0.0, 0.25]"),
                ("max = [2.0, 1.5]", "max = [2.0, 1.5, 0.75]")]
        hashes = []
        for name, law in (("shipped", 'law = "neo-hookean"'), ("mine", 'law = "file"\nsource = "rubber.hpp"')):
            scene = with_law(law, keys)
            for old, new in deep:
                scene = scene.replace(old, new)
            hashes.append(self.run_hash(self.write(scene, f"{name}.toml"), name, ALLOWED))
        self.assertEqual(*hashes)

    def test_a_restart_goes_on_to_the_same_bits_and_not_with_another_source(self):
        expected = self.run_hash(self.scene, "whole", ALLOWED)
        first = checkpoints(self.folder / "whole")[0]
        self.assertEqual(self.run_hash(self.scene, "again", ALLOWED, "--restart", first, ranks=2), expected)
        copy_of("von_mises.hpp", "VonMises", self.folder, change=("return elastic.energy", "return Real(2) * elastic.energy"))
        said = self.refused("run", self.scene, ALLOWED, "--output", self.folder / "other", "--restart", first)
        self.assertRegex(said, r"material\.jelly\.law is my_law\.hpp:\w{16} and was my_law\.hpp:\w{16}")
        self.assertFalse((self.folder / "other").exists())

    def test_code_is_not_run_unasked(self):
        for words in (("run", self.scene, "--output", self.folder / "out"), ("check", self.scene)):
            said = self.refused(*words)
            self.assertIn("material.jelly.source", said)
            self.assertIn("--allow-code?", said)
        self.assertFalse((self.folder / "cache").exists())
        self.assertFalse((self.folder / "out").exists())

    def test_what_the_compiler_says_names_the_line_of_the_file(self):
        text = (self.folder / "my_law.hpp").read_text()
        line = text.splitlines().index("    Hypoelastic<Real> elastic;") + 1
        (self.folder / "my_law.hpp").write_text(text.replace("    Hypoelastic<Real> elastic;", "    Hypoelastik<Real> elastic;"))
        for ranks in (None, 2):
            said = self.refused("check", self.scene, ALLOWED, ranks=ranks)
            self.assertEqual(len(re.findall(rf"^my_law\.hpp:{line}:\d+: error: .*Hypoelastik", said, re.M)), 1, said)
            self.assertNotIn("/tmp", said.replace(str(self.folder), ""))

    def test_a_file_without_a_law_is_refused(self):
        self.write("#pragma once\n", "my_law.hpp")
        self.assertIn("no `template <class Real> struct Law` in namespace moraine", self.refused("check", self.scene, ALLOWED))

    def test_a_law_that_takes_a_name_of_others_is_refused(self):
        copy_of("von_mises.hpp", "VonMises", self.folder, change=('"plastic_shear_strain"', '"pressure"'))
        self.assertIn('has a scalar "pressure"', self.refused("check", self.scene, ALLOWED))

    def test_keys_of_a_law_are_checked_as_those_of_others(self):
        for old, new, wanted in (("su = 500.0", "su = -1.0", "material.jelly.su"), ("su = 500.0", "sx = 1.0", "mean material.jelly.su?"),
                                 ("su = 500.0\n", "", "material.jelly.su is missing"),
                                 ('source = "my_law.hpp"', 'source = "no_law.hpp"', "cannot be read"),
                                 ('source = "my_law.hpp"\n', "", "material.jelly.source is missing")):
            with self.subTest(wanted=wanted):
                scene = self.write(self.scene.read_text().replace(old, new), "wrong.toml")
                self.assertIn(wanted, self.refused("check", scene, ALLOWED))

    def test_without_a_compiler_a_remedy_is_said(self):
        os.environ["CXX"] = "no-such-compiler"
        self.addCleanup(os.environ.pop, "CXX")
        self.assertIn("(there is no no-such-compiler). Install g++, or name one by CXX?", self.refused("check", self.scene, ALLOWED))

    def kernels(self, output):
        words = ("kernels", self.scene, ALLOWED, "--architecture", "90", "--kernel-cache", self.folder / output)
        ended = call(*words)
        if "built without CUDA" in ended.err or "there is no libnvrtc" in ended.err:
            self.skipTest("no CUDA")
        return ended

    def test_kernels_of_devices_have_the_law(self):
        ended = self.kernels("kernels")
        self.assertEqual(ended.code, 0, ended)
        self.assertRegex(ended.out, r"my_law\.hpp:\w{16}, stress in the gather")
        text = (self.folder / "my_law.hpp").read_text()
        self.write("#ifdef __CUDACC_RTC__\n#error no devices\n#endif\n" + text, "my_law.hpp")
        ended = self.kernels("other")
        self.assertEqual(ended.code, 2, ended)
        self.assertRegex(ended.err, r"(?m)^my_law\.hpp\(2\): .*no devices")

    def test_a_law_without_stiffness_is_refused(self):
        copy_of("von_mises.hpp", "VonMises", self.folder, change=("return elastic.wave_modulus()", "return Real(0)"))
        self.assertIn("begins with a wave modulus of 0 Pa", self.refused("check", self.scene, ALLOWED))

    def test_ranks_compile_a_law_once(self):
        compiler, calls = self.write('#!/bin/sh\necho call >> "$0.calls"\nexec c++ "$@"\n', "compiler"), self.folder / "compiler.calls"
        compiler.chmod(0o755)
        os.environ["CXX"] = str(compiler)
        self.addCleanup(os.environ.pop, "CXX")
        for output, expected in (("first", 1), ("second", 1)):
            self.run_hash(self.scene, output, ALLOWED, ranks=3)
            self.assertEqual(len(calls.read_text().splitlines()), expected)

    def test_a_law_is_compiled_once(self):
        first, second = (call("check", self.scene, ALLOWED) for _ in range(2))
        self.assertIn("Compiling the law of my_law.hpp", first.err)
        self.assertNotIn("Compiling", second.err)
        self.assertRegex(second.out, r"(?m)^law +jelly: my_law\.hpp:\w{16}, \"von-mises\"")


if __name__ == "__main__":
    moraine.main()
