"""Random damage to scenes, checkpoints, records and tables: what the program must bear. By test_fuzz.py.

A case is a word, "scene:17": its kind and the seed of its random numbers, so that any case can be had again by
`python3 tests/program/test_fuzz.py --case scene:17`. A finding is a text; no finding is None.
"""
import base64
import pathlib
import random
import re
import shutil
import signal
import struct
import subprocess
import time
import zlib

import damage
import fuzz_stages
import moraine
import valley
from moraine import INPUTS, SMALL_SCENE, sets, summary

LIMIT = 120 if moraine.SLOW else 30  # [s]
VALUES = ["0", "-1", "1e400", "nan", "-inf", "1e-320", "9223372036854775808", "-9223372036854775808", "0.1", "true", '""', "[]",
          "[1,2,3,4]", "{}", '"x"', "2021-01-01", "[[0,0],[1,0]]", "1_0", "0x7fffffff", '"\\u0000"', "''", "1e308", '"../x"']
WORDS = ["\n[[body]]\n", "[", "]]", '"""', "\\u001b", "=", ".", "#", "\x00", "\x1b[31m", "\xff", "a.b.c=1\n", "{", "\r", "é", "e9"]
TABLE = 'dimensions = 2\n[domain]\nmin = [0, 0]\nmax = [4, 2]\ncell = 0.25\n[time]\nend = 0.001\n[[material]]\nname = "m"\n' \
    'law = "linear-elastic"\ndensity = 1000\nyoung = 1e5\npoisson = 0.3\n[[body]]\nname = "b"\nmaterial = "m"\n' \
    'shape = "table"\nfile = "t.csv"\n'
# x, y, mass (whole numbers) and a packed vx of 12 particles, as h5py writes them.
TABLE_H5 = zlib.decompress(base64.b85decode(
    b'c-rgqaB<`1lHy_j0S*oZ76t(ZWbhvf93)ZsF!=;1%?PDCp!5nRm^dR?P68?}2sIyFT}Y6tD@gT!Gyt>5fCWOMx^5JV6yV|N7yzOppnMG|eS!&9T?Le`gwk'
    b'bDf!xI6V&rscK%~8l46G16j4(bVB{MQY1bCq8U^FvO9wZ~EV9&q-7I9!O;bt)T&kT`g1&V^?nV6Ws25>;lV`hXZhvz5;v>Y`!K(L>`3nQ?UP=JM_1b+1}='
    b'?*sh>Y$!yP+-Qd4wnBbSci6creC^B7!v7<k%5iO@Q`PKR1FFY;v5X(^$cj?!3+rxZlF9P*gTl|9N?NMB{eN4u_P6022!{&F~QOr3luY8569sEKG@Hi2?8J'
    b'Ojltlv{n;}h@Wnn248GYz)ct^}`)O|iR`(mK?hjPmKd3qe2Z%T@k%GYk`=A|it*-+g*e@xt<+{H3f&Dj)nEpdwAJ}_5tP)x0{t#;JL;E*@AcYU@?SQHZY#'
    b'-SJ6#-Q~vWF;p1a;qId!S)Jg^%qk;;gHm^}LN#;bDmR!qthN%Lq+h#Ntsf3P!;w7zLwXm;zA0n-SQWLhpC;<4}J9+M0yPv!KbJN0aA3lfQ>1z=Ok_Q7{Td'
    b'!6+C7qhJ&a9zgoIl>k_&00#qnoCXANk5|2gwh+)qXeSKH@BjcmLcNI'))
KINDS = ("scene", "run", "checkpoint", "forged", "series", "csv", "loads", "summary", "table", "hdf5", "grid", "gis", "kill", *fuzz_stages.KINDS)
UNKNOWN = ["-9999", "-9999.0", "-32767", "1e10", "nan", "-3.4028235e+38", "inf", "", "1e400", "0x10", "--1", "+1"]


def big_endian(*numbers):
    return struct.pack(f">{len(numbers)}I", *numbers)


def netcdf(columns, rows, side, at):
    """A classic netCDF of heights, with x and y."""
    name = lambda text: big_endian(len(text)) + text.encode().ljust(4, b"\0")
    head = b"CDF\1" + big_endian(0, 10, 2) + name("x") + big_endian(columns) + name("y") + big_endian(rows, 0, 0, 11, 3)
    place, variables = len(head) + 36 + 36 + 40, b""
    for text, dims, count in (("x", (0,), columns), ("y", (1,), rows), ("z", (1, 0), columns * rows)):
        variables += name(text) + big_endian(len(dims), *dims, 0, 0, 6, 8 * count, place)
        place += 8 * count
    numbers = [side * i for i in range(columns)] + [side * j for j in range(rows)]
    numbers += [at(side * i, side * j) for j in range(rows) for i in range(columns)]
    return head + variables + struct.pack(f">{len(numbers)}d", *numbers)


def respelled(text, pick):
    """The same grid as another program writes it."""
    lines = text.strip("\n").split("\n")
    head, rows = lines[:6], lines[6:]
    pick.shuffle(head)
    for way in pick.sample(range(7), 3):
        if way == 0:
            head = [line.upper() for line in head]
        elif way == 1:
            rows = [" ".join("+" + word if word[0] != "-" else word for word in row.split()) for row in rows]
        elif way == 2:
            rows = [row.replace(" ", pick.choice(("\t", "  ", "\r\n"))) for row in rows]
        elif way == 3:
            head = [line for line in head if not line.lower().startswith("nodata")]
        elif way == 4:
            head = [line.lower().replace("cellsize", "dx") for line in head] + [f"dy {line.split()[1]}" for line in head if line.lower().startswith("cellsize")]
        elif way == 5:
            rows = [" ".join(f"{float(word):.17e}" for word in row.split()) for row in rows]
        else:
            rows = [" " + row + " " for row in rows]
    return pick.choice(("", "\ufeff")) + pick.choice(("\n", "\r\n")).join(head + rows) + pick.choice(("", "\n", "\n\n"))


def broken_grid(text, pick):
    lines = text.split("\n")
    k = pick.randrange(len(lines) - 1)
    cells = lines[k].split()
    way = pick.randrange(5)
    if way <= 2:
        cells[pick.randrange(len(cells))] = pick.choice(UNKNOWN)
    elif way == 3:
        cells = cells[:-1] if pick.random() < 0.5 else cells + ["1"]
    else:
        cells = []
    lines[k] = " ".join(cells)
    return "\n".join(lines)


def mutated_text(text, pick):
    """A text with some changes that a hand, a script or a bad disk could have made."""
    for _ in range(pick.choice((1, 1, 1, 2, 4))):
        lines = text.split("\n")
        k = pick.randrange(len(lines))
        at = pick.randrange(len(text) + 1)
        way = pick.randrange(9)
        if way <= 3 and "=" in lines[k]:
            lines[k] = lines[k].split("=")[0] + "= " + pick.choice(VALUES)
        elif way == 4:
            lines.insert(pick.randrange(len(lines)), lines[k])
        elif way == 5:
            del lines[k]
        elif way == 6:
            number = re.search(r"[0-9.]+", lines[k])
            if number:
                lines[k] = lines[k].replace(number.group(), pick.choice(VALUES), 1)
        elif way == 7:
            lines = (text[:at] + pick.choice(WORDS) * pick.choice((1, 1, 300)) + text[at:]).split("\n")
        else:
            lines = (text[:at] + text[at + pick.randrange(1, 40):]).split("\n")
        text = "\n".join(lines)
    return text


def mutated_bytes(data, pick):
    """Bits flipped, bytes set, a piece zeroed, cut off, swapped or added."""
    data = bytearray(data)
    for _ in range(pick.choice((1, 1, 2, 5))):
        at, size = pick.randrange(len(data)), pick.choice((1, 8, 8, 64, 512))
        way = pick.randrange(7)
        if way <= 2:
            data[at] ^= 1 << pick.randrange(8)
        elif way == 3:
            data[at:at + 8] = pick.choice((b"\0" * 8, b"\xff" * 8, b"\xff" * 7 + b"\x7f", b"\0\0\0\0\0\1\0\0"))
        elif way == 4:
            data[at:at + size] = bytes(len(data[at:at + size]))
        elif way == 5:
            other = pick.randrange(len(data))
            data[at:at + size], data[other:other + size] = data[other:other + size], data[at:at + size]
        else:
            data = data[:at + 1] if pick.random() < 0.5 else data + bytes(pick.randrange(1, 99))
    return bytes(data)


class Fuzzer(fuzz_stages.StageCases):
    """Runs cases in a folder of its own; `seed` files come from one good run."""

    mutated_text, mutated_bytes, respelled, broken_grid = map(staticmethod, (mutated_text, mutated_bytes, respelled, broken_grid))

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.scene = self.folder / "scene.toml"
        self.scene.write_text(SMALL_SCENE)
        self.good = self.folder / "good"
        keys = sets(output__checkpoint_interval=0.05, output__interval=0.02, output__block_loads="on", balance__interval=2)
        ended = moraine.call("run", self.scene, "--output", self.good, "--quiet", *keys, ranks=2)
        assert ended.code == 0, ended
        self.checkpoint = moraine.checkpoints(self.good)[0]
        self.hash = summary(self.good)["state_hash"]
        self.write_valley(self.folder)
        self.maps = self.folder / "maps-of-a-run"
        ended = moraine.call("run", self.folder / "s.toml", "--output", self.maps, "--quiet", "--device", "cpu",
                             *sets(time__end=0.4, output__checkpoint_interval=0.02))
        assert ended.code == 0, ended
        self.make_stages()

    def case(self, word):
        """What is wrong with the program's answer to this case."""
        kind, number = word.split(":")
        pick, place = random.Random(word), self.folder / word.replace(":", "-")
        place.mkdir()
        try:
            return getattr(self, "try_" + kind)(pick, place)
        finally:
            shutil.rmtree(place)

    def ask(self, words, place, codes=(0, 2)):
        """Starts the program; its exit code, and what is wrong."""
        process = subprocess.Popen(moraine.command(words), cwd=place, env=moraine.environment(), stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, stdin=subprocess.DEVNULL)
        try:
            _, err = process.communicate(timeout=LIMIT)
        except subprocess.TimeoutExpired:
            if 5 not in codes:
                process.kill()
                return None, f"no end in {LIMIT} s"
            process.send_signal(signal.SIGTERM)
            _, err = process.communicate(timeout=LIMIT)
        text = err.decode(errors="replace")
        if process.returncode not in codes:
            return process.returncode, f"exit code {process.returncode}: {text[:500]}"
        return process.returncode, self.wrong_words(process.returncode, text)

    def wrong_words(self, code, text):
        lines = text.splitlines()
        if code == 0:
            return None
        if len(lines) != 1 or len(text.encode()) > 2200 or not re.fullmatch(moraine.PROBLEM.pattern + ".*", lines[0]):
            return f"not one message of the form problem (why). suggestion?: {text[:500]!r}"
        return None if lines[0].isprintable() or "\ufffd" in text else f"not printable: {text[:500]!r}"

    def restart(self, file, place, codes, *words):
        code, wrong = self.ask(["run", self.scene, "--restart", file, "--output", "new", "--quiet", *words], place, codes)
        if not wrong and code == 2 and (place / "new").exists():
            wrong = "refused, but the directory was made"
        return code, wrong

    def try_scene(self, pick, place):
        source = pick.choice(sorted(INPUTS.glob("*.toml")))
        text = mutated_text(source.read_text(), pick)
        if 'file = "reference' in text:
            shutil.copy(INPUTS / "reference_particles.csv", place)
        if "[terrain]" in text:
            shutil.copy(INPUTS / "valley.asc", place)
            shutil.copy(INPUTS / "valley_release.csv", place)
            shutil.copy(INPUTS / "valley_gauges.csv", place)
            shutil.copy(INPUTS / "valley_sections.csv", place)
        (place / "s.toml").write_text(text, errors="surrogateescape")
        return self.ask(["check", "s.toml"], place)[1]

    def try_run(self, pick, place):
        (place / "s.toml").write_text(mutated_text(SMALL_SCENE, pick), errors="surrogateescape")
        words = ["run", "s.toml", "--quiet", "--output", "o", *sets(time__end=0.01)]
        code, wrong = self.ask(words, place, (0, 2, 3, 5))
        return wrong or ("refused, but the directory was made" if code == 2 and (place / "o").exists() else None)

    def try_checkpoint(self, pick, place):
        data = self.checkpoint.read_bytes()
        (place / "c.h5").write_bytes(mutated := mutated_bytes(data, pick))
        code, wrong = self.restart("c.h5", place, (0, 2))
        return wrong or ("a damaged checkpoint was taken" if code == 0 and mutated != data else None)

    def try_forged(self, pick, place):
        body, regions = damage.parts(self.checkpoint.read_bytes())
        (place / "c.h5").write_bytes(damage.sealed(mutated_bytes(body, pick), regions))
        return self.restart("c.h5", place, (0, 2, 3, 5))[1]

    def resume(self, name, pick, place):
        for path in self.good.iterdir():
            shutil.copy(path, place)
        data = (place / name).read_bytes()
        (place / name).write_bytes(mutated_bytes(data, pick))
        words = ["run", self.scene, "--restart", place / self.checkpoint.name, "--output", place, "--quiet"]
        code, wrong = self.ask(words, place)
        if not wrong and code == 0 and summary(place)["state_hash"] != self.hash:
            return "another hash"
        return wrong

    def try_series(self, pick, place):
        return self.resume("particles.vtkhdf", pick, place)

    def try_csv(self, pick, place):
        return self.resume(pick.choice(("history.csv", "balance.csv")), pick, place)

    def replay(self, name, pick, place):
        for path in ("balance.csv", "block_loads.bin", "history.csv", "summary.json"):
            shutil.copy(self.good / path, place)
        data = (place / name).read_bytes()
        (place / name).write_bytes(mutated_bytes(data, pick))
        return self.ask(["replay", ".", "--ranks", "2,5"], place)[1]

    def try_loads(self, pick, place):
        return self.replay("block_loads.bin", pick, place)

    def try_summary(self, pick, place):
        return self.replay("summary.json", pick, place)

    def try_table(self, pick, place):
        rows = "x,y,vx,vy\n" + "".join(f"{1 + 0.1 * k},{0.5 + 0.01 * k},0.1,{k}\n" for k in range(12))
        (place / "s.toml").write_text(TABLE)
        (place / "t.csv").write_text(mutated_text(rows, pick).replace("=", pick.choice(",;=")), errors="surrogateescape")
        return self.ask(["check", "s.toml"], place)[1]

    def try_hdf5(self, pick, place):
        (place / "s.toml").write_text(TABLE.replace("t.csv", "t.h5"))
        (place / "t.h5").write_bytes(mutated_bytes(TABLE_H5, pick))
        return self.ask(["check", "s.toml"], place)[1]

    def write_valley(self, place, dem="valley.asc", area="area.csv", **more):
        scene = valley.SCENE.replace("valley.asc", dem).replace("area.csv", area)
        for name, text in {"s.toml": scene, "valley.asc": valley.grid(), "area.csv": valley.AREA, **more}.items():
            (place / name).write_bytes(text if isinstance(text, bytes) else text.encode())

    def mass_of(self, place):
        ended = moraine.call("check", "s.toml", folder=place)
        return re.search("mass .*|$", ended.out).group()

    def try_grid(self, pick, place):
        """Another spelling is the same ground; another value is refused or said."""
        self.write_valley(place)
        whole = self.mass_of(place)
        if pick.random() < 0.5:
            (place / "valley.asc").write_text(respelled(valley.grid(), pick))
            found = self.mass_of(place)
            return None if found == whole else f"another spelling gives {found!r}, not {whole!r}"
        (place / "valley.asc").write_text(broken_grid(valley.grid(), pick))
        return self.ask(["check", "s.toml"], place)[1]

    def try_gis(self, pick, place):
        """Damaged files of each format that GDAL reads here."""
        if not valley.GDAL:
            return None
        corners = [[2, 3], [6, 3.5], [6.5, 8], [4, 9], [2, 8.5]]
        files = {"v.nc": netcdf(13, 7, 2.0, valley.heights), "a.geojson": valley.features((corners, {"thickness": 1.0})).encode()}
        shutil.copy(self.maps / "maps" / "max_depth.tif", place / "v.tif")
        shutil.copy(self.maps / "maps" / "outline.gpkg", place / "a.gpkg")
        name = pick.choice(("v.nc", "v.tif", "a.geojson", "a.gpkg"))
        data = files.get(name) or (place / name).read_bytes()
        dem, area = (name, "area.csv") if name[0] == "v" else ("valley.asc", name)
        self.write_valley(place, dem, area, **{name: data})
        if pick.random() < 0.7:
            (place / name).write_bytes(mutated_bytes(data, pick))
        elif name == "v.nc":
            (place / name).write_bytes(data[:pick.randrange(1, len(data))])
            code, wrong = self.ask(["check", "s.toml"], place, (2,))
            return wrong or (None if code == 2 else "a netCDF file that is cut short was taken")
        return self.ask(["check", "s.toml"], place)[1]

    def try_kill(self, pick, place):
        """A run that is killed while it writes maps and checkpoints goes on to the same maps."""
        self.write_valley(place)
        words = ["run", "s.toml", "--quiet", "--output", "o", "--device", "cpu",
                 *sets(time__end=0.4, output__checkpoint_interval=0.02)]
        job = subprocess.Popen(moraine.command(words), cwd=place, env=moraine.environment(), stdin=subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(pick.uniform(0.05, 1.5))
        job.kill()
        job.wait()
        last = moraine.checkpoints(place / "o") if (place / "o").exists() else []
        code, wrong = self.ask(words + (["--restart", last[-1]] if last else ["--overwrite"]), place, (0,))
        if wrong:
            return wrong
        for path in (self.maps / "maps").iterdir():
            if path.suffix in (".tif", ".asc") and path.read_bytes() != (place / "o" / "maps" / path.name).read_bytes():
                return f"{path.name} is another after a kill"
        return None if summary(place / "o")["state_hash"] == summary(self.maps)["state_hash"] else "another hash"
