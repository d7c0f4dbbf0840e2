"""Runout of a slurry beside a volume-of-fluid solution

`inputs/slurry_runout.toml` beside interFoam of OpenFOAM 1912 (Debian's package, a process of its own): two incompressible fluids in one field of
velocity, the surface carried by fluxes with compression, pressure by PISO. No particles, and no code in common.

* Same law, factor 1: sqrt(J2) = yield_stress + viscosity (2 D:D)^(1/2) above the yield stress. The viscosities that interFoam used are within 0.6 % of that in the
  median at every level (0.03 % with square cells at H0/50).
* Not the same: interFoam has air (1 kg/m3, 0.05 Pa s) and no compressibility, and below the yield stress it creeps with 1.5e5 Pa s, where Moraine is elastic.
* base: square cells of H0/level, as Moraine's. graded: cells half as high at the bed. air lifted: the same, and every 0.1 s air in the two lowest rows, 1 m and
  more behind the front, goes to the surface of its column (at H0/50 to 17.5 s).
* Front: 0.5 % of the volume is ahead. Centre: of mass. Depth: columns of 0.4 m, L1 of the difference. Moraine on the host; its fronts at H0/100 and 200 without
  depths are those of [the slurry's page](slurry.md), one H100.

What came out:

* **At 8 s interFoam agrees with itself**: fronts at H0/50 of 52.20 m (base; 55.80 and 52.75 at H0/12.5 and 25), 52.36 m (a tenth of the creep viscosity) and 52.29 m (air
  lifted; 53.18, 52.32), depths within 0.5 %, centres at 24.42 to 24.45 m.
* **Moraine agrees with it the better the finer it is.** Depth at 8 s with APIC: 8.5, 3.9 and 2.0 % at H0/25, 50 and 100 (base); its centre is 6.0 and 0.7 % short, then 0.4 % far.
* Moraine's front is 0.9 to 1.3 % of the runout further at H0/200, and still coming nearer: 54.27, 53.15, 52.71 m (AFLIP, H0/50, 100, 200), 53.30, 53.06, 52.68 (APIC). From
  H0/100 to 200 that is 0.4 m, as much as is left. It is longer and thinner.
* Behind the front (x < 40 m at 8 s, H0/50) depths differ by 0.2 (APIC) and 1.6 cm (AFLIP) in the mean, and from column to column by 2 cm, as particles are counted: two fifths of
  the L1.
* **At rest** Moraine's fronts (60.46 to 60.61 m at H0/200) lie between interFoam's at 14 s (60.08 base, 60.29 with a tenth of the creep viscosity, 61.13 air lifted). interFoam
  cannot say it better: see next.
* Goals: 1 % of the runout and of the centre's way, as between levels; 5 % of the depth is this page's own.

What of interFoam is not to be trusted:

* **It does not come to rest** at H0/50: its slurry keeps 0.05 m/s (root mean square) and creeps on, by 0.9 m from 14 to 30 s. That grows with the creep viscosity: energies at 14 s
  are 0.02, 0.02 and 0.22 kJ for a tenth, one and ten times at H0/25, 0.07 and 0.12 kJ for a tenth and one at H0/50, where a tenth creeps on by 0.4 m. So it is likely of the
  stiff, partly explicit viscous term. Hence fixed times.
* **Flat cells at the bed trap air** under the front, which no-slip holds back: 7.6 % of the lowest row at H0/50, 0.16 at H0/25, 0.02 with square cells. The
  slurry slides on it: 0.35 m further at 8 s than with the air lifted. With air at the bed's faces held as slurry a whole film formed, and the front went
  7 m too far (H0/25, 8 s); that way was given up. Cells a quarter as high trap 24 % already at H0/25: 54.54 m.
* **Without compression** the surface smears, and the front is at 58.71 m at 8 s (H0/25, with it 52.75).
* The tip moves over a no-slip bed by what the lowest cell lets pass. At 8 s base and graded
  are 8.5 and 2.1 % of the runout too far at H0/12.5, and 0.2 % apart at H0/50 (air lifted).
"""
import numpy

import figure
import norms
import openfoam_case
import plain_names
import records
from particles import Particles
from runs import table
from sheet import Row, goal_table

TIMES = (2.0, 4.0, 8.0, 14.0, 30.0)  # at which depths are kept [s]
BIN = 0.4  # of depths [m]: a cell of the coarsest level
LENGTH = 72.0  # of what is looked at [m]
DIGITS = 5
SHOWN = ("base", "creep viscosity / 10", "graded", "graded, air lifted", "APIC", "AFLIP")
REFERENCES = (("interFoam", "base", 50), ("interFoam", "creep viscosity / 10", 50), ("interFoam", "graded, air lifted", 50))
GPU = [f"{transfer} shifted grid 10" for transfer in ("APIC", "AFLIP", "FLIP")]  # of cases/slurry.py: what the shipped scene has


def rounded(values):
    return [float(f"{v:.{DIGITS}g}") for v in values]


def result(times, fronts, bulks, centres, heights, kinetic, depths):
    """What is kept of a run: series in time, and depths in bins at TIMES."""
    kinetic = 1e-3 * numpy.asarray(kinetic)
    curves = {"time": rounded(times), "front": rounded(fronts), "x_cm": rounded(centres)}
    figures = {}
    for t in TIMES:
        if t > times[-1] + 0.1:
            continue
        for name, series in (("front 99.5 %", fronts), ("front 95 %", bulks), ("x of centre", centres), ("y of centre", heights), ("kinetic", kinetic)):
            figures[f"{name} at {t:g} s"] = float(f"{numpy.interp(t, times, series):.6g}")
        h = depths[int(numpy.abs(numpy.asarray(times) - t).argmin())]
        curves[f"depth at {t:g} s"] = [round(float(d), 4) for d in h[:int(numpy.flatnonzero(h > 1e-3)[-1]) + 2]]
    return figures, curves


def law_error(folder, mesh, scene):
    """Median of the viscosity that interFoam used at 2 s over that of Moraine's law, less 1 [%]: of full cells of the L's lower corner."""
    shape = (len(mesh.y_low) - 1, mesh.near)
    corner = shape[0] * shape[1]
    alpha, nu, velocity = (openfoam_case.read(folder / "2" / name)[:corner] for name in ("alpha.slurry", "nu1", "U"))
    alpha, nu, *u = (f.reshape(shape) for f in (alpha, nu, *velocity.T[:2]))
    y, x = 0.5 * (mesh.y_low[1:] + mesh.y_low[:-1]), mesh.h * (numpy.arange(mesh.near) + 0.5)
    (u_y, u_x), (v_y, v_x) = (numpy.gradient(component, y, x) for component in u)
    rate = numpy.sqrt(2 * u_x**2 + 2 * v_y**2 + (u_y + v_x) ** 2)
    law = (scene["viscosity"] + scene["yield_stress"] / numpy.maximum(rate, 1e-9)) / scene["density"]
    full = (alpha[1:-1, 1:-1] > 0.999) & (alpha[2:, 1:-1] > 0.999)
    return 100 * float(numpy.median((nu / law)[1:-1, 1:-1][full]) - 1)


def of_cells(folder, mesh, scene):
    """Figures and curves of an interFoam run."""
    x, y, high = mesh.cells()
    volumes, columns = mesh.h * high, numpy.round(x / mesh.h).astype(int)
    edges = mesh.h * numpy.arange(columns.max() + 2)
    bins = numpy.arange(0, LENGTH + 0.5 * BIN, BIN)
    series, depths, air = [], [], []
    names = sorted((p.name for p in folder.iterdir() if p.name.replace(".", "").isdigit()), key=float)
    for name in names:
        alpha = openfoam_case.read(folder / name / "alpha.slurry")
        speed2 = (openfoam_case.read(folder / name / "U") ** 2).sum(axis=1) if name != "0" else 0.0
        part = alpha * volumes
        sums = numpy.concatenate(([0.0], numpy.cumsum(numpy.bincount(columns, part))))
        total = sums[-1]
        front, bulk = (numpy.interp(share * total, sums, edges) for share in (0.995, 0.95))
        series.append((float(name), front, bulk, (part * (x + 0.5 * mesh.h)).sum() / total, (part * (y + 0.5 * high)).sum() / total,
                       0.5 * scene["density"] * (part * speed2).sum()))
        depths.append(numpy.diff(numpy.interp(bins, edges, sums)) / BIN)
        air.append(100 * numpy.mean(1 - alpha[(y == 0) & (x < bulk - mesh.h)]))
    figures, curves = result(*map(list, zip(*series)), depths)
    figures |= {"air at the bed [%]": round(max(air), 4), "volume, off by [%]": round(100 * (total / (scene["width"] * scene["height"]) - 1), 5),
                "law, off by [%]": round(law_error(folder, mesh, scene), 4)}
    return figures, curves


def of_particles(folder, program):
    """Figures and curves of a run of Moraine."""
    series, history = Particles(folder / "particles.vtkhdf", program), table(folder / "history.csv")
    places = [series.at(t) for t in series.times]
    volume = 50.0 / len(places[0])
    fronts, bulks = ([numpy.quantile(x[:, 0], share) for x in places] for share in (0.995, 0.95))
    depths = [norms.depth(x[:, 0], volume, 0.0, LENGTH, BIN)[1] for x in places]
    centres, heights = ([x[:, k].mean() for x in places] for k in (0, 1))
    return result(list(series.times), fronts, bulks, centres, heights, numpy.interp(series.times, history["time_s"], history["kinetic_J"]), depths)


def row_of(rows, code, variant, level):
    return next((x for x in rows if (x["code"], x["variant"], x["level"]) == (code, variant, level)), None)


def of_records(folder):
    """Moraine's finest levels on one GPU, of results.jsonl: {(transfer, level): line}."""
    lines = records.read(folder / "results.jsonl")
    return {(x["variant"].split()[0], x["level"]): x for x in lines if x["case"] == "slurry" and x["variant"] in GPU and x["level"] >= 100}


def value(row, name, t, digits=2):
    found = row["figures"].get(f"{name} at {t:g} s")
    return "" if found is None else f"{found:.{digits}f}"


def series_table(rows, gpu):
    columns = ("code", "level", "front at 2, 4, 8, 14, 30 s [m]", "x of the centre [m]", "y of the centre [m]", "kinetic energy [kJ]", "cells or particles", "steps", "wall [s]")
    text = [f"| {' | '.join(columns)} |", "|---" * len(columns) + "|"]
    for x in [x for x in rows if x["variant"] in SHOWN]:
        name = f"{x['code']}, {x['variant']}"
        shown = (("front 99.5 %", 2), ("x of centre", 2), ("y of centre", 3), ("kinetic", 2))
        groups = [", ".join(filter(None, (value(x, what, t, digits) for t in TIMES))) for what, digits in shown]
        text.append(f"| {name} | H0/{x['level']:g} | {' | '.join(groups)} | {x.get('cells', x.get('particles'))} | {x['steps']} | {x['wall_s']:.0f} |")
    for (transfer, level), x in sorted(gpu.items()):
        fronts = f"-, -, {x['figures']['at 8 s [m]']:.2f}, -, {x['figures']['front 99.5 % [m]']:.2f}"
        text.append(f"| Moraine, {transfer}, one H100 | H0/{level} | {fronts} | | | | {x['particles']} | {x['steps']} | {x['wall_s']:.0f} |")
    return text


def difference(row, base, t):
    """L1 of the depths' difference over the volume [%]."""
    ours, theirs = (x["curves"].get(f"depth at {t:g} s") for x in (row, base))
    if not ours or not theirs:
        return None
    length = max(len(ours), len(theirs))
    ours, theirs = (numpy.pad(h, (0, length - len(h))) for h in (ours, theirs))
    return 100 * norms.l1(ours, theirs)


def difference_at_rest(line, base):
    """The same of a line of results.jsonl at rest, whose curve keeps every few bins, and interFoam at 14 s."""
    x, ours = map(numpy.asarray, line["curves"]["depth"])
    theirs = base["curves"]["depth at 14 s"]
    theirs = numpy.pad(theirs, (0, round(LENGTH / BIN) - len(theirs)))[numpy.round(x / BIN - 0.5).astype(int)]
    return 100 * norms.l1(ours, theirs)


def depth_table(rows, gpu):
    bases = [row_of(rows, *base) for base in REFERENCES]
    names = [f"{x['variant']} H0/{x['level']:g}" for x in bases]
    text = [f"| depth, L1 of the difference at 2, 4, 8, 14, 30 s | {' | '.join(f'against interFoam, {name}' for name in names)} |", "|---" * (len(names) + 1) + "|"]
    for x in [x for x in rows if x["variant"] in SHOWN]:
        found = [[difference(x, base, t) for t in TIMES] if x is not base else [] for base in bases]
        words = [", ".join(f"{d:.2f}" for d in ds if d is not None) + (" %" if ds else "") for ds in found]
        text.append(f"| {x['code']} {x['variant']} H0/{x['level']:g} | {' | '.join(words)} |")
    for (transfer, level), x in sorted(gpu.items()):
        text.append(f"| Moraine {transfer} H0/{level}, one H100 | " + " | ".join(f"at rest, and interFoam at 14 s: {difference_at_rest(x, base):.2f} %" for base in bases) + " |")
    return text


def creep(row):
    late, early = (row["figures"].get(f"front 99.5 % at {t} s") for t in (30, 14))
    return "" if late is None else f"{late - early:+.2f}"


def sensitivity_table(rows, level):
    base = row_of(rows, "interFoam", "base", level)
    columns = (f"interFoam at H0/{level}, at 8 s", "front 99.5 % [m]", "front 95 % [m]", "x of the centre [m]", "depth, L1", "front from 14 to 30 s [m]", "steps", "wall [s]")
    text = [f"| {' | '.join(columns)} |", "|---" * len(columns) + "|"]
    for x in [x for x in rows if x["code"] == "interFoam" and x["level"] == level]:
        cells = []
        for name in ("front 99.5 %", "front 95 %", "x of centre"):
            now, before = (y["figures"][f"{name} at 8 s"] for y in (x, base))
            cells.append(f"{now:.2f}" if x is base else f"{now:.2f} ({100 * (now / before - 1):+.2f} %)")
        depth = "" if x is base else f"{difference(x, base, 8.0):.2f} %"
        text.append(f"| {x['variant']} | {' | '.join(cells)} | {depth} | {creep(x)} | {x['steps']} | {x['wall_s']:.0f} |")
    return text


def goals(rows, gpu):
    """Runouts of Moraine's finest level, centres and depths of what ran on the host, against each reference; the worst of the transfers."""
    found = []
    fine = [x["figures"] for (_, level), x in gpu.items() if level == 200]
    ours = {"APIC and AFLIP at H0/50": ("APIC", "AFLIP", 50), "APIC at H0/100": ("APIC", 100)}
    ours = {name: [row_of(rows, "Moraine", transfer, level) for transfer in transfers] for name, (*transfers, level) in ours.items()}
    for base in (row_of(rows, *base) for base in REFERENCES):
        against = f"against interFoam ({base['variant']}, H0/{base['level']:g})"
        for t, name, when in ((8, "at 8 s [m]", "at 8 s"), (14, "front 99.5 % [m]", "at rest (interFoam: at 14 s)")):
            theirs = base["figures"][f"front 99.5 % at {t} s"]
            error = max((100 * (x[name] - theirs) / (theirs - 10) for x in fine), key=abs)
            found.append(Row(f"runout {when}, three transfers at H0/200 {against}", f"{error:+.2f} %", "1 %", abs(error) <= 1))
        for who, lines in ours.items():
            for t in [t for t in (8, 14) if t <= lines[0]["end"]]:
                name = f"x of centre at {t} s"
                error = max((100 * (x["figures"][name] - base["figures"][name]) / (base["figures"][name] - 5) for x in lines), key=abs)
                found.append(Row(f"way of the centre of mass to {t} s, {who} {against}", f"{error:+.2f} %", "1 %", abs(error) <= 1))
                error = max(difference(x, base, float(t)) for x in lines)
                found.append(Row(f"depth (L1) at {t} s, {who} {against}", f"{error:.2f} %", "5 %", error <= 5))
    return found


def draw(rows, path):
    plt = figure.pyplot("slurry-reference")
    if not plt:
        return
    drawing, axes = plt.subplots(4, figsize=(8, 7), sharex=True)
    shown = [(*REFERENCES[0], "k-"), (*REFERENCES[-1], "k:"), ("Moraine", "APIC", 50, "C0-"), ("Moraine", "AFLIP", 50, "C1-"), ("Moraine", "APIC", 100, "C2-")]
    for t, axis in zip(TIMES, axes):
        for code, variant, level, style in shown:
            row = row_of(rows, code, variant, level)
            h = row["curves"].get(f"depth at {t:g} s", []) if row else []
            axis.plot(BIN * (numpy.arange(len(h)) + 0.5), h, style, label=f"{code}, {variant}, H0/{level}", linewidth=1.1)
        axis.set(ylabel="depth [m]", ylim=(0, None))
        axis.set_title(f"{t:g} s", loc="right", y=0.75, x=0.98)
        axis.grid(alpha=0.25)
    axes[0].legend(fontsize=7, frameon=False, loc="upper center")
    axes[-1].set(xlabel="x [m]")
    figure.save(plt, drawing, path)


def about(rows):
    ours = next(x for x in rows if x["code"] == "Moraine")
    versions = ", ".join(sorted({x["version"] for x in rows if x["code"] == "interFoam"}))
    return f"Moraine {ours['version']} ({ours['commit'][:7]}, {ours['precision']}) and interFoam of {versions}, each on one core of: {ours['machine']}, which others used."


def write(rows, folder):
    """Page and plot."""
    title, _, text = __doc__.partition("\n")
    gpu = of_records(folder)
    parts = {"Goals": goal_table(goals(rows, gpu)), "Series": series_table(rows, gpu), "Depths": depth_table(rows, gpu),
             "What the peer's own choices do": sensitivity_table(rows, 25)}
    lines = [f"# {title}", "", text.strip(), "", "![Depth at four times](slurry-reference.svg)", ""]
    for name, part in parts.items():
        lines += [f"## {name}", "", *part, ""]
    lines += [about(rows), "", "Repeat: `benchmarks/validation/beside_openfoam`. All rows: slurry-reference.jsonl."]
    (folder / "slurry-reference.md").write_text(plain_names.in_words("\n".join(lines) + "\n"))
    draw(rows, folder / "slurry-reference.svg")
