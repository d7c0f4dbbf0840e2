"""One page that holds everything: no script, no font and no picture from elsewhere."""
import html
import io
import re

STYLE = """
:root { color-scheme: light dark; --ink: #1c1f23; --faint: #59616b; --edge: #d5d9de; --grid: #e4e7eb; --zero: #9aa3ad; --paper: #ffffff;
  --pane: #ffffff; --code: #f1f3f5; --bad: #b3261e; --badpaper: #fdecea; --good: #1e6b34; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e8eb; --faint: #a4acb6; --edge: #3a4048; --grid: #2c3138; --zero: #69727d;
  --paper: #14171a; --pane: #e9ebee; --code: #24292f; --bad: #ffb4ab; --badpaper: #3b1a17; --good: #8ed6a0; } }
* { box-sizing: border-box; }
body { font: 16px/1.5 system-ui, "DejaVu Sans", sans-serif; color: var(--ink); background: var(--paper); max-width: 84rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0.5rem 0; } h2 { font-size: 1.3rem; margin: 2.2rem 0 0.8rem; border-bottom: 1px solid var(--edge); }
h3 { font-size: 1.05rem; margin: 0 0 0.4rem; } h4 { font-size: 0.95rem; margin: 0 0 0.2rem; }
.scroll { overflow-x: auto; } table { border-collapse: collapse; font-size: 0.85rem; }
th, td { padding: 0.25rem 0.5rem; border-bottom: 1px solid var(--grid); text-align: right; }
th { vertical-align: bottom; } td { white-space: nowrap; } .words td { white-space: normal; overflow-wrap: anywhere; min-width: 8rem; }
th:first-child, td:first-child { text-align: left; } thead th { border-bottom: 1px solid var(--zero); }
figure { margin: 1rem 0; } figcaption { color: var(--faint); font-size: 0.85rem; margin-top: 0.4rem; max-width: 44rem; }
figure.fixed svg { width: 100%; max-width: 60rem; height: auto; display: block; } svg text { fill: currentColor; }
.predicted { border-left: 4px solid #e08214; padding-left: 1rem; } code { background: var(--code); padding: 0 0.2rem; overflow-wrap: anywhere; }
dl.facts { display: flex; flex-wrap: wrap; gap: 0.6rem 2rem; margin: 0 0 1rem; } dl.facts div { min-width: 7rem; }
details { font-size: 0.85rem; margin: 0.5rem 0; } details div { display: flex; gap: 0.8rem; } details dt { min-width: 7.5rem; }
details dl { margin: 0.4rem 0; } details dd { font-size: 0.85rem; } dt { color: var(--faint); font-size: 0.8rem; } dd { margin: 0; font-size: 1.05rem; }
.warning { border-left: 4px solid var(--bad); background: var(--badpaper); padding: 0.7rem 1rem; margin: 1rem 0; } .warning h3 { color: var(--bad); }
.warning ul { margin: 0; padding-left: 1.2rem; } .good { color: var(--good); }
.charts { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 20rem), 1fr)); gap: 1.6rem 2rem; margin-top: 1.6rem; }
section > .chart { max-width: 60rem; } section > .chart .area { height: 15rem; }
.chart, .still { margin: 0; min-width: 0; } .none { color: var(--faint); }
.plot { display: grid; grid-template-columns: 3.2rem minmax(0, 1fr); padding: 0.5rem 0 0; }
.area { height: 12rem; border: 1px solid var(--edge); } .area svg { width: 100%; height: 100%; display: block; overflow: visible; }
.grid { stroke: var(--grid); stroke-width: 1; vector-effect: non-scaling-stroke; } .zero { stroke: var(--zero); }
.line { fill: none; stroke-width: 2; vector-effect: non-scaling-stroke; stroke-linejoin: round; stroke-linecap: round; }
.ys, .xs { position: relative; font-size: 0.8rem; color: var(--faint); } .xs { grid-column: 2; height: 1.4rem; }
.ys span { position: absolute; right: 0.4rem; transform: translateY(-50%); line-height: 1; white-space: nowrap; }
.xs span { position: absolute; top: 0.15rem; transform: translateX(-50%); line-height: 1.2; white-space: nowrap; }
.xs .first { transform: none; } .xs .last { transform: translateX(-100%); }
.xlabel, .ylabel { font-size: 0.8rem; color: var(--faint); } .xlabel { text-align: right; }
.legend { list-style: none; display: flex; flex-wrap: wrap; gap: 0.2rem 1rem; padding: 0; margin: 0.4rem 0 0; font-size: 0.85rem; }
.legend i { display: inline-block; width: 1.4rem; border-top: 3px solid; margin-right: 0.4rem; vertical-align: middle; } .legend .dashed { border-top-style: dashed; }
.pane { position: relative; background: var(--pane); border: 1px solid var(--edge); } .pane img { display: block; width: 100%; height: auto; }
.pane b { position: absolute; transform: translate(-50%, -50%); font-size: 0.8rem; color: #111; background: #ffffffb0; padding: 0 0.2rem; border-radius: 2px; }
.stills { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 20rem), 1fr)); gap: 1.2rem 2rem; margin: 1.2rem 0; }
.scroll + h3, .scroll + .scroll { margin-top: 1.2rem; }
@media (max-width: 47rem) { td { white-space: normal; } td:first-child { overflow-wrap: anywhere; min-width: 4rem; } th, td { padding: 0.25rem 0.3rem; } .maps .pane b { font-size: 0.7rem; padding: 0 0.1rem; } }
.maps { display: grid; grid-template-columns: minmax(0, 1fr); gap: 1.6rem; margin: 1.2rem 0; }
@media print { body { max-width: none; padding: 0; } figure, table, .warning { break-inside: avoid; } .movie { display: none; } }
.stills.flat { grid-template-columns: minmax(0, 1fr); gap: 0.6rem; } .movie { margin: 2rem 0 1rem; } .movie.high { max-width: 40rem; }
.bar { max-width: 24rem; margin-left: 3.2rem; } .bar .colours { height: 0.8rem; border-radius: 2px; } .bar .xs { color: var(--faint); }
.bars { display: grid; grid-template-columns: max-content minmax(0, 1fr); gap: 0.4rem 0.8rem; align-items: center; }
.barname { font-size: 0.85rem; } .barline { display: flex; height: 1.8rem; } .barline span { overflow: hidden; font-size: 0.8rem; line-height: 1.8rem; text-align: center; }
.legend .square { width: 0.9rem; height: 0.9rem; border: 0; } .narrow { display: none; }
@media (max-width: 47rem) { .narrow { display: block; } .narrow + .scroll { display: none; } .bars { grid-template-columns: minmax(0, 1fr); gap: 0.2rem; } }
.pane .scale { position: absolute; right: 3%; bottom: 0.5rem; height: 6px; border: 1px solid #111; background: linear-gradient(to right, #111 50%, #fff 50%); }
.pane .scaled { left: auto; right: 3%; bottom: 0.9rem; transform: none; } .beside { display: grid; gap: 1rem 1.6rem; margin: 1rem 0; }
@media (min-width: 47rem) { .beside.two { grid-template-columns: repeat(2, minmax(0, 1fr)); } .beside.three { grid-template-columns: repeat(3, minmax(0, 1fr)); } }
.control { display: flex; align-items: center; gap: 0.8rem; margin: 0.4rem 0; } .control input { flex: 1; min-width: 6rem; } .control output { min-width: 6.5rem; }
button { font: inherit; padding: 0.25rem 0.9rem; min-width: 4.5rem; }
"""


def table(columns, rows, words=False):
    """`words`: cells may break into lines. A column is a name, or a name and what it means."""
    cell = lambda tag, value: f"<{tag}>{html.escape(str(value))}</{tag}>"  # noqa: E731
    head = "".join(f'<th title="{html.escape(name[1])}">{html.escape(name[0])}</th>' if isinstance(name, tuple) else cell("th", name)
                   for name in columns)
    body = "\n".join("<tr>" + "".join(cell("td", value) for value in row) + "</tr>" for row in rows)
    kind = ' class="words"' if words else ""
    meanings = "".join(f"<div><dt>{html.escape(name[0])}</dt><dd>{html.escape(name[1])}</dd></div>" for name in columns if isinstance(name, tuple))
    below = f"\n<details><summary>What the columns mean</summary><dl>{meanings}</dl></details>" if meanings else ""
    return (f'<div class="scroll"><table{kind}><thead><tr>{head}</tr></thead><tbody>\n{body}\n'
            f"</tbody></table></div>{below}")


def facts(rows):
    return '<dl class="facts">' + "".join(f"<div><dt>{html.escape(name)}</dt><dd>{html.escape(value)}</dd></div>" for name, value in rows) + "</dl>\n"


def inline_svg(figure, name):
    """The figure as SVG for a page: without prolog, with ids that no other figure has, and with the page's colour for what is black."""
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
    text = out.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg"):], flags=re.S)
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r'(href="#|url\(#)', lambda found: f"{found.group(1)}{name}-", text)
    text = re.sub(r"(stroke|fill): #000000", r"\1: currentColor", text)
    least = 88 * figure.get_size_inches()[0]  # pixels: 96 an inch is its own size, and labels of 9 points are 11 pixels then
    return text.replace("<svg ", f'<svg role="img" aria-label="{html.escape(name)}" style="min-width:{least:.0f}px" ', 1)


def narrow_svg(plot):
    """The figure again for a narrow screen, where its panels stand one above the other and it is not large; else nothing."""
    from matplotlib.colors import to_hex
    axes, legend = plot.figure.axes[0], plot.figure.axes[0].get_legend()
    if axes.get_subplotspec().get_gridspec().ncols > 1:
        return ""
    size = plot.figure.get_size_inches().copy()
    plot.figure.set_size_inches(3.7, size[1] * (1 if axes.get_aspect() == "auto" else 0.7))
    names = ""
    if legend:  # there is no room beside the panels
        legend.set_visible(False), legend.set_in_layout(False)
        patches = zip(legend.get_texts(), legend.get_patches())
        names = '<ul class="legend">' + "".join(f'<li><i class="square" style="background:{to_hex(patch.get_facecolor())}"></i>'
                                                f"{html.escape(text.get_text())}</li>" for text, patch in patches) + "</ul>"
    text = inline_svg(plot.figure, plot.name + "-narrow")
    plot.figure.set_size_inches(*size)
    if legend:
        legend.set_visible(True), legend.set_in_layout(True)
    return f'<div class="narrow">{text}{names}</div>' if len(text) < 250_000 else ""


def section(plot):
    import charts
    if isinstance(plot, charts.Chart):
        return f"<section>\n{charts.section(plot, 'h2')}\n</section>"
    marked = ' class="predicted"' if plot.name == "predictions" else ""
    shown = plot.html or f'{narrow_svg(plot)}<div class="scroll">{inline_svg(plot.figure, plot.name)}</div>'
    return (f'<section{marked}>\n<h2>{html.escape(plot.title)}</h2>\n<figure class="fixed">\n{shown}\n'
            f"<figcaption>{html.escape(plot.caption)}</figcaption>\n</figure>\n</section>")


def page(title, parts, script=""):
    end = f"\n<script>{script}</script>" if script else ""
    return ("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
            "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
            f"<title>{html.escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
            f"<h1>{html.escape(title)}</h1>\n" + "\n".join(parts) + f"{end}\n</body>\n</html>\n")
