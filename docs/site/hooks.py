"""Hooks of the site: pages and cases from outside `docs`, equations as MathML, links to sources."""

import pathlib
import posixpath
import re

from latex2mathml.converter import convert
from markdown import Extension
from markdown.inlinepatterns import InlineProcessor
from markdown.preprocessors import Preprocessor
from mkdocs.structure.files import File

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Pages of the site that stand elsewhere in the repository.
OUTSIDE = {
    "case-keys.md": "cases/FORMAT.md",
    "architecture.md": "ARCHITECTURE.md",
    "changes.md": "CHANGELOG.md",
}
# Files that the site serves under their own path.
CASES = sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "cases").rglob("*.toml"))
PAGES = {source: page for page, source in OUTSIDE.items()} | {case: case for case in CASES}


def on_config(config):
    config.markdown_extensions.append(Equations())
    return config


def on_files(files, config):
    for page, source in OUTSIDE.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        files.append(File.generated(config, page, content=text))
    for case in CASES:
        files.append(File.generated(config, case, abs_src_path=str(ROOT / case)))
    return files


def on_page_markdown(markdown, page, **_):
    own = OUTSIDE.get(page.file.src_uri, "docs/" + page.file.src_uri)
    parts = re.split(r"(^```.*?^```\n?)", markdown, flags=re.MULTILINE | re.DOTALL)
    return "".join(part if k % 2 else _links(part, own, page.file.src_uri) for k, part in enumerate(parts))


def _links(text, own, page):
    """Links of a page at `own` in the repository, as those of `page` of the site; those to sources become their path."""

    def replaced(match):
        label, target = match.group(1), match.group(2)
        path, hash_, anchor = target.partition("#")
        if "://" in target or target.startswith("mailto:") or not path:
            return match.group()
        whole = posixpath.normpath(posixpath.join(posixpath.dirname(own), path))
        if not (ROOT / whole).exists():
            # mkdocs reports it.
            return match.group()
        inside = PAGES.get(whole) or (whole.removeprefix("docs/") if whole.startswith("docs/") else None)
        if inside is None:
            return f"{label} (`{whole}`)" if whole not in label else label
        return f"[{label}]({posixpath.relpath(inside, posixpath.dirname(page) or '.')}{hash_}{anchor})"

    return re.sub(r"(?<!!)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)", replaced, text)


class Equations(Extension):
    """Blocks ```` ```math ```` and `$...$` become MathML, which browsers draw without scripts and fonts."""

    def extendMarkdown(self, md):
        # After white space is normalised, before fences, which would take the blocks.
        md.preprocessors.register(Blocks(md), "equations", 27)
        md.inlinePatterns.register(Inline(r"(?<![\\$])\$([^$\n]+)\$", md), "equation", 185)


class Blocks(Preprocessor):
    def run(self, lines):
        text = "\n".join(lines)

        def drawn(match):
            # Parts of a line wrap on narrow pages.
            parts = "".join(mathml(part, "block") for part in match.group(1).split(r"\qquad"))
            return "\n" + self.md.htmlStash.store(f'<div class="equation">{parts}</div>') + "\n"

        return re.sub(r"^```math\n(.*?)^```$", drawn, text, flags=re.MULTILINE | re.DOTALL).split("\n")


class Inline(InlineProcessor):
    def handleMatch(self, m, data):
        return self.md.htmlStash.store(mathml(m.group(1), "inline")), m.start(0), m.end(0)


def mathml(latex, display):
    return convert(latex.strip(), display=display)
