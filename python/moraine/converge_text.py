"""What a refinement study says after each level and at its end, as text."""
from typing import Dict, List, Tuple

from .converge_files import map_errors, rows_of
from .number_text import digits, duration, exact, two_digits
from .map_errors import map_line
from .quantity import Quantity
from .richardson import Estimate
from .study import Study, Variant

NO_BAR = {
    "too few": "an order is seen on three levels",
    "oscillates": "DOES NOT CONVERGE on these levels (the value goes up and down), so there is no error bar",
    "stalls": "SHOWS NO ORDER on these levels (the finest two have the same, the one before has not), so there is no error bar",
    "diverges": "DOES NOT CONVERGE on these levels (the changes do not shrink), so there is no error bar",
}


def estimate_line(quantity: Quantity, found: Estimate, change: float = 0.0) -> str:
    """change: to the level before.

    >>> estimate_line(Quantity("front_m", "front_m", "end"), Estimate("converges", 56.4, 1.2, 55.9, 1.94, 0.97, 40.0))
    'front_m = 56.40 +- 0.97 (5.9 % of the way of 16.40 m): order 1.20, Richardson value 55.90, safety factor 1.94'
    """
    if found.error is None:
        return f"{quantity.text} = {exact(found.finest, change, found.origin)}: {NO_BAR[found.verdict]}"
    way = f" of the way of {digits(abs(found.finest - found.origin), found.error)} m" if found.origin else ""
    share = "" if found.relative is None else f" ({two_digits(100 * found.relative)} %{way})"
    if found.verdict == "equal":
        return f"{quantity.text} = {digits(found.finest, found.error)} +- {two_digits(found.error)}{share}: the same on three levels, but for rounding"
    assert found.order is not None and found.value is not None and found.safety is not None
    return (f"{quantity.text} = {digits(found.finest, found.error)} +- {two_digits(found.error)}{share}: order {found.order:.2f}, "
            f"Richardson value {digits(found.value, found.error)}, safety factor {found.safety:.2f}")


def _on_the_bar(variant: Variant, quantity: Quantity) -> List[str]:
    """Whether the level before foretold this one."""
    count = len(variant.levels)
    if count == 3 and variant.estimate(quantity).verdict == "converges":
        return ["    (by three levels alone, which can be chance: a fourth confirms it or not)"]
    if variant.is_confirmed(quantity) is None:
        return []
    before = variant.estimate(quantity, count - 1)
    assert before.error is not None
    bar = f"{digits(before.finest, before.error)} +- {two_digits(before.error)}"
    return [f"    (the bar of the level before, {bar}, {'holds it' if variant.is_confirmed(quantity) else 'DOES NOT HOLD it: those levels were too coarse'})"]


def _next_line(variant: Variant) -> List[str]:
    following = variant.next_level
    if not following:
        return []
    return [f"  the next level: cell {following['cell']:.6g} m, {following['particles']} particles, about {following['steps']} steps and "
            f"{duration(following['seconds'])}, {following['memory']}"]


def before_level(variant: Variant) -> str:
    """What a level behind the first is expected to take."""
    head = f"{variant.name}: " if variant.name else ""
    return "\n".join(f"{head}{line.strip()}" if head else line for line in _next_line(variant))


def after_level(study: Study, variant: Variant) -> str:
    """The text after a level, or after the last."""
    head = f"{variant.name}: " if variant.name else ""
    if variant.stopped:
        return "\n".join([f"{head}{variant.stopped}", *_next_line(variant)])
    level = variant.levels[-1]
    lines = [f"{head}level {len(variant.levels)}: cell {level.cell:.6g} m, {level.particles} particles, {level.steps} steps, {duration(level.wall_s)}"]
    lines += [f"  {remark}" for remark in level.remarks]
    for quantity in study.quantities:
        values = [level.values[quantity.text] for level in variant.levels[-2:]]
        lines.append(f"  {estimate_line(quantity, variant.estimate(quantity), values[-1] - values[0])}")
        lines += _on_the_bar(variant, quantity)
        if variant.estimate(quantity).verdict == "oscillates" and quantity.resolution(level.cell) > 0:
            lines.append(f"    ({quantity.name} is counted in whole cells: --quantity front is not)")
    lines += [f"  {map_line(found)}" for found in map_errors(study, variant)]
    return "\n".join(lines)


def _least_changes(study: Study) -> Dict[Tuple[str, str], float]:
    """Of each variant and quantity the least change between two levels, 0 where there is none."""
    found = {}
    for variant in study.variants:
        for quantity in study.quantities:
            values = [level.values[quantity.text] for level in variant.levels]
            found[variant.name, quantity.text] = min((abs(b - a) for a, b in zip(values, values[1:]) if a != b), default=0.0)
    return found


def table(study: Study) -> str:
    """All levels as a table of text."""
    shown = [["cell [m]", "particles", "time", "", "value", "order", "Richardson", "GCI", "factor"]]
    named = any(v.name for v in study.variants)
    changes = _least_changes(study)
    for name, _, cell, particles, _, wall, quantity, value, verdict, order, richardson, safety, error, origin in rows_of(study):
        change = changes[name, quantity]
        marks = [verdict, "", "", ""]
        if verdict == "converges":
            marks = [f"{order:.2f}", exact(richardson, min(change, error) or error, origin), two_digits(error), f"{safety:.2f}"]
        shown.append([f"{cell:.6g}", str(particles), duration(wall), f"{name + ' ' if named else ''}{quantity}", exact(value, change, origin), *marks])
    wide = [max(len(row[k]) for row in shown) for k in range(len(shown[0]))]
    return "\n".join("  ".join(word.ljust(wide[k]) if k == 3 else word.rjust(wide[k]) for k, word in enumerate(row)).rstrip() for row in shown)
