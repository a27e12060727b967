"""Where the program is, and how it is called."""

from __future__ import annotations

import os
import pathlib
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Mapping, Sequence

from .errors import ProgramNotFound

# `coordinator` is the name of the program in a build of the workspace.
NAMES = ["tidelock", "coordinator"]


def find_program() -> pathlib.Path:
    """The program that runs cases.

    Looked for in this order: the environment variable TIDELOCK_PROGRAM, the folder of programs of this Python, where
    `pip install` puts it, the release build of the checkout that holds this package, the PATH.

    Raises:
        ProgramNotFound: with the places that were looked at.
    """
    named = os.environ.get("TIDELOCK_PROGRAM")
    if named:
        found = shutil.which(named)
        if found is None:
            raise ProgramNotFound(f"TIDELOCK_PROGRAM = {named}: no such program, or not executable")
        return pathlib.Path(found)
    checkout = pathlib.Path(__file__).resolve().parents[3] / "target" / "release"
    scripts = [sysconfig.get_path("scripts"), str(pathlib.Path(sys.executable).parent), str(checkout)]
    for folder in [*scripts, None]:
        for name in NAMES:
            found = shutil.which(name, path=folder)
            if found is not None:
                return pathlib.Path(found)
    raise ProgramNotFound(
        f"no program `tidelock` in {', '.join(dict.fromkeys(scripts))} or on the PATH: install the package with pip, "
        "or set TIDELOCK_PROGRAM to the program"
    )


def settings(values: Mapping[str, object] | None) -> list[str]:
    """Words that set keys over a case.

    >>> settings({"fluid.scheme": "leapfrog", "domain.upper_m": [1, 0.5], "solid.contact.wet": False})
    ['--set', 'fluid.scheme=leapfrog', '--set', 'domain.upper_m=[1, 0.5]', '--set', 'solid.contact.wet=false']
    """
    words = []
    for key, value in (values or {}).items():
        words += ["--set", f"{key}={value if isinstance(value, str) else written(value)}"]
    return words


def written(value: object) -> str:
    """A value as a case file writes it.

    >>> written({"type": "fixed", "time_step_s": 1e-4})
    '{ type = "fixed", time_step_s = 0.0001 }'
    """
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        text = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{text}"'
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {written(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(written, value)) + "]"
    if hasattr(value, "tolist"):
        return written(value.tolist())  # type: ignore[attr-defined]
    return repr(value)


def call(words: Sequence[object], echo: bool = False) -> tuple[int, str]:
    """Runs the program; its exit code and what it printed.

    With `echo` it prints to the terminal, with a progress bar, and only errors are returned. Ctrl-C lets a run end in
    order, with a checkpoint, before it is raised again.
    """
    command = [str(find_program()), *map(str, words)]
    out = None if echo else subprocess.PIPE
    process = subprocess.Popen(command, stdout=out, stderr=out, text=True, encoding="utf-8", errors="replace")
    try:
        printed, said = process.communicate()
    except KeyboardInterrupt:
        process.communicate()
        raise
    return process.returncode, "\n".join(part.strip("\n") for part in [printed or "", said or ""] if part.strip())
