"""What runs at some points say of parameters: surfaces through their values (radial basis functions), and samples of the posterior (emcee).

The likelihood is Gaussian: chi2 = sum ((surface - seen) / s)^2 with s^2 = error^2 + surface error^2, the latter by leaving each run out in
turn. All is in the unit cube of the parameters, over which the prior is even.
"""
import dataclasses
from typing import Any, List

import numpy
from numpy.typing import NDArray

from .errors import Error

WALKERS, STEPS, BURN = 32, 1500, 500


def _libraries() -> Any:
    try:
        import emcee
        from scipy.interpolate import RBFInterpolator
    except ImportError as missing:
        raise Error(f"a calibration needs scipy and emcee ({missing}). pip install 'scipy>=1.7' emcee, or apt-get install python3-scipy python3-emcee?") from None
    return emcee, RBFInterpolator


class Surfaces:
    """Through values (runs, targets) at points (runs, parameters); `errors` (targets,): what they miss at points left out."""

    def __init__(self, points: NDArray[Any], values: NDArray[Any]) -> None:
        _, self._kind = _libraries()
        count, dimensions = points.shape
        self.dimensions: int = dimensions
        if count < dimensions + 3:
            raise Error(f"{count} runs are too few for {dimensions} parameters (a surface through their values wants {dimensions + 3} at least). More runs?")
        self.scale = numpy.ptp(values, axis=0)
        self.scale[self.scale == 0] = 1.0
        self._low = values.min(axis=0)
        self._surface = self._through(points, values)
        missed = numpy.empty_like(values)
        for k in range(count):
            rest = numpy.arange(count) != k
            missed[k] = self._through(points[rest], values[rest])(points[k:k + 1])[0] * self.scale + self._low - values[k]
        self.errors: NDArray[Any] = numpy.sqrt(numpy.median(missed**2, axis=0)) * 1.4826

    def _through(self, points: NDArray[Any], values: NDArray[Any]) -> Any:
        return self._kind(points, (values - self._low) / self.scale, kernel="thin_plate_spline", degree=1)

    def at(self, points: NDArray[Any]) -> NDArray[Any]:
        found: NDArray[Any] = self._surface(points) * self.scale + self._low
        return found


@dataclasses.dataclass(frozen=True)
class Posterior:
    """samples (n, parameters) of the unit cube, the most likely of them, and its chi2 by the surfaces."""

    samples: NDArray[Any]
    best: NDArray[Any]
    chi2: float

    def quantile(self, parameter: int, percent: float) -> float:
        return float(numpy.percentile(self.samples[:, parameter], percent))


def sample(surfaces: Surfaces, seen: List[float], errors: List[float], seed: int) -> Posterior:
    """The posterior by the surfaces."""
    emcee, _ = _libraries()
    dimensions = surfaces.dimensions
    wide = numpy.sqrt(numpy.array(errors)**2 + surfaces.errors**2)

    def misfit(points: NDArray[Any]) -> NDArray[Any]:
        found: NDArray[Any] = (((surfaces.at(points) - numpy.array(seen)) / wide)**2).sum(axis=1)
        return found

    def likelihood(points: NDArray[Any]) -> NDArray[Any]:
        inside = ((points >= 0) & (points <= 1)).all(axis=1)
        found = numpy.full(len(points), -numpy.inf)
        if inside.any():
            found[inside] = -0.5 * misfit(points[inside])
        return found
    state = numpy.random.RandomState(seed)
    start = state.uniform(0.02, 0.98, (20 * WALKERS, dimensions))
    start = start[numpy.argsort(misfit(start), kind="stable")[: max(WALKERS, 4 * dimensions)]]
    sampler = emcee.EnsembleSampler(len(start), dimensions, likelihood, vectorize=True)
    sampler.random_state = numpy.random.RandomState(seed + 1).get_state()
    sampler.run_mcmc(start, STEPS)
    samples = sampler.get_chain(discard=BURN, thin=5, flat=True)
    chances = sampler.get_log_prob(discard=BURN, thin=5, flat=True)
    best = samples[int(numpy.argmax(chances))]
    return Posterior(samples, best, float(misfit(best[None])[0]))
