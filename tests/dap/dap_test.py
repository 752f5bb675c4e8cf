"""`meldsim debug --dap` as an editor meets it: whole sessions, moves that take long, programs that fail, and messages that are none.

    dap_test.py --meldc PATH --meldsim PATH [--record] [unittest options]

The client is that of client.py. Sessions in the folder `sessions` are requests with the messages that came between them; they are made
again and compared. --record writes them anew.
"""
import json
import os
import random
import re
import signal
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(ROOT / "tests"))
sys.path.insert(0, str(HERE))

import frame  # noqa: E402
from client import Client, Refused  # noqa: E402
from frame import OPEN_MPI, TOOLS, environment_with, main, square  # noqa: E402

GRADIENT = ROOT / "examples/meld/gradient.meld"
CHAIN = """\
type dist(node, min int D).
type near(node, int).
type source(node).
type linear token(node, int).

source(@0).
token(@0, 3).

dist(A, 0) :- source(A).
dist(B, D + 1) :-
    neighbor(A, B),
    dist(A, D).
near(A, D) :- dist(A, D), D < 3.

token(A, N), N > 0 -o token(A, N - 1).
"""
LINE = 'lattice = "square"\n[[body]]\nshape = "box(6, 1, 1)"\n'
FOREVER = "type p(node, int).\ntype q(node, int).\np(A, N) :- tick(A, N).\nq(A, N) :- p(A, N), N > 1000000000.\n"
FAILS = "type n(node, int).\nn(A, 10 / (4 - T)) :- tick(A, T).\n" \
    "type action setColor(node, int, int, int).\nsetColor(A, N, 0, 0) :- n(A, N).\n"


class DapTest(frame.Case):
    FILES = {"chain.meld": CHAIN, "chain.toml": LINE, "forever.meld": FOREVER, "forever.toml": square(2)}

    def client(self, **environment):
        client = Client([TOOLS.meldsim, "debug", "--dap"], cwd=self.folder, env=environment_with({**OPEN_MPI, **environment}))
        self.addCleanup(client.kill)
        return client

    def begin(self, program="chain.meld", **more):
        client = self.client()
        more.setdefault("capabilities", {"supportsInvalidatedEvent": True})
        self.entry = client.begin(program=str(self.folder / program), **more)
        return client

    def lines(self, client, *lines, file="chain.meld", **more):
        asked = [{"line": n, **more} for n in lines]
        return client.ask("setBreakpoints", source={"path": str(self.folder / file)}, breakpoints=asked)["breakpoints"]

    def refused(self, says, call, *arguments, **more):
        with self.assertRaisesRegex(Refused, says):
            call(*arguments, **more)


class Sessions(DapTest):
    def test_there_and_back(self):
        for processes in (1, 2):
            c = self.begin(processes=processes, ticks=20)
            self.assertEqual(self.entry["reason"], "entry")
            seen = {}
            for tick in range(1, 5):
                self.assertEqual(c.go("next")["description"], f"tick {tick}")
                scopes = c.scopes()
                run = c.values(scopes["Run"])
                self.assertEqual((run["tick"]["value"], run["catom"]["value"], run["catoms"]["value"]), (str(tick), "@0", "6"))
                seen[tick] = (run["digest"]["value"], {n: v["value"] for n, v in c.values(scopes["@0"]).items()})
            self.assertEqual(seen[4][1]["dist"], "dist(@0, 0)")
            for tick in (3, 2):
                self.assertEqual(c.go("stepBack")["description"], f"tick {tick}")
                scopes = c.scopes()
                self.assertEqual((c.values(scopes["Run"])["digest"]["value"],
                                  {n: v["value"] for n, v in c.values(scopes["@0"]).items()}), seen[tick])
            self.assertEqual(c.go("continue")["description"], "nothing is left to do")
            self.assertEqual(c.go("reverseContinue")["description"], "tick 0")
            self.assertEqual(c.go("stepBack")["description"], "back 1: this is tick 0, and the first is 0")
            self.assertEqual(c.leave(), 0)

    def test_a_derivation_is_the_stack(self):
        c = self.begin(catom=3)
        c.go("continue")
        stack = [(f["name"], f["line"], f.get("source", {}).get("path")) for f in c.frames()]
        path = str(self.folder / "chain.meld")
        self.assertEqual(stack, [("dist(@3, 3)", 10, path), ("dist(@2, 2)", 10, path), ("dist(@1, 1)", 10, path),
                                 ("dist(@0, 0)", 9, path), ("source(@0)", 6, path), ("tick 7", 0, None)])
        rests = c.values(c.scopes(1)["Rests on"])
        self.assertEqual((rests["neighbor"]["value"], rests["neighbor"]["variablesReference"]), ("neighbor(@2, @3)  sensed", 0))
        below = c.values(rests["dist"]["variablesReference"])
        self.assertEqual(below["dist"]["value"], "dist(@1, 1)")
        self.assertEqual(below["dist"]["evaluateName"], "dist(@1, 1)")
        # What was asked for in the console, of another catom.
        self.assertIn("chain.meld:13", c.type("why near(@2, _)"))
        self.assertEqual(c.event("invalidated"), {"areas": ["all"]})
        self.assertEqual([f["name"] for f in c.frames()][:2], ["near(@2, 2)", "dist(@2, 2)"])
        part = c.ask("stackTrace", threadId=1, startFrame=1, levels=1)
        self.assertEqual([f["name"] for f in part["stackFrames"]], ["dist(@2, 2)"])
        self.assertGreater(part["totalFrames"], 3)

    def test_the_chosen_catom(self):
        c = self.begin()
        c.go("continue")
        self.assertIn("dist(@5, 5).", c.type("@5"))
        c.event("invalidated")
        self.assertEqual(c.values(c.scopes()["@5"])["dist"]["value"], "dist(@5, 5)")
        self.assertEqual(c.ask("claymeld/catom", catom=1), {"catom": 1, "facts": ["dist(@1, 1).", "near(@1, 1)."]})
        run = c.scopes()["Run"]
        self.assertEqual(c.ask("setVariable", variablesReference=run, name="catom", value="2"), {"value": "@2"})
        self.assertIn("@2", c.scopes())
        self.refused("no catom @77", c.type, "@77")
        run = c.scopes()["Run"]
        self.refused("cannot be changed", c.ask, "setVariable", variablesReference=run, name="tick", value="3")
        self.refused("is no catom", c.ask, "setVariable", variablesReference=run, name="catom", value="everywhere")
        self.assertIn("@2", c.scopes())
        # Numbers of an earlier stop mean nothing.
        c.go("reverseContinue")
        self.refused("there is no variable", c.values, run)

    def test_expressions(self):
        c = self.begin()
        c.go("continue")
        self.assertEqual(c.evaluate("dist(@2, 2)")["result"], "yes")
        self.assertEqual(c.evaluate("dist(@2, 3)")["result"], "no")
        self.assertEqual(c.evaluate("N = count : { dist(_, _) }")["result"], "6")
        self.assertEqual(c.evaluate("dist(A, D), D > 9")["result"], "none")
        self.assertEqual(c.evaluate("dist(A, D),\n  D = 4")["result"], "A = @4, D = 4")
        rows = c.evaluate("dist(A, D), D > 3")
        self.assertEqual(rows["result"], "2 rows")
        self.assertEqual([v["value"] for v in c.values(rows["variablesReference"]).values()], ["A = @4, D = 4", "A = @5, D = 5"])
        self.assertEqual(list(c.values(rows["variablesReference"], start=1, count=1)), ["1"])
        self.assertEqual(c.values(c.evaluate("@1")["variablesReference"])["near"]["value"], "near(@1, 1)")
        self.assertEqual(c.evaluate("near", "hover")["result"], "near(@0, 0).")
        self.assertEqual(c.values(c.evaluate("neighbor(@2, B)", "watch")["variablesReference"])["0"]["value"], "B = @1")
        self.assertEqual(c.evaluate('X = strlen("a#b")')["result"], "3")  # No comment begins in it.
        self.refused("no predicate", c.evaluate, "D", "hover")
        self.refused("did you mean `dist`", c.evaluate, "dits(A, D)")
        self.refused("the body is missing", c.evaluate, " ")
        self.refused("nothing to ask", c.type, " ")
        self.refused("too long", c.evaluate, "p(A), " * 10000)

    def test_the_console_takes_commands(self):
        c = self.begin()
        self.assertEqual(c.type("rules near"), "chain.meld:13: near(A, D) :- dist(A, D), D < 3.")
        self.assertEqual(c.type("step 3"), "")
        c.event("continued")
        self.assertEqual(c.event("stopped")["description"], "tick 3")
        self.assertEqual([e["output"] for e in c.take_events("output")], ["tick 3\n"])
        self.assertIn("first_tick", json.dumps(c.values(c.scopes()["Run"])))
        self.refused("Did you mean 'where'", c.type, "wheer")
        c.type("to 1x")
        self.assertIn("to: '1x' is no whole number", c.event("stopped")["description"])
        labels = lambda text: [t["label"] for t in c.ask("completions", text=text, column=len(text) + 1)["targets"]]
        self.assertIn("history", labels("hi"))
        self.assertIn("why-not", labels("why-"))
        self.assertEqual(labels("facts @2 ne"), ["near", "neighbor", "neighborCount"])
        self.assertEqual(c.ask("completions", text="facts ne", column=9)["targets"][0],
                         {"label": "near", "type": "function", "start": 7, "length": 2})
        c.type("quit")
        self.assertEqual(c.event("exited"), {"exitCode": 0})
        c.event("terminated")
        self.refused("the run has ended", c.frames)
        self.assertEqual(c.leave(), 0)

    def test_a_program_that_is_read_again(self):
        c = self.begin()
        self.assertEqual(c.ask("completions", text="facts ne", column=9)["targets"][0]["label"], "near")
        self.assertTrue(self.lines(c, 13)[0]["verified"])
        c.type("step 3")
        c.event("stopped")
        self.write("chain.meld", "type new(node).\n" + CHAIN.replace("near(", "close(") + "new(A) :- close(A, _).\n")
        self.assertIn("derived anew: ", c.type("reload"))
        c.event("invalidated")
        self.assertEqual(c.ask("completions", text="facts ne", column=9)["targets"][-1]["label"], "new")
        self.assertEqual(self.lines(c, 14)[0]["verified"], True)
        self.assertEqual(c.type("rules new")[:10], "chain.meld")
        self.assertEqual(c.leave(), 0)

    def test_attributes_of_a_launch(self):
        self.write("given.meld", "type p(node, string, int).\nconst limit = 1.\np(@0, @arg1, limit).\n")
        c = self.begin("given.meld", args=["-two words"], set={"limit": 7}, world="chain.toml", cwd=str(self.folder), seed=3, threads=2,
                       ticks=1, history="1MB", optimization=1, strict=True, __sessionId="x")
        c.go("continue")
        self.assertEqual(c.values(c.scopes()["@0"])["p"]["value"], 'p(@0, "-two words", 7)')

    def test_what_cannot_be_launched(self):
        for attributes, says in (({}, "`program` is missing"), ({"program": 3}, "`program` has to be a path"),
                                 ({"program": "chain.meld", "processes": "two"}, "`processes` has to be a whole number"),
                                 ({"program": "chain.meld", "processes": -2}, "`processes` has to be a whole number"),
                                 ({"program": "chain.meld", "processes": 1e300}, "`processes` has to be a whole number"),
                                 ({"program": "chain.meld", "set": ["a=1"]}, "`set` has to be an object"),
                                 ({"program": "chain.meld", "library": [1]}, "`library` has to be a list of strings"),
                                 ({"program": "chain.meld", "catom": -1}, "`catom` has to be a whole number"),
                                 ({"program": "chain.meld", "stopOnEntry": 1}, "`stopOnEntry` has to be true or false"),
                                 ({"program": "nowhere.meld"}, "nowhere.meld"), ({"program": "chain.meld", "processes": 0}, "--processes"),
                                 ({"program": "chain.meld", "cwd": "/no/where"}, "cannot enter the folder /no/where"),
                                 ({"program": "chain.meld", "world": "no.toml"}, "no.toml")):
            with self.subTest(attributes=attributes):
                c = self.client()
                c.ask("initialize", adapterID="meld")
                self.refused(re.escape(says), c.ask, "launch", **attributes)
                self.assertEqual(c.leave(), 0)
        self.write("wrong.meld", "type p(node).\np(A) :- q(A).\n")
        c = self.client()
        c.ask("initialize", adapterID="meld")
        self.refused("E0301", c.ask, "launch", program="wrong.meld")
        self.assertIn("wrong.meld:2", "".join(e["output"] for e in c.take_events("output")))

    def test_without_debugging_it_runs_to_its_end(self):
        c = self.begin(noDebug=True, stopOnEntry=False)
        self.assertEqual(c.event("exited"), {"exitCode": 0})
        c.event("terminated")
        self.assertIn("nothing is left to do", "".join(e["output"] for e in c.take_events("output")))
        self.assertEqual(c.leave(), 0)

    def test_a_recording(self):
        """Of which only the client knows where its program is."""
        self.call("meldsim", "run", "chain.meld", "--quiet", "--record", "run.vtkhdf")
        (self.folder / "chain.meld").rename(self.folder / "moved.meld")
        elsewhere = self.write("elsewhere/chain.meld", CHAIN)
        c = self.client()
        c.begin(lambda: self.assertTrue(self.lines(c, 13, file="elsewhere/chain.meld")[0]["verified"]),
                program=str(self.folder / "run.vtkhdf"))
        self.assertEqual(c.go("continue")["reason"], "breakpoint")
        self.assertEqual(c.frames()[0]["source"]["path"], str(elsewhere))


class Stops(DapTest):
    def test_lines_are_those_of_rules(self):
        c = self.begin()
        found = self.lines(c, 12, 1, 13, 14, 99)
        self.assertEqual([(b["verified"], b.get("line"), b.get("endLine")) for b in found],
                         [(True, 10, 12), (False, 6, 6), (True, 13, 13), (True, 15, 15), (False, None, None)])
        self.assertIn("no body", found[1]["message"])
        self.assertIn("no rule at or after", found[4]["message"])
        other = c.ask("setBreakpoints", source={"path": "/other.meld"}, breakpoints=[{"line": 3}])["breakpoints"]
        self.assertEqual((other[0]["verified"], other[0]["message"]), (False, "the program of this run has no rules in this file"))
        places = c.ask("breakpointLocations", source={"path": str(self.folder / "chain.meld")}, line=8, endLine=13)
        self.assertEqual(places["breakpoints"], [{"line": 9, "endLine": 9}, {"line": 10, "endLine": 12}, {"line": 13, "endLine": 13}])

    def test_it_stops_where_a_rule_fires(self):
        for processes in (1, 2):
            c = self.begin(processes=processes)
            line = self.lines(c, 13)[0]
            ticks = []
            while (stop := c.go("continue"))["reason"] == "breakpoint":
                self.assertEqual((stop["hitBreakpointIds"], stop["description"]), ([line["id"]], "chain.meld:13"))
                top = c.frames()[0]
                bound = c.values(c.scopes(top["id"])["Variables of the rule"])
                ticks.append((top["line"], bound["A"]["value"], bound["D"]["value"]))
                # The rule rests on this, and its catom is looked at.
                self.assertEqual(c.frames()[1]["name"], f"dist({bound['A']['value']}, {bound['D']['value']})")
                self.assertIn(bound["A"]["value"], c.scopes())
            self.assertEqual(ticks, [(13, "@0", "0"), (13, "@1", "1"), (13, "@2", "2")])
            self.assertEqual(stop["description"], "nothing is left to do")

    def test_a_linear_rule_and_back_to_where_it_fired(self):
        for processes in (1, 2):
            c = self.begin(catom=3, processes=processes)
            self.lines(c, 15, condition="N < 3")
            stop = c.go("continue")
            self.assertEqual((stop["reason"], stop["description"]), ("breakpoint", "chain.meld:15"))
            bound = c.values(c.scopes()["Variables of the rule"])
            self.assertEqual((bound["A"]["value"], bound["N"]["value"], bound["also 1"]["value"]), ("@0", "2", "A = @0, N = 1"))
            self.assertEqual(c.frames()[0]["line"], 15)
            self.assertIn("@0", c.scopes())
            c.go("continue")
            again = c.go("reverseContinue")
            self.assertEqual((again["reason"], again["description"], again["hitBreakpointIds"]),
                             ("breakpoint", "chain.meld:15", stop["hitBreakpointIds"]))
            self.assertEqual(c.go("reverseContinue")["description"], "tick 0")

    def test_conditions_names_and_bodies(self):
        c = self.begin()
        self.assertTrue(self.lines(c, 10, condition="D > 3")[0]["verified"])
        c.go("continue")
        self.assertEqual(c.values(c.scopes()["Variables of the rule"])["D"]["value"], "4")
        self.assertFalse(self.lines(c, 10, condition="D >")[0]["verified"])
        self.assertIn("E0301", self.lines(c, 10, condition="nothing(A)")[0]["message"])
        self.assertEqual(self.lines(c), [])
        c.go("reverseContinue")
        asked = [{"name": "near", "condition": "D = 2"}, {"name": "dist(@5, _)"}, {"name": "dits"}]
        named = c.ask("setFunctionBreakpoints", breakpoints=asked)
        self.assertEqual([b["verified"] for b in named["breakpoints"]], [True, True, False])
        ids = [b["id"] for b in named["breakpoints"]]
        hit = [c.go("continue") for _ in range(3)]
        self.assertEqual(hit[0]["hitBreakpointIds"], [ids[0]])
        self.assertEqual(hit[1]["hitBreakpointIds"], [ids[1]])
        self.assertEqual(hit[2]["description"], "nothing is left to do")
        c.type("breaks")

    def test_a_breakpoint_set_on_the_way_counts(self):
        c = self.begin("forever.meld", stopOnEntry=False)
        time.sleep(0.3)
        self.assertEqual(c.take_events("stopped"), [])
        self.assertTrue(self.lines(c, 3, file="forever.meld")[0]["verified"])
        self.assertEqual(c.event("stopped")["reason"], "breakpoint")


class LongRuns(DapTest):
    def test_pause(self):
        for processes in (1, 2):
            c = self.begin("forever.meld", processes=processes)
            last = 0
            for _ in range(2):
                c.ask("continue", threadId=1)
                time.sleep(0.3)
                self.assertEqual(c.ask("threads")["threads"], [{"id": 1, "name": "forever.meld"}])
                c.ask("pause", threadId=1)
                self.assertEqual(c.event("stopped")["reason"], "pause")
                tick = int(c.values(c.scopes()["Run"])["tick"]["value"])
                self.assertGreater(tick, last)
                last = tick
            # A pause that comes when nothing is done is over with that.
            c.ask("pause", threadId=1)
            self.assertEqual(c.go("next")["description"], f"tick {last + 1}")
            self.assertEqual(c.leave(), 0)

    def test_a_question_on_the_way_is_answered_and_the_run_goes_on(self):
        c = self.begin("forever.meld")
        c.ask("continue", threadId=1)
        ticks = [int(c.evaluate("p(@0, N)")["result"]) for _ in range(3)]
        self.assertEqual(ticks, sorted(set(ticks)))
        self.refused("on its way", c.ask, "next", threadId=1)
        self.assertEqual(c.take_events("stopped"), [])
        c.ask("pause", threadId=1)
        self.assertEqual(c.event("stopped")["reason"], "pause")

    def test_a_client_may_leave_at_any_time(self):
        for leave in ("disconnect", "terminate", None):
            for processes in (1, 2):
                c = self.begin("forever.meld", processes=processes)
                c.ask("continue", threadId=1)
                time.sleep(0.2)
                children = self.children_of(c.process.pid)
                self.assertTrue(children)
                if leave is None:
                    c.process.stdin.close()
                    self.assertEqual(c.wait(), 1)
                else:
                    c.ask(leave)
                    if leave == "terminate":
                        c.event("terminated")
                        c.ask("disconnect")
                    self.assertEqual(c.wait(), 0)
                self.wait_for(lambda: not any(self.lives(child) for child in children))

    def children_of(self, pid):
        listed = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
        return [int(child) for child in listed] + [g for child in listed for g in self.children_of(int(child))]

    def lives(self, pid):
        try:
            return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] not in "ZX"
        except OSError:
            return False

    def test_an_adapter_that_is_killed_leaves_nothing(self):
        c = self.begin("forever.meld")
        c.ask("continue", threadId=1)
        children = self.children_of(c.process.pid)
        c.process.send_signal(signal.SIGKILL)
        self.wait_for(lambda: not any(self.lives(child) for child in children))

    def test_a_run_that_is_killed(self):
        c = self.begin("forever.meld")
        c.ask("continue", threadId=1)
        time.sleep(0.1)
        os.kill(self.children_of(c.process.pid)[0], signal.SIGKILL)
        self.assertEqual(c.event("exited"), {"exitCode": 137})
        c.event("terminated")
        self.assertEqual(c.leave(), 0)

    def test_a_program_that_fails(self):
        c = self.begin(self.write("fails.meld", FAILS).name, world="forever.toml", cwd=str(self.folder))
        stop = c.go("continue")
        self.assertEqual(stop["reason"], "exception")
        self.assertRegex(stop["text"], "is divided by zero")
        self.assertIn("is divided by zero", "".join(e["output"] for e in c.take_events("output")))
        # The tick before is there to be looked at.
        self.assertTrue(c.values(c.scopes()["Run"])["tick"]["value"])
        self.assertEqual(c.go("reverseContinue")["description"], "tick 0")


class Damage(DapTest):
    def test_messages_that_are_none(self):
        """Each is told, and the session goes on."""
        for text, says in ((b"nonsense", "not JSON"), (b"[1, 2]", "no request"), (b"{}", "no request"), (b'"x"', "no request"),
                           (b"", "not JSON"),
                           (b'{"seq": 1.5, "type": "request", "command": "threads"}', "no request"), (b"\xff\xfe", "not JSON"),
                           (b'{"seq": 1, "type": "response", "command": "threads"}', "no request"),
                           (b'{"seq": 1, "type": "request", "command": 7}', "no request"), (b"[" * 200_000, "more than 100 deep"),
                           (b'{"a":' * 150_000, "more than 100 deep"), (b'{"seq": 1' + b" " * 100_000, "not JSON")):
            with self.subTest(text=text[:40]):
                c = self.client()
                c.framed(text)
                self.assertIn(says, c.event("output")["output"])
                self.assertIn("supportsStepBack", c.ask("initialize", adapterID="meld"))
                self.assertEqual(c.leave(), 0)

    def test_bytes_in_which_no_message_can_be_found(self):
        for data in (b"GET / HTTP/1.1\r\nHost: x\r\n\r\n", b"Content-Length: -3\r\n\r\n{}", b"Content-Length: 99999999999\r\n\r\n",
                     b"Content-Length: 1e3\r\n\r\n", b"x" * 10_000, b"Content-Length: 18446744073709551617\r\n\r\n{}"):
            with self.subTest(data=data[:40]):
                c = self.client()
                c.raw(data)
                self.assertEqual(c.wait(), 2)
                c.readers[1].join()
                self.assertRegex(c.errors, rb"^meldsim: ")

    def test_headers_and_bytes_as_they_come(self):
        c = self.client()
        text = json.dumps({"seq": 1, "type": "request", "command": "initialize"}).encode()
        for byte in b"content-type: x\r\nCONTENT-LENGTH:%d \r\n\r\n%s" % (len(text), text):
            c.raw(bytes([byte]))
        self.assertTrue(c.response(1)["supportsStepBack"])

    def test_requests_out_of_order_or_of_another_form(self):
        c = self.client()
        self.refused("initialize comes first", c.ask, "threads")
        self.refused("not by addresses", c.ask, "initialize", pathFormat="uri")
        c.ask("initialize", adapterID="meld", linesStartAt1=False, columnsStartAt1=False)
        self.refused("it has come before", c.ask, "initialize")
        self.refused("launch comes first", c.ask, "next", threadId=1)
        self.refused("launch starts one", c.ask, "attach")
        c.ask("launch", program=str(self.folder / "chain.meld"))
        self.refused("it has come before", c.ask, "launch", program="chain.meld")
        self.refused("configurationDone comes first", c.ask, "next", threadId=1)
        # Lines from 0 on.
        self.assertEqual(self.lines(c, 12)[0]["line"], 12)
        c.ask("configurationDone")
        self.refused("it has come before", c.ask, "configurationDone")
        self.refused("there is no request frobnicate", c.ask, "frobnicate")
        for command in ("setBreakpoints", "setFunctionBreakpoints", "scopes", "variables", "setVariable", "evaluate", "completions",
                        "breakpointLocations", "claymeld/catom"):
            self.refused("not as the protocol has it", c.ask, command)
        self.refused("not as the protocol has it", c.ask, "evaluate", expression=["p"])
        self.refused("there is no frame 7", c.ask, "scopes", frameId=7)
        self.assertEqual(c.leave(), 0)

    def test_numbers_that_do_not_fit(self):
        c = self.client()
        c.ask("initialize", adapterID="meld")
        c.ask("launch", program=str(self.folder / "chain.meld"))
        c.ask("configurationDone")
        for number in 3.3e21, -1, 2**31, 2**64 - 1, 1.5, "1":
            self.refused("must be a whole number from 0 to 2147483647", c.ask, "stackTrace", threadId=1, startFrame=number)
            self.refused("must be a whole number", c.ask, "stackTrace", threadId=1, levels=number)
            self.refused("must be a whole number", c.ask, "scopes", frameId=number)
            self.refused("must be a whole number", c.ask, "variables", variablesReference=number)
            self.refused("must be a whole number", c.ask, "completions", text="di", column=number)
            self.refused("must be a whole number", c.ask, "breakpointLocations", source={"path": "/a.meld"}, line=number)
        self.refused("must be a whole number", c.ask, "claymeld/catom", catom=1e20)

    def test_random_requests(self):
        """Whatever comes is answered, and the session can still be used."""
        rng = random.Random(5)
        values = [None, True, -1, 0, 1, 7, 2**62, 1.5, "", "dist", "@2", "dist(A, D)", "to 3", "step", "@99999999999999999999", "(", [], {},
                  [{}], [{"line": 10}], [{"name": "near"}], {"path": str(self.folder / "chain.meld")}, {"path": 3}, "why near(@1, _)", "é🚀"]
        names = ["source", "breakpoints", "lines", "frameId", "variablesReference", "name", "value", "expression", "context", "text",
                 "column", "line", "startFrame", "levels", "start", "count", "catom"]
        commands = ["setBreakpoints", "setFunctionBreakpoints", "next", "stepBack", "pause", "stackTrace", "scopes", "variables",
                    "setVariable", "evaluate", "completions", "claymeld/catom", "threads", "breakpointLocations", "setExceptionBreakpoints"]
        c = self.begin(ticks=9)
        sent = [c.send(rng.choice(commands), {n: rng.choice(values) for n in rng.sample(names, rng.randrange(7))}) for _ in range(400)]
        for number in sent:
            try:
                c.response(number)
            except Refused:
                pass
        c.ask("claymeld/catom", catom=1)
        c.type("to 2")
        while c.event("stopped")["description"] != "tick 2":
            pass
        self.assertEqual(c.evaluate("dist(@1, D)")["result"], "1")
        self.assertEqual(c.leave(), 0)


class Recorded(DapTest):
    """The same requests get the same messages, to the last byte but for what snapshots take."""

    def scripts(self):
        path = str(GRADIENT)
        gradient = [("initialize", {"adapterID": "meld", "supportsInvalidatedEvent": True}), ("launch", {"program": path, "catom": 4}),
                    ("setBreakpoints", {"source": {"path": path}, "breakpoints": [{"line": 10, "condition": "D > 20"}, {"line": 11}]}),
                    ("configurationDone", {}), ("stopped", None), ("threads", {}), ("next", {"threadId": 1}), ("stopped", None),
                    ("next", {"threadId": 1}), ("stopped", None), ("stackTrace", {"threadId": 1}), ("scopes", {"frameId": 1}),
                    ("variables", {"variablesReference": 1}), ("variables", {"variablesReference": 2}), ("continue", {"threadId": 1}),
                    ("stopped", None), ("stackTrace", {"threadId": 1, "levels": 4}), ("scopes", {"frameId": 1}),
                    ("evaluate", {"expression": "N = max D : { dist(_, D) }", "context": "watch"}),
                    ("evaluate", {"expression": "why-not dist(@4, 3)", "context": "repl"}),
                    ("stepBack", {"threadId": 1}), ("stopped", None),
                    ("setBreakpoints", {"source": {"path": path}, "breakpoints": []}), ("continue", {"threadId": 1}), ("stopped", None),
                    ("terminate", {}), ("terminated", None), ("disconnect", {})]
        return {"gradient": gradient}

    def play(self, script):
        c = self.client()
        for name, arguments in script:
            c.event(name) if arguments is None else c.ask(name, **arguments)
        self.assertEqual(c.wait(), 0)
        lines = [json.dumps(message).replace(str(ROOT), "ROOT") for message in c.transcript]
        return "".join(re.sub(r'"\d+ in \d+ bytes"', '"N in N bytes"', line) + "\n" for line in lines)

    def test_they_are_the_same_again(self):
        for name, script in self.scripts().items():
            path = HERE / "sessions" / f"{name}.jsonl"
            played = self.play(script)
            if TOOLS.record:
                path.parent.mkdir(exist_ok=True)
                path.write_text(played)
            self.assertEqual(played, path.read_text())


class CommandLine(DapTest):
    def test_it_stands_alone(self):
        for words in (("chain.meld",), ("-n", "2"), ("--json",)):
            out, err = self.call("meldsim", "debug", "--dap", *words, code=2)
            self.assertIn("--dap", err)
        self.assertIn("PROGRAM", self.call("meldsim", "debug", code=2)[1])


if __name__ == "__main__":
    main("meldc", "meldsim", record={"action": "store_true", "help": "write the recorded sessions anew"})
