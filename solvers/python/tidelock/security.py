"""Authentication and encryption: certificates and the access token. The options are those of the built-in servers."""

import hmac
import os
import pathlib
import sys

import grpc

ACCESS_KEY = "fsi-access"
# Is 1 if the first line of standard input is the access token.
ANNOUNCEMENT = "TIDELOCK_TOKEN_STDIN"
MAX_TOKEN_BYTES = 256
GUARDED = "/fsi.v2.Participant/"
LOOPBACK = ("127.", "localhost:", "[::1]:")


class Gate(grpc.ServerInterceptor):
    """Refuses calls of the control plane without the access token, without giving a reason."""

    def __init__(self, token: str):
        self.token = token.encode()
        # A handler of this kind waits for no message of the caller, whatever the call.
        self.refusal = grpc.stream_stream_rpc_method_handler(self._refuse)

    @staticmethod
    def _refuse(_requests, context):
        context.abort(grpc.StatusCode.PERMISSION_DENIED, "not allowed")

    def intercept_service(self, continuation, handler_call_details):
        """Accepts calls with the token; the peer stream has the run's own token."""
        given = dict(handler_call_details.invocation_metadata).get(ACCESS_KEY, "")
        guarded = handler_call_details.method.startswith(GUARDED)
        if guarded and not hmac.compare_digest(given.encode(), self.token):
            return self.refusal
        return continuation(handler_call_details)


class Security:
    """Credentials that a server presents and requires, from its command line."""

    @staticmethod
    def add_options(parser) -> None:
        """Adds the options."""
        parser.add_argument("--tls-cert", metavar="FILE", help="certificate chain of this server (PEM); it then speaks TLS only")
        parser.add_argument("--tls-key", metavar="FILE", help="private key of the certificate (PEM)")
        parser.add_argument("--tls-client-ca", metavar="FILE", help="demand a certificate signed by one of these (PEM) of everyone who calls")
        parser.add_argument("--token-file", metavar="FILE", help="demand the token in this file of every coordinator")
        parser.add_argument("--insecure", action="store_true", help="listen beyond this machine without certificate or token: "
                            "everyone who reaches the port can read along or use the server")

    def __init__(self, arguments):
        """Reads the files; raises ValueError with what is wrong."""
        given = arguments.tls_cert, arguments.tls_key
        if any(given) and not all(given) or arguments.tls_client_ca and not all(given):
            raise ValueError("--tls-cert, --tls-key: both are needed, also for --tls-client-ca")
        self.credentials, self.token = None, None
        if all(given):
            authority = _read(arguments.tls_client_ca) if arguments.tls_client_ca else None
            pair = _read(arguments.tls_key), _read(arguments.tls_cert)
            self.credentials = grpc.ssl_server_credentials([pair], authority, require_client_auth=authority is not None)
        if arguments.token_file:
            self.token = _token(f"--token-file {arguments.token_file}", _read(arguments.token_file))
        elif os.environ.get(ANNOUNCEMENT) == "1":
            # The rest of the input is ignored; its end means that the coordinator is gone.
            self.token = _token("the first line of standard input, the access token,", sys.stdin.buffer.readline(MAX_TOKEN_BYTES + 2))
        secured = self.credentials and self.token
        if not (arguments.listen.startswith(LOOPBACK) or secured or arguments.insecure):
            raise ValueError(f"--listen {arguments.listen} reaches beyond this machine, which needs --tls-cert, --tls-key and "
                             "--token-file; listen on 127.0.0.1, or add --insecure to accept that everyone who reaches the port "
                             "can read along or use the server")

    def interceptors(self) -> list:
        """Interceptors of the services."""
        return [Gate(self.token)] if self.token else []

    def listen(self, server, address: str) -> int:
        """Binds `server` to `address` and returns the port; RuntimeError if it is in use or the certificate is invalid."""
        if self.credentials:
            return server.add_secure_port(address, self.credentials)
        return server.add_insecure_port(address)


def _token(what: str, content: bytes) -> str:
    token = content.decode(errors="replace").strip()
    if not (16 <= len(token) <= MAX_TOKEN_BYTES and all("!" <= letter <= "~" for letter in token)):
        raise ValueError(f"{what}: must have 16 to {MAX_TOKEN_BYTES} printable ASCII characters")
    return token


def _read(path: str) -> bytes:
    try:
        return pathlib.Path(path).read_bytes()
    except OSError as error:
        raise ValueError(f"`{path}` cannot be read: {error}") from error
