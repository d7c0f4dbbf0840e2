"""Hook of MkDocs: equations between dollars become MathML, which browsers typeset by themselves, offline and without a script.

Of entries of the navigation that are folders it makes lists of their pages.
"""
import html
import logging
import re

from latex2mathml.converter import convert
from mkdocs.structure.files import InclusionLevel

LOG = logging.getLogger("mkdocs.hooks.equations")
MATH = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)
FETCHED = re.compile(r'<(?:script|link|img|iframe)[^>]*(?:src|href)="(https?://[^"]*)')
FOLDER = re.compile(r"\[([^\]\n]+)\]\([\w./-]+/\)")  # links to folders, which a site has not
REMARK = re.compile(r"^(```\w+) \w+$", re.MULTILINE)  # of code blocks, which only tests read


def _mathml(match):
    return convert(html.unescape(match[3]).strip(), display="block" if match[2] == "[" else "inline")


def on_page_markdown(markdown, page, config, files):
    return FOLDER.sub(r"\1", REMARK.sub(r"\1", markdown))


def on_page_content(page_html, page, config, files):
    found = MATH.sub(_mathml, page_html)
    if "arithmatex" in found:
        LOG.warning("%s has an equation that is not typeset", page.file.src_uri)
    return found


def on_post_page(output, page, config):
    for place in FETCHED.findall(output):
        LOG.warning("%s fetches %s from the network", page.file.src_uri, place)
    return output


def _pages_of(entry, files):
    if isinstance(entry, dict):
        return {name: _pages_of(inside, files) for name, inside in entry.items()}
    if isinstance(entry, list):
        return [_pages_of(inside, files) for inside in entry]
    inside = sorted(path for path in files if path.startswith(f"{entry}/") and path.endswith(".md"))
    return inside or entry


def on_files(files, config):
    pages = [file.src_uri for file in files.documentation_pages(inclusion=InclusionLevel.is_included)]
    config.nav = _pages_of(config.nav, pages)
    return files
