"""Where the particles were, on which rank: blocks at chosen times, coloured by owner."""
import numpy
from matplotlib.collections import PatchCollection
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch, Rectangle
from plots import Plot, legend_beside, pyplot


def columns_of(loads, check):
    """One square per block, in 3-D per column of blocks seen from above: corner, particles, owner of most of them."""
    x, y = loads.position(check)[:2]
    held = {}
    for corner, particles, owner in zip(zip(x, y), check.rows["particles"], check.rows["owner"]):
        by_owner = held.setdefault(corner, {})
        by_owner[owner] = by_owner.get(owner, 0) + int(particles)
    return [(corner, sum(by.values()), max(by, key=by.get)) for corner, by in sorted(held.items())]


def colours(ranks):
    from moraine.panels import RANKS
    return ListedColormap(RANKS)


def extent(loads, times):
    """Lower and upper corner of what is held at these times."""
    corners = numpy.concatenate([loads.position(loads.nearest(time))[:2] for time in times], axis=1)
    return corners.min(1), corners.max(1) + loads.side


def panels_of(runs, times, flat):
    """One for each run and time: side by side, or one above the other where the flow is long and low. Also as they
    lie on the page."""
    sizes = [high - low for low, high in (extent(run.loads, times) for run in runs)]
    length = max(size[0] / size[1] for size in sizes)
    if flat and length > 4:
        rows = len(runs) * len(times)
        figure, panels = pyplot.subplots(rows, 1, figsize=(8.2, (0.55 + 7.6 / length) * rows + 0.6), squeeze=False)
        return figure, panels.reshape(len(runs), len(times)), panels
    size = (8.2, 1.1 + (1.2 if flat else 2.6) * len(runs))
    figure, panels = pyplot.subplots(len(runs), len(times), figsize=size, sharex="row", sharey="row", squeeze=False)
    return figure, panels, panels


def name_colours(axes, ranks):
    """Which colour is which rank; of many ranks it would say little, and colours come again."""
    if ranks <= 10:
        patches = [Patch(color=colours(ranks)(rank), label=f"rank {rank}") for rank in range(ranks)]
        legend_beside(axes, handles=patches)


def draw(axes, loads, check, most):
    squares = columns_of(loads, check)
    colour = colours(check.ranks)
    patches, faces = [], []
    for corner, particles, owner in squares:
        patches.append(Rectangle(corner, loads.side, loads.side))
        shade = 0.35 + 0.65 * min(1, particles / most)
        faces.append((*colour(owner % colour.N)[:3], shade))
    axes.add_collection(PatchCollection(patches, facecolors=faces, edgecolors="white", linewidths=0.15))
    axes.set_aspect("equal")
    axes.grid(False)
    return squares


def chosen_times(runs, times):
    if times:
        return times
    end = max(run.loads.checks[-1].time for run in runs)
    return [0.0, end / 2, end]


def owners(runs, times=None):
    """None where no run recorded its block loads."""
    runs = [run for run in runs if run.loads and run.loads.checks]
    if not runs:
        return None
    times = chosen_times(runs, times)
    flat = all(run.loads.dimensions == 2 for run in runs)
    figure, panels, page = panels_of(runs, times, flat)
    rows = []
    for run, line in zip(runs, panels):
        low, high = extent(run.loads, times)
        most = max(square[1] for square in columns_of(run.loads, run.loads.checks[0]))
        for time, axes in zip(times, line):
            check = run.loads.nearest(time)
            squares = draw(axes, run.loads, check, most)
            axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
            axes.set_title(f"{run.name}, t = {check.time:.3g} s", fontsize=9)
            rows += [(run.name, check.time, *corner, particles, owner) for corner, particles, owner in squares]
    name_colours(page[0][-1], max(check.ranks for run in runs for check in run.loads.checks))
    for axes in page[-1]:
        axes.set_xlabel("x [m]")
    for axes in page[:, 0]:
        axes.set_ylabel("y [m]")
    words = "" if flat else " In 3-D seen from above: the colour of a column is the rank that holds most of it."
    return Plot("owners", "Who held which block", "Occupied blocks, coloured by the rank that held them; faint blocks "
                "hold few particles." + words, figure, ("run", "time_s", "x_m", "y_m", "particles", "rank"), rows)
