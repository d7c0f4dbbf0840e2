"""Designs of a study: which values its parameters have in each run."""
import itertools
from typing import Any, Dict, List, Sequence

from .errors import Error
from .parameters import Parameter

METHODS = ("grid", "latin-hypercube", "sobol", "saltelli", "morris")
LEVELS, TRAJECTORIES = 4, 10  # of Morris' design


def _qmc() -> Any:
    try:
        from scipy.stats import qmc
    except ImportError as missing:
        raise Error(f"this sampling needs scipy ({missing}). pip install 'scipy>=1.7', apt-get install python3-scipy, or method = \"grid\"?") from None
    return qmc


def salib() -> Any:
    """SALib's modules of samples and indices."""
    try:
        import SALib.analyze.morris
        import SALib.analyze.sobol
        import SALib.sample.morris
        import SALib.sample.sobol
    except ImportError as missing:
        raise Error(f"Sobol's indices and Morris' effects need SALib ({missing}). pip install 'SALib>=1.4.6', or method = \"sobol\"?") from None
    return SALib


def cube_of(parameters: Sequence[Parameter]) -> Dict[str, Any]:
    """As SALib names it, over the unit cube."""
    return {"num_vars": len(parameters), "names": [p.key for p in parameters], "bounds": [[0.0, 1.0]] * len(parameters)}


def unit_points(dimensions: int, method: str, runs: int, seed: int) -> List[List[float]]:
    """Points of the unit cube by latin hypercube or a scrambled Sobol sequence."""
    qmc = _qmc()
    if method == "latin-hypercube":
        points = qmc.LatinHypercube(dimensions, seed=seed).random(runs)
    else:
        import warnings
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a number of runs that is no power of two
            points = qmc.Sobol(dimensions, scramble=True, seed=seed).random(runs)
    return [[float(f"{x:.12g}") for x in row] for row in points]


def _by_salib(parameters: Sequence[Parameter], method: str, runs: int, seed: int) -> List[List[float]]:
    library, count = salib(), len(parameters)
    if method == "saltelli":
        base = 2 ** max(1, (max(runs // (count + 2), 2)).bit_length() - 1)
        points = library.sample.sobol.sample(cube_of(parameters), base, calc_second_order=False, seed=seed)
    else:
        points = library.sample.morris.sample(cube_of(parameters), max(2, runs // (count + 1)), num_levels=LEVELS, seed=seed)
    return [[float(f"{x:.12g}") for x in row] for row in points]


def design(parameters: Sequence[Parameter], method: str, runs: int, seed: int) -> List[Dict[str, Any]]:
    """Keys and values of each run: all combinations of a grid, else `runs` points (or as many as the method's own number next below).

    >>> [point["xi"] for point in design([Parameter("xi", "values", values=(300, 500))], "grid", 0, 1)]
    [300, 500]
    """
    if method not in METHODS:
        raise Error(f"sampling.method = {method} (it is none of {', '.join(METHODS)}). Is it sobol?")
    if method == "grid":
        return [{p.key: value for p, value in zip(parameters, values)} for values in itertools.product(*(p.grid() for p in parameters))]
    if runs < 2:
        raise Error(f"sampling.runs = {runs} (two at least). Is it 32?")
    points = _by_salib(parameters, method, runs, seed) if method in ("saltelli", "morris") else unit_points(len(parameters), method, runs, seed)
    return [{p.key: p.at(share) for p, share in zip(parameters, point)} for point in points]


def shares_of(parameters: Sequence[Parameter], method: str, runs: int, seed: int) -> List[List[float]]:
    """The same as points of the unit cube, which indices need."""
    return _by_salib(parameters, method, runs, seed) if method in ("saltelli", "morris") else unit_points(len(parameters), method, runs, seed)
