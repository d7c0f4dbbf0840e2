"""The pictures of docs/gallery.md and of the tutorials, each from a scene of inputs/: checked, run, read, drawn.

    python3 python/examples/gallery.py [--only NAME,...] [--quick] [--output DIR]

Start it where inputs/, docs/ and build/release/moraine are. Editors and Jupyter (by Jupytext) show the cells between `# %%` as a
notebook. Pictures go to DIR/pictures, named as in docs/pictures, and runs to DIR/NAME. --quick takes coarse
cells and ends early.
"""
# %% [markdown]
# # The gallery, picture by picture
# Each cell checks a scene, runs it, reads what it did and draws it.

# %%
import argparse
import pathlib
import re
import shutil
import sys

import numpy

import moraine
from moraine.animation import save
from moraine.grids import read_grid
from moraine.map_figure import draw_map
from moraine.picture import draw
from moraine.stability_page import write_pictures

NAMES = ("slurry", "slide", "slide-coarse", "slope", "valley", "sand", "mud", "pipe", "barrier", "ranks", "converge", "safety", "scenarios", "load")
words = argparse.ArgumentParser(description="Makes the pictures of the gallery, all or some.")
words.add_argument("--only", default=",".join(NAMES), metavar="NAME,...", help=f"of {', '.join(NAMES)} (slide takes most of the time)")
words.add_argument("--quick", action="store_true", help="coarse cells and early ends: seconds instead of minutes")
words.add_argument("--output", default="runs/gallery", type=pathlib.Path, metavar="DIR", help="default: runs/gallery")
given = words.parse_args([] if "ipykernel" in sys.modules else None)  # a kernel's words are not ours
ONLY = given.only.split(",")
for name in ONLY:
    if name not in NAMES:
        words.error(f"--only {name} (there is no such picture). One of {', '.join(NAMES)}?")
PICTURES = given.output / "pictures"
PICTURES.mkdir(parents=True, exist_ok=True)


def made(name, scene, sets={}, quick={}, ranks=None):
    """The run of a scene: checked first, on the processor's cores; with --quick the keys of `quick` change, too."""
    sets = {**sets, **(quick if given.quick else {})}
    found = moraine.check(scene, sets)
    print(f"{name}: {found.particles} particles, {found.steps} steps, {found.values['time'][0].split(' on ')[0]}")
    run = moraine.run(scene, given.output / name, sets, ranks=ranks, progress=not given.quick, overwrite=True, options=["--device", "cpu"])
    print(f"  took {run.summary['wall_s']:.1f} s, front at {run.summary['front_m']:.2f} m")
    return run


def keep(run, picture, **view):
    """Draws a run as `moraine picture` does, and keeps the one file of that ending as DIR/pictures/`picture`."""
    ending = pathlib.Path(picture).suffix
    if "times" in view:
        view["times"] = [min(time, run.particles.times[-1]) for time in view["times"]]  # --quick ends sooner
    drawn = [file for file in draw(run.path, animate=ending == ".gif", **view) if file.suffix == ending]
    shutil.copyfile(drawn[-1], PICTURES / picture)
    print(f"  {PICTURES / picture}")


# %% [markdown]
# ## A slurry that runs out
# A block of 10 m by 5 m is let go. An output each half second gives the animation 31 frames to 15 s.

# %%
if "slurry" in ONLY:
    run = made("slurry", "inputs/slurry_runout.toml", {"output.interval": 0.5}, {"domain.cell": 0.5, "output.interval": 2.5, "time.end": 10.0})
    print(f"  largest speed {run.history['max_speed_m_s'].max():.1f} m/s")
    keep(run, "slurry.gif", times=[0, 15])

# %% [markdown]
# ## A slide under water
# The shipped cells, and twice as coarse ones as in the tutorial.

# %%
if "slide" in ONLY:
    run = made("slide", "inputs/submarine_slide.toml", quick={"domain.cell": 1.0, "time.end": 5.0})
    keep(run, "submarine_slide.png", times=[0, 10, 20, 30, 50], sheet=True)
if "slide-coarse" in ONLY:
    run = made("slide-coarse", "inputs/submarine_slide.toml", {"domain.cell": 0.5}, {"domain.cell": 1.0, "time.end": 5.0})
    keep(run, "slide_coarse.png", times=[0, 10, 20, 30, 52], sheet=True)

# %% [markdown]
# ## A slope that fails backwards
# Sensitive clay whose toe is cut away; what rests behind the last slip surface sleeps.

# %%
if "slope" in ONLY:
    run = made("slope", "inputs/retrogressive_slope.toml", {"time.end": 15.0}, {"domain.cell": 1.0, "time.end": 3.0})
    print(f"  {100 * run.summary['sleep']['share_of_particle_steps']:.0f} % of the particle-steps were saved")
    keep(run, "retrogressive_slope.png", times=[0, 3, 6, 9, 15], sheet=True)

# %% [markdown]
# ## Debris in a valley
# Hazard maps over the shaded ground: how deep, when, and what stays. The gauges are places at which the depth is written over time.

# %%
if "valley" in ONLY:
    run = made("valley", "inputs/valley.toml", {"hazard.gauges": "valley_gauges.csv"}, {"domain.cell": 2.0, "hazard.cell": 4.0, "time.end": 10.0})
    print(f"  up to {numpy.nanmax(run.maps['max_depth'].values):.1f} m deep, {run.gauges['channel_depth_m'].max():.1f} m in the channel")
    keep(run, "valley_max_depth.png", field="max_depth")
    keep(run, "valley_times.png", field="arrival")
    keep(run, "valley_deposit.png", field="deposit")

# %% [markdown]
# ## A column of sand
# Sand 0.2 m high loses its wall.

# %%
if "sand" in ONLY:
    run = made("sand", "inputs/granular_column.toml", {"output.interval": 0.1}, {"domain.cell": 0.01})
    x, depth = moraine.depth_profile(run.particles[-1].position)
    print(f"  at the end {depth.max():.3f} m high")
    keep(run, "sand_column.png", times=[0, 0.2, 0.68], sheet=True)

# %% [markdown]
# ## A dam break of mud
# Twice as coarse as the shipped scene, as in the tutorial.

# %%
if "mud" in ONLY:
    run = made("mud", "inputs/mud_dam_break.toml", {"domain.cell": 0.01}, {"domain.cell": 0.02, "time.end": 1.0})
    keep(run, "mud_dam_break.png", times=[0, 0.5, 1, 6], sheet=True)

# %% [markdown]
# ## A pipe in clay
# The pressure under a pipe, by the default of clay and as particles have it.

# %%
if "pipe" in ONLY:
    for name, picture, sets in (("pipe", "pipe.png", {}), ("pipe-particle", "pipe_particle.png", {"material.clay.volumetric": "particle"})):
        run = made(name, "inputs/pipe_penetration.toml", {"domain.cell": 0.1, **sets}, {"domain.cell": 0.2, "time.end": 1.0})
        print(f"  largest load {2 * run.structures['pipe']['force_y_N'].max():.0f} N per metre")
        keep(run, picture, field="pressure", times=[8], sheet=True)

# %% [markdown]
# ## Mud against a barrier
# The scene is the one that docs/guide/own-scene.md builds step by step: it is read from that page.

# %%
if "barrier" in ONLY:
    barrier = given.output / "barrier.toml"
    barrier.write_text(re.search(r"^```toml\n(.*?)^```$", pathlib.Path("docs/guide/own-scene.md").read_text(), re.M | re.S)[1])
    run = made("barrier", barrier, quick={"domain.cell": 0.5, "time.end": 2.0})
    print(f"  largest force {run.structures['barrier']['force_x_N'].max():.0f} N per metre")
    keep(run, "barrier.png", times=[0, 2, 4, 6], sheet=True)

# %% [markdown]
# ## Ranks that follow a flow
# Four ranks, in whose colours the particles are.

# %%
if "ranks" in ONLY:
    run = made("ranks", "inputs/slurry_runout.toml", {"domain.cell": 0.2, "domain.max": [72.0, 7.6]}, {"domain.cell": 0.5, "domain.max": [72.0, 8.0], "time.end": 3.0}, ranks=4)
    print(f"  {run.summary['repartitions']} repartitions, imbalance {run.summary['imbalance_mean']:.3f}")
    keep(run, "ranks_follow.png", field="rank", times=[0, 1, 3, 6, 15], sheet=True)

# %% [markdown]
# ## Error against run time
# The refinement study of docs/converge.md: an elastic bar on finer and finer cells.

# %%
if "converge" in ONLY:
    study = moraine.converge("inputs/elastic_bar.toml", "kinetic_J@16", given.output / "converge", sets={"time.end": 20.0}, ratio="1:2", coarsest=1.0,
                             levels=3 if given.quick else None, error=None if given.quick else "1%", options=["--device", "cpu"], overwrite=True)
    shutil.copyfile(study.path / "error-kinetic_J_16.svg", PICTURES / "converge.svg")
    print(f"  {PICTURES / 'converge.svg'}")

# %% [markdown]
# ## Where a slope slides
# Its strengths are divided until it fails (docs/factor-of-safety.md); on the finer cell, the plastic shear strain at the lowest factor that does.

# %%
if "safety" in ONLY:
    coarse = {"tolerance": 0.2, "cell": 1.25, "levels": 1} if given.quick else {}
    found = moraine.stability("inputs/stability.toml", given.output / "safety", options=["--device", "cpu"], overwrite=True, told=lambda line: None, **coarse)
    write_pictures(found)
    shutil.copyfile(found.path / found.levels[-1].picture, PICTURES / "slip_surface.png")
    print(f"  {PICTURES / 'slip_surface.png'}")

# %% [markdown]
# ## What if the friction is another?
# The study of the tutorial: in which share of its runs a place is more than half a metre deep.

# %%
if "scenarios" in ONLY:
    sampling = {"sampling": {"method": "grid"}, "set": {"domain.cell": 2.0, "hazard.cell": 4.0, "time.end": 4.0, "hazard.gauges": "valley_gauges.csv"}} if given.quick else {}
    study = moraine.read_scene("inputs/studies/valley_study.toml")
    friction = {**study["parameter"][0], "steps": 2}
    study = {**study, "scene": "inputs/valley.toml", **sampling, **({"parameter": [friction]} if given.quick else {})}
    found = moraine.run_study(study, given.output / "scenarios", options=["--device", "cpu"], overwrite=True)
    share = read_grid(next((found.path / "maps").glob("max_depth-exceeds-0.5.*")))
    figure = draw_map("share of the runs [-]", "viridis", share, numpy.isfinite(share.values), read_grid("inputs/valley.asc"), "more than half a metre deep")
    save(figure, PICTURES / "valley_exceeds.png")
    print(f"  {PICTURES / 'valley_exceeds.png'}")

# %% [markdown]
# ## A load curve with a band
# The pipe again, on three sizes of cells, beside a curve of one's own.

# %%
if "load" in ONLY:
    study = moraine.converge("inputs/pipe_penetration.toml", "structure.pipe.force_y@end", given.output / "load", coarsest=0.4 if given.quick else 0.2,
                             sets={"time.end": 1.0} if given.quick else {}, curves=["structure.pipe.force_y/displacement_y"],
                             data="inputs/pipe_fit.csv", options=["--device", "cpu"], overwrite=True)
    shutil.copyfile(next(study.path.glob("curve-*.svg")), PICTURES / "load_curve.svg")
    print(f"  {PICTURES / 'load_curve.svg'}")

# %%
print(f"Pictures are in {PICTURES}")
