"""One answer, to the bit, whatever registers a processor has: with AVX-512 where it is found, and without."""
import os

import moraine
from moraine import INPUTS, sets, summary

# Jittered bodies of several laws fall onto a floor and against walls: odd numbers of particles in a cell, light nodes.
FALLING = """\
dimensions = 3
gravity = [0.0, 0.0, -9.81]
[domain]
min = [0.0, 0.0, 0.0]
max = [4.0, 2.0, 3.0]
cell = 0.25
[numerics]
shape = "quadratic"
[time]
end = 0.2
[output]
interval = 0.1
[[material]]
name = "clay"
law = "von-mises"
density = 1800.0
young = 1.0e6
poisson = 0.4
su = 2.0e3
sensitivity = 3.0
xi95 = 2.0
rate_log = 0.1
rate_reference = 0.01
[[material]]
name = "jelly"
law = "neo-hookean"
density = 1000.0
young = 5.0e5
poisson = 0.3
[[material]]
name = "sand"
law = "mu-i"
density = 1600.0
young = 1.0e6
poisson = 0.3
static_friction = 0.4
limit_friction = 0.6
grain_diameter = 0.01
grain_density = 2600.0
[[body]]
name = "clay"
material = "clay"
shape = "box"
min = [0.0, 0.0, 0.0]
max = [1.2, 1.6, 1.5]
seeding = "jittered"
velocity = [2.0, 0.5, 0.0]
[[body]]
name = "jelly"
material = "jelly"
shape = "box"
min = [2.3, 0.4, 0.6]
max = [3.4, 1.7, 1.7]
seeding = "jittered"
velocity = [-2.0, 0.0, -3.0]
[[body]]
name = "sand"
material = "sand"
shape = "box"
min = [2.3, 0.0, 0.0]
max = [3.9, 2.0, 0.45]
seeding = "jittered"
[[wall]]
face = "z-min"
kind = "no-slip"
""" + "".join(f'[[wall]]\nface = "{face}"\nkind = "free-slip"\n' for face in ("x-min", "x-max", "y-min", "y-max"))


class Processors(moraine.ProgramTest):
    def both(self, scene, name, **keys):
        """Runs with AVX-512 where the processor has it, and without; compares states and histories."""
        found = {}
        for words in ("", "0"):
            os.environ["MORAINE_AVX512"] = words
            found[words] = self.run_scene(scene, f"{name}-{words}", *sets(**keys))
        del os.environ["MORAINE_AVX512"]
        with self.subTest(name):
            self.assertEqual(*(summary(directory)["state_hash"] for directory in found.values()))
            self.assertEqual(*((directory / "history.csv").read_text() for directory in found.values()))

    def test_bodies_fall_in_space(self):
        scene = self.write(FALLING)
        for precision in ("double", "single"):
            for transfer in ("flip", "apic", "tpic"):
                self.both(scene, f"falling-{precision}-{transfer}", numerics__precision=precision, numerics__transfer=transfer)
        self.both(scene, "falling-musl", numerics__stress_update="musl")

    def test_scenes_of_the_plane(self):
        self.both(INPUTS / "slurry_runout.toml", "slurry", time__end=0.1, output__interval=0.05)
        self.both(INPUTS / "granular_column.toml", "column", time__end=0.1, output__interval=0.05)
        self.both(INPUTS / "soft_clay_footing.toml", "footing", time__end=0.02, output__interval=0.02)

    def test_scenes_of_space(self):
        for precision in ("double", "single"):
            self.both(INPUTS / "slurry_runout_3d.toml", f"slurry-{precision}", time__end=0.04, output__interval=0.04,
                      numerics__precision=precision)


if __name__ == "__main__":
    moraine.main()
