"""What an editor gets from a language server for a case file: completion, explanation, mistakes."""

import json
import subprocess


class Server:
    """A language server, spoken to over its standard streams."""

    def __init__(self, words, folder):
        self.folder = folder.resolve().as_uri()
        self.process = subprocess.Popen(
            words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        self.asked = 0
        abilities = {
            "hover": {"contentFormat": ["markdown"]},
            "completion": {"completionItem": {"snippetSupport": True}},
        }
        self.ask(
            "initialize",
            {"processId": None, "rootUri": self.folder, "capabilities": {"textDocument": abilities}},
        )
        self.send({"method": "initialized", "params": {}})

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()

    def send(self, message):
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        self.process.stdin.flush()

    def receive(self, wanted):
        """The first message that is `wanted`; questions of the server are answered on the way."""
        while True:
            length = 0
            while line := self.process.stdout.readline().strip():
                if line.lower().startswith(b"content-length:"):
                    length = int(line.split(b":")[1])
            message = json.loads(self.process.stdout.read(length))
            if "id" in message and "method" in message:
                folders = [{"uri": self.folder, "name": "cases"}]
                answer = folders if message["method"] == "workspace/workspaceFolders" else None
                self.send({"id": message["id"], "result": answer})
            elif wanted(message):
                return message

    def ask(self, method, params):
        self.asked += 1
        number = self.asked
        self.send({"id": number, "method": method, "params": params})
        return self.receive(lambda message: message.get("id") == number).get("result")

    def open(self, name, text):
        """Opens `text` under `name`; address and what the server finds wrong."""
        address = f"{self.folder}/{name}"
        document = {"uri": address, "languageId": "toml", "version": 1, "text": text}
        self.send({"method": "textDocument/didOpen", "params": {"textDocument": document}})
        # What it says of other documents may come late.
        found = self.receive(
            lambda message: message.get("method") == "textDocument/publishDiagnostics"
            and message["params"]["uri"] == address
        )
        return address, [mistake["message"] for mistake in found["params"]["diagnostics"]]

    def at(self, method, address, line, character):
        """Completion or explanation at a place."""
        place = {"line": line, "character": character}
        return self.ask(f"textDocument/{method}", {"textDocument": {"uri": address}, "position": place})


CASE = """#:schema case.schema.json
name = "tank"
[time]
end_time_s = 1.0

[[wall]]
name = "tank"
type = "solid"
shape = { type = "circle", centre_m = [0.0, 0.0], radius_m = 0.5 }
"""


def failures(words, folder):
    """What the server `words` does not do for a case in `folder`, where the schema is."""
    lacking = []
    with Server(words, folder) as server:
        address, _ = server.open("editor.toml", CASE)
        labels = {item["label"] for item in server.at("completion", address, 4, 0)}
        if not {"start_time_s", "step", "limit_factor"} <= labels:
            lacking.append(f"completes [time] by {sorted(labels)}")
        for line, character, words_meant in [
            (3, 2, ["end of the run", "Unit: s", "Default: must be written", "Range: a finite number"]),
            (8, 54, ["radius", "Unit: m", "a number above 0"]),
        ]:
            text = str((server.at("hover", address, line, character) or {}).get("contents"))
            lacking += [f"does not explain `{word}`: {text}" for word in words_meant if word not in text]
        _, mistakes = server.open("wrong.toml", CASE.replace("end_time_s", "end_tme_s"))
        if not any("end_tme_s" in mistake for mistake in mistakes):
            lacking.append(f"finds {mistakes} in place of `end_tme_s`")
    return lacking
