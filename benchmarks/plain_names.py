"""Codes of cases and their plain names: pages say the names, commands and files keep the codes.

    text = plain_names.in_words(text)

replaces codes in prose, in headings and in tables, and leaves alone what stands between backquotes, in indented lines (commands) and behind links.
"""
import re

NAMES = {
    "E1": "vibrating bar",
    "E1-drift": "vibrating bar adrift",
    "E2": "column under its own weight",
    "E3": "manufactured displacement",
    "E3-small": "small manufactured displacement",
    "E3-large": "large manufactured displacement",
    "E3-jitter": "manufactured displacement, jittered",
    "E4": "vortex",
    "E6": "projectile",
    "E7": "turning square",
    "E8": "objective rate",
    "E12": "colliding disks",
    "E14": "strip footing",
    "E20": "stress paths of laws",
    "R4": "viscous current",
    "R6a": "arrest without inertia",
    "R6c": "arrest without inertia, next order",
    "R8": "columns of sand",
    "R9": "films on an incline",
    "SEED-1": "slurry runout",
    "SEED-1-rest": "slurry at rest",
    "SEED-1a": "slurry runout",
    "SEED-2": "pipe penetration",
    "B0": "reference scheme",
    "S1": "largest stable steps",
    "S2": "particles alone",
    "S5": "ringing bar over ten periods",
    "S6": "energy over many periods",
    "S8": "pulse into a bonded block",
    "S9": "other seedings",
    "S10": "bar that flies apart",
    "S11": "single precision",
    "S12": "inputs that nobody should give",
    "S15": "block at rest for a million steps",
    "S16": "where energy goes",
    "S17": "step and answer",
    "S22": "random scenes",
    "S22-whole": "random scenes at whole steps",
    "S23": "random thin scenes",
    "S24": "random fluid scenes",
    "S25": "stable substeps",
    "S26": "fluids over many periods",
    "S27": "stable steps of cured fluids",
    "dam-break": "dam break",
    "C1": "block at rest on a plane",
    "C2": "sliding block",
    "C4": "undrained bed",
    "C5": "bar against a wall",
    "C6": "half the step under a pipe",
    "C7": "sliding block, inclined grid",
    "C8": "layers on a bed",
    "T1": "block on heights",
    "T2": "block on a parabola",
    "T6": "slab at rest on rough ground",
    "T7": "steady slab with drag",
}
CODE = re.compile(r"(?<![\w/#.-])(" + "|".join(sorted(map(re.escape, NAMES), key=len, reverse=True)) + r")(?![\w-]|\.(?:md|svg|cpp|hpp))")
KEPT = re.compile(r"(^```[\s\S]*?^```$|`[^`\n]*`|\]\([^)\n]*\)|^    (?:benchmarks|build|scripts)/[^\n]*$)", re.MULTILINE)


def plain(code):
    """The name of a case; of one that has none, the code."""
    return NAMES.get(code, code)


def title(code):
    name = plain(code)
    return name[0].upper() + name[1:]


def in_words(text):
    parts = KEPT.split(text)
    parts[::2] = [CODE.sub(lambda found: plain(found[1]), part) for part in parts[::2]]
    return "".join(parts)
