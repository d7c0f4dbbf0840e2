"""Runs a scene from coarse to fine until a value is known well enough: `moraine.converge`."""
import itertools
import pathlib
import tempfile
from typing import Any, Callable, List, Mapping, Optional, Sequence

from .errors import Error
from .level_run import Plan, compute, forecast, name_of, take
from .levels import Level, cell_sizes, coarsest_of, fit
from .number_text import duration
from .program import check, run, words_of_check
from .results import Run
from .study import Study, Variant

INPUT_WRONG = 2  # of the program's exit codes
CLOSER = 1.05          # levels whose cells differ by less tell nothing
FAR = 2.0              # times the budget: runs took 0.8 to 3.2 times what check said (docs/guide/cells-and-cost.md), and cores differ


def variants_of(set_each: Mapping[str, Sequence[Any]]) -> List[Variant]:
    """Every combination of the values.

    >>> [v.name for v in variants_of({"numerics.transfer": ["apic", "flip"], "time.cfl": [0.5]})]
    ['apic,0.5', 'flip,0.5']
    """
    keys = list(set_each)
    found = [Variant(",".join(str(value) for value in values), dict(zip(keys, values))) for values in itertools.product(*set_each.values())]
    if any(not values for values in set_each.values()) or len({v.name for v in found}) < len(found):
        raise Error("--set-each (it names a value twice, or none). Is it numerics.transfer=apic,flip?")
    return found


def _has_reached(study: Study, variant: Variant, plan: Plan) -> bool:
    found = [(variant.estimate(q).relative, variant.is_confirmed(q)) for q in study.quantities]
    return plan.error is not None and all(error is not None and error <= plan.error and confirmed for error, confirmed in found)


def _predict_next(study: Study, variant: Variant, plan: Plan, wanted: float) -> Optional[Level]:
    """The level that comes next, whose forecast the variant then has; None where it cannot be."""
    try:
        level = fit(study.keys, wanted)
        if variant.levels and variant.levels[-1].cell < CLOSER * level.cell:
            raise Error(f"the next cell would be {level.cell:.6g} m (only that fits the domain). Another --ratio?")
        said = check(study.scene, {**study.sets, **variant.sets, **level.sets}, plan.program, plan.ranks or 1, words_of_check(plan.options))
    except Error as wrong:
        if not variant.levels:
            raise
        variant.stopped, variant.next_level = f"the next level cannot be computed: {wrong}", None
        return None
    on_device = bool(variant.levels) and Run(study.path / variant.levels[-1].directory).summary["device"] != "cpu"
    variant.next_level = {"cell": level.cell, **forecast(variant, said, on_device)}
    return level


def _may_go_on(study: Study, variant: Variant, plan: Plan, name: str) -> bool:
    """Whether the level that was predicted is to be computed; sets why not."""
    seconds = (variant.next_level or {}).get("seconds")
    if variant.levels and _has_reached(study, variant, plan):
        variant.stopped, variant.reached = "the wanted error is reached", True
    elif len(variant.levels) >= plan.levels:
        variant.stopped = f"{plan.levels} levels are done"
    elif plan.budget_s is not None and not study.is_finished(name, float(study.keys["time"]["end"])) and study.spent_s + (seconds or 0) > plan.budget_s:
        variant.stopped = "the next level would go over the budget"
    return not variant.stopped


def _refuse_quantities(study: Study, plan: Plan, cell: float) -> None:
    """A run of no steps on the coarsest cells tells whether the quantities are there."""
    sets = {**study.sets, **study.variants[0].sets, **fit(study.keys, cell).sets, "time.end": 0.0}
    with tempfile.TemporaryDirectory(prefix="moraine-") as folder:
        start = run(study.scene, pathlib.Path(folder) / "start", sets, options=[*plan.options, "--no-particles"], progress=False, program=plan.program)
        for quantity in study.quantities:
            quantity.check(start, study.keys)


def _refuse_budget(study: Study, plan: Plan, wanted: float) -> None:
    """A first level that would go far over the budget by what `moraine check` says is not begun; one that was, is gone on with."""
    if plan.budget_s is None:
        return
    words = " ".join(plan.options).replace("--device=", "--device ").split()
    device = [word for pair in zip(words, words[1:]) if pair[0] == "--device" for word in pair]
    threads = plan.threads if "cuda" not in device else 1
    level, seconds = fit(study.keys, wanted), 0.0
    for variant in study.variants:
        if name_of(variant, level.cell) not in study.known["runs"]:
            said = check(study.scene, {**study.sets, **variant.sets, **level.sets}, plan.program, plan.ranks or 1, [*device, *words_of_check(plan.options)])
            seconds += (said.seconds or 0.0) / threads
    left = max(plan.budget_s - study.spent_s, 0.0)
    if seconds > FAR * left:
        first = "the first level" if len(study.variants) == 1 else f"the first level of {len(study.variants)}"
        raise Error(f"--budget {duration(plan.budget_s)} ({first}, cell {level.cell:.6g} m, takes about {duration(seconds)} by moraine check"
                    f"{f', and {duration(left)} are left' if study.spent_s else ''}). A larger --coarsest, or --budget {duration(study.spent_s + 1.5 * seconds).replace(' ', '')}?")


def refine(study: Study, plan: Plan, before: Callable[[Variant], None], after: Callable[[Study, Variant], None],
           told: Callable[[str], None]) -> None:
    """Computes level by level, all variants on one level before the next. `before` is called with the forecast of a level behind
    the first, `after` when a level is there, and again with a variant that stopped.
    """
    cell = study.keys["domain"]["cell"]
    sizes = cell_sizes(plan.ratio, plan.coarsest or coarsest_of(plan.ratio, cell))
    first = True
    _refuse_budget(study, plan, plan.coarsest or coarsest_of(plan.ratio, cell))
    for wanted in sizes:
        for variant in [v for v in study.variants if not v.stopped]:
            level = _predict_next(study, variant, plan, wanted)
            name = name_of(variant, level.cell) if level else ""
            if first and not study.known["runs"]:
                _refuse_quantities(study, plan, wanted)
            first = False
            if level and _may_go_on(study, variant, plan, name):
                if variant.levels:
                    before(variant)
                try:
                    take(study, variant, level, name, compute(study, plan, {**study.sets, **variant.sets, **level.sets}, name, told))
                except Error as wrong:
                    if wrong.code == INPUT_WRONG and not variant.levels:
                        raise
                    variant.stopped, variant.failed = f"the level of cell {level.cell:.6g} m failed: {wrong}", wrong.code
                else:
                    after(study, variant)
            if variant.stopped:
                after(study, variant)
            study.save()
        if all(v.stopped for v in study.variants):
            return
