"""One session with the language server: JSON-RPC over its standard input and output."""

import json
import pathlib
import queue
import subprocess
import threading
import urllib.parse


def uri(path):
    return "file://" + urllib.parse.quote(str(path))


def path_of(address):
    return pathlib.Path(urllib.parse.unquote(urllib.parse.urlparse(address).path))


class Session:
    SECONDS = 30

    def __init__(self, command, environment=None):
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment)
        self.messages = queue.Queue()
        self.diagnostics = {}
        self.versions = {}
        self.shown = []
        self.last = 0
        self.errors = b""
        threading.Thread(target=self.read, daemon=True).start()
        threading.Thread(target=self.read_errors, daemon=True).start()

    # ---- the wire

    def read(self):
        stream = self.process.stdout
        while True:
            length = None
            while (line := stream.readline().strip()):
                if line.lower().startswith(b"content-length:"):
                    length = int(line.split(b":")[1])
            if length is None:
                self.messages.put(None)
                return
            self.messages.put(json.loads(stream.read(length)))

    def read_errors(self):
        self.errors = self.process.stderr.read()

    def raw(self, data):
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(data), data))
        self.process.stdin.flush()

    def send(self, **message):
        self.raw(json.dumps({"jsonrpc": "2.0", **message}).encode())

    def next(self):
        message = self.messages.get(timeout=self.SECONDS)
        if message is None:
            raise EOFError(f"the server ended with {self.process.wait()}: {self.errors.decode()}")
        if message.get("method") == "textDocument/publishDiagnostics":
            self.diagnostics[path_of(message["params"]["uri"]).name] = message["params"]["diagnostics"]
            self.versions[path_of(message["params"]["uri"]).name] = message["params"]["version"]
        if message.get("method") == "window/showMessage":
            self.shown.append(message["params"])
        return message

    def notify(self, method, params=None):
        self.send(method=method, params=params if params is not None else {})

    def answer(self, method, params=None):
        """The whole answer to a request, result or error."""
        self.last += 1
        self.send(id=self.last, method=method, params=params if params is not None else {})
        while (message := self.next()).get("id") != self.last:
            pass
        return message

    def ask(self, method, params=None):
        message = self.answer(method, params)
        if "error" in message:
            raise RuntimeError(message["error"]["message"])
        return message["result"]

    # ---- the protocol

    def start(self, **more):
        result = self.ask("initialize", {"processId": None, "rootUri": None, "capabilities": {}, **more})
        self.notify("initialized")
        return result

    def open(self, path, text, version=1):
        self.notify("textDocument/didOpen", {"textDocument": {"uri": uri(path), "languageId": "meld", "version": version, "text": text}})
        return self.told(path, version)

    def change(self, path, version, *changes):
        self.notify("textDocument/didChange", {"textDocument": {"uri": uri(path), "version": version}, "contentChanges": list(changes)})
        return self.told(path, version)

    def told(self, path, version):
        """Waits for the diagnostics of this version."""
        while self.versions.get(pathlib.Path(path).name) != version:
            self.next()
        return self.diagnostics[pathlib.Path(path).name]

    def about(self, method, path, line, character, **more):
        return self.ask("textDocument/" + method,
                        {"textDocument": {"uri": uri(path)}, "position": {"line": line, "character": character}, **more})

    def end(self):
        """Says goodbye; returns the exit code."""
        self.ask("shutdown")
        self.notify("exit")
        return self.process.wait(timeout=self.SECONDS)

    def kill(self):
        self.process.kill()
        self.process.wait()
        for stream in (self.process.stdin, self.process.stdout, self.process.stderr):
            try:
                stream.close()
            except BrokenPipeError:
                pass
