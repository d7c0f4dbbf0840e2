"""How far a slurry runs out under three yield stresses: runs each, prints the fronts, draws them over time.

    python3 python/examples/compare_runouts.py [--end SECONDS] [--cell METRES]

Start it where inputs/ and build/release/moraine are. Results go to runs/compare_runouts.
"""
import argparse
import pathlib

import matplotlib
import moraine
from moraine.picture import draw

matplotlib.use("agg")
from matplotlib import pyplot  # noqa: E402  (the backend comes first)

SCENE = pathlib.Path("inputs/slurry_runout.toml")
OUTPUT = pathlib.Path("runs/compare_runouts")


def main():
    parser = argparse.ArgumentParser(description="Runout under three yield stresses.")
    parser.add_argument("--end", type=float, default=6.0, help="simulated time [s]")
    parser.add_argument("--cell", type=float, default=0.5, help="side of a cell [m]: 0.5 is coarse, and takes a second")
    given = parser.parse_args()
    figure, axes = pyplot.subplots(figsize=(7, 4), layout="constrained")
    for stress in (100.0, 500.0, 2500.0):
        run = moraine.run(SCENE, OUTPUT / f"{stress:.0f}_Pa", progress=False, overwrite=True,
                          sets={"material.slurry.yield_stress": stress, "domain.cell": given.cell, "time.end": given.end})
        print(f"{stress:6.0f} Pa  {run.summary['front_m']:6.2f} m  in {run.summary['wall_s']:.1f} s")
        axes.plot(run.history["time_s"], run.history["front_m"], label=f"{stress:.0f} Pa")
        draw(run.path, times=[given.end], scene=SCENE, animate=False)
    axes.set(xlabel="time [s]", ylabel="front [m]")
    axes.legend(title="yield stress", frameon=False)
    figure.savefig(OUTPUT / "fronts.png", dpi=100)
    print(f"Pictures are in {OUTPUT}")


if __name__ == "__main__":
    main()
