"""What is wrong with the input of a report."""


class Wrong(Exception):
    """The input is wrong; the words are for the user."""
