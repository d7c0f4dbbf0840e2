"""Numbers and times as people read them."""
from typing import Optional


def duration(seconds: Optional[float]) -> str:
    """
    >>> duration(12.34), duration(300.0), duration(9000.0), duration(None)
    ('12.3 s', '5.0 min', '2.5 h', 'an unknown time')
    """
    if seconds is None:
        return "an unknown time"
    return f"{seconds:.3g} s" if seconds < 100 else f"{seconds / 60:.1f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


def two_digits(value: float) -> str:
    """
    >>> two_digits(583.2), two_digits(0.0314), two_digits(9.96), two_digits(0.0), two_digits(3.2e-7)
    ('580', '0.031', '10.0', '0', '3.2e-07')
    """
    return digits(float(f"{value:.2g}"), value) if 1e-4 <= abs(value) < 1e9 else f"{value:.2g}"


def exact(value: float, change: float, origin: float = 0.0) -> str:
    """A value with the digits that tell it from others: two of the change to the next one, else six of its distance from the origin.

    >>> exact(600025.6123, 0.0342), exact(600025.6123, 0.0, 600016.0), exact(84.99684, 0.0)
    ('600025.612', '600025.61230', '84.9968')
    """
    if change and _exponent(change) > -12:
        return digits(value, abs(change)) if abs(change) < abs(value) or origin else f"{value:.6g}"
    away = abs(value - origin)
    return f"{value:.6g}" if not origin or away == 0 else digits(value, away / 1e4)


def digits(value: float, error: float) -> str:
    """A value with two digits of its error."""
    return f"{value:.{max(0, min(12, 1 - _exponent(error)))}f}" if error > 0 and _exponent(error) > -12 else f"{value:.8g}"


def _exponent(value: float) -> int:
    return int(f"{abs(value):e}".partition("e")[2])
