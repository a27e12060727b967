"""Runs the notebooks of docs/notebooks as written; a cell that fails ends the program with its error."""

import pathlib
import sys

import nbclient
import nbformat

FOLDER = pathlib.Path(__file__).resolve().parents[1] / "notebooks"


def main():
    paths = sorted(FOLDER.glob("*.ipynb"))
    for path in paths:
        notebook = nbformat.read(path, as_version=4)
        nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3").execute()
        pictures = sum("image/png" in o.get("data", {}) for cell in notebook.cells for o in cell.get("outputs", []))
        # A notebook that shows nothing has lost its plots.
        assert pictures, f"{path.name} shows no picture"
        print(f"{path.name}: {len(notebook.cells)} cells, {pictures} pictures")
    return 0 if paths else 1


if __name__ == "__main__":
    sys.exit(main())
