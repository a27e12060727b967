"""Checks links by the standard library alone.

    python3 docs/site/links.py markdown    links of all Markdown files of the repository
    python3 docs/site/links.py site        links, pictures and scripts of all pages of the built site

Each link inside must have its target, with its anchor. Links to other hosts are listed, not followed; on the site only
links may lead there: no picture, script or style may come from another host.
"""

import pathlib
import re
import sys
from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Page(HTMLParser):
    """Anchors, links and loaded files of a page."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links, self.loaded = set(), [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        for name in ("id", "name"):
            if values.get(name):
                self.anchors.add(values[name])
        if tag == "a" and values.get("href"):
            self.links.append(values["href"])
        elif values.get("src"):
            self.loaded.append(values["src"])
        elif tag == "link" and values.get("href") and values.get("rel") != "canonical":
            self.loaded.append(values["href"])


def slug(heading):
    """The anchor that GitHub makes of a heading."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
    text = re.sub(r"[^\w\- ]", "", text.strip().lower())
    return text.replace(" ", "-")


def markdown_page(path):
    """Anchors and links of a Markdown file."""
    text = re.sub(r"^(```|~~~).*?^\1", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    headings = [slug(h) for h in re.findall(r"^#{1,6} (.+)$", text, re.MULTILINE)]
    anchors = {f"{h}-{headings[:k].count(h)}" if h in headings[:k] else h for k, h in enumerate(headings)}
    anchors |= set(re.findall(r"<a (?:id|name)=\"([^\"]+)\"", text))
    text = re.sub(r"`[^`\n]*`", "", text)
    links = re.findall(r"\]\(([^)\s]+)(?: \"[^\"]*\")?\)", text) + re.findall(r"(?:src|href)=\"([^\"]+)\"", text)
    return anchors, links


def markdown():
    """Problems of the Markdown files, and links to other hosts."""
    skipped = {"target", "results", "site", ".git", "node_modules"}
    files = [p for p in ROOT.rglob("*.md") if not skipped & set(p.relative_to(ROOT).parts)]
    pages = {path: markdown_page(path) for path in files}
    problems, outside, count = [], set(), 0
    for path, (_, links) in pages.items():
        for link in links:
            count += 1
            parts = urlsplit(link)
            if parts.scheme:
                outside.add(link)
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                problems.append(f"{path.relative_to(ROOT)}: {link}: no such file")
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target][0]:
                problems.append(f"{path.relative_to(ROOT)}: {link}: no such heading")
    return problems, outside, count


def site(folder):
    """Problems of the built pages, and links to other hosts."""
    # The page for what is not found has absolute paths, which only a server resolves.
    files = [path for path in folder.rglob("*.html") if path.name != "404.html"]
    pages = {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in files}
    problems, outside, count = [], set(), 0
    for path, page in pages.items():
        for link in page.links + page.loaded:
            count += 1
            parts = urlsplit(link)
            if parts.scheme in ("http", "https") or parts.netloc:
                outside.add(link)
                if link in page.loaded:
                    problems.append(f"{path.name}: loads {link} from another host")
                continue
            if parts.scheme:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            if not target.is_file():
                problems.append(f"{path.relative_to(folder.resolve())}: {link}: no such file")
            elif parts.fragment and target in pages:
                anchor = unquote(parts.fragment)
                if anchor not in pages[target].anchors and not anchor.startswith("__"):
                    problems.append(f"{path.relative_to(folder.resolve())}: {link}: no such anchor")
    return problems, outside, count


def main():
    problems, outside, count = markdown() if sys.argv[1] == "markdown" else site(pathlib.Path(sys.argv[1]))
    for link in sorted(outside):
        print(f"outside, not followed: {link}")
    for problem in problems:
        print(f"error: {problem}", file=sys.stderr)
    print(f"{count} links, {len(outside)} to other hosts, {len(problems)} without target")
    # Nothing found means that nothing was read.
    return 1 if problems or count < 100 else 0


if __name__ == "__main__":
    sys.exit(main())
