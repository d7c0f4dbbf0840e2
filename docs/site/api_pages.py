"""Writes the API pages of the site: `python3 docs/site/api_pages.py FOLDER [python] [sources]`, called by scripts/docs.

api/python.md has the public names of the package, module by module; mkdocstrings puts their docstrings there. api/sources.md leads to
Doxygen's pages. What is not named could not be had: its page says so.
"""
import ast
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "python/moraine"
#: What public names give or take, and is not imported by the package itself.
ALSO = {"grids": ["Grid"], "study": ["LevelRun", "Variant"], "quantity": ["Quantity"], "picture": ["draw"]}

PYTHON = """# Python package

By name, from the docstrings. [Moraine from Python](../docs/python.md) shows how to use it. Shapes are in round brackets, units in square ones.

"""
SOURCES = """# C++ sources

From the comments of `src/`, by [Doxygen](https://www.doxygen.nl): types, functions and files with their sources, and a search.

<a href="cpp/index.html">Open the pages of the sources</a>

[ARCHITECTURE.md](../ARCHITECTURE.md) is the tour of them, [CONTRIBUTING.md](../CONTRIBUTING.md) says which files a new part touches.
"""


def modules():
    """Name, first line and public names of each module, in the order of the package's imports."""
    found = {}
    for line in ast.parse((PACKAGE / "__init__.py").read_text()).body:
        if isinstance(line, ast.ImportFrom):
            found.setdefault(line.module, []).extend(alias.name for alias in line.names)
    for name, more in ALSO.items():
        found.setdefault(name, []).extend(more)
    for name, names in found.items():
        text = ast.get_docstring(ast.parse((PACKAGE / f"{name}.py").read_text()))
        yield name, text.split("\n\n")[0].replace("\n", " "), names


def python_page():
    text = PYTHON
    for module, first, names in modules():
        text += f"## {module}\n\n{first}\n\n"
        for name in names:
            text += f"::: moraine.{module if name in ALSO.get(module, []) else ''}.{name}\n\n".replace("..", ".")
    return text


def main():
    folder = pathlib.Path(sys.argv[1]) / "api"
    folder.mkdir(parents=True, exist_ok=True)
    absent = "# {}\n\nThis site was built without them ({} could not be had). `scripts/docs` builds them where it can.\n"
    (folder / "python.md").write_text(python_page() if "python" in sys.argv[2:] else absent.format("Python package", "mkdocstrings"))
    (folder / "sources.md").write_text(SOURCES if "sources" in sys.argv[2:] else absent.format("C++ sources", "Doxygen"))


if __name__ == "__main__":
    main()
