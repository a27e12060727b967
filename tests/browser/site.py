"""The documentation site in a browser: pages open without errors, equations are drawn, the search finds, nothing is loaded
from elsewhere.

    python3 tests/browser/site.py SITE [PICTURES]
"""

import functools
import http.server
import pathlib
import sys
import threading

from chromium import Browser

PAGES = ["index", "method", "tutorials/first_case", "gallery/index", "accuracy", "peers"]


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


def main():
    site = pathlib.Path(sys.argv[1]).resolve()
    pictures = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=str(site)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    own = f"http://127.0.0.1:{server.server_port}/"
    browser = Browser()
    try:
        for width in (1300, 390):
            browser.size(width, 900, mobile=width < 500)
            for page in PAGES:
                browser.open(f"{own}{page}.html")
                browser.wait(f"location.pathname === '/{page}.html' && document.readyState === 'complete'")
                foreign = browser.run(
                    "performance.getEntriesByType('resource').map(e => e.name).filter(n => !n.startsWith(location.origin))"
                )
                assert not foreign, f"{page} loads {foreign}"
                broken = browser.run("[...document.images].filter(i => i.complete && !i.naturalWidth).map(i => i.src)")
                assert not broken, f"{page}: pictures do not load: {broken}"
                wide = browser.run("document.documentElement.scrollWidth - innerWidth")
                assert wide <= 0, f"{page} is {wide} pixels wider than a window of {width}"
                if pictures:
                    browser.picture(pictures / f"{page.replace('/', '_')}_{width}.png")
        browser.size(1300, 900)
        browser.open(f"{own}method.html")
        browser.wait("document.querySelectorAll('math').length > 25")
        heights = browser.run("[...document.querySelectorAll('math')].map(m => m.getBoundingClientRect().height)")
        # A fraction is taller than a line of text.
        assert max(heights) > 30, heights
        if pictures:
            browser.run("document.querySelectorAll('math')[8].scrollIntoView()")
            browser.picture(pictures / "equations.png")
        browser.open(f"{own}index.html?q=hourglass")
        browser.wait("document.querySelectorAll('.md-search-result__item').length > 1", 30)
        if pictures:
            browser.picture(pictures / "search.png")
        print(f"{len(PAGES)} pages at two widths, {len(heights)} equations, search finds")
        assert not browser.problems, browser.problems
    finally:
        browser.close()


if __name__ == "__main__":
    main()
