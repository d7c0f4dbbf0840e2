"""moraine report RUN_DIR... [--output report.html] [--times T,T,...] [--errors DIR] [--pdf]

One self-contained page about runs: what the flow did, then how its work was shared. Next to it a folder NAME_files with every plot as
CSV, and as SVG and PNG where matplotlib is. Called by the program. Exit codes are the program's: 2 the input is wrong, 4 the disk failed.
"""
import argparse
import csv
import html
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import flow

DEBIAN = "/usr/bin/python3"  # where Debian's packages are, whatever python3 comes first in PATH
PACKAGES = {"numpy": "python3-numpy", "matplotlib": "python3-matplotlib", "h5py": "python3-h5py"}


def fail(code, words):
    print(f"moraine: {words}", file=sys.stderr)
    sys.exit(code)


def missing_packages():
    """What this Python lacks, after a try with the .venv that docs/python.md makes, and with Debian's own."""
    missing = [name for name in PACKAGES if importlib.util.find_spec(name) is None]
    here = pathlib.Path(__file__).resolve().parent
    places = [str(place / ".venv/bin/python3") for place in (pathlib.Path.cwd(), here.parent, *here.parents[1:4])]
    for python in [*places, DEBIAN] if missing and not {"MORAINE_SECOND_TRY", "MORAINE_PYTHON"} & set(os.environ) else []:
        if os.path.exists(python) and subprocess.run([python, "-c", "import " + ", ".join(PACKAGES)], capture_output=True).returncode == 0:
            os.environ["MORAINE_SECOND_TRY"] = "1"
            os.execv(python, [python, "-B", *sys.argv])
    return missing


class Parser(argparse.ArgumentParser):
    def error(self, message):
        fail(2, f"moraine report ({message}). Try moraine report runs/slabs runs/morton --output report.html?")


def parse():
    parser = Parser(prog="moraine report", description="One page about runs, side by side.")
    parser.add_argument("runs", nargs="+", metavar="RUN_DIR", help="directories of runs; one that is under way or was killed is shown as far as it is")
    parser.add_argument("--output", default="report.html", metavar="FILE", help="page to write (default: report.html)")
    parser.add_argument("--times", metavar="T,T,...", help="times of the pictures of owners [s] (default: three)")
    parser.add_argument("--errors", metavar="DIR", help="error bars for the first page: what moraine converge wrote")
    parser.add_argument("--with", dest="data", metavar="FILE.csv", help="a load curve of your own, as displacement_y_m,force_y_N")
    parser.add_argument("--pdf", action="store_true", help="the page as PDF too, by chromium")
    options = parser.parse_args()
    try:
        options.times = [float(word) for word in options.times.split(",")] if options.times else None
    except ValueError:
        parser.error(f"--times {options.times} is not a list of numbers")
    if not options.output.endswith(".html"):
        parser.error(f"--output {options.output} must end with .html")
    return options


def run_rows(runs):
    """The table of runs; of runs on one rank without what tells of many."""
    columns = [("run", "the end of its directory"), ("partitioner", "how the ground is shared out"), ("ranks", "processes"),
               ("threads", "of each rank"), ("particles", "at the end"), ("steps", "of the whole run"), ("wall [s]", "from start to end"),
               ("Mp-steps/s", "million particle-steps in a second of stepping"),
               ("imbalance", "most particles of a rank over the mean of all ranks, mean of the steps"), ("worst", "largest imbalance"),
               ("of time", "largest computing time of a rank over the mean"), ("repartitions", "how often blocks changed owner"),
               ("moved [%]", "particles that repartitions moved, of all"), ("halo [MB/step]", "sent by all ranks together")]
    alone = all(run.summary["ranks"] == 1 for run in runs if run.finished)
    keep = [k for k in range(len(columns)) if not alone or k in (0, 2, 3, 4, 5, 6, 7)]
    rows = []
    for run in runs:
        s = run.summary
        if not run.finished:
            row = [f"{run.name}, not ended", *["-"] * 3, flow.number(s["particles"], digits=9), flow.number(s["steps"], digits=9), *["-"] * 8]
            rows.append([row[k] for k in keep])
            continue
        row = (run.name, s["partitioner"], s["ranks"], s["threads"], s["particles"], s["steps"],
               f"{s['wall_s']:.4g}", f"{s['particle_steps_per_s'] / 1e6:.4g}", f"{s['imbalance_mean']:.3f}",
               f"{s['imbalance_max']:.3f}", f"{s['imbalance_time_mean']:.3f}", s["repartitions"],
               f"{100 * s['migrated_particles'] / max(1, s['particles']):.1f}",
               f"{s['halo_bytes'] / max(1, s['steps']) / 1e6:.3g}")
        rows.append([row[k] for k in keep])
    return [columns[k] for k in keep], rows


def machine_rows(runs):
    return (("run", "scene", "machine", "device", "precision", "version", "commit", "state_hash",
             "directory"),
            [(run.name, run.summary["scene"], *(run.summary.get(name, "not recorded") for name in ("machine", "device", "precision", "version", "commit", "state_hash")),
              run.path) for run in runs])


def words_on_answers(runs):
    if not all(run.finished for run in runs):
        return ""
    hashes = {run.summary["state_hash"] for run in runs}
    if len(runs) > 1 and len(hashes) == 1:
        return "<p>All runs ended in the same state, to the bit: they differ in time only.</p>"
    return "" if len(runs) == 1 else "<p>The runs ended in different states: they are of different scenes, or end times.</p>"


def install_words(missing):
    """What packages would add, as HTML; empty where all are there."""
    if not missing:
        return []
    return [f"Pictures of the flow{', and plots of load balance' if set(missing) - {'h5py'} else ''}: this Python has no {', '.join(missing)}. "
            f"Install by <code>sudo apt-get install {' '.join(PACKAGES[name] for name in missing)}</code> and make the report again."]


def left_out(plots, runs):
    """What is not there of load balance, and what would put it there."""
    names = {plot.name for plot in plots}
    shared = [run for run in runs if run.finished and run.summary["ranks"] > 1]
    words = [f"How {html.escape(run.name)} shared its work: it has no summary.json yet." for run in runs if not run.finished]
    if shared and not names & {"strong_scaling", "weak_scaling"}:
        words.append("Scaling: give runs of one scene on two or more numbers of ranks.")
    words += [f"The speed of {html.escape(run.name)} in scaling: {html.escape(run.not_measurable())}." for run in runs if run.finished and run.not_measurable()]
    if any(run.loads is None for run in shared):
        words.append("Owners and causes of imbalance: of runs with <code>--set output.block_loads=on</code>.")
    if any(run.loads is None and "asleep" in run.history for run in runs if run.finished):
        words.append("Where it slept: of runs with <code>--set output.block_loads=on</code>.")
    if shared and "predictions" not in names:
        words.append("Predictions for more ranks: of runs that <code>moraine replay</code> has looked at.")
    return words


def write_files(plots, folder, drawn):
    folder.mkdir(parents=True, exist_ok=True)
    for done, plot in enumerate(plots):
        with open(folder / f"{plot.name}.csv", "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(plot.columns)
            writer.writerows(plot.rows)
        if drawn:
            figure = plot.figure
            figure.savefig(folder / f"{plot.name}.svg", metadata={"Date": None})
            figure.savefig(folder / f"{plot.name}.png", dpi=200)
        progress(f"plot {done + 1} of {len(plots)}: {plot.name}")


def progress(words):
    """On a terminal one line that changes; else nothing."""
    if sys.stderr.isatty():
        print(f"\r\033[Kmoraine report: {words}", end="", file=sys.stderr, flush=True)


def own_data(path):
    """A reader's own curve."""
    from wrong import Wrong
    if path is None:
        return None
    from moraine.curves import read_data
    from moraine.errors import Error
    try:
        return read_data(pathlib.Path(path))
    except Error as error:
        raise Wrong(str(error)) from None


def write_pdf(output):
    """The page printed by chromium."""
    from wrong import Wrong
    browser = next((found for found in map(shutil.which, (os.environ.get("CHROMIUM", ""), "chromium", "chromium-browser", "google-chrome")) if found), None)
    if browser is None:
        raise Wrong(f"no PDF (there is no chromium, which prints the page; {output} is written). sudo apt-get install chromium, or print it from a browser?")
    target = output.with_suffix(".pdf")
    with tempfile.TemporaryDirectory(prefix="moraine-chromium-", ignore_cleanup_errors=True) as folder:
        done = subprocess.run([browser, "--headless=new", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer", f"--user-data-dir={folder}",
                               f"--print-to-pdf={target.resolve()}", output.resolve().as_uri()], capture_output=True, text=True)
    if done.returncode != 0 or not target.is_file():
        raise Wrong(f"no PDF (chromium failed: {(done.stderr.strip().splitlines() or ['it said nothing'])[-1]}; {output} is written). Print it from a browser?")


def balance_plots(runs, times):
    """Plots of how the work was shared; of runs on one rank there are none but scaling and predictions."""
    import plots as p
    from asleep import where_it_slept
    from owners import owners
    runs = [run for run in runs if run.finished]
    if not runs:
        return []
    shared = [run for run in runs if run.summary["ranks"] > 1]
    shown = [run for run in shared if len(run.balance["step"]) > 0]
    found = [where_it_slept(runs), p.strong(runs), p.weak(runs), p.lost_time(runs) if shared else None]
    if shown:
        found += [p.imbalance(shown), owners(shown, times), p.halo(shown), p.migration(shown), p.decisions(shown)]
    return [plot for plot in [*found, p.predictions(runs)] if plot]


def alone_words(runs):
    """Where the time went, of runs that shared nothing."""
    words = []
    for run in runs:
        if run.finished and run.summary["ranks"] == 1:
            wall = run.summary["wall_s"]
            words.append(f"{run.name}: {wall:.4g} s on one rank, of which {100 * run.times['computing'] / wall:.0f} % computing and "
                         f"{100 * run.times['output'] / wall:.0f} % output.")
    return "".join(f"<p>{html.escape(line)}</p>" for line in words)


def make(options, missing):
    import page
    import together
    from runs import Run, unique_names
    runs = [Run(directory) for directory in options.runs]
    unique_names(runs)
    drawn = not {"numpy", "matplotlib"} & set(missing)
    progress("pictures of the flow")
    parts, charts, lacking = flow.sections(runs, options.errors, own_data(options.data))
    plots = balance_plots(runs, options.times) if drawn else []
    title = "Moraine: " + ", ".join(sorted({run.summary["title"] or run.summary["scene"] for run in runs}))
    columns, rows = run_rows(runs)
    parts.append("<section>\n<h2>The computation</h2>\n" + page.table(columns, rows) + words_on_answers(runs) + alone_words(runs) + "\n</section>")
    parts.append(together.sharing(runs))
    parts += [*map(page.section, plots), "<section>\n<h2>Machine and commit</h2>\n" + page.table(*machine_rows(runs), words=True) + "\n</section>"]
    lacking = (install_words(missing) or lacking) + left_out(plots, runs)
    if lacking:
        parts.append("<section>\n<h2>Not on this page</h2>\n<ul>" + "".join(f"<li>{line}</li>" for line in lacking) + "</ul>\n</section>")
    output = pathlib.Path(options.output)
    files = output.parent / (output.stem + "_files")
    output.parent.mkdir(parents=True, exist_ok=True)
    write_files([*charts, *plots], files, drawn)
    output.write_text(page.page(title, parts, flow.script()), encoding="utf-8")
    if options.pdf:
        progress("PDF")
        write_pdf(output)
    progress("")
    print(f"The report is {output}{f' and {output.stem}.pdf' if options.pdf else ''}; its plots as {'CSV, SVG and PNG' if drawn else 'CSV'} are in {files}")
    if missing:
        print(f"It lacks the pictures: this Python has no {', '.join(missing)}. Install them by sudo apt-get install "
              f"{' '.join(PACKAGES[name] for name in missing)}", file=sys.stderr)


def main():
    options = parse()
    missing = missing_packages()
    here = pathlib.Path(__file__).resolve().parent
    sys.path[1:1] = [str(place) for place in (here.parent / "python", here.parents[1] / "python") if place.is_dir()]
    from wrong import Wrong
    try:
        make(options, missing)
    except Wrong as wrong:
        fail(2, str(wrong))
    except OSError as error:
        fail(4, f"cannot write or read {error.filename} ({error.strerror}). Is the disk full or read-only?")


if __name__ == "__main__":
    main()
