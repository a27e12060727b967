"""Builds the wheel: maturin's backend, with the .proto files inside the package.

The files belong to the crate `proto`; maturin follows no links and cannot move files that it includes.
"""

import contextlib
import pathlib
import shutil

import maturin
from maturin import (  # noqa: F401
    build_sdist,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

HERE = pathlib.Path(__file__).resolve().parent
FROM, TO = HERE.parents[1] / "proto" / "proto", HERE / "tidelock" / "proto"


@contextlib.contextmanager
def protocol():
    """The .proto files in the package, for as long as the wheel is built."""
    shutil.copytree(FROM, TO, dirs_exist_ok=True)
    try:
        yield
    finally:
        shutil.rmtree(TO)


def build_wheel(*arguments, **named):
    with protocol():
        return maturin.build_wheel(*arguments, **named)


# An editable install uses the checkout's own files.
build_editable = maturin.build_editable
