"""What `moraine stability` says at its end, as text."""
from typing import List

from .number_text import duration
from .slope_result import FactorOfSafety, SlopeResult
from .verdict import UNDECIDED


def bracket_row(level: SlopeResult) -> List[str]:
    """Cell, particles, cells over H, the bracket, what is undecided in it, runs and their time."""
    undecided = [trial.factor for trial in level.trials if trial.verdict == UNDECIDED and level.stands < trial.factor < level.fails]
    return [f"{level.cell:.6g}", str(level.particles), f"{level.height / level.cell:.3g}", f"{level.stands:g}", f"{level.fails:g}",
            ", ".join(f"{factor:g}" for factor in undecided) or "-", str(len(level.trials)), duration(sum(trial.wall_s for trial in level.trials))]


def bracket_rows(found: FactorOfSafety) -> List[List[str]]:
    """A head, and a row for each cell."""
    return [["cell [m]", "particles", "cells over H", "stands", "fails", "undecided", "runs", "time"], *map(bracket_row, found.levels)]


def warnings_of(found: FactorOfSafety) -> List[str]:
    """What a reader should know before the factor."""
    lines = list(found.remarks)
    for level in found.levels:
        lines += [f"cell {level.cell:.6g} m: {remark}" for remark in level.remarks]
        if level.uneven:
            lines.append(f"cell {level.cell:.6g} m: a factor stands above one that fails; the bracket is the lower one")
    if len(found.levels) > 1 and found.levels[-1].middle > found.levels[-2].middle + (found.levels[-1].fails - found.levels[-1].stands):
        lines.append("the finer cells are the stronger ones, against the rule: the bar may be too small")
    return lines


def answer(found: FactorOfSafety) -> str:
    """The line that matters.

    >>> import pathlib
    >>> level = lambda cell, stands: SlopeResult(cell, stands, stands + 0.01, 10.0, 0.01, 400, False, [], [], "")
    >>> answer(FactorOfSafety(pathlib.Path(), "slope", [level(0.5, 1.44), level(0.25, 1.4)]))
    'FS = 1.405 +- 0.05 (between cells 0.04, bracket 0.01)'
    >>> answer(FactorOfSafety(pathlib.Path(), "slope", [level(0.5, 1.44)]))
    'FS between 1.44 and 1.45 on cells of 0.5 m; no error bar (that takes a second cell)'
    """
    fine = found.levels[-1]
    if found.error is None:
        return f"FS between {fine.stands:g} and {fine.fails:g} on cells of {fine.cell:.6g} m; no error bar (that takes a second cell)"
    width = fine.fails - fine.stands
    return f"FS = {fine.middle:.4g} +- {found.error:.2g} (between cells {abs(found.levels[-2].middle - fine.middle):.2g}, bracket {width:.2g})"


def summary(found: FactorOfSafety) -> str:
    rows = bracket_rows(found)
    wide = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = ["  ".join(word.rjust(width) for word, width in zip(row, wide)) for row in rows]
    return "\n".join([*lines, *warnings_of(found), answer(found)])
