"""The messages and services of package fsi.v2, generated from the .proto files at the first start.

The files are found in the installed package, in a checkout in its `proto/proto`, or where the environment variable
TIDELOCK_PROTO points. The stubs are stored next to this file, or in the system's temporary folder if that is read-only,
under the digest of the files from which they were generated, so that they are never out of date.
"""

import hashlib
import importlib
import os
import pathlib
import sys
import tempfile

from .vectors import axial, lifted

HERE = pathlib.Path(__file__).resolve().parent
NAMES = ["types", "setup", "peer", "participant"]


def proto_folder() -> pathlib.Path:
    """The folder that holds fsi/v2."""
    places = [HERE / "proto", HERE.parents[2] / "proto" / "proto"]
    own = next((place for place in places if place.is_dir()), places[-1])
    folder = pathlib.Path(os.environ.get("TIDELOCK_PROTO", own))
    if not (folder / "fsi" / "v2" / "participant.proto").is_file():
        raise SystemExit(f"no fsi/v2/participant.proto in {folder}: set TIDELOCK_PROTO to the folder that holds fsi/")
    return folder


def _generate(sources: pathlib.Path, target: pathlib.Path) -> None:
    from grpc_tools import protoc

    files = [str(sources / "fsi" / "v2" / f"{name}.proto") for name in NAMES]
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent) as made:
        out = [f"--python_out={made}", f"--grpc_python_out={made}"]
        if protoc.main(["protoc", f"-I{sources}", *out, *files]) != 0:
            raise SystemExit(f"protoc cannot read the files in {sources}")
        whole = pathlib.Path(made) / "whole"
        whole.mkdir()
        (pathlib.Path(made) / "fsi").rename(whole / "fsi")
        try:
            whole.rename(target)
        except OSError:
            if not target.is_dir():  # else another start was faster
                raise


def _stubs() -> pathlib.Path:
    sources = proto_folder()
    digest = hashlib.sha256(sys.version.encode())
    for name in NAMES:
        digest.update((sources / "fsi" / "v2" / f"{name}.proto").read_bytes())
    folder = HERE if os.access(HERE, os.W_OK) else pathlib.Path(tempfile.gettempdir()) / f"tidelock-{os.getuid()}"
    target = folder / "_generated" / digest.hexdigest()[:16]
    if not target.is_dir():
        _generate(sources, target)
    return target


sys.path.insert(0, str(_stubs()))
types, setup, peer, participant = (importlib.import_module(f"fsi.v2.{name}_pb2") for name in NAMES)
peer_grpc, participant_grpc = (importlib.import_module(f"fsi.v2.{name}_pb2_grpc") for name in NAMES[2:])

# Version of the files above; see ProtocolVersion.
MAJOR, MINOR = 2, 0
# Interface laws that go with force coupling.
INTERFACE_LAWS = [setup.INTERFACE_LAW_WALL, setup.INTERFACE_LAW_WALL_NO_SLIP]
# Limits of the protocol: bytes of a message on either plane, of a name, of a text.
MAX_MESSAGE_BYTES = 256 << 20
MAX_FRAME_BYTES = 64 << 20
MAX_NAME_BYTES = 256
MAX_TEXT_BYTES = 4096


def vector(values):
    """A Vector message of `values`."""
    return types.Vector(components=[float(value) for value in values])


def torque(value):
    """The Vector message of a torque or angular momentum in sums; a number is one about z."""
    return vector(axial(value))


def force(values):
    """The Vector message of a force or momentum in sums."""
    return vector(lifted(values))
