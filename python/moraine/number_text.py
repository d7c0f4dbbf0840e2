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


def digits(value: float, error: float) -> str:
    """A value with two digits of its error."""
    return f"{value:.{max(0, min(12, 1 - _exponent(error)))}f}" if error > 0 and _exponent(error) > -12 else f"{value:.8g}"


def _exponent(value: float) -> int:
    return int(f"{abs(value):e}".partition("e")[2])
