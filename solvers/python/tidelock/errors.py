"""What can go wrong, with what there is to know about it."""

from __future__ import annotations

import pathlib

# Meanings of the program's exit codes, as `tidelock --help` lists them.
EXIT_CODES = {
    2: "the command line or the case file is wrong",
    3: "an output cannot be written or would overwrite something",
    4: "a server cannot be started or reached, or does not fit",
    5: "the physics broke down",
    6: "the ledger does not balance or a frame was stale",
    7: "a partner or a connection was lost during the run",
    8: "stopped from outside before the end time, outputs complete",
    11: "the run reached its end with reservations, and strict was given; outputs complete",
    12: "members of a sweep failed or are not finished",
    70: "a fault of the program",
}


class TidelockError(Exception):
    """Base of all errors of this package."""


class ProgramNotFound(TidelockError):
    """There is no program to run cases with."""


class CaseRefused(TidelockError):
    """A case has mistakes; the text of the error lists all of them with line and remedy."""


class NoResults(TidelockError):
    """A folder holds no results of a run."""


class RunFailed(TidelockError):
    """The program ended with an exit code other than 0.

    Attributes:
        exit_code: see EXIT_CODES; negative numbers are signals.
        verdict, reason: those of `summary.json`, if the run came so far.
        lines: the last lines that the program printed.
        folder: where results are, complete up to where the run ended.
    """

    def __init__(self, exit_code: int, lines: list[str], folder: pathlib.Path, verdict: str = "", reason: str = ""):
        self.exit_code, self.lines, self.folder = exit_code, lines, folder
        self.verdict, self.reason = verdict, reason
        meaning = EXIT_CODES.get(exit_code, f"ended by signal {-exit_code}" if exit_code < 0 else "unknown exit code")
        # The program has mostly printed the reason.
        printed = any(reason in line for line in lines)
        said = [verdict if printed else f"{verdict}: {reason}"] if verdict else []
        text = [f"exit code {exit_code}: {meaning}", *said, *(f"  {line}" for line in lines)]
        if folder.exists():
            text.append(f"results so far: {folder}")
        super().__init__("\n".join(text))
