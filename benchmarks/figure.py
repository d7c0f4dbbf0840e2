"""Plots of benchmarks: matplotlib if it can be had, and SVG that a second run writes the same."""
import sys

ENVIRONMENT = {"OMP_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}  # of a program on one core


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


def save(plt, figure, path):
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)
    text = path.read_text()
    path.write_text("\n".join(line.rstrip() for line in text.splitlines()) + "\n")
