"""Figures and goals of the verification tests: what their checks compared, from doctest's own report.

One line per test program, test case and check: the expression, its worst figure (nearest to its goal, or furthest beyond it) over all
times that it was checked, how often, and whether it always held.
"""
import os
import re
import subprocess
import sys
import time
import xml.etree.ElementTree

import records
from figure import ENVIRONMENT

NUMBER = r"-?[0-9.]+(?:e[+-]?[0-9]+)?"


def programs(build, words):
    found = sorted((build / "tests").glob("verification.test_*"))
    return [p for p in found if os.access(p, os.X_OK) and (not words or any(w in p.name for w in words.split(",")))]


def compared(original, expanded):
    """(what is compared, relation, figure, goal); figures are None where it is no comparison of two numbers."""
    sides = re.split(r"\s(<=|>=|<|>)\s", original, maxsplit=1)
    values = re.match(rf"({NUMBER}) (<=|>=|<|>) ({NUMBER})$", expanded)
    if len(sides) != 3 or not values:
        return original, "", None, None
    return sides[0].strip(), sides[1], float(values[1]), float(values[3])


def worse(a, b):
    """Of two lines of one check, the one nearer to failing."""
    if a["figure"] is None or a["met"] != b["met"]:
        return a if not a["met"] else b
    slack = {line["figure"]: (line["goal"] - line["figure"]) / (abs(line["goal"]) or 1) * (1 if "<" in line["relation"] else -1) for line in (a, b)}
    return min(a, b, key=lambda line: slack[line["figure"]])


def lines_of(report, program):
    """Of one run's XML; a case that was skipped gives none."""
    found, said = {}, {}
    for case in report.iter("TestCase"):
        name = case.get("name")
        said[name] = [text.text.strip() for message in case.findall(".//Message") for text in message.findall("Text")]
        for check in case.iter("Expression"):
            original, expanded = (" ".join(check.find(tag).text.split()) if check.find(tag) is not None else "" for tag in ("Original", "Expanded"))
            what, relation, figure, goal = compared(original, expanded)
            line = {"program": program, "case": name, "check": what, "relation": relation, "goal": goal, "figure": figure,
                    "met": check.get("success") == "true", "times": 1}
            key = name, what, relation, original
            if key in found:
                times = found[key]["times"] + 1
                found[key] = dict(worse(found[key], line), times=times)
            else:
                found[key] = line
        for failure in case.iter("Exception"):
            found[name, "exception"] = {"program": program, "case": name, "check": " ".join((failure.text or "").split()), "relation": "",
                                        "goal": None, "figure": None, "met": False, "times": 1}
    return [dict(line, said=said[line["case"]]) if line is first_of(found, line["case"]) else line for line in found.values()]


def first_of(found, case):
    return next(line for line in found.values() if line["case"] == case)


def run(program, long, limit):
    environment = dict(os.environ, **ENVIRONMENT, **({"MORAINE_LONG_TESTS": "1"} if long else {}))
    began = time.monotonic()
    try:
        done = subprocess.run([str(program), "-s", "-r=xml"], env=environment, stdout=subprocess.PIPE, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return [{"program": program.name, "case": program.name, "check": f"ended after {limit:g} s", "relation": "", "goal": None, "figure": None, "met": False,
                 "times": 1, "long": long}]
    report = xml.etree.ElementTree.fromstring(done.stdout[done.stdout.index("<?xml"):])
    seconds = round(time.monotonic() - began, 1)
    return [dict(line, long=long, program_s=seconds) for line in lines_of(report, program.name)]


def keep(path, fresh):
    """What is measured again replaces its case's lines."""
    again = {(x["program"], x["case"]) for x in fresh}
    lines = [x for x in records.read(path) if (x["program"], x["case"]) not in again] + fresh
    records.write(path, sorted(lines, key=lambda x: x["program"]))


def measure(args, path):
    for program in programs(args.build, args.tests):
        print(f"verification: {program.name}", file=sys.stderr)
        keep(path, run(program, not args.short, args.limit))
