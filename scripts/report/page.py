"""One page that holds everything: no script, no font and no picture from elsewhere."""
import html
import io
import re

STYLE = """
body { font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; color: #222; max-width: 78rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 2.2rem; border-bottom: 1px solid #ddd; }
.scroll { overflow-x: auto; } table { border-collapse: collapse; font-size: 0.8rem; }
th, td { padding: 0.2rem 0.45rem; border-bottom: 1px solid #eee; text-align: right; }
th { vertical-align: bottom; } td { white-space: nowrap; } .words td { white-space: normal; overflow-wrap: anywhere; }
th:first-child, td:first-child { text-align: left; } thead th { border-bottom: 1px solid #999; }
figure { margin: 1rem 0; } figure svg { width: 100%; max-width: 60rem; height: auto; } figcaption { color: #555; font-size: 0.9rem; }
.predicted { border-left: 4px solid #e08214; padding-left: 1rem; } code { background: #f4f4f4; padding: 0 0.2rem; }
"""


def table(columns, rows, words=False):
    """`words`: cells may break into lines."""
    cell = lambda tag, value: f"<{tag}>{html.escape(str(value))}</{tag}>"  # noqa: E731
    head = "".join(cell("th", name) for name in columns)
    body = "\n".join("<tr>" + "".join(cell("td", value) for value in row) + "</tr>" for row in rows)
    kind = ' class="words"' if words else ""
    return (f'<div class="scroll"><table{kind}><thead><tr>{head}</tr></thead><tbody>\n{body}\n'
            "</tbody></table></div>")


def inline_svg(figure, name):
    """The figure as SVG for a page: without prolog, and with ids that no other figure has."""
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None})
    text = out.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg"):], flags=re.S)
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r'(href="#|url\(#)', lambda found: f"{found.group(1)}{name}-", text)
    return text.replace("<svg ", f'<svg role="img" aria-label="{html.escape(name)}" ', 1)


def section(plot):
    marked = ' class="predicted"' if plot.name == "predictions" else ""
    return (f"<section{marked}>\n<h2>{html.escape(plot.title)}</h2>\n<figure>\n{inline_svg(plot.figure, plot.name)}\n"
            f"<figcaption>{html.escape(plot.caption)}</figcaption>\n</figure>\n</section>")


def page(title, parts):
    return ("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
            "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
            f"<title>{html.escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
            f"<h1>{html.escape(title)}</h1>\n" + "\n".join(parts) + "\n</body>\n</html>\n")
