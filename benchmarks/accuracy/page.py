"""What the lines of benchmark_accuracy say together: orders, time to an error, Pareto front; as Markdown and as a plot.

results.md has one row per case, CASE.md all of a case. A level is one line: a configuration at one number of cells. A level fails where the program refused to go on, or where the error is
not a number or at least 1 (100 %). Times to an error are interpolated on log-log axes between two neighbouring levels, never extrapolated.
"""
import math

import figure
import plain_names

B0 = "gimp FLIP USL"
DEFAULT = "quadratic APIC USL @0.688"  # the program's, at its own step
ON_CELLS = "on cells"
GOALS = (0.01, 0.001)


def key(line):
    return line["case"], line["configuration"], line["precision"], line["cells"]


def fails(line):
    return "failed" in line or line["error"] is None or line["error"] >= 1


def short(line):
    what = f"{line['case']} {line['configuration']} {line['precision']} {line['cells']}"
    return f"{what}: {line['failed']}" if "failed" in line else f"{what}: {line['error']} in {line['processor_s']} s"


def ladder(lines, configuration, precision):
    levels = [x for x in lines if x["configuration"] == configuration and x["precision"] == precision]
    return sorted(levels, key=lambda x: x["cells"])


def order(levels):
    """Over the last two levels; None if one of them fails."""
    if len(levels) < 2 or fails(levels[-1]) or fails(levels[-2]):
        return None
    coarse, fine = levels[-2:]
    return math.log(coarse["error"] / fine["error"]) / math.log(fine["cells"] / coarse["cells"])


def reach(levels, goal, key):
    """(key at which the error is `goal` and stays below, whether that is only an upper bound, False); if it does not stay, where it first was and True; None: never."""
    first = None
    for k, level in enumerate(levels):
        if fails(level) or level["error"] > goal:
            continue
        again = any(fails(x) or x["error"] > goal for x in levels[k + 1:])
        if again and first:
            continue
        if k == 0 or fails(levels[k - 1]):
            found = level[key], True, again
        elif levels[k - 1]["error"] <= goal:
            continue
        else:
            before = levels[k - 1]
            share = math.log(before["error"] / goal) / math.log(before["error"] / level["error"])
            found = before[key] * (level[key] / before[key]) ** share, False, again
        if not again:
            return found
        first = found
    return first


def front(lines):
    """Levels that no other beats in both time and error."""
    best, kept = math.inf, []
    for line in sorted((x for x in lines if not fails(x)), key=lambda x: (x["processor_s"], x["error"])):
        if line["error"] < best:
            best = line["error"]
            kept.append(line)
    return kept


def seconds_to(reached):
    if not reached:
        return "-"
    value, bound, again = reached
    return f"{'<= ' if bound else ''}{value:.2g}{' (then worse)' if again else ''}"


def gain(base, reached, longest=0):
    """How many times sooner than B0; where B0 never gets there, than its finest level if that is given, `longest`, which is not there either."""
    if not reached:
        return "-"
    if not base:
        return f"> {longest / reached[0]:.2g}" if longest else "B0 never"
    sign = "" if base[1] == reached[1] else ("<= " if base[1] else ">= ")
    return f"{sign}{base[0] / reached[0]:.2g}" if not (base[1] and reached[1]) else "both below"


def error_text(line):
    return "fails" if fails(line) else f"{line['error']:.1e}"


def row(lines, name, precision, cells):
    levels = ladder(lines, name, precision)
    by_cells = {x["cells"]: x for x in levels}
    base = ladder(lines, B0, precision)
    p = order(levels)
    columns = [name + (" (B0)" if name == B0 else "")]
    columns += [error_text(by_cells[n]) if n in by_cells else "" for n in cells]
    columns.append("-" if p is None else f"{p:.2f}")
    last = levels[-1]
    columns += ["-"] * 3 if fails(last) and "failed" in last else [
        f"{last['processor_s']:.2g}", f"{last['wall_s']:.2g}", f"{last['particle_steps'] / 1e6:.2g}"]
    for goal in GOALS:
        columns.append(seconds_to(reach(levels, goal, "processor_s")))
        for key in ("processor_s", "particle_steps"):
            longest = max((x[key] for x in base if not fails(x)), default=0) if any(ON_CELLS in x["configuration"] for x in lines) else 0
            columns.append(gain(reach(base, goal, key), reach(levels, goal, key), longest))
    return "| " + " | ".join(columns) + " |"


def table(lines, precision):
    cells = sorted({x["cells"] for x in lines if x["precision"] == precision})
    names = list(dict.fromkeys(x["configuration"] for x in lines if x["precision"] == precision))
    head = ["configuration"] + [f"{n} cells" for n in cells] + ["p", "processor s", "wall s", "M particle-steps"]
    for goal in GOALS:
        head += [f"s to {100 * goal:g} %", "B0 / this", "in particle-steps"]
    return ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"] + [row(lines, n, precision, cells) for n in names]


def precisions(lines):
    """One sentence: how far single is from double, and what it saves."""
    doubles = {(x["configuration"], x["cells"]): x for x in lines if x["precision"] == "double" and not fails(x)}
    pairs = [(doubles[x["configuration"], x["cells"]], x) for x in lines if x["precision"] == "single" and not fails(x)
             and (x["configuration"], x["cells"]) in doubles]
    if not pairs:
        return []
    apart = [(abs(s["error"] - d["error"]), d, s) for d, s in pairs]
    worst, d, s = max(apart, key=lambda x: x[0])
    within = sum(1 for a, _, _ in apart if a <= 1e-3)
    times = sorted(s["processor_s"] / d["processor_s"] for d, s in pairs if d["processor_s"] > 0.2)
    text = (f"Single against double: the errors of {within} of {len(pairs)} levels differ by at most 0.1 % of the quantity; the largest difference is "
            f"{worst:.1e} ({d['configuration']}, {d['cells']} cells: {d['error']:.2e} in double, {s['error']:.2e} in single).")
    if times:
        text += f" Single took {times[len(times) // 2]:.2f} of the time of double (median of levels above 0.2 s)."
    return ["", text]


def failures(lines):
    rows = []
    for x in lines:
        if fails(x):
            why = x.get("failed") or ("the error is not a number" if x["error"] is None else f"error {x['error']:.1e}")
            rows.append(f"* {x['configuration']}, {x['precision']}, {x['cells']} cells: {why}")
    return (["", f"Failing ({len(rows)} of {len(lines)} levels):", ""] + rows) if rows else ["", "No level fails."]


def second_norms(lines):
    """The other norms of the finest level of each configuration, in double."""
    cells = max(x["cells"] for x in lines)
    rows = [x for x in lines if x["cells"] == cells and x["precision"] == "double" and not fails(x)]
    if not rows:
        return []
    names = list(rows[0]["norms"])
    text = ["", f"All norms at {cells} cells, in double:", "", "| configuration | " + " | ".join(names) + " |", "|---" * (len(names) + 1) + "|"]
    for x in rows:
        text.append(f"| {x['configuration']} | " + " | ".join("-" if x["norms"][n] is None else f"{x['norms'][n]:.1e}" for n in names) + " |")
    return text + [""]


def beside_reference(lines):
    """When the others are at the least error of B0's finest level in the same run; seconds only of one commit and machine."""
    cured = [x for x in lines if ON_CELLS in x["configuration"] and x["precision"] == "double"]
    if not cured:
        return []
    base = ladder(lines, B0, "double")
    same = [x for x in base if x["commit"] == cured[0]["commit"]]
    last = (same or base)[-1]
    text = ["", f"To the error of B0 at {last['cells']} cells, {100 * last['error']:.2g} %" + (", in one run on one machine" if same else "") + ":", "",
            "| configuration | processor s | M particle-steps | B0 / this | in particle-steps |", "|---|---|---|---|---|"]
    for name in dict.fromkeys(x["configuration"] for x in cured + [x for x in lines if x["configuration"] == DEFAULT]):
        levels = [x for x in ladder(lines, name, "double") if not same or x["commit"] == last["commit"]]
        seconds, steps = (reach(levels, last["error"], key) for key in ("processor_s", "particle_steps"))
        if not steps:
            text.append(f"| {name} | - | - | - | - |")
            continue
        bound = ">= " if steps[1] else ""
        text.append(f"| {name} | {seconds_to(seconds) if same else '-'} | {seconds_to((steps[0] / 1e6, *steps[1:]))} | "
                    f"{bound + format(last['processor_s'] / seconds[0], '.2g') if same else '-'} | {bound}{last['particle_steps'] / steps[0]:.2g} |")
    return text


def case_page(case, words, lines):
    text = [f"# {plain_names.title(case)}", "", f"Problem: {words}.", "", f"![{case}]({case}.svg)", ""]
    text += ["In double; what the columns are: [results.md](results.md).", ""] + table(lines, "double")
    best = [x for x in lines if x["precision"] == "double"]
    text += ["", "Pareto front in double:", "", "| configuration | cells | processor s | error |", "|---|---|---|---|"]
    text += [f"| {x['configuration']} | {x['cells']} | {x['processor_s']:.2g} | {x['error']:.1e} |" for x in front(best)]
    text += beside_reference(lines) + precisions(lines) + failures(lines) + second_norms(lines) + ["", f"Repeat: `benchmarks/accuracy/run {case}`."]
    return plain_names.in_words("\n".join(text).rstrip() + "\n")


def summary_row(case, words, lines):
    """When B0, the default and the fastest of all are at 1 %, and the least error at the largest number of cells, in double."""
    reached = {x["configuration"]: reach(ladder(lines, x["configuration"], "double"), 0.01, "processor_s") for x in lines if x["precision"] == "double"}
    fastest = min((r[2], r[0], name) for name, r in reached.items() if r) if any(reached.values()) else None
    cells = max(x["cells"] for x in lines if x["precision"] == "double")
    finest = [x for x in lines if (x["precision"], x["cells"]) == ("double", cells) and not fails(x)]
    least = min(finest, key=lambda x: x["error"]) if finest else None
    columns = [f"[{case}]({case}.md)", words, *[seconds_to(reached.get(name)) for name in (B0, DEFAULT)],
               f"{seconds_to(reached[fastest[-1]])} ({fastest[-1]})" if fastest else "-", f"{least['error']:.1e} at {cells} ({least['configuration']})" if least else "-"]
    return "| " + " | ".join(columns) + " |"


def results(lines, words):
    machines = {}
    for x in lines:
        about = f"{x['machine']}, {x['cores']} cores, one of them used; {x['compiler']}, -march={x['march']}; commit {x['commit']}"
        machines.setdefault(about, {})[x["case"]] = None
    text = ["# Run time against error on one core", "",
            "Processor time and error of every method on problems with exact solutions, and on whole scenes, in both precisions. In words: "
            "[docs/accuracy.md](../../docs/accuracy.md).", "",
            "| case | problem | s to 1 %: B0 | the default | the fastest | least error at the most cells |", "|---|---|---|---|---|---|"]
    for case, about in words.items():
        mine = [x for x in lines if x["case"] == case]
        if mine:
            text.append(summary_row(case, about, mine))
    text += ["", f"B0: {B0}, the method paper's scheme, dt = 0.3 h/c. The default: {DEFAULT}, the program's at its own step. In double.", "",
             *[f"* {about}: {', '.join(cases)}" for about, cases in machines.items()], "", "## Repeat", "", "    benchmarks/accuracy/run [CASE ...]", "",
             "makes this page, a page and a plot of each case, and results.jsonl, which has every line; `page.py` says how the figures are made of them. "
             "Hours on one core. Whole scenes on a GPU by `benchmarks/validation/run`, for the tables of docs/accuracy.md.", "",
             "## What the columns are", "",
             "* **The machines were shared.** Times are of the processor, over the step loop only, without the body force of E3. Neighbours disturb these too, so ratios stand "
             "beside those of particle-steps. A run below 0.2 s is the median of up to five.",
             "* p: order over the last two levels. `B0 / this`: how many times sooner than B0 the error is reached; `-`: not on these levels.",
             "* All take dt = 0.3 h/c, those with @ that share of h/c; in the dam break h / (c + |v|) stands for h/c.",
             f"* {ON_CELLS}: what the shipped scenes of fluids take, `volumetric = \"grid\"`, up to ten substeps, `pressure_smoothing = 0.22`, `particle_shifting = 0.2` and the "
             "program's own step. In flows only.",
             "* s to 1 %: from where the error stays below, of the levels that were run; `then worse`: it does not stay. `> 5`: B0 is not there on its finest level, whose time is 5 times this.",
             "* With USF the stress that a run leaves is one step older than its places, so its stress norm in E3 is of first order in dt.", ""]
    return plain_names.in_words("\n".join(text).rstrip() + "\n")


def style(name):
    shape, transfer, update = (name.split() + ["USL"])[:3]  # FMPM(k) has one update
    colors = {"gimp": "black", "gimp-contiguous": "tab:red", "quadratic": "tab:blue", "cubic": "tab:green"}
    marker = {"FLIP": "o", "APIC": "s", "TPIC": "^", "AFLIP": "D"}.get(transfer) or f"${transfer[5:-1]}$"  # FMPM: its order
    if ON_CELLS in name:
        colors[shape] = "tab:purple"
    return {"color": colors[shape], "marker": marker, "markersize": 5 if "FMPM" in name else 3,
            "linestyle": {"USL": "-", "USF": "--", "MUSL": ":"}[update], "linewidth": 2 if name == B0 else 0.8,
            "markerfacecolor": "none" if "@" in name else colors[shape]}


def plot(lines, words, path):
    lines = [x for x in lines if x["precision"] == "double" and not fails(x)]
    plt = figure.pyplot("accuracy") if lines else None
    if not plt:
        return
    drawing, axes = plt.subplots(figsize=(9, 5))
    for name in dict.fromkeys(x["configuration"] for x in lines):
        levels = ladder(lines, name, "double")
        axes.loglog([x["processor_s"] for x in levels], [x["error"] for x in levels], label=name, **style(name))
    best = front(lines)
    axes.loglog([x["processor_s"] for x in best], [x["error"] for x in best], color="orange", linewidth=5, alpha=0.35, label="Pareto front")
    for goal in GOALS:
        axes.axhline(goal, color="gray", linewidth=0.5)
    axes.set_xlabel("processor time of the step loop [s]")
    axes.set_ylabel("error")
    axes.set_title(words, fontsize=8)
    axes.legend(fontsize=6, loc="center left", bbox_to_anchor=(1.01, 0.5))
    figure.save(plt, drawing, path)
