"""The version of the package, which is that of the program it comes with."""

import importlib.metadata


def _version() -> str:
    try:
        return importlib.metadata.version("tidelock")
    except importlib.metadata.PackageNotFoundError:
        # Imported from a checkout that is not installed.
        return "0.0.0+checkout"


__version__ = _version()
