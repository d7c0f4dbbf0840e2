"""A window of a run's timeline (moraine run --trace FILE) as a picture: one row per rank, phases in colours.

    python3 python/examples/timeline.py trace.json --from-step 40 --steps 4 --output timeline.svg
"""
import argparse
import json

COLOURS = {"p2g": "#4477aa", "nodes": "#66ccee", "g2p": "#228833", "halo": "#ccbb44", "agree": "#ee6677", "migrate": "#aa3377",
           "balance": "#bbbbbb", "output": "#333333"}
WIDTH, ROW, LEFT, TOP = 860, 34, 70, 26


def window(spans, step, steps):
    """Spans of so many recorded steps from this one on; begin and end [us]."""
    chosen = sorted({span["args"]["step"] for span in spans if span["args"]["step"] >= step})[:steps]
    found = [span for span in spans if chosen and chosen[0] <= span["args"]["step"] <= chosen[-1] and span["cat"] in COLOURS]
    if not found:
        raise SystemExit(f"timeline: no step from {step} on is in the file (the run was shorter). A smaller --from-step?")
    return found, min(span["ts"] for span in found), max(span["ts"] + span["dur"] for span in found)


def picture(spans, begin, end):
    ranks = sorted({span["pid"] for span in spans})
    scale = (WIDTH - LEFT - 10) / (end - begin)
    height = TOP + ROW * len(ranks) + 52
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif" font-size="12">',
             f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>']
    for k, rank in enumerate(ranks):
        top = TOP + ROW * k
        parts.append(f'<text x="8" y="{top + 18}">rank {rank}</text>')
        for name, colour in COLOURS.items():
            bars = [(LEFT + scale * (span["ts"] - begin), max(0.4, scale * span["dur"])) for span in spans if (span["pid"], span["cat"]) == (rank, name)]
            parts.append(f'<path fill="{colour}" d="' + "".join(f"M{x:.1f} {top}h{width:.1f}v{ROW - 8}h-{width:.1f}" for x, width in bars) + '"/>')
    foot = TOP + ROW * len(ranks) + 12
    parts.append(f'<text x="{LEFT}" y="{TOP - 10}">{(end - begin) / 1e3:.2f} ms</text>')
    for k, (name, colour) in enumerate(COLOURS.items()):
        x = LEFT + 95 * k
        parts.append(f'<rect x="{x}" y="{foot}" width="12" height="12" fill="{colour}"/><text x="{x + 17}" y="{foot + 11}">{name}</text>')
    return "\n".join([*parts, "</svg>\n"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("trace")
    parser.add_argument("--from-step", type=int, default=0)
    parser.add_argument("--steps", type=int, default=4)
    parser.add_argument("--output", default="timeline.svg")
    words = parser.parse_args()
    with open(words.trace) as file:
        spans = [event for event in json.load(file)["traceEvents"] if event["ph"] == "X"]
    with open(words.output, "w") as file:
        file.write(picture(*window(spans, words.from_step, words.steps)))


if __name__ == "__main__":
    main()
