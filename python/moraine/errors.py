"""What the package raises when its user can put things right."""


class Error(Exception):
    """A problem in the form `problem (why). suggestion?`.

    `code` is the exit code of the program where that is what failed (2: the input is wrong; see docs/guide/results.md for
    the others), else 2.

    >>> raise Error("no run is named (the list is empty). Give a directory?")
    Traceback (most recent call last):
    ...
    moraine.errors.Error: no run is named (the list is empty). Give a directory?
    """

    def __init__(self, message: str, code: int = 2) -> None:
        super().__init__(message)
        self.code = code
