"""What the page costs: wall and CPU time of a case with its page open in a browser over those without, in turns; then size
of the report and time until it is drawn. The browser has no graphics card and takes cores from the run.

usage: cost.py PROGRAM FOLDER [CASE] [ROUNDS]
"""

import json
import os
import re
import statistics
import subprocess
import sys
import time

from chromium import Browser

HERE = os.path.dirname(os.path.abspath(__file__))


def cpu_of(process):
    """CPU time of a process and all that it started, in s."""
    parents, times = {}, {}
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{name}/stat") as file:
                fields = file.read().rpartition(")")[2].split()
        except OSError:
            continue  # ended meanwhile
        parents[int(name)] = int(fields[1])
        times[int(name)] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    ours = {process.pid}
    while more := {child for child, parent in parents.items() if parent in ours} - ours:
        ours |= more
    return sum(times.get(one, 0.0) for one in ours)


def timed(program, case, out, browser=None):
    """Wall time of a run, its CPU time and that of the browser, in s; its page is open in `browser` if there is one."""
    words = [program, "run", case, "--out", out, "--quiet", *(["--view"] if browser else [])]
    before = cpu_of(browser.process) if browser else 0.0
    process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    if browser:
        browser.open(re.search(r"http://\S+", process.stderr.readline())[0])
    # The program waits for its servers, whose time is in its own.
    process.stderr.read()
    _, status, used = os.wait4(process.pid, 0)
    watching = cpu_of(browser.process) - before if browser else 0.0
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, f"exit code {process.returncode}"
    if browser:
        drawn = browser.run("page.player ? page.player.frames.filter(Boolean).length : 0")
        assert drawn > 0, "the browser has drawn no frame"
        browser.open("about:blank")
    with open(os.path.join(out, "summary.json")) as file:
        # Without the moment in which a browser may ask for the last state.
        wall = json.load(file)["wall_seconds"]
    return wall, used.ru_utime + used.ru_stime, watching


def main():
    program, folder, *more = sys.argv[1:]
    case = more[0] if more else os.path.join(HERE, "..", "..", "cases", "drifting_body.toml")
    rounds = int(more[1]) if len(more) > 1 else 3
    browser = Browser(webgl=False)
    try:
        ratios = []
        for k in range(rounds):
            times = {}
            # The order changes with the round: what the machine does otherwise falls on both.
            for watched in [False, True] if k % 2 == 0 else [True, False]:
                out = os.path.join(folder, f"{'watched' if watched else 'alone'}-{k}")
                times[watched] = timed(program, case, out, browser if watched else None)
                wall, used, watching = times[watched]
                name = "page open" if watched else "no page"
                print(f"round {k + 1}, {name}: wall {wall:.1f} s, CPU {used:.1f} s, browser {watching:.1f} s", flush=True)
            ratios.append([watched / alone for watched, alone in zip(times[True][:2], times[False][:2])])
        wall, used = (statistics.median(column) for column in zip(*ratios))
        print(f"page open over no page, median: wall {wall:.3f}, CPU {used:.3f}; {os.cpu_count()} cores for both")
        report = os.path.abspath(os.path.join(folder, "alone-0", "report.html"))
        begun = time.monotonic()
        browser.open(f"file://{report}")
        browser.wait("page.player.canvas.dataset.drawn > 0")
        first = time.monotonic() - begun
        browser.wait("page.player.frames.length === page.run.frames.length")
        print(
            f"report: {os.path.getsize(report)} bytes, first frame drawn after {first:.2f} s, all frames read after "
            f"{time.monotonic() - begun:.2f} s"
        )
    finally:
        browser.close()


if __name__ == "__main__":
    main()
