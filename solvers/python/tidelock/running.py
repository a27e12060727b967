"""Runs of single cases."""

from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Mapping, Sequence

from .case import Case
from .errors import CaseRefused, RunFailed
from .program import call, settings
from .results import Results

# Lines that an error repeats.
LAST_LINES = 20


def run(
    case: Case | str | os.PathLike,
    out: str | os.PathLike | None = None,
    *,
    set: Mapping[str, object] | None = None,
    threads: int | None = None,
    force: bool = False,
    strict: bool = False,
    in_process: bool = False,
    echo: bool = False,
    options: Sequence[str] = (),
) -> Results:
    """Runs a case to its end and opens its results.

    Args:
        case: a case, or the path of its file.
        out: folder for the results; by default `results/` and the name of the case.
        set: keys over the case, by path: `{"fluid.particle_spacing_m": 0.004}`.
        threads: compute threads of each solver; results do not depend on it.
        force: replace the results of an earlier run in that folder.
        strict: a run that ends with reservations counts as failed.
        in_process: solvers as threads of one process instead of servers; same bits.
        echo: let the program print, with a progress bar.
        options: further words of `tidelock run`.

    Raises:
        CaseRefused: the case has mistakes, all listed.
        RunFailed: any other exit code than 0.
        ProgramNotFound: there is no program.
    """
    case = case if isinstance(case, Case) else Case.read(case)
    if out is None:
        out = pathlib.Path("results") / (case.path.stem if case.path else case.name)
    out = pathlib.Path(out)
    flags = {"--force": force, "--strict": strict, "--in-process": in_process, "--quiet": not echo}
    words = ["--out", out, *settings(set), *(flag for flag, given in flags.items() if given)]
    if threads is not None:
        words += ["--threads", threads]
    carry_out("run", case, [*words, *options], out, echo)
    return Results(out)


def carry_out(command: str, case: Case, words: Sequence[object], out: pathlib.Path, echo: bool) -> None:
    """Has the program carry out `command` on a case; results are in `out`.

    Raises:
        CaseRefused: the case has mistakes.
        RunFailed: any other exit code than 0.
    """
    with case.file() as path:
        code, text = call([command, path, *words], echo)
        text = text.replace(str(path), str(case.path or path.name))
    if code == 2:
        raise CaseRefused(text or "see the messages above")
    if code != 0:
        raise failure(code, text, out)


def failure(code: int, text: str, out: pathlib.Path) -> RunFailed:
    """The error of a run that ended with `code`."""
    summary = {}
    # Outputs of code 3 may be those of another run.
    if code != 3 and (out / "summary.json").is_file():
        summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    lines = text.splitlines()[-LAST_LINES:]
    return RunFailed(code, lines, out, summary.get("verdict", ""), summary.get("reason", ""))
