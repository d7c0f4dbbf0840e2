"""The pages of all cases: tables of levels, goals met or missed, and plots as small SVG. Plots are data; only `draw` knows matplotlib."""
import collections

import figure
import plain_names

Row = collections.namedtuple("Row", "what value goal met")  # met: True, False, or None where there is no goal
Plot = collections.namedtuple("Plot", "name title x y lines log")  # lines: (label, x, y, style)


def ladders(lines):
    """{variant: [line by level]} of one case, without failed levels."""
    found = {}
    for line in sorted(lines, key=lambda x: (x["variant"], x["level"])):
        if "failed" not in line:
            found.setdefault(line["variant"], []).append(line)
    return found


def number(value):
    return f"{value:.4g}"


def level_table(case, lines):
    names = list(dict.fromkeys(name for x in lines for name in x.get("figures", {})))
    text = ["| variant | level | " + " | ".join(names) + " | particles | steps | wall [s] | on |", "|---" * (len(names) + 6) + "|"]
    for x in sorted(lines, key=lambda x: (x["variant"], x["level"])):
        head = f"| {x['variant']} | {case.RUNG.format(x['level'])} | "
        if "failed" in x:
            text.append(head + " | ".join([x["failed"]] + [""] * (len(names) + 3)) + " |")
            continue
        values = [number(x["figures"][name]) if name in x["figures"] else "" for name in names]
        on = "1 GPU" if "NVIDIA" in x["device"] else "host"
        text.append(head + " | ".join(values + [str(x["particles"]), str(x["steps"]), f"{x['wall_s']:.0f}", on]) + " |")
    return text


def goal_table(rows):
    words = {True: "met", False: "**missed**", None: "-"}
    return ["| what | measured | goal | |", "|---|---|---|---|"] + [f"| {r.what} | {r.value} | {r.goal} | {words[r.met]} |" for r in rows]


def case_page(name, case, lines):
    """Scene, norms and reasons, plots, and every run."""
    title, _, rest = case.__doc__.partition("\n")
    plots = case.plots(ladders(lines))
    text = [f"# {title}", "", rest.strip(), ""] + [f"![{p.title}]({name}-{p.name}.svg)" for p in plots]
    text += ["", "## Goals", "", *goal_table(case.rows(ladders(lines))), "", "## All runs", "", *level_table(case, lines)]
    text += ["", f"Repeat: `benchmarks/validation/run {name}`. All cases: [results.md](results.md)."]
    return plain_names.in_words("\n".join(text) + "\n"), plots


def summary_row(name, case, rows):
    asked = [r for r in rows if r.met is not None]
    return f"| [{name}]({name}.md) | {case.__doc__.splitlines()[0]} | {sum(1 for r in asked if r.met)} of {len(asked)} |"


def machines(lines):
    """Each once, with the commits of what it ran."""
    commits = {}
    for x in lines:
        if "machine" in x:
            on = x["device"] if "NVIDIA" in x["device"] else x["machine"]
            commits.setdefault(f"{on}, {x['precision']}", set()).add(x["commit"][:7])
    return "; ".join(f"{on}, commit {', '.join(sorted(of))}" for on, of in sorted(commits.items()))


def write(lines, cases, folder):
    """results.md: how many goals each case meets; CASE.md: all of them, and its plots."""
    summary, drawn = [], []
    for name, case in cases.items():
        mine = [x for x in lines if x["case"] == name]
        if not mine:
            continue
        text, plots = case_page(name, case, mine)
        (folder / f"{name}.md").write_text(text)
        drawn += [(folder / f"{name}-{p.name}.svg", p) for p in plots]
        summary.append(summary_row(name, case, case.rows(ladders(mine))))
    text = ["# Validation", "", "Refinement studies of whole scenes, run as a user would run them, against published and exact references.", "",
            "| case | what | goals met |", "|---|---|---|", *summary, "", "Measured on: " + machines(lines) + ".", "",
            "Wall times are of whole runs with their output, on a host that may have been shared, many side by side on one GPU.", "",
            "## Repeat", "", "    benchmarks/validation/run CASE ... [--device cuda]", "",
            "writes a line per run, with its command, to results.jsonl, this page, and a page of each case with its goals met and missed, reasons, plots and runs. "
            "Modules in cases/ say how figures and goals are made of them.", ""]
    (folder / "results.md").write_text(plain_names.in_words("\n".join(text).rstrip() + "\n"))
    draw(drawn)


def draw(drawn):
    plt = figure.pyplot("validation")
    for path, plot in drawn if plt else []:
        drawing, axes = plt.subplots(figsize=(8, 4))
        for label, x, y, style in plot.lines:
            axes.plot(x, y, style, label=label, linewidth=1.2, markersize=4)
        axes.set(xlabel=plot.x, ylabel=plot.y, title=plot.title)
        if plot.log:
            axes.set(xscale="log", yscale="log")
        axes.grid(alpha=0.25)
        axes.legend(fontsize=7, frameon=False)
        figure.save(plt, drawing, path)
