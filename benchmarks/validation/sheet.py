"""The page of all cases: tables of rungs, goals met or missed, and plots as SVG. Plots are data; only `draw` knows matplotlib."""
import collections
import sys

Row = collections.namedtuple("Row", "what value goal met")  # met: True, False, or None where nothing is asked
Plot = collections.namedtuple("Plot", "name title x y lines log")  # lines: (label, x, y, style)


def ladders(lines):
    """{variant: [line by level]} of one case, without failed rungs."""
    found = {}
    for line in sorted(lines, key=lambda x: (x["variant"], x["level"])):
        if "failed" not in line:
            found.setdefault(line["variant"], []).append(line)
    return found


def number(value):
    return f"{value:.4g}"


def rung_table(case, lines):
    names = list(dict.fromkeys(name for x in lines for name in x.get("figures", {})))
    text = ["| variant | rung | " + " | ".join(names) + " | particles | steps | wall [s] | on |", "|---" * (len(names) + 6) + "|"]
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


def section(name, case, lines):
    title, _, rest = case.__doc__.partition("\n")
    plots = case.plots(ladders(lines))
    text = [f"## {name}: {title}", "", rest.strip(), ""] + [f"![{p.title}]({name}-{p.name}.svg)" for p in plots] + [""]
    return text + goal_table(case.rows(ladders(lines))) + [""] + rung_table(case, lines) + [""], plots


def machines(lines):
    words = []
    for x in lines:
        if "machine" in x:
            on = x["device"] if "NVIDIA" in x["device"] else x["machine"]
            words.append(f"{on}, {x['precision']}, commit {x['commit']}")
    return "; ".join(sorted(set(words)))


def write(lines, cases, folder):
    text = ["# Validation", "", "Made by `benchmarks/validation/run CASE`; every run, with its command, is a line of [results.jsonl](results.jsonl), and "
            "[cases/](cases/) say how figures and goals are made of it. Measured on: " + machines(lines) + ". Wall times are of whole "
            "runs with their output, on a host that may have been shared, many side by side on one GPU.", ""]
    drawn = []
    for name, case in cases.items():
        mine = [x for x in lines if x["case"] == name]
        if mine:
            part, plots = section(name, case, mine)
            text += part
            drawn += [(folder / f"{name}-{p.name}.svg", p) for p in plots]
    (folder / "results.md").write_text("\n".join(text).rstrip() + "\n")
    draw(drawn)


def draw(drawn):
    try:
        from plots import pyplot
    except ImportError:
        return print("validation: no plots (matplotlib is missing). Install python3-matplotlib?", file=sys.stderr)
    for path, plot in drawn:
        figure, axes = pyplot.subplots(figsize=(8, 4))
        for label, x, y, style in plot.lines:
            axes.plot(x, y, style, label=label, linewidth=1.2, markersize=4)
        axes.set(xlabel=plot.x, ylabel=plot.y, title=plot.title)
        if plot.log:
            axes.set(xscale="log", yscale="log")
        axes.legend(fontsize=8)
        figure.savefig(path, metadata={"Date": None})
        pyplot.close(figure)
        path.write_text("\n".join(line.rstrip() for line in path.read_text().splitlines()) + "\n")
