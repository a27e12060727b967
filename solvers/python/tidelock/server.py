"""The services of participant.proto and peer.proto: life cycle, tokens, codes."""

import argparse
import hmac
import os
import queue
import signal
import stat
import sys
import threading
import time
from concurrent import futures

import grpc
import numpy as np

from . import protocol
from .driver import BEAT_SECONDS, NO_MORE, Run
from .security import Security
from .setup import Refused, Setup
from .vectors import TENSOR

MESSAGES, CODE = protocol.participant, grpc.StatusCode
MAX_STATUS_BYTES = 3500
KERNEL = "cubic-spline"


class Session:
    """The run that a server holds, from Open to Close."""

    def __init__(self, run_id: str, token: str, holder: str, solver):
        self.run_id, self.token, self.holder, self.solver = run_id, token, holder or "an unnamed coordinator", solver
        self.state, self.run, self.listens, self.exchanging = "OPEN", None, False, False
        self.opened = self.last_call = time.monotonic()

    def admits(self, context) -> bool:
        """Whether the caller carries the run's token."""
        given = dict(context.invocation_metadata()).get("fsi-token", "")
        return hmac.compare_digest(given.encode(), self.token.encode())


def _stop(context, code, text: str):
    """Ends a call with `code`; does not return."""
    context.abort(code, text.encode()[:MAX_STATUS_BYTES].decode(errors="ignore"))


class Server(protocol.participant_grpc.ParticipantServicer, protocol.peer_grpc.PeerServicer):
    """A server of one run at a time; `factory` creates the solver from a Setup."""

    def __init__(self, factory, lease: float):
        self.factory, self.lease, self.lock, self.session = factory, lease, threading.RLock(), None

    # Life cycle.

    def _admit(self, context, call: str, run_id: str, state: str | None = None) -> Session:
        session = self.session
        if session is None:
            _stop(context, CODE.FAILED_PRECONDITION, f"`{call}` is not allowed in state IDLE; expected: {state or 'a run that was opened'}")
        if session.run_id != run_id:
            _stop(context, CODE.FAILED_PRECONDITION, f"`{call}` is for run {run_id!r}; expected: the run that is open here")
        if not session.admits(context):
            _stop(context, CODE.PERMISSION_DENIED, "not allowed")
        session.last_call = time.monotonic()
        if state is not None and session.state != state:
            _stop(context, CODE.FAILED_PRECONDITION, f"`{call}` is not allowed in state {session.state}; expected: {state}")
        return session

    def _remove(self, session: Session) -> None:
        with self.lock:
            if self.session is session:
                self.session = None
        if session.run is not None:
            session.run.abort()

    def expire(self) -> None:
        """Closes a run that has been idle, or whose coordinator has granted no step, for the lease."""
        session = self.session
        if session is None:
            return
        asked = session.run.asked() if session.state == "RUNNING" else session.last_call
        if time.monotonic() - asked > self.lease:
            self._remove(session)

    def Describe(self, request, context):
        """What the solver is and can do."""
        described = MESSAGES.Description(
            name=self.factory.name, version=self.factory.version, language="python", dimensions=self.factory.dimensions,
            roles=[protocol.types.ROLE_SOLID], coupling_kinds=[protocol.types.COUPLING_KIND_LOADS],
            interface_laws=protocol.INTERFACE_LAWS,
            arithmetic=f"numpy {np.__version__}",
        )
        described.lowest_protocol.major, described.lowest_protocol.minor = protocol.MAJOR, 0
        described.highest_protocol.major, described.highest_protocol.minor = protocol.MAJOR, protocol.MINOR
        described.capabilities.deterministic = self.factory.deterministic
        described.capabilities.adaptive_step = True
        described.capabilities.exact_times = True
        described.capabilities.implicit_coupling = True
        limits = described.limits
        limits.runs, limits.lease_s = 1, self.lease
        limits.max_message_bytes, limits.max_frame_bytes = protocol.MAX_MESSAGE_BYTES, protocol.MAX_FRAME_BYTES
        return described

    def Open(self, request, context):
        """Builds the solver for a run."""
        if request.protocol.major != protocol.MAJOR:
            _stop(context, CODE.UNIMPLEMENTED, f"`open.protocol` is {request.protocol.major}.{request.protocol.minor}, "
                  f"this server speaks {protocol.MAJOR}.{protocol.MINOR}")
        token = request.token
        if not (16 <= len(token) <= 256 and all("!" <= letter <= "~" for letter in token)):
            _stop(context, CODE.INVALID_ARGUMENT, "`open.token`: must have 16 to 256 printable ASCII characters")
        if len(request.holder.encode()) > protocol.MAX_NAME_BYTES:
            _stop(context, CODE.INVALID_ARGUMENT, "`open.holder`: at most 256 bytes are allowed")
        if request.WhichOneof("setup") != "solid":
            _stop(context, CODE.INVALID_ARGUMENT, "`open.setup`: must be `solid`, this solver plays solids")
        run, offered = request.solid.run, self.factory.dimensions
        if run.dimensions not in offered:
            words = " or ".join(map(str, offered))
            _stop(context, CODE.INVALID_ARGUMENT, f"`open.solid.run.dimensions`: is {run.dimensions}, this solver computes in {words}")
        with self.lock:
            held = self.session
            if held is not None:
                _stop(context, CODE.RESOURCE_EXHAUSTED, f"busy: run `{held.run_id}` is held by {held.holder} for "
                      f"{time.monotonic() - held.opened:.0f} s, state {held.state}; one run at a time")
            try:
                solver = self.factory(Setup(request.solid))
            except Refused as refused:
                _stop(context, CODE.INVALID_ARGUMENT, str(refused))
            self.session = Session(request.solid.run.run_id, token, request.holder, solver)
            return self._open_reply(solver)

    def _open_reply(self, solver):
        setup, run = solver.setup, solver.setup.message.run
        reply = MESSAGES.OpenReply(
            run_id=setup.run_id, role=protocol.types.ROLE_SOLID, name=self.factory.name, version=self.factory.version,
            arithmetic=f"numpy {np.__version__}", coupling_kind=protocol.types.COUPLING_KIND_LOADS,
            time_step_limit_s=solver.time_step_limit(solver.state),
        )
        reply.protocol.major, reply.protocol.minor = protocol.MAJOR, protocol.MINOR
        constants = reply.constants
        constants.kernel = KERNEL
        # The values that the equations use, not an echo.
        constants.body_force.gravity_m_per_s2.CopyFrom(protocol.vector(setup.gravity))
        constants.domain.CopyFrom(run.domain)
        constants.time.CopyFrom(run.time)
        if setup.coupled:
            constants.coupling.CopyFrom(run.coupling)
            constants.coupling.solid_spacing_m = setup.spacing
            types = protocol.types
            dimensions = setup.dimensions
            for field, unit, count in [(types.FIELD_POSITION, "m", dimensions), (types.FIELD_VELOCITY, "m/s", dimensions),
                                       (types.FIELD_VOLUME, "m3", 1)]:
                reply.fields_sent.add(field=field, unit=unit, components=count)
            reply.fields_needed.add(field=types.FIELD_FORCE, unit="N", components=dimensions)
        position, _ = solver.kinematics(solver.state)
        box = np.concatenate([position.min(axis=0), position.max(axis=0)])
        reply.extent.boxes_m = box.astype("<f8").tobytes()
        reply.counts.particles = len(solver.ids)
        masses, inertias = solver.body_masses(), solver.body_inertias()
        for k in range(len(setup.bodies)):
            body = reply.bodies.add(mass_kg=masses[k])
            inertia = None if inertias is None else inertias[k]
            if inertia is not None and setup.dimensions == 3:
                body.inertia_tensor_kg_m2[:] = [inertia[place] for place in TENSOR]
            elif inertia is not None:
                body.inertia_kg_m2 = inertia
        reply.remarks.extend(solver.remarks())
        return reply

    def Link(self, request, context):
        """Stores the partner's extent and the first time-step limit."""
        with self.lock:
            session = self._admit(context, "Link", request.run_id, "OPEN")
            partner = request.WhichOneof("partner")
            wanted = "listen" if session.solver.setup.coupled else "alone"
            if partner != wanted:
                _stop(context, CODE.INVALID_ARGUMENT, f"`link.partner`: is {partner}, must be `{wanted}`")
            if not (request.HasField("first_limit_s") and request.first_limit_s > 0):
                _stop(context, CODE.INVALID_ARGUMENT, f"`link.first_limit_s`: is {request.first_limit_s}, must be positive")
            if partner == "listen" and not request.HasField("partner_extent"):
                _stop(context, CODE.INVALID_ARGUMENT, "`link.partner_extent`: is missing")
            session.run, session.listens, session.state = Run(session.solver, request), partner == "listen", "LINKED"
            return MESSAGES.LinkReply(run_id=request.run_id)

    def Close(self, request, context):
        """Ends the run, whatever its state."""
        with self.lock:
            session = self.session
            if session is None or session.run_id != request.run_id:
                return MESSAGES.CloseReply(closed=False)
            self._admit(context, "Close", request.run_id)
        self._remove(session)
        return MESSAGES.CloseReply(closed=True)

    def Checkpoint(self, request, context):
        """Not offered."""
        _stop(context, CODE.UNIMPLEMENTED, "`Checkpoint` needs the capability `checkpoint`, which this server does not offer")

    def Restore(self, request_iterator, context):
        """Not offered."""
        _stop(context, CODE.UNIMPLEMENTED, "`Restore` needs the capability `checkpoint`, which this server does not offer")

    # Streams.

    def Run(self, request_iterator, context):
        """Commands in, events out."""
        with self.lock:
            session = self._admit(context, "Run", self.session.run_id if self.session else "", "LINKED")
            session.state = "RUNNING"
        run, ended = session.run, threading.Event()

        def listen():
            try:
                for command in request_iterator:
                    if command.run_id == session.run_id and command.epoch == 0:
                        run.command(command)
            except grpc.RpcError:
                pass  # the coordinator is gone, which the callback sees
            if not ended.is_set():
                self._remove(session)

        context.send_initial_metadata(())
        context.add_callback(lambda: ended.is_set() or self._remove(session))
        threading.Thread(target=listen, daemon=True).start()
        threading.Thread(target=run.run, daemon=True).start()
        yield from self._events(session, run, context)
        ended.set()
        session.state, session.last_call = "ENDED", time.monotonic()

    def _events(self, session, run, context):
        next_beat = time.monotonic() + BEAT_SECONDS
        while True:
            try:
                event = run.events.get(timeout=max(next_beat - time.monotonic(), 0.01))
            except queue.Empty:
                event = run.beat()
            if event is NO_MORE:
                return
            if isinstance(event, Exception):
                self._remove(session)
                _stop(context, CODE.INTERNAL, f"the solver failed: {event!r}")
            batch = MESSAGES.EventBatch(run_id=session.run_id)
            batch.events.append(event)
            if time.monotonic() >= next_beat:
                batch.events.insert(0, run.beat())
                next_beat = time.monotonic() + BEAT_SECONDS
            yield batch

    def Snapshots(self, request, context):
        """Particle fields."""
        with self.lock:
            session = self._admit(context, "Snapshots", request.run_id, "LINKED")
            if session.run.wants_snapshots:
                _stop(context, CODE.FAILED_PRECONDITION, "`Snapshots` is open already; expected: one stream only")
            session.run.wants_snapshots = True
        # The stream's caller waits for headers before it starts the run.
        context.send_initial_metadata(())
        while (chunk := session.run.snapshots.get()) is not NO_MORE:
            yield chunk

    def Exchange(self, request_iterator, context):
        """Frames of the fluid in, own frames out."""
        with self.lock:
            session = self.session
            if session is None or not session.admits(context):
                _stop(context, CODE.PERMISSION_DENIED, "not allowed")
            if session.state not in ("LINKED", "RUNNING") or not session.listens or session.exchanging:
                _stop(context, CODE.FAILED_PRECONDITION, f"`Exchange` is not allowed in state {session.state}; "
                      "expected: a run linked to listen, one stream only")
            session.exchanging = True
        run = session.run
        context.send_initial_metadata(())

        def listen():
            try:
                for frame in request_iterator:
                    run.inbound.put(frame)
            except grpc.RpcError:
                pass  # a lost partner: reported by the end of the stream
            run.inbound.put(NO_MORE)

        threading.Thread(target=listen, daemon=True).start()
        while (frame := run.outbound.get()) is not NO_MORE:
            yield frame


class RefuseVersion1(grpc.GenericRpcHandler):
    """Answers every call of a coordinator of protocol 1 (VERSIONS of participant.proto)."""

    def service(self, details):
        """The handler of a call."""
        if not details.method.startswith("/fsi.v1.Participant/"):
            return None
        text = f"the call is of protocol 1, this server speaks {protocol.MAJOR}.{protocol.MINOR}: update the coordinator"
        return grpc.stream_stream_rpc_method_handler(lambda _, context: _stop(context, CODE.UNIMPLEMENTED, text))


def _arguments(factory):
    parser = argparse.ArgumentParser(description=factory.__doc__)
    parser.add_argument("--listen", metavar="ADDR", default="127.0.0.1:0", help="address to listen on; port 0 takes any free one")
    parser.add_argument("--lease", type=float, default=120.0, metavar="S", help="close an idle run after this many seconds")
    Security.add_options(parser)
    arguments = parser.parse_args()
    try:
        return arguments, Security(arguments)
    except ValueError as problem:
        parser.error(str(problem))


def main(factory) -> None:
    """Serves solvers of class `factory` as the command line says; prints `LISTEN <addr>` when ready."""
    arguments, security = _arguments(factory)
    servicer = Server(factory, arguments.lease)
    options = [
        ("grpc.max_receive_message_length", protocol.MAX_MESSAGE_BYTES), ("grpc.max_send_message_length", -1),
        # The coordinator's pings come more often than the library's default allows.
        ("grpc.http2.min_ping_interval_without_data_ms", 1000), ("grpc.keepalive_permit_without_calls", 1),
        ("grpc.http2.min_recv_ping_interval_without_data_ms", 1000), ("grpc.so_reuseport", 0),
        ("grpc.max_concurrent_streams", 64),
    ]
    server = grpc.server(futures.ThreadPoolExecutor(max_workers=16), options=options, interceptors=security.interceptors())
    protocol.participant_grpc.add_ParticipantServicer_to_server(servicer, server)
    protocol.peer_grpc.add_PeerServicer_to_server(servicer, server)
    server.add_generic_rpc_handlers((RefuseVersion1(),))
    try:
        port = security.listen(server, arguments.listen)
    except RuntimeError as error:
        print(f"error: cannot listen on {arguments.listen}: {error}; choose another port", file=sys.stderr)
        raise SystemExit(3) from error
    server.start()
    print(f"LISTEN {arguments.listen.rsplit(':', 1)[0]}:{port}", flush=True)
    ended = threading.Event()
    # Stays ignored if it was ignored at the start, as by nohup.
    hangup = () if signal.getsignal(signal.SIGHUP) == signal.SIG_IGN else (signal.SIGHUP,)
    # Started by a coordinator, which closes the pipe when the run is over. A batch system asks both to end: the coordinator
    # needs the server for a checkpoint then.
    has_parent = stat.S_ISFIFO(os.fstat(0).st_mode)
    decides = threading.Event()
    if not has_parent:
        decides.set()

    def asked_to_end(*_):
        if decides.is_set():
            ended.set()
        decides.set()

    for number in (signal.SIGTERM, signal.SIGINT, *hangup):
        signal.signal(number, asked_to_end)
    if has_parent:
        threading.Thread(target=lambda: (sys.stdin.buffer.read(), ended.set()), daemon=True).start()
    while not ended.wait(1.0):
        servicer.expire()
    server.stop(grace=0.5).wait()
    # Threads that still wait for a partner must not delay the exit.
    sys.stdout.flush()
    os._exit(0)
