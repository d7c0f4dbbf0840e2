"""What the commands of the package have in common: how they refuse words, and what they say of errors."""
import argparse
import sys
from typing import Any, Callable

from .errors import Error


class Parser(argparse.ArgumentParser):
    """Refuses words as the program does: problem (why). suggestion?"""

    def __init__(self, example: str, **more: Any) -> None:
        super().__init__(epilog=f"Example: {example}", allow_abbrev=False, **more)
        self._example = example

    def error(self, message: str) -> Any:
        print(f"moraine: {self.prog} ({message}). Try {self._example}?", file=sys.stderr)
        sys.exit(2)


def exit_code(work: Callable[[], int], place: str = "a file") -> int:
    """That of the work; where it raises, a message and the exit code that the program has for it.

    place: what was read or written, where the error does not say.
    """
    try:
        return work()
    except Error as wrong:
        print(f"moraine: {wrong}", file=sys.stderr)
        return wrong.code
    except OSError as wrong:
        print(f"moraine: cannot write or read {wrong.filename or place} ({wrong.strerror or wrong}). Is the disk full or read-only?", file=sys.stderr)
        return 4
