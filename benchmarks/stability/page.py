"""What the lines of benchmark_stability say together, as Markdown and as a map of the stable steps."""
import figure
import plain_names

LIMIT = "least adrift"
RANDOM = ("S22", "S23", "S24", "S28")
WHOLE = "S22-whole"  # scenes that fail with a build that takes whole steps: docs/stability.md has what they say
CLOUDS = ("strip frozen", "strip adrift", "strip free", "2-D frozen", "2-D adrift", "2-D free", "2-D jittered", "3-D adrift", "3-D free")


def key(line):
    return line["case"], scene(line) if line["case"] in RANDOM else line["configuration"]


def scene(line):
    return line["configuration"].split(":")[0]


def kept(line):
    """A random scene that stands by its number alone: `benchmark_stability` makes it again, and the page has the largest of all."""
    if line["case"] not in RANDOM or not line["pass"]:
        return line
    numbers = {name: value if value is None or name == "particles" else float(f"{value:.1e}") for name, value in line["numbers"].items()}
    return {**line, "configuration": scene(line), "numbers": numbers}


def merged(lines, fresh):
    again = {key(x) for x in fresh}
    return [x for x in lines if key(x) not in again] + fresh


def number(value):
    return "-" if value is None else f"{value:.3g}"


def verdict(line):
    return "" if line["pass"] is None else ("pass" if line["pass"] else "**fails**")


def table(lines):
    """One row per configuration."""
    names = list(dict.fromkeys(n for x in lines for n in x["numbers"]))
    rows = ["| configuration | " + " | ".join(names) + " | |", "|---" * (len(names) + 2) + "|"]
    for x in lines:
        why = x["why"] or ("" if x["pass"] is not False else "; ".join(f"{n} is not a number" for n, v in x["numbers"].items() if v is None))
        words = " ".join(w for w in (verdict(x), why) if w)
        rows.append(f"| {x['configuration']} | " + " | ".join(number(x["numbers"].get(n)) for n in names) + f" | {words} |")
    return rows


def random_scenes(lines):
    """How many stand, and those that do not."""
    failing = [x for x in lines if not x["pass"]]
    particles = [x["numbers"]["particles"] for x in lines]
    momentum = max(x["numbers"]["momentum"] or 0 for x in lines)
    text = [f"{len(lines) - len(failing)} of {len(lines)} scenes stand ({min(particles):.0f} to {max(particles):.0f} particles); largest momentum error "
            f"{momentum:.1e} of M c; processor time {sum(x['seconds'] for x in lines):.0f} s."]
    return text + (["", "Those that do not:", ""] + table(failing) if failing else [])


def summary_row(case, about, lines):
    asked = [x for x in lines if x["pass"] is not None]
    met = f"{sum(1 for x in asked if x['pass'])} of {len(asked)}" if asked else "-"
    return f"| [{case}]({case}.md) | {about.replace('|', '')} | {len(lines)} | {met} |"


def results(lines, words):
    commits = ", ".join(sorted({x["commit"] for x in lines}))
    machines = dict.fromkeys(f"* {x['machine']}, one core, {x['compiler']}, -march={x['march']}" for x in lines)
    text = ["# Where the method is stable", "",
            "The largest stable steps of every method, stress tests and random scenes, in double precision. In words: [docs/stability.md](../../docs/stability.md).", "",
            "| case | what, and its goal | configurations or scenes | meet the goal |", "|---|---|---|---|"]
    for case, about in words.items():
        mine = [x for x in lines if x["case"] == case]
        if mine:
            text.append(summary_row(case, about, mine))
    return plain_names.in_words("\n".join(text + [
        "", f"`-`: no goal. Commits {commits}, on", "", *machines, "", "## Repeat", "", "    benchmarks/stability/run [CASE ...]", "",
        "makes this page, a page of each case, the map of S1 and results.jsonl, which has every line. Hours on one core. S5 and S11 are taken from "
        "[accuracy](../accuracy/results.md).", "",
        f"{WHOLE} in results.jsonl: the scenes of S22 that fail at the program's own step instead of 0.2 to 0.9 of it, by a build with `random_share` of random.cpp at 1."]) + "\n")


def case_page(case, about, lines):
    text = [f"# {plain_names.title(case)}", "", *[f"{part[:1].upper()}{part[1:]}.\n" for part in about.replace("; goal", "\ngoal").splitlines()]]
    if case == "S1":
        text += ["![Largest stable steps](S1.svg)", ""]
    text += [f"`-`: not measured. All cases: [results.md](results.md). Repeat: `benchmarks/stability/run {case}`.", "", *(random_scenes(lines) if case in RANDOM else table(lines))]
    return plain_names.in_words("\n".join(text) + "\n")


def plot(lines, path):
    """The limits over method and cloud."""
    plt = figure.pyplot("stability") if lines else None
    if not plt:
        return
    values = [[x["numbers"].get(c) or float("nan") for c in CLOUDS] for x in lines]
    drawing, axes = plt.subplots(figsize=(7, 1.2 + 0.2 * len(lines)))
    axes.imshow(values, aspect="auto", cmap="viridis", vmin=0, vmax=2.5)
    for i, row in enumerate(values):
        for j, value in enumerate(row):
            if value == value:
                axes.text(j, i, f"{value:.2f}", ha="center", va="center", fontsize=6, color="white" if value < 1.5 else "black")
    axes.set_xticks(range(len(CLOUDS)), CLOUDS, rotation=30, ha="right")
    axes.set_yticks(range(len(lines)), [x["configuration"] for x in lines])
    axes.set_title("largest stable dt c / h")
    figure.save(plt, drawing, path)
