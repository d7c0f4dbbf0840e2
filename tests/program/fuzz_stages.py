"""Random damage to what came with stages: tables of time, rasters of strength, checkpoints within stages, and kills there. Part of fuzz.py."""
import re
import subprocess
import time

import damage
import moraine
import valley
from moraine import checkpoints, sets, summary

# Soil that settles under a gravity that grows, is cut and filled, and weakens, on a bed that acts on its surface.
SCENE = """\
dimensions = 2
gravity = [0.0, -10.0]
gravity_table = "grows"
domain = { min = [0.0, 0.0], max = [4.0, 1.5], cell = 0.25 }
time = { end = 0.16 }
numerics = { bed = "surface" }
[[table]]
name = "grows"
file = "grows.csv"
[[material]]
name = "clay"
law = "tresca"
density = 1000.0
young = 1.0e6
poisson = 0.45
su = 1.0e4
"""
SCENE += "".join(f'[[body]]\nname = "{name}"\nmaterial = "clay"\nshape = "box"\nmin = [{low}, 0.0]\nmax = [{high}, {top}]\n'
                 for name, low, high, top in (("ground", 0, 2, 1), ("cut", 2, 3, 1), ("fill", 2.25, 2.75, 0.5)))
SCENE += '[[wall]]\nface = "y-min"\nkind = "no-slip"\n'
SCENE += '[[stage]]\nname = "settle"\nuntil = 0.04\n[[stage]]\nname = "dig"\nuntil = 0.08\nremove = ["cut"]\n'
SCENE += '[[stage]]\nname = "fill"\nuntil = 0.12\nadd = ["fill"]\n[[stage]]\nname = "weak"\nset = { "material.clay.su" = 5.0e2 }\n'
GROWS = "time,value\n0.0,0.5\n0.05,0.75\n0.1,1.0\n"
KEYS = sets(output__interval=0.02, output__checkpoint_interval=0.02, output__energy_budget="on")
KINDS = ("rows", "strength", "staged", "stagekill")


class StageCases:
    """Cases of these kinds; a part of the fuzzer (fuzz.py has the rest)."""

    def make_stages(self):
        """The run that all restarts are compared with."""
        folder = self.folder / "stages"
        folder.mkdir()
        self.write_stages(folder)
        ended = moraine.call("run", "s.toml", "--output", "o", "--quiet", "--device", "cpu", *KEYS, folder=folder)
        assert ended.code == 0, ended
        self.staged = folder / "o"

    def write_stages(self, place, rows=GROWS):
        (place / "s.toml").write_text(SCENE)
        (place / "grows.csv").write_text(rows, errors="surrogateescape")

    def line_of(self, word, place):
        return re.search(f"^{word} .*|\\Z", moraine.call("check", "s.toml", folder=place).out, re.M).group()

    def try_rows(self, pick, place):
        """Another spelling of a table is the same table; a damaged one is refused or another."""
        if pick.random() < 0.3:
            rows = pick.choice(("", "\ufeff")) + GROWS.replace(",", pick.choice((",", ";", "\t", " , "))).replace("\n", pick.choice(("\n", "\r\n", "\n\n", "\n# NUL\0\n")))
            self.write_stages(place, rows.replace("0.75", pick.choice(("+0.75", "7.5e-1", '"0.75"'))))
            wrong = self.ask(["run", "s.toml", "--quiet", "--output", "o", *KEYS], place, (0,))[1]
            return wrong or (None if summary(place / "o")["state_hash"] == summary(self.staged)["state_hash"] else "another spelling gives another hash")
        self.write_stages(place, self.mutated_text(GROWS, pick).replace("=", pick.choice(",;=")))
        return self.ask(["run", "s.toml", "--quiet", "--output", "o", *sets(time__end=0.02)], place, (0, 2, 3, 5))[1]

    def try_strength(self, pick, place):
        """Another spelling of a raster or a table over depth is the same profile; a damaged one is refused or another."""
        return self.try_raster(pick, place) if pick.random() < 0.5 else self.try_profile(pick, place)

    def try_profile(self, pick, place):
        """A table over depth, of a property of the clay."""
        self.write_stages(place)
        key, value = pick.choice((("su", "1.0e4"), ("young", "1.0e6"), ("density", "1000.0")))
        whole = f"{key} = {{ depth = [0.25, 0.5], value = [{value}, 3.0e4] }}"
        text = SCENE.replace(f"{key} = {value}", whole)
        for stage in re.findall(r'set = \{.*', text):
            text = text.replace(stage, "")  # which would change su
        write = (place / "s.toml").write_text
        write(text)
        expected = self.line_of("profile", place)
        if pick.random() < 0.5:
            low, high = pick.choice(("0.25", "+0.25", "2.5e-1", "0.2500")), pick.choice(("3.0e4", "30_000.0", "30000", "+3e4"))
            spelled = pick.choice((whole, whole.replace(" ", ""), f"{key}.depth = [0.25, 0.5]\n{key}.value = [{value}, 3.0e4]"))
            write(text.replace(whole, spelled.replace("0.25", low).replace("3.0e4", high)))
            found = self.line_of("profile", place)
            return None if found == expected != "" else f"another spelling gives {found!r}, not {expected!r}"
        write(text.replace(whole, self.mutated_text(whole, pick)), errors="surrogateescape")
        return self.ask(["check", "s.toml"], place)[1]

    def try_raster(self, pick, place):
        self.write_valley(place)
        scene = valley.SCENE.replace('law = "drucker-prager"', 'law = "tresca"').replace("friction_angle = 25.0", 'su = { surface = "su.asc", gradient = 500.0 }')
        grid = valley.grid(at=lambda x, y: 1000 + 100 * y + 10 * x)
        (place / "s.toml").write_text(scene)
        (place / "su.asc").write_text(grid)
        whole = self.line_of("profile", place)
        if pick.random() < 0.5:
            (place / "su.asc").write_text(self.respelled(grid, pick))
            found = self.line_of("profile", place)
            return None if found == whole != "" else f"another spelling gives {found!r}, not {whole!r}"
        (place / "su.asc").write_text(self.broken_grid(grid, pick))
        return self.ask(["check", "s.toml"], place)[1]

    def try_staged(self, pick, place):
        """A checkpoint from within a stage that is damaged, or forged under a new seal."""
        data, forges = pick.choice(checkpoints(self.staged)).read_bytes(), pick.random() < 0.5
        if forges:
            body, regions = damage.parts(data)
            mutated = damage.sealed(self.mutated_bytes(body, pick), regions)
        else:
            mutated = self.mutated_bytes(data, pick)
        (place / "c.h5").write_bytes(mutated)
        self.write_stages(place)
        code, wrong = self.ask(["run", "s.toml", "--restart", "c.h5", "--output", "new", "--quiet", *KEYS], place, (0, 2, 3, 5) if forges else (0, 2))
        return wrong or ("a damaged checkpoint was taken" if code == 0 and not forges and mutated != data else None)

    def try_stagekill(self, pick, place):
        """A run that is killed within a stage goes on to the same state on other ranks."""
        self.write_stages(place)
        words = ["run", "s.toml", "--quiet", "--output", "o", "--device", "cpu", *KEYS]
        job = subprocess.Popen(moraine.command(words), cwd=place, env=moraine.environment(), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(pick.uniform(0.05, 0.8))
        job.kill()
        job.wait()
        last = checkpoints(place / "o") if (place / "o").exists() else []
        ended = moraine.call(*words, *(("--restart", last[-1]) if last else ("--overwrite",)), ranks=pick.choice((1, 2, 3)), folder=place)
        if ended.code != 0:
            return f"does not go on: {ended}"
        whole, found = summary(self.staged), summary(place / "o")
        same = whole["state_hash"] == found["state_hash"] and whole["stages"] == found["stages"]
        return None if same and (place / "o/history.csv").read_bytes() == (self.staged / "history.csv").read_bytes() else "another end after a kill"
