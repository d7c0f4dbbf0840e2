"""What is counted of a tree: {item: value} for each budget."""
import pathlib
import re
import subprocess

import cpp

SOURCES = (".hpp", ".cpp", ".cu", ".cuh", ".ipp", ".in")
EVIDENCE = ("docs/adr/", "docs/evidence/", "docs/verification", "docs/stability", "docs/accuracy", "benchmarks/")
PICTURES = (".png", ".svg", ".gif", ".jpg")
NEITHER = ("CHANGELOG.md",)
REFERENCES = ("inputs/reference.toml", "inputs/reference_terrain.toml", "inputs/reference_water.toml")


class Tree:
    def __init__(self, root, build):
        self.root, self.build = root, build
        listed = subprocess.run(["git", "-C", str(root), "ls-files", "-co", "--exclude-standard"], check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()
        self.files = sorted({name for name in listed if (root / name).is_file()})
        self.sources = {}
        for name in self.files:
            if name.startswith("src/") and name.endswith(SOURCES):
                self.sources[name] = cpp.Reader((root / name).read_text())

    def text(self, name):
        return (self.root / name).read_text()


def tree_bytes(tree):
    return {"tree": sum((tree.root / name).stat().st_size for name in tree.files if not name.endswith(PICTURES))}


def of_classes(tree, what):
    return largest((f"{file} {c.name}", getattr(c, what)) for file, found in tree.sources.items() for c in found.classes)


def template_parameters(tree):
    return largest((f"{file} {t.name}", t.parameters) for file, found in tree.sources.items() for t in found.templates)


def largest(pairs):
    found = {}
    for name, value in pairs:
        found[name] = max(found.get(name, 0), value)
    return found


def scene_keys(tree):
    """Distinct keys of the reference scenes, those that are commented out too; of tables with names of the user's, once."""
    keys, table = set(), ""
    for line in "\n".join(tree.text(name) for name in REFERENCES if name in tree.files).splitlines():
        if header := re.match(r"(?:# )?\[+([\w.\"-]+)\]+$", line):
            table = header[1].split(".")[0] + ("." + header[1].rsplit(".", 1)[1] if header[1].count(".") > 1 else "")
        elif key := re.match(r"(?:# )?([a-z_0-9]+) = ", line):
            keys.add(f"{table}.{key[1]}")
    return {"scene": len(keys)} if keys else {}


def words(tree, names):
    return sum(len(tree.text(name).split()) for name in names)


def adr_words(tree):
    return {name: words(tree, [name]) for name in tree.files if re.match(r"docs/adr/\d.*\.md$", name)}


def evidence(tree):
    pages = [name for name in tree.files if name.endswith(".md") and name not in NEITHER]
    proofs = [name for name in pages if name.startswith(EVIDENCE)]
    guidance = words(tree, set(pages) - set(proofs))
    return {"documents": round(words(tree, proofs) / guidance, 2)} if guidance else {}


def kernels(tree):
    file = tree.build / "kernels.md"
    return {"default build": sum(line.startswith("| ") for line in file.read_text().splitlines()) - 1} if file.is_file() else {}


def compiled(tree):
    """What compilers have read for the objects of a folder, by ninja's own record: what a clean build costs, whatever the machine and who shares it."""
    if not (tree.build / ".ninja_deps").is_file():
        return {}
    listed = subprocess.run(["ninja", "-C", str(tree.build), "-t", "deps"], check=True, stdout=subprocess.PIPE, text=True).stdout
    sizes = {name: size(tree.build / name) for name in set(re.findall(r"^ +(.+)$", listed, re.M))}
    read = sum(sizes[name] for name in re.findall(r"^ +(.+)$", listed, re.M))
    return {"build": round(read / 1e6)} if read else {}


def size(file):
    return file.stat().st_size if file.is_file() else 0


BUDGETS = {
    "bytes of the tree": tree_bytes,
    "members of a class": lambda tree: of_classes(tree, "members"),
    "private functions of a class": lambda tree: of_classes(tree, "private"),
    "virtuals of an interface": lambda tree: of_classes(tree, "virtuals"),
    "template parameters": template_parameters,
    "scene keys": scene_keys,
    "words of an ADR": adr_words,
    "words of evidence over words of guidance": evidence,
    "kernels of a device build": kernels,
    "megabytes that compilers read": compiled,
}


def measure(root, build):
    tree = Tree(pathlib.Path(root), pathlib.Path(build))
    return {name: of(tree) for name, of in BUDGETS.items()}
