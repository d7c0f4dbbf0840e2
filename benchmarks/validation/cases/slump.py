"""Slump of a cylinder of Bingham fluid

H = D = 0.1 m, let go at t = 0: a quarter between two planes of symmetry, no slip on the bed, mu = 30 Pa s, to 3 s. t is tau_y / (rho g H), s the slump over H.

* Plain formula (Pashias et al. 1996, Schowalter and Christensen 1998): each layer carries what is above it and spreads until its shear stress is tau_y. In
  uniaxial compression by rho g z the largest shear stress is rho g z / 2, so what is above z = 2 t H does not yield, and s = 1 - 2 t (1 - ln 2 t).
* Factored formula: the program yields at J2^(1/2) = tau_y. In uniaxial compression by S the deviator is S (-2/3, 1/3, 1/3), so J2 = S^2 / 3 and it yields at
  S = 3^(1/2) tau_y, not 2 tau_y: t becomes (3^(1/2) / 2) t = 0.866 t, s = 1 - 3^(1/2) t (1 - ln(3^(1/2) t)).
* Slump: of the highest particle within R/4 of the axis, plus half the spacing of the start, as the top does not yield; beside it that of the volume within R/2
  over the area of that circle. Radius: with 99 % of the volume inside, of all, and of sectors of 15 degrees along x, y and the diagonal.
* The start is in balance up to where it yields: the vertical stress is the weight above, the horizontal one zero. Particles that the
  mantle cuts have the mass and centroid of what is inside.
* Variants: `grid` has the keys of a fluid on a level bed (`volumetric = "grid"`, both cures, substeps), `plain` pressures of particles; `slip` is `grid` on a smooth
  bed, `slip4` and `slip8` that with R = H/4 and H/8. mu=120: four times the viscosity, to 4 or 6 s. nu-0.3: Poisson's ratio 0.3.

Why it differs from the formula:

* The formula is for slender cylinders, whose sides stay steep, on a smooth bed. On a smooth bed the program nears it as cylinders get slender: for R = H/2, H/4, H/8 the
  slump at t = 0.3 is 0.184, 0.178, 0.151 (factored formula 0.140), at 0.2 0.391, 0.355, 0.311 (0.286), at 0.1 0.666, 0.631, 0.600 (0.523).
* These hardly depend on the cells: R = H/2 0.185 and 0.184 at H/8 and H/12, R = H/8 0.1514 and 0.1513 at H/16 and H/24 (t = 0.3).
* Layer by layer, R = H/4, t = 0.3, H/16: what lies above 0.52 H does not spread, as the formula says (0.2 % of area, 7 % in the layer next to its end), but the
  foot carries 0.43 rho g H on average, not 0.52. A load that stays within the column's own width would explain that; stresses were not looked at.
* The rough bed takes that back: 0.520, 0.298 and 0.102 for t = 0.1, 0.2, 0.3 at H/16 against 0.666, 0.391 and 0.184. So the factored formula is met at t = 0.1 and 0.2 as two
  errors of it cancel, and at 0.3, where only the lowest half yields, the bed holds it.
* Inertia has little part: four times the viscosity changes slumps at H/8 by -0.005 to -0.002, and these still sink by 0.003 to 0.007 in the last third of their time.
* At t = 0.1 it sinks by another 0.003 H in the third second, at 0.2 and 0.3 by 0.0002 and less (H/16).

Why `plain` is missed: volumes of single particles lock. At H/8, t = 0.2, the slump is 0.123; with Poisson's ratio 0.3 0.239, with the mean volumetric rate of a cell
0.312, which is that of `grid` (0.309); at H/12 0.232, 0.263, 0.311 (0.303). Only Poisson's ratio differs in the first, only the rate of volume in the second.
"""
import math

import numpy

from sheet import Plot, Row

SCENE = "slump"
MATERIAL = "fluid"
LEVELS = {"cpu": [8, 12, 16], "cuda": [8, 12, 16, 24]}
RUNG = "H/{}"
YIELDS = (0.1, 0.2, 0.3)
HEIGHT, DENSITY, GRAVITY, VISCOSITY, END = 0.1, 1000.0, 9.81, 30.0, 3.0
RADII = {"": HEIGHT / 2, "4": HEIGHT / 4, "8": HEIGHT / 8}  # [m], by what stands behind the name of a variant
WEIGHT = DENSITY * GRAVITY * HEIGHT  # [Pa]
LEVEL_BED = ["material.fluid.volumetric=grid", "material.fluid.pressure_smoothing=0.22", "material.fluid.particle_shifting=0.2", "numerics.substeps=auto", "numerics.transfer=apic"]
SLIP = "wall.z-min.kind=free-slip"


KINDS = {"grid": LEVEL_BED, "plain": ["material.fluid.volumetric=particle", "numerics.transfer=apic"], "slip": [*LEVEL_BED, SLIP],
         "slip4": [*LEVEL_BED, SLIP, "body.cylinder.file=cylinder4.csv"], "slip8": [*LEVEL_BED, SLIP, "body.cylinder.file=cylinder8.csv"]}
VARIANTS = {f"{kind}-{tau:g}": [f"material.fluid.yield_stress={tau * WEIGHT:.6g}", *more] for kind, more in KINDS.items() for tau in YIELDS}
ASKED = [v for v in VARIANTS if v.startswith(("grid", "plain"))]  # those with goals; the others show causes
VARIANTS |= {f"{name} mu=120": [*VARIANTS[name], "material.fluid.viscosity=120", f"time.end={end}", f"output.interval={end / 30:.6g}"]
             for name, end in (("grid-0.2", 6), ("grid-0.3", 4), ("slip-0.2", 6), ("slip-0.3", 4))}


def sets(level):
    return []


def squares(level, radius):
    """(x, y, area) of the parts of the lattice's squares, four a cell, that lie in the quarter of the disk; areas add up to a quarter of the disk's within 1e-3."""
    side, fine = HEIGHT / level / 2, 64
    count = math.ceil(radius / side)
    places = (numpy.arange(count * fine) + 0.5) * side / fine
    x, y = (a.ravel() for a in numpy.meshgrid(places, places, indexing="ij"))
    inside = x * x + y * y < radius**2
    x, y = x[inside], y[inside]
    key = (x / side).astype(int) * count + (y / side).astype(int)
    number = numpy.bincount(key)
    kept = number > 0
    return numpy.bincount(key, x)[kept] / number[kept], numpy.bincount(key, y)[kept] / number[kept], number[kept] * (side / fine)**2


def write_scene(level, folder):
    """Particles on a lattice; those that the mantle cuts have the mass and the centroid of what is inside."""
    layers, side = 2 * level, HEIGHT / level / 2
    for name, radius in RADII.items():
        x, y, area = squares(level, radius)
        area *= math.pi * radius**2 / 4 / area.sum()
        lines = [f"{a!r},{b!r},{(k + 0.5) * side!r},{DENSITY * c * side!r}" for k in range(layers) for a, b, c in zip(x.tolist(), y.tolist(), area.tolist())]
        (folder / f"cylinder{name}.csv").write_text("x,y,z,mass\n" + "\n".join(lines) + "\n")
    walls = "".join(f'\n[[wall]]\nface = "{face}"\nkind = "{kind}"\n' for face, kind in (("x-min", "free-slip"), ("y-min", "free-slip"), ("z-min", "no-slip")))
    (folder / f"{SCENE}.toml").write_text(f"""title = "slump of a cylinder"
dimensions = 3
gravity = [0.0, 0.0, {-GRAVITY!r}]

[domain]
min = [0.0, 0.0, 0.0]
max = [0.2, 0.2, 0.125]
cell = {HEIGHT / level!r}

[time]
end = {END!r}

[output]
interval = {END / 60!r}
fields = ["velocity", "mass"]

[[material]]
name = "fluid"
law = "bingham"
density = {DENSITY!r}
young = 1e5
poisson = 0.49
viscosity = {VISCOSITY!r}
yield_stress = 98.1

[[body]]
name = "cylinder"
material = "fluid"
shape = "table"
file = "cylinder.csv"
geostatic = {{ surface = {HEIGHT!r}, k0 = 0.0 }}
{walls}""")


def published(tau):
    """s' of a cylinder that yields under its weight at rho g z = 2 tau_y."""
    return 1 - 2 * tau * (1 - math.log(2 * tau)) if tau < 0.5 else 0.0


def factored(tau):
    """s' with yield at rho g z = 3^(1/2) tau_y, as J2^(1/2) = rho g z / 3^(1/2) in uniaxial compression."""
    return published(math.sqrt(3) / 2 * tau)


def spread(x, y, volume, side):
    """(radius, angle, volume) of each particle as 4 x 4 parts of the square that it began as."""
    part = side * (numpy.arange(4) - 1.5) / 4
    dx, dy = (a.ravel() for a in numpy.meshgrid(part, part))
    x, y = numpy.abs(x[:, None] + dx).ravel(), numpy.abs(y[:, None] + dy).ravel()
    return numpy.hypot(x, y), numpy.degrees(numpy.arctan2(y, x)), numpy.repeat(volume / 16, 16)


def radius_of(share, r, volume):
    """r with this share of the volume within it."""
    order = numpy.argsort(r)
    sums = numpy.cumsum(volume[order])
    return float(numpy.interp(share, sums / sums[-1], r[order]))


def tops(place, volume, side, wide):
    """Heights [m]: top at the axis, of the column's volume there, highest.

    Columns have radii of R/4 and R/2 at every level (at least a spacing); a particle reaches half a spacing of the start above its centre,
    for what is on top has not yielded. depth_profile would add another half at the bed, where layers get thinner.
    """
    r = numpy.hypot(place[:, 0], place[:, 1])
    radius, _, parts = spread(place[:, 0], place[:, 1], volume, side)
    area = math.pi * (wide / 2)**2 / 4
    return place[r < max(wide / 4, side), 2].max() + side / 2, parts[radius < wide / 2].sum() / area, place[:, 2].max() + side / 2


def measure(level_run):
    series, history = level_run.particles(), level_run.history
    side, (kind, tau) = HEIGHT / level_run.level / 2, level_run.variant.split()[0].partition("+")[0].split("-")
    tau, wide = float(tau), RADII[kind.lstrip("abcdefghijklmnopqrstuvwxyz")]
    viscosity = float(level_run.variant.partition("mu=")[2].partition("+")[0] or VISCOSITY)
    volume = series.at(None, "mass") / DENSITY
    end = series.at(None)
    axis, column, highest = tops(end, volume, side, wide)
    r, angle, parts = spread(end[:, 0], end[:, 1], volume, side)
    along = {name: radius_of(0.99, r[m], parts[m]) for name, m in (("x", angle < 15), ("y", angle > 75), ("diagonal", numpy.abs(angle - 45) < 7.5))}
    heights = numpy.array([tops(series.at(t), series.at(t, "mass") / DENSITY, side, wide)[0] for t in series.times])
    late = numpy.abs(series.times - 2 / 3 * series.times[-1]).argmin()
    speed = float(numpy.max([numpy.linalg.norm(series.at(t, "velocity"), axis=1).max() for t in series.times]))
    slump = 1 - axis / HEIGHT
    figures = {"slump": slump, "height / H": axis / HEIGHT, "plain formula": published(tau), "factored": factored(tau), "slump of the highest": 1 - highest / HEIGHT,
               "slump of the column's volume": 1 - column / HEIGHT, "r along x / R": along["x"] / wide, "y": along["y"] / wide, "diagonal": along["diagonal"] / wide,
               "r of all / R": radius_of(0.99, r, parts) / wide, "creep [% of H]": 100 * (heights[late] - heights[-1]) / HEIGHT,
               "Re": DENSITY * speed * HEIGHT / viscosity, "over-filling [%]": 100 * max(history["over_filling"]),
               "unaccounted / potential [%]": 100 * history["unaccounted_J"][-1] / history["potential_J"][0]}
    edges = wide / 8 * numpy.arange(25)
    depth = numpy.histogram(r, edges, weights=parts)[0] / (math.pi / 4 * numpy.diff(edges**2))
    return figures, {"height": (series.times, heights / HEIGHT), "depth": (0.5 * (edges[1:] + edges[:-1]) / wide, depth / HEIGHT)}


def steps(lines, what):
    """[(coarse level, fine level, change [%])] of a figure from each level to the next."""
    return [(a["level"], b["level"], 100 * (b["figures"][what] / a["figures"][what] - 1)) for a, b in zip(lines, lines[1:])]


def formula_rows(name, figures, asked):
    for formula, most in (("factored", 2), ("plain formula", None))[:2 if asked else 1]:
        off = 100 * (figures["slump"] - figures[formula])
        yield Row(f"{name}: slump less that of the {formula.removesuffix(' formula')} formula ({figures[formula]:.3f})",
                  f"{figures['slump']:.3f}, {off:+.1f} % of H", f"{most} %" if asked and most else "-", abs(off) <= most if asked and most else None)


def rows(ladders):
    found = []
    for variant, lines in ladders.items():
        asked = variant in ASKED
        finest = lines[-1]["figures"]
        name = f"{variant}, H/{lines[-1]['level']}"
        found += formula_rows(name, finest, asked)
        if not asked:
            continue
        off = 100 * (finest["diagonal"] / finest["r along x / R"] - 1)
        found.append(Row(f"{name}: radius along the diagonal over that along x", f"{off:+.2f} %", "1 %", abs(off) <= 1))
        for what in ("height / H", "r of all / R"):
            for coarse, fine, change in steps(lines, what)[-1:]:
                found.append(Row(f"{variant}: {'radius' if what[0] == 'r' else 'height'} from H/{coarse} to H/{fine}", f"{change:+.2f} %", "2 %", abs(change) <= 2))
    return found


def tau_of(variant):
    return float(variant.split()[0].partition("+")[0].split("-")[1])


def plots(ladders):
    tau = numpy.linspace(0.02, 0.5, 97)
    lines = [("1 - 2 t (1 - ln 2 t)", tau, [published(float(t)) for t in tau], "k:"), ("with 0.866 t for t", tau, [factored(float(t)) for t in tau], "k--")]
    for kind, style in (("grid", "o"), ("plain", "^"), ("slip", "s"), ("slip4", "D"), ("slip8", "v")):
        mine = {v: z for v, z in ladders.items() if v in VARIANTS and "mu=" not in v and v.startswith(kind + "-")}
        levels = sorted({x["level"] for z in mine.values() for x in z})
        for level in levels if not kind.startswith("slip") else []:
            lines.append((f"{kind}, H/{level}", *zip(*sorted((tau_of(v), x["figures"]["slump"]) for v, z in mine.items() for x in z if x["level"] == level)), style))
        if mine and kind.startswith("slip"):
            lines.append((f"{kind}, finest", *zip(*sorted((tau_of(v), z[-1]["figures"]["slump"]) for v, z in mine.items())), style))
    depth = [(f"{v}, H/{x['level']}", *x["curves"]["depth"], "-") for v, z in ladders.items() if v.startswith("grid") and v in ASKED for x in z]
    height = [(f"{v}, H/{z[-1]['level']}", *z[-1]["curves"]["height"], "-") for v, z in ladders.items() if v in ASKED]
    return [Plot("slump", "Slump of a cylinder", "t = yield stress / (rho g H)", "slump / H", lines, False),
            Plot("depth", "Mean depth at rest over the radius", "r / R", "depth / H", depth, False),
            Plot("height", "Height at the axis", "time [s]", "height / H", height, False)]
