"""The plots of a report: each is a figure, the sentence under it, and the table of its points."""
import collections

import numpy
from canvas import pyplot
from charts import Chart, Line, bars
from matplotlib import ticker

COMPUTING = ("computing, mean of the ranks", "#4d9221")
CAUSES = {  # of lost time: what it is called, and its colour
    "granularity": ("granularity: even the best cut is uneven", "#b2182b"),
    "partition": ("partition: not the best cut for the loads of then", "#ef8a62"),
    "timing noise": ("timing noise: equal loads that did not take equal time", "#fddbc7"),
    "imbalance": ("imbalance (no block loads recorded: causes unknown)", "#ef8a62"),
    "exchange": ("exchange: halo, binning, migration, agreement", "#67a9cf"),
    "balancing": ("balancing: checks, plans, moves", "#2166ac"),
    "output": ("output", "#999999"),
    "rest": ("start, end and rest", "#d9d9d9"),
}

Plot = collections.namedtuple("Plot", "name title caption figure columns rows html", defaults=[""])  # html: instead of the figure


def colours(count):
    from moraine.panels import RANKS
    return [RANKS[k % len(RANKS)] for k in range(count)]


def log_axis(axis, values):
    """Numbers that a reader expects on a log axis, as many as there is room for."""
    wide = max(values) > 12 * min(values)
    axis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5) if wide else (1, 1.5, 2, 3, 4, 5, 6, 8)))
    axis.set_minor_locator(ticker.NullLocator())
    axis.set_major_formatter("{x:.3g}")


def legend_beside(axes, **what):
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), borderaxespad=0, fontsize=9, **what)


def over_time(runs, name, title, label, caption, value, log=False):
    """One line per run against simulated time. value(run) is an array along the rows of balance.csv."""
    lines = [Line(run.name, list(map(float, run.time)), list(map(float, value(run)))) for run in runs]
    return Chart(name, title, caption, "simulated time [s]", label, lines, log, columns=("run", "time_s", name))


def imbalance(runs):
    return over_time(runs, "imbalance", "Imbalance over time", "maximum / mean particles",
                     "Particles of the fullest rank over the mean of all ranks, idle ones included, at each balance "
                     "interval. 1 is perfect; a step lasts as long as its slowest rank.",
                     lambda run: run.balance["imbalance"],
                     log=any(run.balance["imbalance"].max() > 3 for run in runs))


def halo(runs):
    return over_time(runs, "halo_MB_per_step", "Halo volume", "MB per step, all ranks",
                     "Bytes of halo messages that all ranks together send in a step.",
                     lambda run: run.balance["halo_bytes"] / numpy.maximum(1, run.steps_between) / 1e6)


def migration(runs):
    """Particles that repartitions moved, cumulated, in per cent of all."""
    plot = over_time(runs, "migrated_percent", "Migration volume", "particles moved [% of all, summed]",
                     "Particles that repartitions have moved so far, in per cent of all particles. Static "
                     "partitions move none.",
                     lambda run: 100 * numpy.cumsum(run.balance["migrated_particles"]) / run.summary["particles"])
    return plot


def lost_time(runs):
    tall = 0.6 + 0.45 * len(runs)
    figure, (axes, below) = pyplot.subplots(2, 1, figsize=(8, tall + 1.2), height_ratios=(tall, 1.2))
    rows, seen = [], set()
    for k, run in enumerate(runs):
        wall, left = run.summary["wall_s"], 100 * run.times["computing"] / run.summary["wall_s"]
        axes.barh(k, left, color=COMPUTING[1], label=None if seen else COMPUTING[0])
        axes.text(left / 2, k, f"{left:.0f} %", ha="center", va="center", color="white", fontsize=9)
        rows.append((run.name, "computing", run.times["computing"], left))
        seen.add("computing")
        parts = {**run.lost(), **{cause: run.times[cause] for cause in ("exchange", "balancing", "output", "rest")}}
        for cause, seconds in parts.items():
            percent = 100 * max(0, seconds) / wall
            words, colour = CAUSES[cause]
            axes.barh(k, percent, left=left, color=colour, label=None if cause in seen else words)
            seen.add(cause)
            left += percent
            rows.append((run.name, cause, seconds, percent))
    lines = [(run.name, [(CAUSES.get(row[1], COMPUTING), row[3]) for row in rows if row[0] == run.name]) for run in runs]
    axes.set(yticks=range(len(runs)), yticklabels=[run.name for run in runs], xlabel="wall time [%]", xlim=(0, 100))
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    below.axis("off")
    below.legend(*axes.get_legend_handles_labels(), loc="center", ncol=2, fontsize=9)
    return Plot("lost_time", "Where the time went", "Wall time of each run by cause. What is not computing was lost. "
                "Waiting for slower ranks is the three causes of imbalance; exchange is what goes beyond it.",
                figure, ("run", "cause", "seconds", "percent"), rows, bars(lines))


def decisions(runs):
    """Each imbalance check, by the reason that the trigger gave."""
    figure, panels = pyplot.subplots(len(runs), 1, figsize=(8, 0.6 + 1.25 * len(runs)), sharex=True, squeeze=False)
    rows = []
    for run, axes in zip(runs, panels[:, 0]):
        reasons = [reason or "one rank" for reason in run.balance["reason"]]
        names = sorted(set(reasons))
        done = run.balance["repartitioned"] > 0
        places = numpy.array([names.index(reason) for reason in reasons])
        axes.scatter(run.time[~done], places[~done], s=10, color="#999999")
        axes.scatter(run.time[done], places[done], s=22, marker="^", color="#b2182b")
        axes.set(yticks=range(len(names)), yticklabels=names, ylim=(-0.6, len(names) - 0.4))
        axes.set_title(f"{run.name}: {int(done.sum())} repartitions at {len(reasons)} checks", loc="left", fontsize=9)
        rows += list(zip([run.name] * len(reasons), run.time, reasons, done.astype(int),
                         run.balance["imbalance"], run.balance["planned_imbalance"], run.balance["plan"]))
    panels[-1, 0].set(xlabel="simulated time [s]")
    return Plot("decisions", "Decisions of the trigger", "Each imbalance check and the reason that the trigger "
                "gave; red triangles: the blocks were repartitioned.", figure,
                ("run", "time_s", "reason", "repartitioned", "imbalance", "planned_imbalance", "plan"), rows)


def groups(runs, key):
    """Runs whose speed can be measured and that differ in ranks only, with at least two numbers of ranks; by (scene, ..., partitioner)."""
    found = collections.defaultdict(list)
    for run in runs:
        if run.not_measurable():
            continue
        s = run.summary
        found[key(s) + (s["device"], s["precision"], s["threads"], run.partitioner)].append(run)
    return {words: sorted(members, key=lambda run: run.ranks) for words, members in found.items()
            if len({run.ranks for run in members}) > 1}


def scaling(runs, name, title, caption, key):
    """Speed and efficiency against ranks; None where no two runs differ in ranks."""
    found = groups(runs, key)
    if not found:
        return None
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(8, 3.2))
    rows = []
    for (words, members), colour in zip(found.items(), colours(len(found))):
        ranks = numpy.array([run.ranks for run in members])
        speed = numpy.array([run.speed() for run in members])
        first = numpy.median(speed[ranks == ranks[0]])
        efficiency = speed / first * ranks[0] / ranks
        at = numpy.unique(ranks)
        for axes, values in ((left, speed / 1e6), (right, 100 * efficiency)):
            middle = numpy.array([numpy.median(values[ranks == n]) for n in at])
            ends = numpy.array([[values[ranks == n].min(), values[ranks == n].max()] for n in at])
            axes.errorbar(at, middle, abs(ends - middle[:, None]).T, fmt="o-", color=colour, capsize=3, label=words[-1])
        left.plot(at, first / 1e6 * at / at[0], ":", color=colour, linewidth=0.8)
        rows += [(run.name, *words, run.ranks, run.summary["particles"], v, e)
                 for run, v, e in zip(members, speed, efficiency)]
    for axes in (left, right):
        axes.set_xscale("log", base=2)
        axes.set(xlabel="ranks", xticks=sorted({row[-4] for row in rows}))
        axes.xaxis.set_major_formatter("{x:.0f}")
    left.set_yscale("log")
    log_axis(left.yaxis, [row[-2] / 1e6 for row in rows])
    left.set(ylabel="million particle-steps / s", title="speed (dotted: ideal)")
    right.set(ylabel="efficiency [%]", ylim=(0, 105 * max(row[-1] for row in rows)), title="against the fewest ranks")
    legend_beside(right)
    return Plot(name, title, caption, figure,
                ("run", "scene", "load", "device", "precision", "threads", "partitioner", "ranks", "particles",
                 "particle_steps_per_s", "efficiency"), rows)


def strong(runs):
    return scaling(runs, "strong_scaling", "Strong scaling", "The same scene on more ranks: measured speed, and "
                   "efficiency against the fewest ranks of each partitioner; medians, and bars from the slowest to the fastest run where there are several.",
                   lambda s: (s["scene"], s["particles"]))


def weak(runs):
    return scaling(runs, "weak_scaling", "Weak scaling", "Runs with the same number of particles per rank (to 10 %).",
                   lambda s: (s["scene"], round(numpy.log(s["particles"] / s["ranks"]) / numpy.log(1.1))))


def predictions(runs):
    """Imbalance and efficiency on ranks that were not there, from replay.csv; None where no run has been replayed."""
    replayed = [run for run in runs if run.replay and "predicted" in run.replay["kind"]]
    if not replayed:
        return None
    figure, panels = pyplot.subplots(len(replayed), 2, figsize=(8, 3.2 * len(replayed)), squeeze=False)
    rows = []
    for run, (left, right) in zip(replayed, panels):
        table = run.replay
        keep = [k for k, kind in enumerate(table["kind"]) if kind == "predicted"]
        lines = sorted({(table["partitioner"][k], table["trigger"][k]) for k in keep})
        for line, colour in zip(lines, colours(len(lines))):
            at = [k for k in keep if (table["partitioner"][k], table["trigger"][k]) == line]
            column = {n: [float(table[n][k]) for k in at] for n in ("ranks", "imbalance_mean", "efficiency", "time_s")}
            left.plot(column["ranks"], column["imbalance_mean"], "o--", markersize=4, color=colour)
            right.plot(column["ranks"], [100 * e for e in column["efficiency"]], "o--", markersize=4, color=colour,
                       label=" ".join(line))
            rows += [(run.name, *line, *values) for values in zip(*column.values())]
        left.set(ylabel="imbalance, mean", yscale="log", title=f"predicted from {run.name}")
        log_axis(left.yaxis, [row[4] for row in rows if row[0] == run.name])
        right.set(ylabel="efficiency [%]", ylim=(0, None), title="predicted by the time model")
        legend_beside(right)
        for axes in (left, right):
            axes.set_xscale("log", base=2)
            axes.set(xlabel="ranks")
            axes.xaxis.set_major_formatter("{x:.0f}")
            axes.xaxis.set_minor_locator(ticker.NullLocator())
    return Plot("predictions", "Predictions (moraine replay)", "Nothing in this plot was measured: recorded block "
                "loads, replayed on other numbers of ranks and under other partitioners. Imbalance is counted; efficiency "
                "follows a model whose network is an assumption.", figure,
                ("run", "partitioner", "trigger", "ranks", "imbalance_mean", "efficiency", "time_s"), rows)
