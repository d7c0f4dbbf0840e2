"""Records of benchmarks: JSON lines, with what many of them share written once.

`{"common": {...}, "columns": [...]}` holds for the lines after it, up to the next such line: `common` are fields of all of them, and a line that is
a list gives the values of `columns`, of which each is a field's name or, for a field of a field, the list of both. A line that is an object goes
before `common`. Plain JSON lines, as the programs print them, are read too.
"""
import json

ABOUT = ("commit", "machine", "cores", "compiler", "march", "device", "driver", "runtime")  # lines under one header agree in these
FEWEST = 3  # lines of one shape that are worth a header


def loads(text):
    """Complete lines of a file's text."""
    common, columns, lines = {}, [], []
    for line in map(json.loads, filter(str.strip, text.splitlines())):
        if isinstance(line, list):
            lines.append(filled(columns, line, common))
        elif "common" in line:
            common, columns = line["common"], line.get("columns", [])
        else:
            lines.append({**common, **line})
    return lines


def filled(columns, values, common):
    line = dict(common)
    for path, value in zip(columns, values):
        *outer, name = path if isinstance(path, list) else [path]
        target = line
        for key in outer:
            target = target.setdefault(key, {})
        target[name] = value
    return line


def read(path):
    return loads(path.read_text()) if path.exists() else []


def shorter(values, digits):
    """Floating-point numbers to so many digits."""
    short = [float(f"{v:.{digits}g}") for v in values]
    return [int(v) if v.is_integer() and abs(v) < 1e15 else v for v in short]


def flat(line, outer=()):
    """{path: value} of an object and of the objects in it."""
    found = {}
    for key, value in line.items():
        found.update(flat(value, (*outer, key)) if isinstance(value, dict) and value else {(*outer, key): value})
    return found


def kind(line):
    return [line.get(key) for key in ABOUT], list(flat(line))


def groups(lines):
    """Runs of lines that one header suits; a line of another shape among them stays in the run."""
    kinds, found = [kind(x) for x in lines], []
    for k, line in enumerate(lines):
        alike = kinds[k:k + FEWEST] == [kinds[k]] * FEWEST
        if not found or kinds[k][0] != found[-1][0][0] or kinds[k] != found[-1][0] and alike:
            found.append((kinds[k], []))
        found[-1][1].append(line)
    return found


def same(lines, path):
    values = [flat(x).get(path, lines) for x in lines]  # `lines`: a value that no field has
    return len(path) == 1 and all(v == values[0] and type(v) is type(values[0]) and not isinstance(v, (list, dict)) for v in values)


def dumps(lines):
    text = []
    for (_, paths), group in groups(lines):
        common = {path[0]: group[0][path[0]] for path in paths if same(group, path)} if len(group) >= FEWEST else {}
        columns = [path for path in paths if path[0] not in common]
        rows = [list(flat(x)) == paths and common != {} for x in group]
        if common or text:
            text.append({"common": common, **({"columns": [path[0] if len(path) == 1 else path for path in columns]} if any(rows) else {})})
        for x, row in zip(group, rows):
            values = flat(x)
            text.append([values[path] for path in columns] if row else {k: v for k, v in x.items() if k not in common})
    return "".join(json.dumps(x, ensure_ascii=False, separators=(",", ":")) + "\n" for x in text)


def write(path, lines):
    path.write_text(dumps(lines))
