"""moraine report RUN_DIR... [--output report.html] [--times T,T,...]

One self-contained page about runs, side by side; next to it a folder NAME_files with every plot as CSV, SVG and PNG.
Called by the program. Exit codes are the program's: 2 the input is wrong, 4 a package is missing or the disk failed.
"""
import argparse
import csv
import os
import pathlib
import sys

DEBIAN = "/usr/bin/python3"  # where Debian's python3-matplotlib is, whatever python3 comes first in PATH


def fail(code, words):
    print(f"moraine: {words}", file=sys.stderr)
    sys.exit(code)


def need_matplotlib():
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        if os.path.exists(DEBIAN) and "MORAINE_REPORT_SECOND_TRY" not in os.environ and "MORAINE_PYTHON" not in os.environ:
            os.environ["MORAINE_REPORT_SECOND_TRY"] = "1"
            os.execv(DEBIAN, [DEBIAN, *sys.argv])
        fail(4, f"the report needs matplotlib ({sys.executable} does not have it). Install it by "
                "sudo apt-get install python3-matplotlib?")


class Parser(argparse.ArgumentParser):
    def error(self, message):
        fail(2, f"moraine report ({message}). Try moraine report runs/slabs runs/morton --output report.html?")


def parse():
    parser = Parser(prog="moraine report", description="One page about runs, side by side.")
    parser.add_argument("runs", nargs="+", metavar="RUN_DIR", help="directories of finished runs")
    parser.add_argument("--output", default="report.html", metavar="FILE", help="page to write (default: report.html)")
    parser.add_argument("--times", metavar="T,T,...", help="times of the pictures of owners [s] (default: three)")
    options = parser.parse_args()
    try:
        options.times = [float(word) for word in options.times.split(",")] if options.times else None
    except ValueError:
        parser.error(f"--times {options.times} is not a list of numbers")
    if not options.output.endswith(".html"):
        parser.error(f"--output {options.output} must end with .html")
    return options


def run_rows(runs):
    columns = ("run", "partitioner", "ranks", "threads", "particles", "steps", "wall [s]", "Mp-steps/s",
               "imbalance", "worst", "of time", "repartitions", "moved [%]", "halo [MB/step]")
    rows = []
    for run in runs:
        s = run.summary
        rows.append((run.name, s["partitioner"], s["ranks"], s["threads"], s["particles"], s["steps"],
                     f"{s['wall_s']:.4g}", f"{s['particle_steps_per_s'] / 1e6:.4g}", f"{s['imbalance_mean']:.3f}",
                     f"{s['imbalance_max']:.3f}", f"{s['imbalance_time_mean']:.3f}", s["repartitions"],
                     f"{100 * s['migrated_particles'] / max(1, s['particles']):.1f}",
                     f"{s['halo_bytes'] / max(1, s['steps']) / 1e6:.3g}"))
    return columns, rows


def machine_rows(runs):
    return (("run", "scene", "machine", "device", "precision", "version", "commit", "state_hash",
             "directory"),
            [(run.name, run.summary["scene"], run.summary.get("machine", "not recorded"), run.summary["device"],
              run.summary["precision"], run.summary["version"], run.summary["commit"], run.summary["state_hash"], run.path) for run in runs])


def words_on_answers(runs):
    hashes = {run.summary["state_hash"] for run in runs}
    if len(runs) > 1 and len(hashes) == 1:
        return "<p>All runs ended in the same state, to the bit: they differ in time only.</p>"
    return "" if len(runs) == 1 else "<p>The runs ended in different states: they are of different scenes, or end times.</p>"


def missing_words(plots, runs):
    """What is not on the page, and what would put it there."""
    names = {plot.name for plot in plots}
    words = []
    if not names & {"strong_scaling", "weak_scaling"}:
        words.append("Scaling: give runs of one scene on two or more numbers of ranks.")
    if any(run.loads is None for run in runs):
        words.append("Owners and causes of imbalance: of runs with <code>--set output.block_loads=on</code>.")
    if "predictions" not in names:
        words.append("Predictions for more ranks: of runs that <code>moraine replay</code> has looked at.")
    return "<ul>" + "".join(f"<li>{word}</li>" for word in words) + "</ul>" if words else ""


def write_files(plots, folder):
    folder.mkdir(parents=True, exist_ok=True)
    for plot in plots:
        with open(folder / f"{plot.name}.csv", "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(plot.columns)
            writer.writerows(plot.rows)
        plot.figure.savefig(folder / f"{plot.name}.svg", metadata={"Date": None})
        plot.figure.savefig(folder / f"{plot.name}.png", dpi=200)


def make(options):
    import page
    import plots as p
    from owners import owners
    from runs import Run, unique_names
    runs = [Run(directory) for directory in options.runs]
    unique_names(runs)
    shown = [run for run in runs if len(run.balance["step"]) > 0]
    plots = [p.strong(runs), p.weak(runs), p.lost_time(runs)]
    if shown:
        plots += [p.imbalance(shown), owners(shown, options.times), p.halo(shown), p.migration(shown), p.decisions(shown)]
    plots = [plot for plot in [*plots, p.predictions(runs)] if plot]
    columns, rows = run_rows(runs)
    title = "Moraine: " + ", ".join(sorted({run.summary["title"] or run.summary["scene"] for run in runs}))
    parts = [page.table(columns, rows), words_on_answers(runs), *map(page.section, plots),
             "<section>\n<h2>Machine and commit</h2>\n" + page.table(*machine_rows(runs), words=True) + "\n</section>"]
    left_out = missing_words(plots, runs)
    if left_out:
        parts.append(f"<section>\n<h2>Not on this page</h2>\n{left_out}\n</section>")
    output = pathlib.Path(options.output)
    files = output.parent / (output.stem + "_files")
    output.parent.mkdir(parents=True, exist_ok=True)
    write_files(plots, files)
    output.write_text(page.page(title, parts), encoding="utf-8")
    print(f"The report is {output}; its plots as CSV, SVG and PNG are in {files}")


def main():
    options = parse()
    need_matplotlib()
    from runs import Wrong
    try:
        make(options)
    except Wrong as wrong:
        fail(2, str(wrong))
    except OSError as error:
        fail(4, f"cannot write or read {error.filename} ({error.strerror}). Is the disk full or read-only?")


if __name__ == "__main__":
    main()
