"""A client of the Debug Adapter Protocol, as small as an editor's may be: requests with their responses, and events as they come."""
import json
import queue
import subprocess
import threading


class Refused(Exception):
    """The response says that it could not be done; its text is for people."""


class Client:
    SECONDS = 30

    def __init__(self, command, **options):
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)
        self.messages = queue.Queue()
        self.events = []  # And responses that nobody has waited for yet.
        self.sent, self.received = 0, 0
        self.errors = b""
        self.transcript = []  # Both ways.
        self.readers = [threading.Thread(target=target, daemon=True) for target in (self.read, self.read_errors)]
        for reader in self.readers:
            reader.start()

    # ---- the wire

    def read(self):
        stream = self.process.stdout
        while True:
            length = None
            while (line := stream.readline().strip()):
                name, _, value = line.partition(b":")
                if name.lower() == b"content-length":
                    length = int(value)
            if length is None:
                self.messages.put(None)
                return
            self.messages.put(json.loads(stream.read(length)))

    def read_errors(self):
        self.errors = self.process.stderr.read()

    def raw(self, data):
        self.process.stdin.write(data)
        self.process.stdin.flush()

    def framed(self, text):
        self.raw(b"Content-Length: %d\r\n\r\n%s" % (len(text), text))

    def next(self):
        message = self.messages.get(timeout=self.SECONDS)
        if message is None:
            raise EOFError(f"the adapter ended with {self.process.wait()}: {self.errors.decode()}")
        self.received += 1
        if message["seq"] != self.received:
            raise ValueError(f"message {self.received} has the number {message['seq']}")
        self.transcript.append(message)
        return message

    # ---- messages

    def send(self, command, arguments=None):
        """Without a wait for the response; returns the number of the request."""
        self.sent += 1
        message = {"seq": self.sent, "type": "request", "command": command}
        if arguments is not None:
            message["arguments"] = arguments
        self.transcript.append(message)
        self.framed(json.dumps(message).encode())
        return self.sent

    def response(self, number):
        found = [message for message in self.events if message.get("request_seq") == number]
        message = found[0] if found else self.next()
        while message.get("request_seq") != number:
            self.events.append(message)
            message = self.next()
        if not message["success"]:
            raise Refused(message["message"])
        return message.get("body")

    def ask(self, command, **arguments):
        return self.response(self.send(command, arguments))

    def event(self, name):
        """The body of the next event of this name."""
        for i, message in enumerate(self.events):
            if message.get("event") == name:
                return self.events.pop(i).get("body")
        while (message := self.next()).get("event") != name:
            self.events.append(message)
        return message.get("body")

    def take_events(self, name):
        """Those that have come so far."""
        found = [message["body"] for message in self.events if message.get("event") == name]
        self.events = [message for message in self.events if message.get("event") != name]
        return found

    # ---- a session

    def begin(self, configure=lambda: None, capabilities={}, **launch):
        """To the first stop, if there is one."""
        self.capabilities = self.ask("initialize", adapterID="meld", linesStartAt1=True, columnsStartAt1=True, pathFormat="path",
                                     **capabilities)
        self.ask("launch", **launch)
        self.event("initialized")
        configure()
        self.ask("configurationDone")
        return self.event("stopped") if launch.get("stopOnEntry", True) else None

    def go(self, command):
        """A move, to the stop behind it."""
        self.ask(command, threadId=1)
        return self.event("stopped")

    def evaluate(self, expression, context="watch"):
        return self.ask("evaluate", expression=expression, context=context)

    def type(self, line):
        return self.evaluate(line, "repl")["result"]

    def frames(self):
        return self.ask("stackTrace", threadId=1)["stackFrames"]

    def scopes(self, frame=1):
        return {scope["name"]: scope["variablesReference"] for scope in self.ask("scopes", frameId=frame)["scopes"]}

    def values(self, reference, **which):
        return {v["name"]: v for v in self.ask("variables", variablesReference=reference, **which)["variables"]}

    def leave(self):
        """Returns the exit code of the adapter."""
        self.ask("disconnect")
        return self.wait()

    def wait(self):
        return self.process.wait(timeout=self.SECONDS)

    def kill(self):
        self.process.kill()
        self.process.wait()
        for reader in self.readers:
            reader.join()
        for stream in (self.process.stdin, self.process.stdout, self.process.stderr):
            try:
                stream.close()
            except BrokenPipeError:
                pass
