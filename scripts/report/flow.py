"""What the flow of a run did, for the page: facts, warnings, pictures, and charts of history.csv and structures.csv."""
import html
import itertools
import math

import overview
import page
import together
from charts import Chart, Line, section

STRONG = 8  # structures at most with a chart of their own


def column(table, name):
    """A column of numbers, or nothing where the run has none."""
    values = table.get(name, [])
    return [v if isinstance(v, (int, float)) else math.nan for v in list(values)]


def prefix(values, unit):
    """A factor and a unit in which the largest value has few digits."""
    most = max((abs(v) for v in values if math.isfinite(v)), default=0)
    for factor, letter in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if most >= factor:
            return 1 / factor, letter + unit
    return 1.0, unit


def since_start(values):
    return [v - values[0] for v in values]


def rest_name(run):
    """What unaccounted_J of a run is called: over a bed with friction most of it is the bed's."""
    keys = together.known_keys(run)
    rubs = any(key.endswith("contact.law") and value in ("coulomb", "voellmy", "undrained") for key, value in keys.items())
    return "friction of the bed, and the rest" if rubs else "unaccounted"


def energies(run):
    """The parts of the energy that the flow began with; potential is counted from the start."""
    h = run.history
    parts = {"kinetic": column(h, "kinetic_J"), "strain": column(h, "strain_J"), "potential": since_start(column(h, "potential_J")),
             "dissipated": column(h, "dissipated_J"), "unaccounted": column(h, "unaccounted_J")}
    parts[rest_name(run)] = parts.pop("unaccounted")
    factor, unit = prefix([v for values in parts.values() for v in values], "J")
    lines = [Line(name, column(h, "time_s"), [factor * v for v in values], dashed=name == rest_name(run)) for name, values in parts.items()]
    return Chart(f"energies_{run.key}", "Energies", f"Potential energy is counted from the start. {rest_name(run).capitalize()} is what the others leave: friction on "
                 "bed, walls and structures, what left the domain, and the error of the transfer.",
                 "time [s]", f"energy [{unit}]", lines)


def unaccounted(run):
    """The budget: unaccounted energy as a share of what moves between the kinds of energy in the whole run."""
    h = run.history
    kinetic, potential, dissipated = (column(h, f"{name}_J") for name in ("kinetic", "potential", "dissipated"))
    turned = [max(abs(k), abs(p - potential[0]), abs(d)) for k, p, d in zip(kinetic, potential, dissipated)]
    most = max((v for v in turned if math.isfinite(v)), default=0)
    shares = [100 * value / most if most > 0 else math.nan for value in column(h, "unaccounted_J")]
    name = rest_name(run)
    return Chart(f"energy_budget_{run.key}", "Energy budget", f"{name.capitalize()} in per cent of the largest of kinetic, released potential and "
                 "dissipated energy in the run. Below zero there is more energy than there was.", "time [s]", f"{name} [%]",
                 [Line(name, column(h, "time_s"), shares)], zero=True)


def fronts(runs):
    """None of flows whose front stays where it was: the facts say so."""
    if not any(len(set(column(run.history, "front_m"))) > 1 for run in runs):
        return None
    lines = []
    for run in runs:
        t, more = column(run.history, "time_s"), f"{run.name}: " if len(runs) > 1 else ""
        lines += [Line(more + "front", t, column(run.history, "front_m")),
                  Line(more + "centre of mass", t, column(run.history, "centre_x_m"), dashed=True)]
    return Chart("front", "Front and centre", "The front is the last column of cells along x that holds at least a quarter of a cell's volume.",
                 "time [s]", "x [m]", lines)


def speeds(runs):
    lines = [Line(run.name, column(run.history, "time_s"), column(run.history, "max_speed_m_s")) for run in runs]
    return Chart("max_speed", "Largest speed", "Of all particles; one that was thrown out counts.", "time [s]", "speed [m/s]", lines, zero=True)


def fillings(runs):
    lines = [Line(run.name, column(run.history, "time_s"), [100 * v for v in column(run.history, "over_filling")]) for run in runs]
    lines = [line for line in lines if any(math.isfinite(v) for v in line.y)]
    if not lines:
        return None
    return Chart("over_filling", "Over-filling", "Share of the volume that does not fit where its particles are; above 5 % fronts fall short by it.",
                 "time [s]", "over-filling [%]", lines, zero=True)


def sleepers(runs):
    """None of runs in which no block can sleep."""
    lines = []
    for run in runs:
        asleep, particles, more = column(run.history, "asleep"), column(run.history, "particles"), f"{run.name}: " if len(runs) > 1 else ""
        if asleep:
            shares = [100 * a / n if n > 0 else math.nan for a, n in zip(asleep, particles)]
            lines += [Line(more + "asleep", column(run.history, "time_s"), shares),
                      Line(more + "awake", column(run.history, "time_s"), [100 - share for share in shares], dashed=True)]
    if not lines:
        return None
    return Chart("asleep", "Asleep and awake", "Share of the particles. Those of blocks that sleep are left out of P2G and G2P, and count little in the load.",
                 "time [s]", "share [%]", lines, zero=True)


def particle_steps(runs):
    """Made and saved so far, of runs that have ended; None of those in which no block can sleep."""
    lines = []
    for run in runs:
        if not run.finished or "asleep" not in run.balance or not len(run.balance["step"]):
            continue
        more, steps = f"{run.name}: " if len(runs) > 1 else "", run.steps_between
        for name, words in (("awake", "made"), ("asleep", "saved")):
            so_far = itertools.accumulate(float(n) * float(of) / 1e6 for n, of in zip(run.balance[name], steps))
            lines.append(Line(more + words, list(map(float, run.time)), list(so_far), dashed=words == "made"))
    if not lines:
        return None
    return Chart("particle_steps", "Particle-steps", "Made and saved since the start, by who slept at each balance interval.", "time [s]",
                 "particle-steps [million]", lines, zero=True)


def forces(run):
    """A chart for each structure: components of the force on it."""
    charts = []
    for number, (name, table) in enumerate(list(run.structures.items())[:STRONG]):
        parts = [(axis, column(table, f"force_{axis}_N")) for axis in "xyz" if f"force_{axis}_N" in table]
        factor, unit = prefix([v for _, values in parts for v in values], "N")
        lines = [Line(f"force along {axis}", column(table, "time_s"), [factor * v for v in values]) for axis, values in parts]
        per = ", per metre across the plane" if run.dimensions == 2 else ""
        charts.append(Chart(f"force_{run.key}_{number}", f"Force on {name}", f"What the flow exerts on the structure{per}.", "time [s]",
                            f"force [{unit}]", lines, zero=True))
    return charts


def load_curves(run, data):
    """A chart for each structure that moves: the force along its way over how far it went; `data` is a curve of the reader's own."""
    charts = []
    for number, (name, table) in enumerate(list(run.structures.items())[:STRONG]):
        ways = {axis: column(table, f"displacement_{axis}_m") for axis in "xyz" if f"displacement_{axis}_m" in table}
        far = {axis: max((abs(v) for v in way if math.isfinite(v)), default=0.0) for axis, way in ways.items()}
        axis = max(far, key=far.get, default=None)
        if axis is None or far[axis] == 0 or f"force_{axis}_N" not in table:
            continue
        away, force = [abs(v) for v in ways[axis]], column(table, f"force_{axis}_N")
        factor, unit = prefix(force, "N")
        lines = [Line(f"force along {axis}", away, [factor * v for v in force])]
        if data is not None and (data.xname, data.yname) == (f"displacement_{axis}_m", f"force_{axis}_N"):
            lines.append(Line("data", data.x.tolist(), [factor * v for v in data.y.tolist()], dashed=True))
        charts.append(Chart(f"load_{run.key}_{number}", f"Load curve of {name}", f"Force along {axis} over how far {name} went along it.", "displacement [m]",
                            f"force [{unit}]", lines, zero=True))
    return charts


def depths(run, frames, stills):
    """Depth along x at the times of the pictures."""
    colours = ("#8a63a8", "#2f7ed8", "#00a08a", "#76a21e", "#d99000", "#d1495b")  # seen on white and on black
    lines = []
    for k, colour in zip(stills, colours):
        particles = frames.read(k, [])
        x, depth = frames.profile(particles)
        if len(x):
            half = frames.width / 2
            lines.append(Line(f"t = {particles.time:.3g} s", [x[0] - half, *x.tolist(), x[-1] + half], [0.0, *depth.tolist(), 0.0], colour))
    return Chart(f"depth_{run.key}", "Depth along x", "Height from the lowest to the highest particle of a column of four particles"
                 + (", the largest over y." if run.dimensions == 3 else "."), "x [m]", "depth [m]", lines, zero=True)


def number(value, unit="", digits=4):
    if not isinstance(value, (int, float)) or isinstance(value, bool) or not math.isfinite(value):
        return "not known"
    return f"{value:.{digits}g}{unit}"


def facts(run):
    """Names and values for the top of the page."""
    s, h = run.summary, run.history
    front, speed = column(h, "front_m"), column(h, "max_speed_m_s")
    last = column(h, "time_s")[-1:]
    fast = [v for v in speed if math.isfinite(v)]
    filling = s.get("over_filling")
    rows = [("simulated time", number(s.get("simulated_time_s", last[0] if last else None), " s")),
            ("particles", f"{s['particles']:,.0f}".replace(",", "\N{THIN SPACE}") if isinstance(s["particles"], (int, float)) else "not known"),
            ("front", f"went {number(front[-1] - front[0], ' m')}, from x = {number(front[0], ' m', 10)}" if front else "not known"),
            ("largest speed", number(max(fast, default=None), " m/s")),
            ("lost particles", number(s.get("lost_particles")))]
    if isinstance(filling, (int, float)):
        rows.append(("over-filling, most", number(100 * filling, " %", 2)))
    return rows


PROBLEMS = {
    "volume": ("a particle of a nearly incompressible material changed its volume", lambda a: f"{math.exp(min(a, 700)):.3g} times"),
    "energy": ("there was more energy than there had been", lambda a: f"{100 * a:.2g} %"),
    "filling": ("volume does not fit where its particles are, and fronts fall short by it", lambda a: f"{100 * a:.2g} %"),
}


def warnings(run):
    """What the run warned of, as HTML."""
    if not run.finished:
        return (f'<div class="warning"><h3>This run has not ended</h3><p>It has no summary.json: it is under way, or was killed. All below is as far as '
                f"its last output, at t = {number(run.summary['simulated_time_s'])} s; what it warned of is not known.</p></div>")
    found = run.summary.get("warnings")
    items = []
    for warning in found if isinstance(found, list) else []:
        if not isinstance(warning, dict):
            continue
        if isinstance(warning.get("message"), str):  # of the scene, before it ran
            items.append(warning["message"])
            continue
        words, amount = PROBLEMS.get(warning.get("problem"), (str(warning.get("problem", "unknown problem")), str))
        value = warning.get("amount")
        size = f" ({amount(value)})" if isinstance(value, (int, float)) and math.isfinite(value) else ""
        place = [number(x) for x in warning.get("place_m") or []]
        items.append(f"{words}{size}, first at t = {number(warning.get('time_s'))} s, step {number(warning.get('step'), digits=9)}"
                     + (f", near ({', '.join(place)}) m" if place else ""))
    if not items:
        return '<p class="good">The run warned of nothing.</p>' if isinstance(found, list) else ""
    return ('<div class="warning"><h3>Warnings: what follows them is doubtful</h3><ul>'
            + "".join(f"<li>{html.escape(item)}</li>" for item in items) + "</ul></div>")


def pictures(run):
    """HTML of the pictures, and the chart of depths; else why there are none."""
    try:
        import planes
        frames, ks, stills = planes.open_frames(run.path)
        run.opened = frames, ks
        shown = planes.pictures(frames, ks, stills, f"movie_{run.key}")
        return shown, depths(run, frames, stills), ""
    except ImportError as missing:
        return "", None, f"Pictures of the flow: {missing}. Install numpy, matplotlib and h5py by <code>sudo apt-get install " \
                         "python3-matplotlib python3-h5py</code>."
    except Exception as wrong:  # a record that cannot be drawn costs its pictures, and not the page
        return "", None, f"Pictures of the flow of {html.escape(run.name)}: {html.escape(str(wrong) or type(wrong).__name__)}"


def distinct(runs):
    """One run of each state in which runs ended: the others did the same, to the bit."""
    return list({run.summary.get("state_hash", str(run.path)): run for run in reversed(runs)}.values())[::-1]


def sections(runs, errors=None, data=None):
    """HTML of the flow, its charts, and what is not there. errors: a folder with error bars; data: a curve of the reader's own."""
    flows, before, parts, charts, missing = distinct(runs), [], [], [], []
    for k, run in enumerate(flows):
        run.key = str(k)
        heading = "The flow" if len(flows) == 1 else f"The flow of {run.name}"
        shown, depth, why = pictures(run)
        first, unmapped = overview.section(run, errors)
        missing += [words for words in (why, unmapped) if words]
        mine = [chart for chart in [depth, energies(run), unaccounted(run), *load_curves(run, data), *forces(run)] if chart]
        if len(flows) == 1:
            mine = [chart for chart in (fronts(flows), *mine, speeds(flows), fillings(flows), sleepers(flows), particle_steps(flows)) if chart]
        if len(run.structures) > STRONG:
            missing.append(f"Forces on {len(run.structures) - STRONG} more structures of {html.escape(run.name)}: see its structures.csv.")
        charts += mine
        before += [first] if first else []
        parts.append(f"<section>\n<h2>{html.escape(heading)}</h2>\n{page.facts(facts(run))}{'' if first else warnings(run)}{shown}\n"
                     f'<div class="charts">{"".join(map(section, mine))}</div>\n</section>')
    if len(flows) > 1:
        both = [chart for chart in (fronts(flows), speeds(flows), *together.forces(flows), fillings(flows), sleepers(flows), particle_steps(flows)) if chart]
        charts += both
        parts.insert(0, together.flows(runs, flows, both))
    return before + parts, charts, missing


def script():
    """Of the slider, where there are pictures."""
    try:
        import planes
    except ImportError:
        return ""
    return planes.SCRIPT
