"""Makes the gallery: runs its cases, draws a picture of each, and writes `index.md`.

    python3 docs/gallery/make.py              all cases that have no picture yet, then the page
    python3 docs/gallery/make.py --again A B  cases A and B again
    python3 docs/gallery/make.py --page       the page alone

Cases run one at a time on one thread. Times are CPU seconds of solvers and coordinator together.
"""

import argparse
import html
import json
import os
import pathlib
import re
import resource
import shutil
import sys
import tempfile
import textwrap

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "site"))

import images  # noqa: E402
from entries import ENTRIES  # noqa: E402

import tidelock  # noqa: E402

ROOT = HERE.parents[1]
RUNS = HERE / "runs.json"


def cpu():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def make(entry, out):
    """Runs a case and draws it; what there is to say of the run."""
    begun = cpu()
    settings = {"outputs.snapshot_interval_s": entry.interval, **entry.settings}
    run = tidelock.run(ROOT / entry.case, out, set=settings, threads=1, in_process=True)
    seconds = cpu() - begun
    if entry.plot:
        plot = run.plot_probes(*entry.plot)
    else:
        plot = run.plot_snapshot(entry.time, field=entry.field)
    size = images.save(plot, HERE / f"{entry.name}.png", 560)
    frame = run.frames[0]
    particles = len(frame.fluid) + len(frame.solid)
    print(f"{entry.name}: {seconds:.1f} s, {particles} particles, picture of {size} bytes", flush=True)
    return {"cpu_s": round(seconds, 1), "particles": particles, "steps": run.summary["steps"]}


def command(entry):
    """The command that runs the case as the gallery does."""
    words = [f"tidelock run {entry.case}"]
    words += [f"--set {key}={value}" for key, value in entry.settings.items()]
    words.append(f"--out results/gallery/{entry.name}")
    return " \\\n    ".join(words)


def case(entry):
    """The case file, folded; HTML, which opens on the site and on GitHub."""
    path = ROOT / entry.case
    # The schema's place is that in a checkout.
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#:schema")]
    return [
        '<details markdown="1">',
        f"<summary>The case, {html.escape(path.name)}</summary>",
        "",
        f"The file: [{path.name}]({os.path.relpath(path, HERE)}).",
        "",
        "```toml",
        *"\n".join(lines).strip().splitlines(),
        "```",
        "",
        "</details>",
    ]


def wrapped(text):
    """A paragraph; code stays whole."""
    whole = re.sub(r"`[^`]*`", lambda code: code.group().replace(" ", "\0"), text)
    return textwrap.fill(whole, 125, break_long_words=False, break_on_hyphens=False).replace("\0", " ")


def page(runs):
    """The page, cases by task."""
    done = [entry for entry in ENTRIES if entry.name in runs]
    total = sum(runs[entry.name]["cpu_s"] for entry in done)
    lines = [
        "# Gallery",
        "",
        wrapped(
            f"{len(done)} small cases by task, each with the one thing that it teaches. Times are CPU seconds on one core of "
            f"the machine of [performance](../performance.md); all together take {total / 60:.0f} minutes. Most are shipped "
            "cases, coarse or shortened. Commands are those of a checkout; below each stands the case, which saved alone runs "
            "by the same command with its name for the path."
        ),
        "",
        "`python3 docs/gallery/make.py` runs all of them and makes this page.",
        "",
    ]
    for task in dict.fromkeys(entry.task for entry in done):
        lines += [f"## {task}", ""]
        for entry in [e for e in done if e.task == task]:
            run = runs[entry.name]
            lines += [
                f"### {entry.title}",
                "",
                f"![{entry.title}]({entry.name}.png){{ width=420 }}",
                "",
                wrapped(f"{entry.teaches} {run['cpu_s']:.0f} s, {run['particles']} particles, {run['steps']} steps."),
                "",
                "```sh",
                command(entry),
                "```",
                "",
                *case(entry),
                "",
            ]
    (HERE / "index.md").write_text("\n".join(lines), encoding="utf-8")
    print(f"{len(done)} cases, {total:.0f} s in all")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--again", nargs="*", default=[])
    parser.add_argument("--page", action="store_true")
    arguments = parser.parse_args()
    runs = json.loads(RUNS.read_text(encoding="utf-8")) if RUNS.is_file() else {}
    failed = []
    for entry in [] if arguments.page else ENTRIES:
        if (arguments.again or entry.name in runs) and entry.name not in arguments.again:
            continue
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "out"
            try:
                runs[entry.name] = make(entry, out)
            except (tidelock.TidelockError, KeyError) as error:
                failed.append(entry.name)
                print(f"FAILED {entry.name}: {error}", file=sys.stderr, flush=True)
                continue
            finally:
                shutil.rmtree(out, ignore_errors=True)
        RUNS.write_text(json.dumps(runs, indent=1) + "\n", encoding="utf-8")
    page(runs)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
