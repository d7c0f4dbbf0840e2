"""Several runs side by side: in what they differ, what they answer, forces and pictures together, and who shared out work best."""
import copy
import html
import json
import math

import page
from charts import Chart, Line, section

KEYS, NAMED, SHOWN = 5, 3, 6  # columns of keys, structures with a column or a chart, flows in pictures, at most


def short(word):
    """Numbers to six digits."""
    try:
        return f"{float(word):.6g}"
    except ValueError:
        return word


def known_keys(run):
    """Keys of the scene that the answer depends on, and how it was run, as words."""
    try:
        keys = json.loads((run.path / "scene.json").read_text(encoding="utf-8"))["keys"]
        keys = {str(key): short(str(value)) for key, value in keys.items()}
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        keys = {}
    if run.finished:
        keys |= {name: str(run.summary[name]) for name in ("partitioner", "ranks", "threads", "device")}
    return keys


def differing(runs):
    """Keys that are not alike in all runs, with the word of each run; '-' where a run has none."""
    known = [known_keys(run) for run in runs]
    names = list(dict.fromkeys(name for keys in known for name in keys))
    found = {name: [keys.get(name, "-") for keys in known] for name in names}
    return {name: words for name, words in found.items() if len(set(words)) > 1}


def of_one_scene(runs):
    """Whether they are of one scene, however changed."""
    return len({run.summary["scene"] for run in runs}) == 1


def numbers(run, name):
    return [v for v in run.history.get(name, []) if isinstance(v, (int, float)) and math.isfinite(v)]


def text(value, digits=5):
    return "-" if value is None else f"{value:.{digits}g}"


def strongest(run, name):
    """Largest force on a structure in the run [N]."""
    table = run.structures.get(name, {})
    parts = [table[f"force_{axis}_N"] for axis in "xyz" if f"force_{axis}_N" in table]
    sizes = [math.hypot(*row) for row in zip(*parts) if all(isinstance(v, (int, float)) and math.isfinite(v) for v in row)]
    return max(sizes, default=None)


def common_structures(runs):
    return [name for name in runs[0].structures if all(name in run.structures for run in runs)][:NAMED]


def went(run):
    """How far the front came from where it was at the start [m]; None where it is not known."""
    front = numbers(run, "front_m")
    return front[-1] - front[0] if front else None


def answers(runs):
    """The table of what runs answer, beside the keys in which they differ."""
    keys = differing(runs) if of_one_scene(runs) else {}
    shown = dict(list(keys.items())[:KEYS])
    moves = any(len(set(numbers(run, "front_m"))) > 1 for run in runs)
    last = went(runs[-1])
    fronts = [("front went [m]", "from the start to the end along x: of the last column of cells that holds a quarter of a cell's volume"),
              (f"beside {runs[-1].name} [%]", "how much farther the front went than that of the last run")]
    columns = [("run", "the end of its directory"), *[(name, "in this the runs differ") for name in shown], *(fronts if moves else []),
               ("largest speed [m/s]", "of all particles at the times of the outputs"),
               *[(f"force on {name} [kN]", "the largest at the recorded times") for name in common_structures(runs)],
               ("wall [s]", "from start to end")]
    rows = []
    for k, run in enumerate(runs):
        front = went(run)
        share = None if front is None or not last or run is runs[-1] else 100 * (front - last) / abs(last)
        forces = [strongest(run, name) for name in common_structures(runs)]
        rows.append([run.name, *[words[k][:24] for words in shown.values()],
                     *([text(front), "-" if share is None else f"{share:+.1f}"] if moves else []), text(max(numbers(run, "max_speed_m_s"), default=None), 4), *[text(f and f / 1e3, 4) for f in forces],
                     text(run.summary["wall_s"], 4) if run.finished else "-"])
    others = [html.escape(name) for name in keys if name not in shown]
    if not of_one_scene(runs):
        return page.table(columns, rows) + f"<p>They are of different scenes: {html.escape(', '.join(dict.fromkeys(run.summary['scene'] for run in runs)))}.</p>"
    more = f"<p>They also differ in {', '.join(others[:20])}{' and more' if len(others) > 20 else ''}.</p>" if others else ""
    return page.table(columns, rows) + more


def forces(runs):
    """A chart for each structure that all flows have: the size of the force on it."""
    charts = []
    for k, name in enumerate(common_structures(runs)):
        lines = []
        for run in runs:
            table = run.structures[name]
            parts = [table[f"force_{axis}_N"] for axis in "xyz" if f"force_{axis}_N" in table]
            sizes = [math.hypot(*row) / 1e3 if all(isinstance(v, (int, float)) for v in row) else math.nan for row in zip(*parts)]
            lines.append(Line(run.name, [v if isinstance(v, (int, float)) else math.nan for v in table["time_s"]], sizes))
        charts.append(Chart(f"forces_{k}", f"Force on {name}", "The size of the force that the flow exerts on the structure.", "time [s]",
                            "force [kN]", lines, zero=True))
    return charts


def nearest(frames, ks, time):
    """The output that is nearest to a time."""
    return min(ks, key=lambda k: abs(frames.read(k, []).time - time))


def pictures(runs):
    """HTML of the flows at the same three times, in one scale and with one colour bar; empty where they cannot be compared."""
    opened = [(run, *run.opened) for run in runs if getattr(run, "opened", None)][:SHOWN]
    if len(opened) < 2 or not of_one_scene(runs) or len({(frames.field.label, tuple(frames.views)) for _, frames, _ in opened}) > 1:
        return ""
    import numpy
    import planes
    limits = numpy.stack([frames.limits for _, frames, _ in opened])
    limits = numpy.stack([limits[:, :, 0].min(axis=0), limits[:, :, 1].max(axis=0)], axis=1)
    scale = (min(frames.range[0] for _, frames, _ in opened), max(frames.range[1] for _, frames, _ in opened))
    end = min(frames.read(ks[-1], []).time for _, frames, ks in opened)
    start = max(frames.read(ks[0], []).time for _, frames, ks in opened)
    times = [start + share * (end - start) for share in (1 / 3, 2 / 3, 1)] if end > start else [end]
    rows, alike = [], []
    for _, frames, ks in opened:
        frames = copy.copy(frames)
        frames.limits, frames.range = limits, scale
        alike.append((frames, ks))
    flat = planes.is_flat(alike[0][0])
    kind = "" if flat else " two" if len(opened) % 3 else " three"
    for time in times:
        shown = []
        for (run, _, _), (frames, ks) in zip(opened, alike):
            particles = frames.read(nearest(frames, ks, time))
            plane = planes.Plane(frames, frames.views[0])
            shown.append(f'<figure class="still"><h4>{html.escape(run.name)}, t = {particles.time:.3g} s</h4>'
                         f"{plane.box(plane.png(particles), particles.time)}</figure>")
        rows.append(f'<div class="beside{kind}">{"".join(shown)}</div>')
    return f"<h3>At the same times</h3>{planes.colour_bar(alike[0][0])}{''.join(rows)}"


def differences(runs):
    """HTML of maps of each run less those of the last, over the ground; empty where they have none in common."""
    try:
        import hazards
        return hazards.differences([run.path for run in runs], [run.name for run in runs])
    except ImportError:
        return ""
    except Exception as wrong:  # a record that cannot be drawn costs its pictures, and not the page
        return f"<p>Differences of maps are not shown: {html.escape(str(wrong) or type(wrong).__name__)}</p>"


def flows(runs, distinct, charts):
    """The section of runs side by side; `distinct` are those that ended in different states, `charts` theirs."""
    shown = "".join(map(section, charts))
    return (f"<section>\n<h2>Side by side</h2>\n{answers(runs)}\n{differences(distinct)}{pictures(distinct)}"
            + (f'<div class="charts">{shown}</div>' if shown else "") + "\n</section>")


def sharing(runs):
    """One flow shared out in several ways on as many ranks: the ways beside each other, as a section; empty where there are none."""
    groups = {}
    for run in runs:
        if run.finished and run.summary["ranks"] > 1:
            groups.setdefault((run.summary["state_hash"], run.summary["ranks"]), []).append(run)
    parts = [ways(group, ranks) for (_, ranks), group in groups.items() if len(group) > 1]
    return f"<section>\n<h2>The same flow, shared out in several ways</h2>\n{''.join(parts)}\n</section>" if parts else ""


def ways(runs, ranks):
    slowest, best = (pick(runs, key=lambda run: run.speed()) for pick in (min, max))
    columns = [("run", "the end of its directory"), ("partitioner", "how the ground is shared out"),
               ("stepping [s]", "wall time of the steps at the run's mean speed"), ("times as fast", f"as {slowest.name}"),
               ("lost to imbalance [%]", "of the wall time: slowest rank less mean, step by step"),
               ("lost to balancing [%]", "of the wall time: checks, plans and moves"), ("exchange [%]", "of the wall time: halo, migration, agreement")]
    rows = []
    for run in sorted(runs, key=lambda run: run.speed()):
        share = {name: 100 * run.times[name] / run.summary["wall_s"] for name in ("lost_to_imbalance", "balancing", "exchange")}
        seconds = run.summary.get("stepping_s")
        rows.append([run.name, run.partitioner, text(seconds if isinstance(seconds, (int, float)) else None, 4), f"{run.speed() / max(slowest.speed(), 1e-300):.2f}",
                     *[f"{share[name]:.1f}" for name in ("lost_to_imbalance", "balancing", "exchange")]])
    doubtful = [(run.name, run.not_measurable(idle=False)) for run in runs if run.not_measurable(idle=False)]
    if doubtful:
        return ("<p>Which is fastest is not said: " + html.escape("; ".join(f"{name}: {why}" for name, why in doubtful)) + ".</p>" + page.table(columns, rows))
    lost = [100 * run.times["lost_to_imbalance"] / run.summary["wall_s"] for run in (best, slowest)]
    words = (f"<p>On {ranks:.0f} ranks {html.escape(best.name)} ({html.escape(best.partitioner)}) is {best.speed() / max(slowest.speed(), 1e-300):.2f} times as fast "
             f"as {html.escape(slowest.name)} ({html.escape(slowest.partitioner)}); imbalance took {lost[0]:.0f} % of its time, and {lost[1]:.0f} % of the other's.</p>")
    return words + page.table(columns, rows)
