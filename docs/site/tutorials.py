"""Runs tutorials as written: each page in a folder of its own, block after block.

    python3 docs/site/tutorials.py [--keep FOLDER] [PAGE ...]

Blocks with a title are written to the file of that name, `sh` blocks go to bash, `python` blocks to one interpreter
for the page. ```` ```sh fails ```` must fail. A block with the title `output` is what the block before printed, where
`...` stands for anything, such as durations, and numbers agree within 1 % or one in the last decimal. `tidelock` is the
program that the package finds.
"""

import argparse
import contextlib
import io
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

import tidelock

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = ["first_picture.md", *(f"tutorials/{n}.md" for n in ["first_case", "flexible_structure", "own_solver", "sweep"]), "python.md"]
BLOCK = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


# Another arithmetic path or build moves the last digits: by less than 1 %, or by one in the last decimal of rounded numbers.
TOLERANCE = 0.01
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w])")


class Broken(Exception):
    """A block did not do what the page says."""


def matches(expected, printed):
    """Whether `printed` is what a page shows: `...` is anything, numbers agree within 1 % or one in the last decimal.

    >>> matches("tip: 18.5 mm ... s", "tip: 18.4 mm at 0.2 s"), matches("tip: 18.5 mm", "tip: 18.2 mm")
    (True, False)
    >>> matches("load 216 N/m", "load 215 N/m"), matches("runs: 4", "runs: 3")
    (True, False)
    """
    parts = NUMBER.split(expected.strip())
    numbers = NUMBER.findall(expected)
    pattern = f"({NUMBER.pattern})".join(re.escape(part).replace(r"\.\.\.", ".*?") for part in parts)
    found = re.fullmatch(pattern, printed.strip(), re.DOTALL)
    if found is None:
        return False
    return all(map(agree, numbers, found.groups()))


def agree(shown, printed):
    """Whether a number that was printed is the one that is shown."""
    decimals = re.search(r"\.(\d+)$", shown)
    last = 10.0 ** -len(decimals.group(1)) if decimals else 0.0
    difference = abs(float(shown) - float(printed))
    # The last decimals of both are rounded.
    return difference <= max(TOLERANCE * abs(float(shown)), 1.001 * last)


def run_shell(code, fails):
    done = subprocess.run(
        ["bash", "-euc", code], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600
    )
    if (done.returncode != 0) != fails:
        raise Broken(f"exit code {done.returncode}:\n{code}\n{done.stdout}")
    return done.stdout


def run_python(code, names):
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, "<block>", "exec"), names)
    return printed.getvalue()


def run_page(page, folder):
    """The blocks of a page; their number."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    # The case that later pages use.
    earlier = folder.parent / "flexible_structure" / "dam_plate.toml"
    if earlier.is_file():
        shutil.copy(earlier, folder)
    names, printed, count = {"__name__": "tutorial"}, "", 0
    for language, options, code in BLOCK.findall(text):
        title = re.search(r'title="([^"]+)"', options)
        if title and title.group(1) == "output":
            if not matches(code, printed):
                raise Broken(f"the page says\n{code}\nprinted was\n{printed}")
        elif title:
            (folder / title.group(1)).write_text(code, encoding="utf-8")
        elif language == "sh":
            printed = run_shell(code, "fails" in options)
        elif language == "python":
            printed = run_python(code, names)
        else:
            continue
        count += 1
    return count


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keep", type=pathlib.Path)
    parser.add_argument("pages", nargs="*")
    arguments = parser.parse_args()
    program = tidelock.find_program()
    with contextlib.ExitStack() as stack:
        top = arguments.keep or pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))
        programs = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))
        (programs / "tidelock").symlink_to(program.resolve())
        os.environ["PATH"] = f"{programs}:{pathlib.Path(sys.executable).parent}:{os.environ['PATH']}"
        failed = 0
        for page in arguments.pages or PAGES:
            folder = top / pathlib.Path(page).stem
            folder.mkdir(parents=True)
            os.chdir(folder)
            begun = time.monotonic()
            try:
                count = run_page(page, folder)
            except Exception as error:  # noqa: BLE001
                failed += 1
                print(f"FAILED {page}: {type(error).__name__}: {error}", file=sys.stderr)
            else:
                print(f"{page}: {count} blocks, {time.monotonic() - begun:.1f} s", flush=True)
        os.chdir(ROOT)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
