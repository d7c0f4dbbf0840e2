"""What a study says at its end."""
from typing import List

import numpy

from .number_text import exact, two_digits
from .scenario_data import Scenarios


def columns_of(rows: List[List[str]]) -> str:
    """Rows of words under each other, the first column to the left."""
    wide = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return "\n".join("  ".join(word.rjust(wide[k]) if k else word.ljust(wide[k]) for k, word in enumerate(row)).rstrip() for row in rows)


def spread_rows(found: Scenarios) -> List[List[str]]:
    """Of each quantity mean, quantiles and extremes over the runs, and the error of the cells beside the spread."""
    rows = [["quantity", "least", "5 %", "median", "mean", "95 %", "largest", "error of the cells"]]
    for quantity in found.file.quantities:
        values = found.column(quantity)
        spread = float(numpy.ptp(values)) if len(values) else 0.0
        figures = [] if not len(values) else [values.min(), *numpy.percentile(values, [5, 50]), values.mean(), numpy.percentile(values, 95), values.max()]
        error = found.cell_error(quantity)
        said = "not asked for" if not found.cells else "none is seen" if error is None else f"+- {two_digits(error)}"
        rows.append([quantity.text, *(exact(float(value), spread / 10) for value in figures), *[""] * (6 - len(figures)), said])
    return rows


def influence_rows(found: Scenarios) -> List[List[str]]:
    rows = [["quantity", "parameter", "measure", "value", "+-"]]
    for each in found.influences:
        rows.append([each.quantity, each.parameter, each.measure, f"{each.value:.2f}" if each.measure != "effect" else two_digits(each.value),
                     "" if each.error is None else two_digits(each.error)])
    return rows


def warnings_of(found: Scenarios) -> List[str]:
    """What a reader must know before believing it."""
    words = []
    missing = len(found.members) - len(found.finished) - len(found.failed)
    if found.failed:
        words.append(f"{len(found.failed)} of {len(found.members)} runs failed and count nowhere: "
                     + "; ".join(f"{m.name}: {m.problem}" for m in found.failed[:3]) + (" ..." if len(found.failed) > 3 else ""))
    if missing:
        words.append(f"{missing} of {len(found.members)} runs are still to come{' (the budget)' if found.stopped_by_budget else ''}: the same command goes on")
    for quantity in found.file.quantities:
        error = found.cell_error(quantity)
        values = found.column(quantity)
        if error is not None and len(values) > 1 and error > 0.5 * float(numpy.ptp(values)):
            words.append(f"{quantity.text}: the error of the cells, {two_digits(error)}, is as large as what the parameters do, {two_digits(float(numpy.ptp(values)))}")
    return words


def summary(found: Scenarios) -> str:
    parts = [f"{len(found.finished)} of {len(found.members)} runs"]
    if found.finished:
        parts.append(columns_of(spread_rows(found)))
    if found.influences:
        parts.append(columns_of(influence_rows(found)))
    return "\n\n".join(parts + [f"Warning: {line}" for line in warnings_of(found)])
