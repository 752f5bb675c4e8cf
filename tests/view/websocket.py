"""A client of the viewer's server: HTTP as browsers speak it, and WebSockets (RFC 6455) whose frames a test can also get wrong."""
import base64
import hashlib
import json
import os
import socket
import struct
import urllib.parse

TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10
KEY_END = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"


class Closed(Exception):
    """The server has ended the connection."""


def frame(opcode, payload, final=True, masked=True, reserved=0, length=None):
    """As a client sends it. `length` is what the header says instead of the truth."""
    length = len(payload) if length is None else length
    head = bytes([(0x80 if final else 0) | reserved << 4 | opcode])
    mask_bit = 0x80 if masked else 0
    if length < 126:
        head += bytes([mask_bit | length])
    elif length < 1 << 16:
        head += bytes([mask_bit | 126]) + struct.pack(">H", length)
    else:
        head += bytes([mask_bit | 127]) + struct.pack(">Q", length)
    if not masked:
        return head + payload
    mask = os.urandom(4)
    repeated = (mask * (len(payload) // 4 + 1))[:len(payload)]
    return head + mask + (int.from_bytes(payload, "big") ^ int.from_bytes(repeated, "big")).to_bytes(len(payload), "big")


def http(port, text, seconds=20):
    """Sends this and returns everything that comes until the connection ends."""
    with socket.create_connection(("127.0.0.1", port), timeout=seconds) as connection:
        connection.sendall(text)
        return read_all(connection)


def read_all(connection):
    out = b""
    try:
        while block := connection.recv(1 << 16):
            out += block
    except ConnectionResetError:
        pass
    return out


def get(port, path="/", host=None, **headers):
    """Status, headers and body of a GET."""
    lines = [f"GET {path} HTTP/1.1", f"Host: {host or f'127.0.0.1:{port}'}", *(f"{k.replace('_', '-')}: {v}" for k, v in headers.items())]
    return parse(http(port, "\r\n".join(lines).encode() + b"\r\n\r\n"))


def parse(answer):
    head, _, body = answer.partition(b"\r\n\r\n")
    first, *lines = head.decode().split("\r\n")
    found = {name.lower(): value.strip() for name, value in (line.split(":", 1) for line in lines)}
    return int(first.split()[1]) if first else 0, found, body


class Page:
    """What a page does: requests with numbers, their answers, and the news that come meanwhile."""

    def __init__(self, link, origin=None, host=None, token=None, path="/ws", receive_bytes=None, seconds=30):
        parts = urllib.parse.urlsplit(link)
        self.port = parts.port
        self.host = host or parts.netloc
        self.socket = socket.socket()
        if receive_bytes:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_bytes)
        self.socket.settimeout(seconds)
        self.socket.connect(("127.0.0.1", self.port))
        self.waiting, self.number, self.news = b"", 0, []
        try:
            self.open(link, origin, token, path)
        except BaseException:
            self.close()
            raise

    def open(self, link, origin, token, path):
        key = base64.b64encode(os.urandom(16))
        token = urllib.parse.urlsplit(link).query if token is None else f"token={token}"
        origin = f"http://{self.host}" if origin is None else origin
        lines = [f"GET {path}?{token} HTTP/1.1", f"Host: {self.host}", "Upgrade: websocket", "Connection: Upgrade",
                 f"Sec-WebSocket-Key: {key.decode()}", "Sec-WebSocket-Version: 13", *([f"Origin: {origin}"] if origin else [])]
        self.socket.sendall("\r\n".join(lines).encode() + b"\r\n\r\n")
        while b"\r\n\r\n" not in self.waiting:
            block = self.socket.recv(4096)
            if not block:
                raise Closed(self.waiting.decode())
            self.waiting += block
        head, _, self.waiting = self.waiting.partition(b"\r\n\r\n")
        self.status, headers, _ = parse(head)
        if self.status != 101:
            raise Closed(head.decode())
        assert headers["sec-websocket-accept"] == base64.b64encode(hashlib.sha1(key + KEY_END).digest()).decode()

    def close(self):
        self.socket.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def take(self, count):
        while len(self.waiting) < count:
            try:
                block = self.socket.recv(1 << 20)
            except ConnectionResetError:
                block = b""
            if not block:
                raise Closed()
            self.waiting += block
        taken, self.waiting = self.waiting[:count], self.waiting[count:]
        return taken

    def message(self):
        """The next one: text, or bytes. Pings are answered."""
        while True:
            first, second = self.take(2)
            assert first & 0x80 and not second & 0x80, "a server sends whole messages, unmasked"
            length = second & 127
            if length == 126:
                (length,) = struct.unpack(">H", self.take(2))
            elif length == 127:
                (length,) = struct.unpack(">Q", self.take(8))
            payload, opcode = self.take(length), first & 15
            if opcode == CLOSE:
                raise Closed(payload)
            if opcode == PING:
                self.socket.sendall(frame(PONG, payload))
            elif opcode in (TEXT, BINARY):
                return payload.decode() if opcode == TEXT else payload

    def send(self, what, **fields):
        """A request, whose number is returned."""
        self.number += 1
        self.socket.sendall(frame(TEXT, json.dumps({"id": self.number, "do": what, **fields}).encode()))
        return self.number

    def answer(self, number):
        """To this request, with its bytes, if there are any."""
        while True:
            said = json.loads(self.message())
            if "event" in said:
                self.news.append(said)
            elif said["id"] == number:
                return said, self.message() if said.get("binary") else None

    def ask(self, what, **fields):
        return self.answer(self.send(what, **fields))

    def event(self, name):
        """The next news of this kind; others are kept."""
        while True:
            for i, said in enumerate(self.news):
                if said["event"] == name:
                    return self.news.pop(i)
            said = json.loads(self.message())
            assert "event" in said, said
            self.news.append(said)
