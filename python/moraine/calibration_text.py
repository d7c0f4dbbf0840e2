"""What a calibration says, and calibration.html."""
import html
import math
import pathlib
from typing import List

from .calibration_data import Calibration
from .number_text import exact, two_digits
from .page_text import Axes, page, table, warning
from .scenario_text import columns_of

WIDE = 0.8    # of the prior's deviation: a posterior that wide says that nothing was learnt
MISFIT = 3.0  # chi2 over the number of targets from which what was seen does not fit


def parameter_rows(found: Calibration) -> List[List[str]]:
    rows = [["parameter", "5 %", "median", "95 %", "best run", "width"]]
    for k, parameter in enumerate(found.file.parameters):
        low, middle, high = found.interval(k)
        change = (high - low) / 10
        rows.append([parameter.key, *(exact(x, change) for x in (low, middle, high, found.best.sets[parameter.key])), f"{100 * found.width(k):.0f} % of the prior"])
    return rows


def target_rows(found: Calibration) -> List[List[str]]:
    rows = [["target", "seen", "known to", "best run", "off by", "error of the surface"]]
    for k, target in enumerate(found.targets):
        value = found.values[found.best.name][k]
        seen = "the outline" if target.seen is not None else "the map" if target.grid is not None else f"{target.value:g}"
        rows.append([target.name, seen, f"+- {two_digits(target.error)}", exact(value, target.error), f"{(value - target.value) / target.error:+.1f} errors",
                     two_digits(found.surface_errors[k])])
    return rows


def warnings_of(found: Calibration) -> List[str]:
    assert found.posterior is not None
    words = []
    chi2, count = found.chi2(found.best), len(found.targets)
    if chi2 > MISFIT * count:
        words.append(f"the best run does not fit: chi2 is {two_digits(chi2)} for {count} target{'s' if count > 1 else ''}. The law, the ground or the errors are wrong, or the ranges too narrow")
    for k, target in enumerate(found.targets):
        if found.surface_errors[k] > target.error:
            words.append(f"{target.name}: the surface through the runs is known to {two_digits(found.surface_errors[k])}, worse than what was seen ({two_digits(target.error)}). More search.runs?")
    for k, parameter in enumerate(found.file.parameters):
        if found.width(k) > WIDE:
            words.append(f"{parameter.key}: what was seen does not tell it (the posterior is {100 * found.width(k):.0f} % as wide as the prior)")
    if found.failed:
        words.append(f"{len(found.failed)} runs failed and count nowhere: {found.failed[0].name}: {found.failed[0].problem}")
    if found.stopped_by_budget:
        words.append("the budget ended the search: the same command goes on")
    return words


def summary(found: Calibration) -> str:
    return "\n\n".join([f"{len(found.finished)} runs; the best is {found.best.name}", columns_of(parameter_rows(found)), columns_of(target_rows(found)),
                        *(f"Warning: {line}" for line in warnings_of(found))])


def _density(found: Calibration, number: int) -> str:
    """Histogram of a parameter's posterior."""
    assert found.posterior is not None
    parameter, samples = found.file.parameters[number], found.posterior.samples[:, number]
    bins = 24
    xs, ys = [], []
    for k in range(bins):
        share = float(((samples >= k / bins) & (samples < (k + 1) / bins)).mean()) * bins
        for edge in (k / bins, (k + 1) / bins):
            xs.append(float(parameter.at(edge)))
            ys.append(share)
    axes = Axes(xs, [0.0, *ys])
    axes.line(xs, ys)
    return f"<figure><h3>{html.escape(parameter.key)}</h3>{axes.svg(parameter.key, 'posterior over prior')}<figcaption>Posterior over prior: 1 says nothing.</figcaption></figure>"


def _fits(found: Calibration) -> str:
    cards = []
    for k, target in enumerate(found.targets):
        values = [found.values[m.name][k] for m in found.finished]
        for parameter in found.file.parameters:
            inputs = [float(m.sets[parameter.key]) for m in found.finished]
            axes = Axes(inputs, [*values, target.value])
            axes.level(target.value, target.error)
            axes.points(inputs, values)
            cards.append(f"<figure><h3>{html.escape(target.name)}</h3>{axes.svg(parameter.key, target.name)}</figure>")
    return f'<div class="cards">{"".join(cards)}</div>'


def write_page(found: Calibration) -> pathlib.Path:
    """calibration.html in the folder; the file."""
    chi2 = found.chi2(found.best)
    parts = [warning(warnings_of(found)), "<h2>Parameters</h2>", table(parameter_rows(found)),
             '<div class="cards">' + "".join(_density(found, k) for k in range(len(found.file.parameters))) + "</div>",
             "<h2>What was seen</h2>", table(target_rows(found)),
             f"<p>{len(found.finished)} runs of {html.escape(found.file.scene.name)}; the best, {found.best.name}, has chi2 {two_digits(chi2) if math.isfinite(chi2) else 'not known'}. "
             "Bands: what was seen, with its error; points: runs.</p>", _fits(found)]
    path = found.path / "calibration.html"
    path.write_text(page(f"Calibration of {found.file.scene.stem}", [part for part in parts if part]), encoding="utf-8")
    return path
