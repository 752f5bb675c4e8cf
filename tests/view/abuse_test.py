"""meldsim view: whoever does not belong there gets nothing, and nobody makes its server stop, hang or grow.

    abuse_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import os
import pathlib
import random
import socket
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import main  # noqa: E402
from viewing import Viewing  # noqa: E402
from websocket import BINARY, CLOSE, PING, TEXT, Closed, Page, frame, get, http, parse  # noqa: E402

MANY_PAGES = 12


class Strangers(Viewing):
    def setUp(self):
        super().setUp()
        self.link = self.view("p.meld")
        self.at = self.port(self.link)
        self.query = "/" + self.link.split("/")[-1]

    def tearDown(self):
        # After all of it the server serves, and ends well.
        with Page(self.link) as page:
            self.assertTrue(page.ask("hello")[0]["ok"])
        self.interrupt()

    def test_nobody_comes_in_without_the_token(self):
        token = self.link.split("=")[1]
        for path in ("/", "/?token=", "/?token=" + "0" * 32, "/?token=" + token[:-1], f"/?token={token}0", f"/?x=1&token={token}",
                     "/index.html", "/ws"):
            status, headers, body = get(self.at, path)
            self.assertEqual(status, 403, path)
            self.assertIn(b"Open the link that this one has printed", body)
            self.assertNotIn(token.encode(), body)
            self.assertEqual(headers["cache-control"], "no-store")
        for token in ("", "0" * 32, token[:-1]):
            with self.assertRaisesRegex(Closed, "403"):
                Page(self.link, token=token)

    def test_no_other_name_or_page_leads_here(self):
        for host in ("example.org", f"example.org:{self.at}", f"127.0.0.1.example.org:{self.at}", "localhost.example.org", "localhost:",
                     "localhost:8080x", "localhost:1234567", "localhost:80@example.org", "127.0.0.1; ws://example.org",
                     "example.org:127.0.0.1", "127.0.0.2", "localhosts", "0.0.0.0", "[::]", "[::1", ""):
            status, _, body = get(self.at, self.query, host=host or " ")
            self.assertIn(status, (400, 403), host)
            if status == 403:
                self.assertIn(f"ssh -L 8080:127.0.0.1:{self.at} HOST", body.decode())
                self.assertNotIn(self.query.split("=")[1], body.decode())
        # Through ssh the page may come from any port here.
        for host in (f"localhost:{self.at}", f"localhost:{self.at + 1}", "localhost:9999", "localhost", "127.0.0.1:9999", "127.0.0.1",
                     "[::1]:9999"):
            status, headers, _ = get(self.at, self.query, host=host)
            self.assertEqual(status, 200, host)
            self.assertIn(f"connect-src 'self' ws://{host};", headers["content-security-policy"])
            with Page(self.link, host=host) as page:
                self.assertTrue(page.ask("hello")[0]["ok"])
            with self.assertRaisesRegex(Closed, "403"):
                Page(self.link, host=host, origin="http://localhost:1")
        for origin in ("http://example.org", "null", f"https://127.0.0.1:{self.at}", f"http://127.0.0.1:{self.at + 1}", ""):
            with self.assertRaisesRegex(Closed, "403"):
                Page(self.link, origin=origin)
        self.assertEqual(get(self.at, self.query, Origin="http://example.org")[0], 403)
        Page(self.link, host=f"localhost:{self.at}").close()

    def test_only_pages_of_this_machine_frame_it_and_only_if_they_may(self):
        def policy(link):
            status, headers, _ = get(self.port(link), "/" + link.split("/")[-1])
            self.assertEqual(status, 200)
            (frame,) = [part.strip() for part in headers["content-security-policy"].split(";") if "frame-ancestors" in part]
            return frame, headers.get("x-frame-options")

        self.assertEqual(policy(self.link), ("frame-ancestors 'none'", "DENY"))
        mine = self.process
        link = self.view("p.meld", "--framed")
        frame, old = policy(link)
        self.assertIsNone(old)
        for ancestor in frame.split()[1:]:
            self.assertRegex(ancestor, r"\Ahttps?://(localhost|127\.0\.0\.1):\*\Z")
        # What is refused is not shown in a frame either, and the secret is as secret.
        status, headers, _ = get(self.port(link), "/?token=" + "0" * 32)
        self.assertEqual((status, headers["x-frame-options"]), (403, "DENY"))
        with self.assertRaisesRegex(Closed, "403"):
            Page(link, origin="http://localhost:8888")
        self.interrupt()
        self.process = mine

    def test_there_is_one_path(self):
        secret = self.write("secret.txt", "secret")
        for path in ("/secret.txt", "/../secret.txt", "/%2e%2e/secret.txt", f"/{secret}", "//etc/passwd", "/..", "/./", "/%2f",
                     "/ws/", "/ws/x", "/ws", "/p.meld"):
            status, _, body = get(self.at, path.replace(" ", "%20") + self.query[1:])
            self.assertIn(status, (400, 403, 404), path)
            self.assertNotIn(b"secret", body)
        for method in ("POST", "PUT", "DELETE", "HEAD", "OPTIONS", "TRACE", "PROPFIND", "X"):
            text = f"{method} {self.query} HTTP/1.1\r\nHost: 127.0.0.1:{self.at}\r\nContent-Length: 0\r\n\r\n"
            self.assertIn(parse(http(self.at, text.encode()))[0], (0, 400, 405, 501), method)

    def test_requests_have_limits(self):
        start = f"GET {self.query} HTTP/1.1\r\nHost: 127.0.0.1:{self.at}\r\n".encode()
        before = self.resident_bytes()
        for text in (start + b"A: " + b"a" * 100_000 + b"\r\n\r\n", start + b"A: b\r\n" * 10_000 + b"\r\n",
                     b"GET /" + b"a" * 1_000_000 + b" HTTP/1.1\r\n\r\n", b"\0" * 10_000, os.urandom(5000) + b"\r\n\r\n", b"\r\n\r\n"):
            try:
                status = parse(http(self.at, text))[0]
            except ConnectionError:
                status = 0
            self.assertIn(status, (0, 400, 403, 413, 414, 431), text[:60])
        self.assertLess(self.resident_bytes() - before, 20e6)

    def test_frames_that_are_wrong_end_the_connection(self):
        fine = json.dumps({"id": 1, "do": "hello"}).encode()
        for wrong in (frame(BINARY, fine), frame(TEXT, fine, reserved=1), frame(0, fine), frame(TEXT, b""), frame(7, fine),
                      frame(TEXT, fine[:5], final=False) + frame(TEXT, fine[5:]), frame(TEXT, b" " * (1 << 20) + fine),
                      frame(TEXT, b"x", length=1 << 62), frame(TEXT, b"x", length=(1 << 63) + 5), frame(CLOSE, b"")):
            page = self.page(self.link)
            page.socket.sendall(wrong)
            page.socket.shutdown(socket.SHUT_WR)
            with self.assertRaises(Closed):
                while True:
                    page.message()
        # In several frames, with others between them, it is a message.
        page = self.page(self.link)
        page.socket.sendall(frame(TEXT, fine[:5], final=False) + frame(PING, b"") + frame(0, fine[5:]))
        self.assertTrue(page.answer(1)[0]["ok"])

    def test_requests_that_are_wrong_are_answered(self):
        page = self.page(self.link)
        texts = [b"nonsense", b"[]", b"7", b"null", b'""', b"{}", b'{"do": 7}', b'{"do": "frame", "tick": 1e300}',
                 b'{"do": "frame", "tick": -1}',
                 b'{"do": "nothing"}', b'{"do": "command"}', b'{"do": "command", "line": ["a"]}', b'{"do": "play", "speed": -1}',
                 b'{"do": "hello", "run": 1}',
                 b'{"do": "image", "size": [1e9, 1e9]}', b'{"do": "world-check", "toml": 3}', b'{"do": "hello", "run": "x"}',
                 b'{"do": "frame", "tick": 99999999999999999999}', b"\xff\xfe", b'{"id": ' + b"[" * 200_000 + b"]" * 200_000 + b"}",
                 b'{"do": "frame", "look": {"a": ' + b'{"a": ' * 50_000 + b"1" + b"}" * 50_000 + b"}}"]
        for text in texts:
            page.socket.sendall(frame(TEXT, text))
            said = json.loads(page.message())
            self.assertFalse(said["ok"], text[:60])
            self.assertTrue(said["error"]["message"], text[:60])
        page.socket.sendall(frame(TEXT, b'{"do": "frme"}'))
        self.assertEqual(json.loads(page.message())["error"]["message"], 'there is no request "frme"')
        dice = random.Random(1)
        for _ in range(300):
            text = bytearray(json.dumps({"do": "frame", "look": {"colour": "p(A, N)"}, "tick": 3}).encode())
            for _ in range(dice.randrange(1, 4)):
                text[dice.randrange(len(text))] = dice.randrange(32, 127)
            page.socket.sendall(frame(TEXT, bytes(text)))
            while "event" in (said := json.loads(page.message())):
                pass
            if said.get("binary"):
                page.message()

    def test_those_who_say_nothing_keep_nobody_out(self):
        before = self.resident_bytes()
        idle = [socket.create_connection(("127.0.0.1", self.at)) for _ in range(100)]
        for i, connection in enumerate(idle):
            connection.sendall((b"", b"GET / HT", f"GET {self.query} HTTP/1.1\r\nHost: x\r\n".encode())[i % 3])
        # Most leave again; the others have more connections than there are threads.
        for connection in idle[30:]:
            connection.close()
        begun = time.monotonic()
        # They have some seconds, as many at once as there are threads for.
        self.assertEqual(parse(http(self.at, f"GET {self.query} HTTP/1.1\r\nHost: 127.0.0.1:{self.at}\r\n\r\n".encode(), 60))[0], 200)
        self.assertLess(time.monotonic() - begun, 30)
        self.assertLess(self.resident_bytes() - before, 50e6)
        for connection in idle[:30]:
            connection.close()

    def test_so_many_pages_and_no_more(self):
        pages = [self.page(self.link) for _ in range(MANY_PAGES)]
        with self.assertRaises(Closed):
            Page(self.link)
        for page in pages:
            self.assertTrue(page.ask("hello")[0]["ok"])
        for page in pages:
            page.close()
        deadline = time.monotonic() + 10
        while time.monotonic() < deadline:
            try:
                Page(self.link).close()
                break
            except Closed:
                time.sleep(0.05)


class Readers(Viewing):
    def test_a_page_that_does_not_read_costs_little(self):
        self.write("large.toml", 'lattice = "cubic"\n[[body]]\nshape = "box(60, 60, 60)"\n')
        link = self.view("p.meld", "--world", "large.toml")
        fast, slow = self.page(link), self.page(link, receive_bytes=4096)
        size = len(fast.ask("frame")[1])
        self.assertGreater(size, 5e6)
        before = self.resident_bytes()
        fast.ask("play", speed=0)
        for _ in range(20):
            slow.send("frame")
        slow.socket.settimeout(0.01)
        most = 0
        for _ in range(25):
            fast.ask("frame")
            most = max(most, self.resident_bytes() - before)
        # One frame waits for it, and while one is made there may be two more.
        self.assertLess(most, 6 * size)
        # Nothing that it has missed stops others, or the end.
        slow.send("interrupt")
        self.assertLess(self.interrupt(), 5)

    def test_many_requests_at_once_wait_in_the_connection(self):
        link = self.view("p.meld")
        page = self.page(link)
        page.ask("hello")
        before = self.resident_bytes()
        page.socket.settimeout(0.5)
        request, sent = frame(TEXT, json.dumps({"id": 1, "do": "command", "line": "facts"}).encode()), 0
        try:
            while sent < 200_000:
                page.socket.sendall(request * 100)
                sent += 100
        except TimeoutError:
            pass
        self.assertLess(self.resident_bytes() - before, 60e6)
        other = self.page(link)
        self.assertTrue(other.ask("hello")[0]["ok"])


if __name__ == "__main__":
    main("meldc", "meldsim")
