"""`meldsim run --profile` and `meldsim profile`: the rule that takes the time is named; the file is written whatever becomes of the run.

    profile_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import pathlib
import signal
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from frame import FOREVER, OPEN_MPI, Case, main, no_file_above, square  # noqa: E402

# Of two rules that are evaluated equally often, one takes its time.
HOT = """fun work(int N, int S) : int = if N = 0 then S else work(N - 1, (S * 7 + N) % 1000003) end.
type quick(node, int).
type slow(node, int).
quick(A, T + 1) :- tick(A, T).
slow(A, work(300, T)) :- tick(A, T).
"""


class Profiles(Case):
    FILES = {"hot.meld": HOT, "w.toml": square(20)}

    def profile(self, *more, ticks=40):
        self.call("meldsim", "run", "hot.meld", "--world", "w.toml", "--quiet", "--ticks", ticks, "--profile", "run.profile", *more,
                  environment=OPEN_MPI)
        return json.loads(self.call("meldsim", "profile", "run.profile", "--json")[0])

    def test_the_expensive_rule_is_the_hottest(self):
        for more in ((), ("--threads", 2), ("-n", 2)):
            statistics = self.profile(*more, ticks=200)["statistics"]
            seconds = {r["rule"]: r["cpu_seconds"] for r in statistics["rules"]}
            self.assertGreater(seconds["slow@5"], 10 * seconds["quick@4"], more)
            others = statistics["other_cpu_seconds"] + sum(p["cpu_seconds"] for p in statistics["predicates"])
            self.assertGreater(seconds["slow@5"], others, more)
        text = self.call("meldsim", "profile", "run.profile")[0]
        hottest = text[text.index("hottest rules"):].splitlines()[2]
        self.assertIn("slow@5  slow(A, work(300, T)) :- tick(A, T).", hottest)

    def test_counts_are_in_a_profile_where_they_are_asked_for(self):
        plain = self.profile()["statistics"]
        self.assertEqual([sorted(rule) for rule in plain["rules"]], [["cpu_seconds", "file", "line", "rule", "text"]] * len(plain["rules"]))
        self.assertNotIn("firings", self.call("meldsim", "profile", "run.profile")[0])
        counted = self.profile("--stats")["statistics"]
        self.assertEqual({rule["evaluations"] for rule in counted["rules"] if rule["file"]}, {400 * 40})
        self.assertIn("firings", self.call("meldsim", "profile", "run.profile")[0])
        # Both count what catoms do.
        for key in ("busiest_ticks", "first_tick", "last_tick"):
            self.assertEqual(plain[key], counted[key])

    def test_a_module_that_does_not_say_where_it_is_is_refused(self):
        for flag in ((), ("--places",), ("--counters",)):
            self.call("meldc", "compile", "hot.meld", *flag, "-o", "hot.so")
            run = ("meldsim", "run", "hot.so", "--world", "w.toml", "--quiet", "--ticks", 9, "--profile", "run.profile")
            if flag:
                self.call(*run)
            else:
                self.refused(*run, code=2, says=["does not say which rule runs", "--places"], lines=None)

    def test_the_stages_take_the_time_of_the_run(self):
        profile = self.profile("--threads", 2, ticks=200)
        [process] = profile["statistics"]["processes"]
        whole = sum(process["wall_seconds"].values())
        self.assertLess(abs(whole - profile["run_seconds"]), 0.1 * profile["run_seconds"] + 0.02)
        # Both threads work at once; on a machine with one core they share it.
        self.assertEqual(len(process["busy_seconds_of_threads"]), 2)
        self.assertLessEqual(max(process["busy_seconds_of_threads"]), process["wall_seconds"]["evaluation"] + 0.01)
        self.assertGreater(sum(process["busy_seconds_of_threads"]), 0.5 * process["wall_seconds"]["evaluation"])

    def test_a_trace_has_every_tick_of_every_process(self):
        self.profile("-n", 2, "--threads", 2)
        self.call("meldsim", "profile", "run.profile", "--trace", "trace.json")
        events = json.loads(self.read("trace.json"))["traceEvents"]
        for process in (0, 1):
            mine = [e for e in events if e["pid"] == process and e["ph"] == "X"]
            self.assertEqual([e["name"] for e in mine if e["name"].startswith("tick")], [f"tick {t}" for t in range(1, 41)])
            self.assertEqual({e["tid"] for e in events if e["pid"] == process and e["ph"] == "M"}, {0, 1, 2})
            self.assertLessEqual({0, 1}, {e["tid"] for e in mine})
            self.assertLessEqual({"evaluation", "exchange", "agreement"}, {e["name"] for e in mine})
            # Stages lie within their tick.
            end = 0
            for e in mine:
                if e["name"].startswith("tick"):
                    self.assertGreaterEqual(e["ts"] + 1, end)
                    end = e["ts"] + e["dur"]
                else:
                    self.assertLessEqual(e["ts"] + e["dur"], end + 50)
        # To standard output it is alone there.
        out, _ = self.call("meldsim", "profile", "run.profile", "--trace", "-")
        self.assertEqual(json.loads(out)["traceEvents"], events)

    def test_a_long_run_has_a_short_trace(self):
        self.write("forever.meld", FOREVER)
        self.write("one.toml", square(1))
        self.call("meldsim", "run", "forever.meld", "--world", "one.toml", "--quiet", "--ticks", 9000, "--profile", "run.profile")
        spans = json.loads(self.read("run.profile"))["statistics"]["processes"][0]["spans"]
        self.assertLessEqual(len(spans), 4096)
        self.assertEqual((spans[0][0], spans[-1][1]), (1, 9000))
        self.assertEqual([s[0] for s in spans[1:]], [s[1] + 1 for s in spans[:-1]])

    def test_it_is_written_whatever_becomes_of_the_run(self):
        self.write("fails.meld", "type linear q(node, int).\ntype p(node, int).\nq(A, 9).\nq(A, N), N > 0 -o q(A, N - 1).\n"
                                 "q(A, 0) -o p(A, 1 / (@world - @world)).\n")
        self.call("meldsim", "run", "fails.meld", "--world", "w.toml", "--profile", "failed.profile", code=1)
        profile = json.loads(self.call("meldsim", "profile", "failed.profile", "--json")[0])
        self.assertEqual(profile["ended"], "failed")
        self.write("forever.meld", FOREVER)
        run = self.begin("meldsim", "run", "forever.meld", "--world", "w.toml", "--quiet", "--digest", "digest.txt", "--profile",
                         "stopped.profile")
        self.wait_for(lambda: (self.folder / "digest.txt").exists() and self.read("digest.txt").count(b"\n") > 20, run)
        run.send_signal(signal.SIGINT)
        self.assertEqual(run.wait(), 130)
        profile = json.loads(self.call("meldsim", "profile", "stopped.profile", "--json")[0])
        self.assertEqual(profile["ended"], "interrupted")
        self.assertGreater(profile["statistics"]["last_tick"], 0)

    def test_where_it_cannot_be_written_is_said_before_the_run(self):
        self.refused("meldsim", "run", "hot.meld", "--world", "w.toml", "--profile", "no/such/folder", code=2, says="no/such/folder")
        self.refused("meldsim", "run", "hot.meld", "--world", "w.toml", "--profile", "hot.meld", code=2, says="--profile", lines=None)

    def test_a_full_disk_is_told(self):
        # The module is in the cache by then.
        self.profile()
        (self.folder / "run.profile").unlink()
        err = self.call("meldsim", "run", "hot.meld", "--world", "w.toml", "--quiet", "--ticks", 40, "--profile", "run.profile", code=4,
                        preexec_fn=no_file_above(100))[1]
        self.assertIn("run.profile", err)
        self.assertFalse((self.folder / "run.profile").exists())

    def test_other_files_are_refused(self):
        self.profile("--stats")
        whole = self.read("run.profile")
        version = whole.replace(b'"claymeld_profile":1', b'"claymeld_profile":99')
        part = whole.replace(b'"evaluations"', b'"evaluated"')
        self.assertNotIn(whole, (version, part))
        for text, says in ((b"", "not whole"), (whole[:len(whole) // 2], "not whole"), (b'{"a": 1}', "something else"),
                           (version, "another version"), (part, "missing")):
            self.write("other", text)
            self.refused("meldsim", "profile", "other", code=6, says=["is no profile", says], lines=None)
        # Nothing that it says is trusted: how long its lists are, how deep it is nested, what its texts hold.
        edited = json.loads(whole)
        process = edited["statistics"]["processes"][0]
        spans, stages = process["spans"], process["wall_seconds"]
        process["spans"] = [[1, 1, 0.0, [], []]]
        self.write("other", json.dumps(edited))
        self.refused("meldsim", "profile", "other", code=6, says="missing", lines=None)
        process["spans"], process["wall_seconds"] = spans, {**stages, **{f"stage {i}": 1.0 for i in range(20000)}}
        self.write("other", json.dumps(edited))
        self.assertEqual(self.call("meldsim", "profile", "other")[0], self.call("meldsim", "profile", "run.profile")[0])
        process["wall_seconds"] = {name: seconds for name, seconds in stages.items() if name != "commit"}
        self.write("other", json.dumps(edited))
        self.refused("meldsim", "profile", "other", code=6, says="missing", lines=None)
        self.write("other", whole.replace(b'"run":', b'"deep":' + b"[" * 100000 + b"]" * 100000 + b',"run":'))
        self.refused("meldsim", "profile", "other", code=6, says="nested more than 8 levels deep", lines=None)
        process["wall_seconds"] = stages
        edited["statistics"]["predicates"][0].update(predicate="\x1b[2J\a/1", cpu_seconds=1.0)
        edited["statistics"]["rules"][0].update(rule="\x1b[2J\a", cpu_seconds=1.0)
        self.write("other", json.dumps(edited))
        out, _ = self.call("meldsim", "profile", "other")
        self.assertNotRegex(out, r"[\x07\x1b]")
        self.assertGreaterEqual(out.count(r"\x1b[2J\x07"), 4)
        self.refused("meldsim", "profile", "nowhere", code=2, says="nowhere", lines=None)
        self.refused("meldsim", "profile", "run.profile", "--trace", "run.profile", code=2, says="--trace", lines=None)
        self.assertEqual(self.read("run.profile"), whole)


if __name__ == "__main__":
    main("meldc", "meldsim")
