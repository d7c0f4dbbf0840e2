"""Plots of benchmarks: matplotlib if it can be had, and small SVG that a second run writes the same."""
import collections
import re
import sys
import xml.etree.ElementTree as tree

ENVIRONMENT = {"OMP_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}  # of a program on one core
SVG, LINK = "http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"
FAMILY = re.compile(r"'DejaVu Sans'[^;]*")  # matplotlib lists every font that it would try


def pyplot(salt):
    """matplotlib, also where only the system's Python has it; None: nowhere."""
    sys.path.append("/usr/lib/python3/dist-packages")  # Debian's python3-matplotlib
    try:
        import matplotlib
        matplotlib.use("svg")
        matplotlib.rcParams.update({"svg.hashsalt": salt, "svg.fonttype": "none", "font.size": 8})
        import matplotlib.pyplot
        return matplotlib.pyplot
    except ImportError:
        print(f"{salt}: no plots (matplotlib is missing). Install python3-matplotlib?", file=sys.stderr)
        return None


def rounded(text, digits=2):
    """Numbers to a hundredth of a point, without zeros at the end."""
    return re.sub(r"-?\d+\.\d+", lambda m: f"{round(float(m[0]), digits) + 0.0:.{digits}f}".rstrip("0").rstrip("."), text)


def tidy(node, used):
    """Drops ids that nobody uses, turns by nothing, and groups that say nothing; {id: its short name} of the others."""
    for key, value in list(node.attrib.items()):
        if key == "id" and value not in used or key == "transform" and value.startswith("rotate(-0 "):
            del node.attrib[key]
        elif key == "id":
            node.attrib[key] = used[value]
        elif key == f"{{{LINK}}}href" and value[1:] in used:
            node.attrib[key] = "#" + used[value[1:]]
        elif key == "clip-path":
            node.attrib[key] = re.sub(r"#(\w+)", lambda m: "#" + used[m[1]], value)
        elif key == "d":
            digits = 1 if "clip-path" in node.attrib else 2  # curves; shapes of marks are a few points wide
            node.attrib[key] = re.sub(r"\s*([MLCQzZ])\s*", r"\1", rounded(value, digits)).rstrip()
        elif key == "style":
            node.attrib[key] = re.sub(r"\s*([:;])\s*", r"\1", FAMILY.sub("sans-serif", value))
        elif key != f"{{{LINK}}}href":
            node.attrib[key] = rounded(value, 1 if key in ("x", "y") else 2)
    children = []
    for child in node:
        tidy(child, used)
        children += list(child) if child.tag == f"{{{SVG}}}g" and not child.attrib else [child]
    node[:] = children
    node.text = (node.text or "").strip() or ("\n" if children else None)
    for child in children:
        child.tail = "\n"


def small(text):
    """The same drawing in fewer bytes: styles that occur often become classes."""
    tree.register_namespace("", SVG)
    tree.register_namespace("xlink", LINK)
    root = tree.fromstring(text)
    for old in root.findall(f"{{{SVG}}}metadata"):
        root.remove(old)
    tidy(root, {name: f"i{k}" for k, name in enumerate(dict.fromkeys(re.findall(r"[\"(]#(\w+)", text)))})
    styles = collections.Counter(x.attrib["style"] for x in root.iter() if "style" in x.attrib)
    names = {style: f"s{k}" for k, (style, times) in enumerate(styles.most_common()) if times > 2}
    for x in root.iter():
        if x.attrib.get("style") in names:
            x.attrib["class"] = names[x.attrib.pop("style")]
    sheet = next(root.iter(f"{{{SVG}}}style"))
    sheet.text = re.sub(r"\s*([:;])\s*", r"\1", sheet.text) + "".join(f"\n.{name}{{{style}}}" for style, name in names.items())
    return tree.tostring(root, encoding="unicode").replace(" />", "/>") + "\n"


def save(plt, figure, path, tight=True):
    if tight:
        figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)
    path.write_text(small(path.read_text()))
