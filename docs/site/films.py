"""Films of the README, from the player of a run's report in Chromium.

    python3 docs/site/films.py PROGRAM           runs the cases in `results/films` and makes all films
    python3 docs/site/films.py PROGRAM NAME...   these alone; a finished run is kept

Needs Debian's package `chromium`, and Pillow.
"""

import base64
import io
import pathlib
import subprocess
import sys
from dataclasses import dataclass, field

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "browser"))

from chromium import Browser  # noqa: E402

PICTURES = ROOT / "docs" / "pictures"
RUNS = ROOT / "results" / "films"
# Pixels of a film across; it is drawn twice as large, so that edges are smooth.
WIDTH = 600
SECONDS = 6.0
# What a film needs no buttons for.
BARE = """
.views, .controls > :not(.clock), .readings, .groups, .note, .colour label { display: none !important; }
.clock { margin: 0 auto; }
"""


@dataclass
class Film:
    case: str
    settings: dict = field(default_factory=dict)
    # Azimuth and elevation in degrees, in space.
    view: tuple | None = None
    # Share of the picture that is left out above.
    above: float = 0.0


FILMS = {
    "drifting_body": Film("cases/drifting_body.toml", {"outputs.snapshot_interval_s": 0.00625}, above=0.25),
    "debris_3d": Film("cases/debris_3d.toml", {"outputs.snapshot_interval_s": 0.01}, (-32, 24)),
}


def run(program, name, film):
    """Folder of the finished run of a film."""
    out = RUNS / name
    if not (out / "report.html").exists():
        words = [program, "run", ROOT / film.case, "--out", out, "--force"]
        for key, value in film.settings.items():
            words += ["--set", f"{key}={value}"]
        subprocess.run(words, check=True)
    return out


def pictures(browser, folder, film):
    """Each frame of the player with its time and its colours."""
    browser.call("Emulation.setDeviceMetricsOverride", width=WIDTH + 40, height=900, deviceScaleFactor=2, mobile=False)
    browser.scheme("light")
    browser.open(f"file://{folder}/report.html")
    browser.wait("page.player.frames.length === page.run.frames.length && page.player.canvas.dataset.drawn > 0")
    browser.run(f"document.head.append(Object.assign(document.createElement('style'), {{textContent: {BARE!r}}}))")
    if film.view:
        browser.run(f"page.player.look({film.view[0]}, {film.view[1]})")
    browser.run("page.player.fit()")
    for k in range(browser.run("page.run.frames.length")):
        browser.run(f"page.player.show({k}, true)")
        browser.run("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        box = browser.run("""(() => {
          const [first, last] = ['.frame', '.colouring'].map((name) => document.querySelector(`#player ${name}`).getBoundingClientRect());
          const above = ABOVE * first.height;
          return {x: first.left + scrollX, y: first.top + above + scrollY, width: first.width, height: last.bottom - first.top - above, scale: 1};
        })()""".replace("ABOVE", str(film.above)))
        shot = browser.call("Page.captureScreenshot", format="png", clip=box, captureBeyondViewport=True)["data"]
        picture = Image.open(io.BytesIO(base64.b64decode(shot))).convert("RGB")
        yield picture.resize((WIDTH, round(picture.height * WIDTH / picture.width)), Image.Resampling.LANCZOS)


def main():
    program, *names = sys.argv[1:]
    browser = Browser()
    for name in names or FILMS:
        film = FILMS[name]
        first, *others = pictures(browser, run(pathlib.Path(program).resolve(), name, film), film)
        path = PICTURES / f"{name}.webp"
        # The last picture stays for a second.
        shown = [round(1000 * SECONDS / (1 + len(others)))] * len(others) + [1000]
        first.save(path, save_all=True, append_images=others, duration=shown, loop=0, quality=60, method=6)
        print(f"{path.relative_to(ROOT)}: {1 + len(others)} pictures, {first.width} x {first.height}, {path.stat().st_size} bytes")
    browser.close()


if __name__ == "__main__":
    main()
