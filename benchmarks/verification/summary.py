"""Tables of case, norm, figure, goal, met or not, of what the tests checked and the three benchmarks wrote: one page per part, and what misses."""
import collections
import importlib.util
import pathlib

import ladder
import plain_names
import records
import sheet

BENCHMARKS = pathlib.Path(__file__).resolve().parents[1]
MEASURED = BENCHMARKS.parent / "runs/benchmarks"
WORDS = {True: "met", False: "**not met**", None: "-"}
Row = collections.namedtuple("Row", "case norm figure goal met")


def lines_of(name):
    return records.read(MEASURED / name / "results.jsonl")


def module(name, file):
    """accuracy and stability both call their module `page`."""
    spec = importlib.util.spec_from_file_location(name, BENCHMARKS / file)
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


accuracy = module("accuracy_page", "accuracy/page.py")
stability = module("stability_page", "stability/page.py")


def number(value):
    return "-" if value is None else f"{value:.3g}"


def of_tests(lines):
    for x in lines:
        norm = x["check"].replace("std::", "").replace("|", "\\|")
        plain = x["figure"] is None
        figure = f"{'held' if x['met'] else 'failed'}" if plain else number(x["figure"])
        times = f", worst of {x['times']}" if x["times"] > 1 else ""
        yield Row(x["case"], f"`{norm}`{times}", figure, "true" if plain else f"{x['relation']} {number(x['goal'])}", x["met"])


def best(lines, cells):
    """The configuration with the least error at so many cells, in double."""
    levels = [x for x in lines if x["precision"] == "double" and x["cells"] == cells and not accuracy.fails(x)]
    return min(levels, key=lambda x: x["error"]) if levels else None


def reaches(lines):
    """(time to 1 % of B0, of its last level, [(time, configuration, reached)]) of one case, in double."""
    base = accuracy.reach(accuracy.ladder(lines, accuracy.B0, "double"), 0.01, "processor_s")
    slowest = max((x["processor_s"] for x in accuracy.ladder(lines, accuracy.B0, "double") if not accuracy.fails(x)), default=0)
    names = dict.fromkeys(x["configuration"] for x in lines if x["precision"] == "double")
    all_of = [(name, accuracy.reach(accuracy.ladder(lines, name, "double"), 0.01, "processor_s")) for name in names]
    return base, slowest, [(reached[0], name, reached) for name, reached in all_of if reached]


def gains(case, lines):
    """Time to 1 % over B0's, of the program's default and of the fastest."""
    base, slowest, found = reaches(lines)
    for what in ("the default", "the fastest"):
        name = accuracy.DEFAULT if what == "the default" else min(found, key=lambda x: (x[2][2], x[0]))[1] if found else None  # first those that stay
        reached = next((r for _, n, r in found if n == name), None)
        ratio = (base[0] if base else slowest) / reached[0] if reached else 0  # B0 is not there after its last level
        words = "1 % is not reached" if not reached else accuracy.gain(base, reached) if base else f"above {ratio:.2g}: B0 is not there after {slowest:.2g} s"
        if what == "the fastest" and name:
            words += f" ({name})"
        yield Row(f"{case} (W)", f"time to 1 %: B0's over that of {what}", words, ">= 3", ratio >= 3)


def of_accuracy(lines):
    for case in dict.fromkeys(x["case"] for x in lines):
        mine = [x for x in lines if x["case"] == case]
        for goal, cells, what in ((5e-4, 64, "E3-small"), (5e-4, 64, "E3-large"), (5e-4, 512, "E3-large"), (2e-3, 64, "E4")):
            x = best(mine, cells) if case == what else None
            if x:
                yield Row(case, f"least error at {cells} cells, dt 0.3 or 0.6 h/c ({x['configuration']})", number(x["error"]), f"<= {goal:g}", x["error"] <= goal)
        yield from gains(case, mine)


def of_stability(lines):
    for case in dict.fromkeys(x["case"] for x in lines):
        mine = [x for x in lines if x["case"] == case]
        asked = [x for x in mine if x["pass"] is not None]
        met = sum(1 for x in asked if x["pass"])
        if asked:
            yield Row(case, "configurations or scenes that meet their goal", f"{met} of {len(asked)}", "all", met == len(asked))
        else:
            yield Row(case, f"{len(mine)} configurations, each a number", "in the table there", "-", None)


MANY = 30


def failing(lines):
    """Each line that fails, with its reason; of cases of which many fail how many, and of the random scenes how many fail for each."""
    text, scenes = [], collections.Counter()
    failed = collections.Counter(x["case"] for x in lines if x["pass"] is False)
    text += [f"* {case}: {n} fail, for the reasons on [its page](../stability/{case}.md)" for case, n in failed.items() if n > MANY]
    for x in lines:
        if x["pass"] is not False or failed[x["case"]] > MANY:
            continue
        if x["case"] == "S22":
            kinds = {"inside out": "a particle is turned inside out (linear shapes)", "energy": "energy grows (USF, MUSL, linear shapes)",
                     "is not": "a particle is not a number (linear shapes)", "closed domain": "a particle passes a wall (plain ghosts, linear shapes)"}
            scenes[next((words for part, words in kinds.items() if part in x["why"]), f"another fault ({x['why'][:60]})")] += 1
        else:
            why = x["why"].strip("; ") or "beyond its goal: " + ", ".join(f"{name} {number(value)}" for name, value in x["numbers"].items())
            text.append(f"* {x['case']}, {x['configuration']}: {why}")
    return text + [f"* S22, {n} scenes: {why}" for why, n in sorted(scenes.items())]


def of_validation(lines):
    for name, case in ladder.cases().items():
        mine = [x for x in lines if x["case"] == name]
        for row in case.rows(sheet.ladders(mine)) if mine else []:
            if row.met is not None:
                yield Row(name, row.what, row.value, row.goal, row.met)


def table(rows):
    return ["| case | norm | figure | goal | |", "|---|---|---|---|---|"] + [f"| {r.case} | {r.norm} | {r.figure} | {r.goal} | {WORDS[r.met]} |" for r in rows]


def about_tests(lines):
    if not lines:
        return "Not run."
    seconds = sum({x["program"]: x.get("program_s", 0) for x in lines}.values())
    long = sorted({x["program"].removeprefix("verification.test_") for x in lines if x["long"]})
    return (f"Programs of tests/verification, {seconds:.0f} s of wall time on a shared host; with the long refinement studies: {', '.join(long) or 'none'}. One row per "
            "check, its worst figure. What they print besides is in tests.jsonl (`said`).")


def parts(tests):
    """{page: (title, what it is made of, its rows, more of the page)}"""
    stable = [x for x in lines_of("stability") if x["case"] != stability.WHOLE]
    return {
        "tests": ("Tests of exact solutions", about_tests(tests), list(of_tests(tests)), []),
        "accuracy": ("Run time against error", "From accuracy/results.jsonl: processor time of one core, B0 = gimp FLIP USL at dt = 0.3 h/c, "
                     f"the default = {accuracy.DEFAULT} (its own step is 0.688 h/c).", list(of_accuracy(lines_of("accuracy"))), []),
        "stability": ("Stability", "From stability/results.jsonl.", list(of_stability(stable)), ["## What fails, and why", "", *failing(stable)]),
        "scenes": ("Whole scenes", "From validation/results.jsonl.", list(of_validation(lines_of("validation"))), [])}


def met_of(rows):
    asked = [r for r in rows if r.met is not None]
    return f"{sum(1 for r in asked if r.met)} of {len(asked)}"


def pages(tests):
    """{file name: text}"""
    found = parts(tests)
    rows = [r for _, _, part, _ in found.values() for r in part]
    text = ["# Verification: what is met and what is not", "",
            f"What the tests of exact solutions and three benchmarks have goals for. **{met_of(rows)} figures meet their goals.** What the cases are, and the reasons: "
            "[verification](../../docs/verification.md), [accuracy](../../docs/accuracy.md), [stability](../../docs/stability.md).", "",
            "| part | goals met |", "|---|---|", *[f"| [{title}]({name}.md) | {met_of(part)} |" for name, (title, _, part, _) in found.items()],
            "", "## Repeat", "", "    benchmarks/verification/run          # all of it (hours)", "    benchmarks/verification/run table    # these pages of what was measured (seconds)", "",
            "## What is not met", ""] + table([r for r in rows if r.met is False])
    texts = {"results.md": text}
    for name, (title, about, part, more) in found.items():
        texts[f"{name}.md"] = [f"# {title}: {met_of(part)} met", "", about, "", *table(part), *([""] + more if more else [])]
    return {name: plain_names.in_words("\n".join(text).rstrip() + "\n") for name, text in texts.items()}
