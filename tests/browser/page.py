"""The page in a real browser: a report, a failed run, a run while it runs. Pictures of it go to a folder, to be looked at.

usage: page.py COORDINATOR FOLDER [report] [space] [failed] [live]
"""

import os
import re
import signal
import subprocess
import sys
import time

from chromium import Browser

HERE = os.path.dirname(os.path.abspath(__file__))
CASES = os.path.join(HERE, "..", "..", "cases")

# Pixels of the canvas that are not transparent, over all.
DRAWN = """(() => {
  const source = page.player.canvas;
  const copy = document.createElement('canvas');
  [copy.width, copy.height] = [source.width, source.height];
  const context = copy.getContext('2d');
  context.drawImage(source, 0, 0);
  const data = context.getImageData(0, 0, copy.width, copy.height).data;
  const colours = new Set();
  let drawn = 0;
  for (let i = 0; i < data.length; i += 4) if (data[i + 3]) { drawn++; colours.add((data[i] >> 4) << 8 | (data[i + 1] >> 4) << 4 | data[i + 2] >> 4); }
  return [drawn / (data.length / 4), colours.size];
})()"""

# All plots are drawn, those far from the screen too.
PRINT = "dispatchEvent(new Event('beforeprint'))"

# Controls without a name, pictures without a text, and texts whose contrast is below 4.5 (3 where they are large): WCAG 2.1, 1.1.1,
# 1.4.3, 4.1.2.
COMPLAINTS = """(() => {
  const found = [];
  const shown = (node) => node.getClientRects().length > 0;
  const name = (node) => node.getAttribute('aria-label') || node.closest('label')?.textContent.trim() || node.textContent.trim();
  for (const node of document.querySelectorAll('button, select, input, a, canvas, svg:not([aria-hidden])')) if (shown(node) && !name(node)) found.push('no name: ' + node.outerHTML.slice(0, 120));
  for (const node of document.querySelectorAll('img')) if (!node.alt) found.push('no text: an image');
  const rgb = (text) => { const [r, g, b, a = 1] = text.match(/[\\d.]+/g).map(Number); return { rgb: [r, g, b], a }; };
  const light = (c) => c.map((v) => v / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)).reduce((s, v, k) => s + v * [0.2126, 0.7152, 0.0722][k], 0);
  const behind = (node) => { for (let at = node; at; at = at.parentElement) { const c = rgb(getComputedStyle(at).backgroundColor); if (c.a > 0.99) return c.rgb; } return [255, 255, 255]; };
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const node = walker.currentNode.parentElement;
    if (!walker.currentNode.textContent.trim() || !shown(node) || node.closest('script, style, option, :disabled')) continue;
    const style = getComputedStyle(node);
    const front = rgb(node.closest('svg') ? style.fill : style.color).rgb;
    const [a, b] = [light(front), light(behind(node))];
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    const size = parseFloat(style.fontSize);
    const least = size >= 24 || (size >= 18.6 && style.fontWeight >= 700) ? 3 : 4.5;
    if (contrast < least) found.push(`contrast ${contrast.toFixed(2)}: ${walker.currentNode.textContent.trim().slice(0, 60)}`);
  }
  const ids = [...document.querySelectorAll('[id]')].map((node) => node.id);
  for (const id of ids) if (ids.indexOf(id) !== ids.lastIndexOf(id)) found.push(`two elements are called ${id}`);
  if (document.documentElement.scrollWidth > innerWidth) found.push(`the page is ${document.documentElement.scrollWidth} px wide on a screen of ${innerWidth}`);
  return found;
})()"""

# Frames a second of 100 000 particles that change with every frame.
RATE = """(async () => {
  const player = page.player;
  const count = 100000;
  const columns = [['x', 0], ['y', 1]].map(([name, k]) => ({ name, bits: 16, lower: player.scene.lower[k], upper: player.scene.upper[k] })).concat([{ name: 'pressure', bits: 16, lower: 0, upper: 1 }]);
  const frames = [0, 1, 2, 3].map((f) => {
    const codes = Object.fromEntries(columns.map((c, k) => [c.name, Uint16Array.from({ length: count }, (_, i) => ((i * 40503 * (k + 1)) >>> 0) % 65535)]));
    return { time: f, step: f, count, groups: new Uint16Array(count), ids: Uint32Array.from({ length: count }, (_, i) => i), codes, columns };
  });
  // As near to each other as so many are in this window.
  const size = player.scene.upper.map((c, k) => c - player.scene.lower[k]);
  const spacings = player.scene.spacings;
  player.scene.spacings = spacings.map(() => Math.sqrt((size[0] * size[1]) / count));
  const begun = performance.now();
  let drawn = 0;
  while (performance.now() - begun < 3000) {
    player.painter.paint(player.prepared(frames[drawn % 4]), player.camera.view());
    // Waits until it is drawn.
    player.painter.gl?.readPixels(0, 0, 1, 1, player.painter.gl.RGBA, player.painter.gl.UNSIGNED_BYTE, new Uint8Array(4));
    drawn++;
  }
  player.scene.spacings = spacings;
  return (1000 * drawn) / (performance.now() - begun);
})()"""


def command(coordinator, case, out, changes, *options):
    """A run of a shipped case with other values of its keys."""
    words = [coordinator, "run", os.path.join(CASES, case), "--out", out, "--in-process", "--quiet", *options]
    for key, value in changes.items():
        words += ["--set", f"{key}={value}"]
    return words


def run(coordinator, case, out, changes, expect=0):
    done = subprocess.run(command(coordinator, case, out, changes), capture_output=True, text=True)
    assert done.returncode == expect, (done.returncode, done.stderr)


def read(browser, address):
    browser.open(address)
    browser.wait("page.player.frames.length === page.run.frames.length && page.player.canvas.dataset.drawn > 0")


def player_works(browser):
    """Draws, plays, pauses, steps, zooms, turns and picks."""
    drawn, colours = browser.run(DRAWN)
    assert drawn > 0.05 and colours > 8, f"{drawn:.3f} of the canvas is drawn, in {colours} colours"
    browser.run("page.player.show(0, true)")
    browser.run("page.player.canvas.focus()")
    browser.press(" ", "Space", " ")
    browser.wait("page.player.shown > 0", 20)
    browser.press(" ", "Space", " ")
    assert not browser.run("page.player.playing")
    at = browser.run("page.player.shown")
    time.sleep(0.5)
    assert browser.run("page.player.shown") == at, "a film that was paused still moves"
    browser.press("Home")
    browser.press("ArrowRight")
    assert browser.run("page.player.shown") == 1
    before = browser.run("page.player.camera.view().pixels")
    browser.press("+", "Equal", "+")
    assert browser.run("page.player.camera.view().pixels") > before
    browser.press("0", "Digit0", "0")
    time.sleep(0.2)
    # The middle of what is drawn of the fluid.
    place = browser.run("""(() => {
      const player = page.player, frame = player.frame(), box = player.canvas.getBoundingClientRect();
      const fluid = [...frame.groups.keys()].filter((i) => player.scene.groups[frame.groups[i]].matter === 'fluid' && !Number.isNaN(valueAt(frame, 'x', i)));
      const [x, y] = player.project(frame, fluid[fluid.length >> 1]);
      return [box.left + x, box.top + y];
    })()""")
    browser.click(*place)
    browser.wait("/particle \\d+ at .*speed/.test(page.player.readings.textContent)", 10)


def looks_right(browser, pictures, name, whole=True):
    for width, height in [(1440, 900), (390, 844)]:
        for scheme in ["light", "dark"]:
            browser.size(width, height)
            browser.scheme(scheme)
            # Until plots have their new width.
            browser.wait("document.documentElement.scrollWidth <= innerWidth", 30)
            browser.run(PRINT)
            complaints = browser.run(COMPLAINTS)
            assert not complaints, f"{name} at {width} px, {scheme}:\n  " + "\n  ".join(complaints)
            top = browser.run("page.player.canvas.getBoundingClientRect().top + scrollY")
            assert top < 0.6 * height, f"{name}: the first picture begins at {top} px of {height}"
            browser.picture(os.path.join(pictures, f"{name}-{width}-{scheme}.png"))
            if whole:
                browser.picture(os.path.join(pictures, f"{name}-{width}-{scheme}-whole.png"), whole=True)


def report(browser, coordinator, folder):
    changes = {"time.end_time_s": 0.03, "outputs.snapshot_interval_s": 0.005, "outputs.picture_times_s": [0.0, 0.03]}
    run(coordinator, "drifting_body_coarse.toml", f"{folder}/plane", changes)
    begun = time.monotonic()
    read(browser, f"file://{folder}/plane/report.html")
    print(f"plane run: {os.path.getsize(f'{folder}/plane/report.html')} bytes, read and drawn in {time.monotonic() - begun:.1f} s")
    # There is no graphics card.
    assert browser.run("page.player.painter.name") == "canvas"
    player_works(browser)
    # Plots are drawn when they come near to the screen, or all for a printer.
    lines = "document.querySelectorAll('#plots svg path').length"
    assert browser.run(lines) < 10
    browser.run("document.getElementById('plots').scrollIntoView()")
    browser.wait(f"{lines} > 2", 10)
    browser.run(PRINT)
    assert browser.run(lines) > 10
    browser.run("scrollTo(0, 0)")
    browser.run("page.plots.seek(0.015)")
    assert abs(browser.run("page.plots.time") - 0.015) < 1e-9
    rate = browser.run(RATE)
    print(f"100 000 particles on a plain canvas: {rate:.1f} frames/s")
    # A machine that is busy with other things says nothing of this.
    if os.getloadavg()[0] < 1.0:
        assert rate > 10, "the film of 100 000 particles stutters"
    browser.run("page.player.show(3, true)")
    looks_right(browser, folder, "plane")
    browser.size(1440, 900)
    read(browser, f"file://{folder}/plane/report.html?draw=webgl")
    assert browser.run("page.player.painter.name") == "WebGL2"
    player_works(browser)


def space(browser, coordinator, folder):
    changes = {"time.end_time_s": 0.06, "outputs.picture_times_s": [0.0, 0.06]}
    run(coordinator, "dam_break_3d.toml", f"{folder}/space", changes)
    browser.size(1440, 900)
    read(browser, f"file://{folder}/space/report.html")
    before = browser.run("page.player.camera.turn()")
    browser.run("page.player.canvas.focus()")
    browser.call("Input.dispatchKeyEvent", type="keyDown", key="ArrowRight", code="ArrowRight", modifiers=8)
    assert browser.run("page.player.camera.turn()") != before, "it does not turn"
    browser.run("page.player.home()")
    player_works(browser)
    looks_right(browser, folder, "space")


def failed(browser, coordinator, folder):
    # A step far above the limit of stability, which the case allows itself.
    changes = {"time.step.time_step_s": 4e-4, "time.limit_factor": 10.0, "outputs.snapshot_interval_s": 0.002}
    run(coordinator, "drifting_body_coarse.toml", f"{folder}/failed", changes, expect=5)
    browser.size(1440, 900)
    read(browser, f"file://{folder}/failed/report.html")
    assert "ended the run" in browser.run("document.getElementById('culprit').textContent")
    browser.run("document.querySelector('#culprit button').click()")
    browser.wait("document.querySelector('.ring.culprit') !== null", 10)
    looks_right(browser, folder, "failed")


def live(browser, coordinator, folder):
    # Far longer than the test, which stops it.
    changes = {"outputs.snapshot_interval_s": 0.002, "time.end_time_s": 20.0}
    words = command(coordinator, "drifting_body_coarse.toml", f"{folder}/live", changes, "--view")
    begun = time.monotonic()
    program = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    try:
        link = re.search(r"http://\S+", program.stderr.readline())[0]
        browser.size(1440, 900)
        browser.scheme("light")
        browser.open(link)
        browser.wait("page.player?.frames.length > 1 && page.player.canvas.dataset.drawn > 0", 180)
        print(f"first moving picture {time.monotonic() - begun:.1f} s after the start of the run")
        browser.wait("document.querySelector('.doing').textContent === 'computing'", 20)
        looks_right(browser, folder, "live", whole=False)
        # Without the token one may look only.
        browser.open(link.split("#")[0])
        browser.wait("document.querySelector('.orders button').disabled && page.player?.frames.length > 1")
        browser.open("about:blank")
        browser.open(link)
        browser.wait("page.player?.frames.length > 1")
        browser.run("[...document.querySelectorAll('.orders button')].find((b) => /checkpoint/.test(b.textContent)).click()")
        browser.wait("/step/.test([...document.querySelectorAll('.live-facts div')].find((d) => /last checkpoint/.test(d.textContent))?.textContent)", 30)
        browser.wait("/checkpoint taken: step \\d+/.test(document.querySelector('.answer').textContent)", 5)
        browser.run("[...document.querySelectorAll('.orders button')].find((b) => /stop/.test(b.textContent)).click()")
        assert program.wait(60) == 8, "stopped from outside"
        browser.wait("/ended: stopped/.test(document.querySelector('.doing').textContent)", 10)
        # A request after the end of the program is refused, and the console says so; what the page has read stays.
        browser.wait("page.player.frames.length > 1")
        browser.problems = [text for text in browser.problems if "ERR_CONNECTION_REFUSED" not in text]
    finally:
        program.kill()
    # The folder, by `view`.
    viewer = subprocess.Popen([coordinator, "view", f"{folder}/live"], stdout=subprocess.PIPE, text=True)
    try:
        read(browser, viewer.stdout.readline().strip())
        assert browser.run("document.getElementById('verdict').textContent").startswith("stopped")
        viewer.send_signal(signal.SIGINT)
        assert viewer.wait(20) == 0
    finally:
        viewer.kill()


def main():
    coordinator, folder = map(os.path.abspath, sys.argv[1:3])
    parts = {part.__name__: part for part in [report, space, failed, live]}
    wanted = sys.argv[3:] or list(parts)
    os.makedirs(folder, exist_ok=True)
    browser = Browser()
    try:
        for part in [parts[name] for name in wanted]:
            part(browser, coordinator, folder)
            assert not browser.problems, f"{part.__name__}: the console says\n  " + "\n  ".join(browser.problems)
            print(f"{part.__name__}: passed")
    finally:
        browser.close()


main()
