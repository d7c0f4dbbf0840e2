"""Scenes of a fluid in plane strain that no file of inputs/ has: what taylor_green, tank and stoker share."""

TRANSFERS = {name: [f"numerics.transfer={name.lower()}"] for name in ("FLIP", "APIC", "AFLIP")}
CURE = ["material.fluid.pressure_smoothing=0.22", "material.fluid.particle_shifting=0.2"]  # docs/adr/0008-filling.md
VARIANTS = TRANSFERS | {f"{name} shifted": sets + CURE for name, sets in TRANSFERS.items()}
DENSITY, POISSON = 1000.0, 0.495


def young(wave_speed):
    """E [Pa] with bulk waves of this speed [m/s]."""
    return 3 * (1 - 2 * POISSON) * DENSITY * wave_speed**2


def head(title, low, high, cell, end, interval, gravity, wave_speed, viscosity):
    """All but bodies and walls. viscosity: [Pa s]."""
    return f"""title = "{title}"
dimensions = 2
gravity = [0.0, {-gravity!r}]

[domain]
min = {list(low)!r}
max = {list(high)!r}
cell = {cell!r}

[time]
end = {end!r}

[output]
interval = {interval!r}
fields = ["pressure"]

[[material]]
name = "fluid"
law = "newtonian"
density = {DENSITY!r}
young = {young(wave_speed)!r}
poisson = {POISSON!r}
viscosity = {viscosity!r}
volumetric = "particle"
"""


def walls(*faces):
    return "".join(f'\n[[wall]]\nface = "{face}"\nkind = "free-slip"\n' for face in faces)


def table(name, rows, geostatic=""):
    """A body of particles; rows: (x, y, vx, vy, mass)."""
    text = "x,y,vx,vy,mass\n" + "".join(",".join(repr(float(v)) for v in row) + "\n" for row in rows)
    return text, f'\n[[body]]\nname = "{name}"\nmaterial = "fluid"\nshape = "table"\nfile = "{name}.csv"\n{geostatic}'
