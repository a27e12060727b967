"""Prints the licence texts of all libraries that are linked into the program, for those who pass the program on."""

import json
import pathlib
import re
import subprocess
import sys


def output(*words):
    return subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True).stdout


def linked():
    """Names and versions of the libraries that `tidelock` is made of, build tools apart."""
    tree = output(
        "cargo", "tree", "--locked", "--package", "coordinator", "--edges", "normal", "--prefix", "none"
    )
    return set(re.findall(r"^(\S+) v(\S+)", tree, re.MULTILINE))


def main():
    wanted = linked()
    packages = json.loads(output("cargo", "metadata", "--locked", "--format-version", "1"))["packages"]
    missing = []
    for package in sorted(packages, key=lambda package: (package["name"], package["version"])):
        key = (package["name"], package["version"])
        if key not in wanted or package["source"] is None:
            continue
        folder = pathlib.Path(package["manifest_path"]).parent
        texts = sorted(
            path for path in folder.iterdir() if re.match(r"(?i)(licen[cs]e|copying|notice)", path.name) and path.is_file()
        )
        print(f"{'=' * 78}\n{key[0]} {key[1]}: {package['license'] or 'see below'}\n{package['repository'] or ''}\n")
        for path in texts:
            print(f"--- {path.name}\n{path.read_text(errors='replace').strip()}\n")
        if not texts:
            missing.append(key[0])
            print(f"The package holds no text of its licence; by: {', '.join(package['authors'])}\n")
    if missing:
        print(f"without a text of their own: {', '.join(missing)}", file=sys.stderr)


if __name__ == "__main__":
    main()
