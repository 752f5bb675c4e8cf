"""The commands as a user meets them: usage, bad worlds, files that cannot be written, programs that never end, hostile
texts. Each must end with its documented exit code and a message, printed once, that names what is wrong.

    cli_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import os
import pathlib
import signal
import subprocess
import sys

import h5py

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import frame  # noqa: E402
from frame import COUNT, FOREVER, TOOLS, main, square  # noqa: E402

SQUARE = square(2)
OUTPUTS = ("--facts-out", "--record", "--digest")


class Case(frame.Case):
    FILES = {"w.toml": SQUARE, "p.meld": COUNT}


class Usage(Case):
    def test_more_processes_than_make_sense_are_refused(self):
        self.write("p.meld", COUNT)
        self.write("w.toml", square(6))
        self.write("g.toml", 'lattice = "graph"\ngraph = "ring(36)"\n')
        self.write("many.toml", square(1000))
        for world in ("w.toml", "g.toml"):
            self.refused("meldsim", "run", "p.meld", "--world", world, "-n", 100000, "--quiet", code=2,
                         says=["-n: 100000 processes are more than the 36 catoms of this world, "
                               "and would only wait for each other. Write -n "])
        self.refused("meldsim", "run", "p.meld", "--world", "many.toml", "-n", 100000, "--quiet", code=2,
                     says=["-n: 100000 processes are too many for this machine, which has ",
                         "or start meldsim with mpirun on several machines"])
        # A few more than catoms do no harm.
        self.write("two.toml", 'lattice = "square"\n[[body]]\nshape = "box(2, 1, 1)"\n')
        self.call("meldsim", "run", "p.meld", "--world", "two.toml", "-n", 4, "--quiet")

    def test_help_shows_an_example_and_the_exit_codes(self):
        for arguments in (["meldc", "--help"], ["meldsim", "--help"]):
            out, err = self.call(*arguments)
            self.assertIn("Example: ", out)
            self.assertIn("Exit codes: 0 success, 1 an error in the program, 2 usage", out)
            self.assertEqual(err, "")
        for tool, command in (("meldc", "check"), ("meldc", "compile"), ("meldc", "explain"), ("meldc", "fmt"), ("meldc", "lsp"),
                              ("meldsim", "run"), ("meldsim", "world"), ("meldsim", "help"), ("meldc", "completion")):
            self.assertIn(f"Example: {tool} {command} ", self.call(tool, command, "--help")[0])

    def test_version(self):
        for tool in ("meldc", "meldsim"):
            self.assertRegex(self.call(tool, "--version")[0], rf"^{tool} \d+\.\d+\.\d+\n$")

    def test_help_is_a_command_too(self):
        self.assertEqual(self.call("meldsim", "help", "run"), self.call("meldsim", "run", "--help"))
        self.assertEqual(self.call("meldc", "help"), self.call("meldc", "--help"))
        self.refused("meldsim", "help", "rn", code=2, says=["there is no command 'rn'", "did you mean 'run'?"])

    def test_unknown_commands_and_options_are_named(self):
        self.refused("meldc", "chek", "p.meld", code=2, says=["there is no command 'chek'", "did you mean 'check'?"])
        self.refused("meldsim", "rum", "p.meld", code=2, says=["there is no command 'rum'", "did you mean 'run'?"])
        self.refused("meldsim", code=2, says=["a command is needed", "'meldsim help'"])
        self.refused("meldc", "check", "--jsn", "p.meld", code=2,
                     says=["meldc check: there is no option '--jsn'", "did you mean '--json'?"])
        self.refused("meldsim", "run", "p.meld", "--tick=3", code=2, says=["no option '--tick'", "did you mean '--ticks'?"])
        self.refused("meldsim", "world", "w.toml", "x.toml", code=2, says="'x.toml' is one argument too many")
        self.refused("meldc", "completion", "bsh", code=2, says="did you mean 'bash'?")
        self.refused("meldc", "check", "--frob", "p.meld", code=2, says="--frob")
        self.refused("meldsim", "run", "p.meld", "--frob", code=2, says="--frob")
        self.refused("meldc", code=2, says="a command is needed")
        self.refused("meldsim", "run", code=2, says="PROGRAM")

    def test_values_out_of_range(self):
        for option, value in (("-n", "0"), ("-n", "x"), ("--threads", "0"), ("--ticks", "-1"),
                              ("--ticks", "99999999999999999999"), ("--seed", "-2")):
            self.refused("meldsim", "run", "p.meld", option, value, code=2, says=f", not '{value}'")
        self.refused("meldc", "compile", "p.meld", "-O", "9", code=2, says="a whole number from 0 to 3")

    def test_unknown_stage_and_code(self):
        self.refused("meldc", "compile", "p.meld", "--emit=plam", code=2, says=["'plam'", "tokens, ast, program, plan, cpp and module"])
        self.refused("meldc", "explain", "E9999", code=2, says="E9999")
        self.assertIn("E0501", self.call("meldc", "explain", "E0501")[0])

    def test_settings(self):
        self.write("c.meld", "const size = 3.\ntype p(node, int).\np(A, size).\n")
        self.refused("meldsim", "run", "c.meld", "--world", "w.toml", "--set", "sise=4", code=2,
                     says=["no constant 'sise'", "did you mean 'size'?"])
        self.refused("meldsim", "run", "c.meld", "--world", "w.toml", "--set", "size", code=2, says="--set size")
        self.refused("meldsim", "run", "c.meld", "--world", "w.toml", "--set", "size=big", code=2, says="size")
        self.refused("meldsim", "run", "p.meld", "--world", "w.toml", "--set", "failed-turn=1", code=2, says="no constant 'failed-turn'")

    def test_closed_standard_output_is_an_error_not_a_crash(self):
        with open("/dev/full", "wb") as full:
            self.call("meldc", "compile", "p.meld", "--emit=cpp", stdout=full, code=4)


class Programs(Case):
    def test_missing_program(self):
        for more in ([], ["-n", "2"]):
            self.refused("meldsim", "run", "missing.meld", *more, code=2, says="missing.meld")
        self.refused("meldc", "check", "missing.meld", code=2, says="missing.meld")
        self.refused("meldc", "check", ".", code=2, says="folder")

    def test_wrong_program_is_told_once_on_any_number_of_processes(self):
        self.write("wrong.meld", "type p(node).\np(A) :- q(A).\n")
        for n in (1, 3):
            self.refused("meldsim", "run", "wrong.meld", "--world", "w.toml", "-n", n, code=1, says="no predicate `q`", lines=None)

    def test_path_with_spaces_and_quotes(self):
        self.write("my 'first' program.meld", COUNT)
        for n in (1, 2):
            out, err = self.call("meldsim", "run", "my 'first' program.meld", "--world", "w.toml", "-n", n, "--facts-out", "out of it")
            self.assertEqual((self.folder / "out of it").read_text(), "".join(f"p(@{i}, 2).\n" for i in range(4)))
            self.assertEqual(out.count("\n  catoms "), 1)
            self.assertEqual(err, "")

    def test_compiled_module_runs_without_its_program(self):
        self.call("meldc", "compile", "p.meld", "-o", "mine.so")
        (self.folder / "p.meld").unlink()
        for n in (1, 2):
            self.call("meldsim", "run", "./mine.so", "--world", "w.toml", "--quiet", "-n", n, "--facts-out", "f")
            self.assertIn("p(@3, 2).", (self.folder / "f").read_text())

    def test_module_that_is_none_is_refused(self):
        self.write("text.so", "no module")
        self.refused("meldsim", "run", "./text.so", "--world", "w.toml", code=5, says="text.so")

    def test_module_of_another_version_is_refused(self):
        self.call("meldc", "compile", "p.meld", "-o", "mine.so")
        data = bytearray((self.folder / "mine.so").read_bytes())
        # The note's owner, then magic, then the version; any change of it must be noticed before the module is loaded.
        sections, _ = self.call("readelf", "-SW", "mine.so")
        line = next(line for line in sections.splitlines() if ".note.meld" in line or ".note.clay" in line)
        fields = line[line.index("]") + 1:].split()
        at, size = int(fields[3], 16), int(fields[4], 16)
        refusals = 0
        for offset in range(at, at + size, 4):
            changed = bytearray(data)
            changed[offset] ^= 0x40
            self.write("changed.so", bytes(changed))
            done = self.run_tool("meldsim", "run", "./changed.so", "--world", "w.toml", "--quiet")
            self.assertIn(done.returncode, (0, 5), done.stderr)
            refusals += done.returncode == 5
        self.assertGreater(refusals, 3)


class Worlds(Case):
    def world(self, text, *, code=2, says):
        self.write("bad.toml", text)
        return self.refused("meldsim", "run", "p.meld", "--world", "bad.toml", code=code, says=says)

    def test_missing_world(self):
        for n in (1, 2):
            self.refused("meldsim", "run", "p.meld", "--world", "missing.toml", "-n", n, code=2, says="missing.toml")

    def test_a_program_for_a_world_and_a_world_for_a_program(self):
        self.write("square.toml", SQUARE)
        for command in (("meldsim", "world", "p.meld"), ("meldsim", "run", "p.meld", "--world", "p.meld")):
            self.refused(*command, code=2, says=["p.meld is a program, not a world", "--world FILE.toml"])
        for command in (("meldc", "check"), ("meldsim", "run"), ("meldsim", "query")):
            self.refused(*command, "square.toml", *(["p(A)"] if command[1] == "query" else []), code=2,
                         says=["square.toml is a world, not a program", "--world square.toml"])

    def test_what_is_not_a_recording(self):
        self.refused("meldsim", "replay", "p.meld", code=6, says=["p.meld is not a recording", "meldsim run --record"])

    def test_sizes_that_are_none(self):
        for size in ("0", "-3", "nan", "inf"):
            self.world(f'[[body]]\nshape = "box({size}, 1, 1)"\n', says="bad.toml:2:")
        self.world('[[body]]\nshape = "box(1e18, 2, 2)"\n', says="make it smaller")
        self.world("[[body]]\ncells = []\n", says="no catom")
        self.world("", says="no catom")

    def test_slips_have_a_place_and_the_nearest_name(self):
        self.world('lattise = "square"\n' + SQUARE[19:], says=["bad.toml:1:1: there is no key 'lattise'", "did you mean 'lattice'?"])
        self.world('lattice = "sqare"\n' + SQUARE[19:], says=["bad.toml:1:11: there is no lattice 'sqare'", "did you mean 'square'?"])
        self.world('[[body]]\nshape = "bxo(3, 1, 1)"\n', says=["bad.toml:2:10", "did you mean 'box'?"])
        self.world('[[body]]\nshape = "box(3, 1"\n', says="bad.toml:2:18: expected ',' or ')'")
        self.world("lattice = \n", says="bad.toml:1:11")
        self.world("[[body]]\ncells = [[0, 0, 0], [0, 0, 0]]\n", says=["cell (0, 0, 0) is listed twice", "bad.toml:2:21"][:1])
        self.world(SQUARE + "[limits]\nmax_ticks = -1\n", says="bad.toml:5:13")
        self.world(SQUARE + '[facts]\nqq = ["all"]\n', says=["bad.toml:5:7", "no predicate qq"])
        self.world(SQUARE + '[facts]\np = ["all"]\n',
                   says=["bad.toml:5:6: p has 1 argument after the catom, and is given 0 arguments", "Rules derive it"])
        self.world(SQUARE + '[components]\nfoo = "x"\n', says=["there is no interface 'foo'", "thermometer"])
        self.world(SQUARE + "[set]\nfoo = 1\n", says="no constant 'foo'")
        self.world(SQUARE + '[motion]\nkind = "latice"\n', says="did you mean 'lattice'?")

    def test_sections_that_do_not_say_where_catoms_are_leave_them_there(self):
        self.write("own.meld", "type route edge(node, node).\ntype hops(node, min int).\ntype linear letter(node, node).\n"
                               "type got(node, node).\ntype mark(node).\ntype marked(node).\nmarked(A) :- mark(A).\n"
                               "edge(@0, @4). edge(@4, @2). edge(@2, @7).\nhops(@0, 0).\n"
                               "hops(B, N + 1) :- edge(A, B), hops(A, N).\nletter(@0, @7).\nletter(A, B) -o got(B, A).\n")
        self.write("cube.meld", "type sum(node, count int).\ntype mark(node).\ntype marked(node).\n"
                                "marked(A) :- mark(A).\nsum(A, 1) :- neighbor(A, _).\n")
        for program in ("own", "cube"):
            self.call("meldsim", "run", program + ".meld", "--quiet", "--facts-out", "alone")
            for text in ("[limits]\nmax_ticks = 50\n", "seed = 3\n", '[clock]\nkind = "sequential"\n', '[time]\ntick = "2ms"\n',
                         '[network]\nkind = "latency"\nmost = 3\n', '# More.\n [network] # links\nkind = "latency"\nmost = 3\n[limits]',
                         'network.kind = "latency"\nnetwork.most = 2\n', 'network = { kind = "latency", most = 2 }',
                         "[record]\nevery = 2"):
                self.write("some.toml", text)
                for n in (1, 2):
                    self.call("meldsim", "run", program + ".meld", "--world", "some.toml", "-n", n, "--quiet", "--facts-out", "f")
                    self.assertEqual(self.read("f"), self.read("alone"), (program, text))
            self.write("some.toml", '[[event]]\ntick = 2\ngive = { mark = "id == 0" }\n')
            self.call("meldsim", "run", program + ".meld", "--world", "some.toml", "--quiet", "--facts-out", "f")
            more = [b"mark(@0).", b"marked(@0)."]
            self.assertEqual(sorted(self.read("f").splitlines()), sorted(self.read("alone").splitlines() + more))
            for text, says in (("[limits]\nmax_tick = 3\n", "bad.toml:2:1: "),
                               ('[network]\nkind = "latency"\nmost = 0\n', "bad.toml:3:8: "),
                               ('[limits]\nmax_ticks = 9\n[facts]\nmark = ["id =="]\n', "bad.toml:4:"),
                               ('[network]\nreach = "none"\n', "bad.toml:2:9: ")):
                self.write("bad.toml", text)
                self.refused("meldsim", "run", program + ".meld", "--world", "bad.toml", code=2, says=says)
        self.write("bad.toml", 'lattice = "square"\n')
        self.refused("meldsim", "run", "cube.meld", "--world", "bad.toml", code=2, says="no catom: the body is empty")

    def test_mistakes_are_told_once_on_more_processes(self):
        self.write("bad.toml", '[[body]]\nshap = "box(2, 2, 1)"\n')
        self.refused("meldsim", "run", "p.meld", "--world", "bad.toml", "-n", "3", code=2, says="there is no key 'shap'")

    def test_what_does_not_fit_is_refused_with_the_estimate_before_it_is_made(self):
        for n in (1, 2):
            self.write("big.toml", '[[body]]\nshape = "box(20000, 20000, 20000)"\n')
            err = self.refused("meldsim", "run", "p.meld", "--world", "big.toml", "-n", n, code=4, says="the world needs")
            self.assertRegex(err, r"needs [\d.]+ TiB for 8 T catoms of \d+ bytes, and [\d.]+ [KMGT]iB are available")

    def test_limits_of_the_process_count_as_what_there_is(self):
        self.write("big.toml", '[[body]]\nshape = "box(400, 400, 400)"\n')
        for option, by in (("-v", "ulimit -v"), ("-d", "ulimit -d")):
            out, err = self.call("bash", "-c", f'ulimit {option} 1500000 && exec "$0" run p.meld --world big.toml', TOOLS.meldsim, code=4)
            self.assertEqual(out, "")
            self.assertRegex(err, rf"\Ameldsim: the world needs .* are left by {by}\..*\n\Z")

    def test_memory_that_runs_out_in_the_run_is_one_line(self):
        self.write("grow.meld", "type linear t(node, int).\ntype l(node, list int).\nt(A, 0).\n"
                                "t(A, N) -o l(A, [N, N, N, N, N, N, N, N, N, N, N, N, N, N, N, N]), t(A, N + 1)@+1.\n")
        self.write("many.toml", 'lattice = "square"\n[[body]]\nshape = "box(300, 300, 1)"\n')
        out, err = self.call("bash", "-c", 'ulimit -v 400000 && exec "$0" run grow.meld --world many.toml --quiet', TOOLS.meldsim, code=4)
        self.assertEqual(out, "")
        self.assertRegex(err, r"\Ameldsim: out of memory.*\n\Z")

    def test_more_processes_than_catoms(self):
        self.write("one.toml", '[[body]]\ncells = [[0, 0, 0]]\n')
        out, err = self.call("meldsim", "run", "p.meld", "--world", "one.toml", "-n", "3", "--facts-out", "f")
        self.assertEqual((self.folder / "f").read_text(), "p(@0, 0).\n")
        self.assertEqual((out.count("catoms"), err), (1, ""))


class Files(Case):
    def test_files_that_cannot_be_written_are_found_before_the_run(self):
        # A run that would never end shows that the files are tried first. /proc cannot be written to by anybody.
        self.write("for ever.meld", FOREVER)
        before = self.files()
        for option in OUTPUTS:
            for path in ("missing/x", "/proc/x", ".", "p.meld/x"):
                self.refused("meldsim", "run", "for ever.meld", "--world", "w.toml", option, path, code=2, says=f"cannot write {path}")
        self.assertEqual(self.files(), before)

    def test_and_so_on_more_processes(self):
        self.write("for ever.meld", FOREVER)
        before = self.files()
        for option in OUTPUTS:
            self.refused("meldsim", "run", "for ever.meld", "--world", "w.toml", "-n", "2", option, "missing/x", code=2,
                         says="cannot write missing/x")
        self.assertEqual(self.files(), before)

    def test_failed_run_leaves_no_facts(self):
        self.write("zero.meld", "type p(node, int).\np(A, 1 / N) :- id(A, N).\n")
        self.call("meldsim", "run", "zero.meld", "--world", "w.toml", "--facts-out", "f", "--strict", code=1)
        self.assertNotIn("f", self.files())
        self.assertNotIn("f.tmp", self.files())

    def test_module_that_cannot_be_written(self):
        self.refused("meldc", "compile", "p.meld", "-o", "missing/x.so", code=2, says="missing/x.so")

    def test_digest_is_the_same_for_any_number_of_processes(self):
        digests = [self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet", "--digest", "-", "-n", n)[0] for n in (1, 2, 3)]
        self.assertRegex(digests[0], r"^tick 1 [0-9a-f]+\n")
        self.assertEqual(digests[0], digests[1])
        self.assertEqual(digests[0], digests[2])

    def test_a_tick_that_failed_has_no_digest(self):
        # How far the other catoms came in it depends on the processes.
        self.write("fails.meld", "type linear counter(node, int). counter(A, 0). counter(A, N), id(A, 0) -o counter(A, N + 1).\n")
        for n in (1, 2):
            out, err = self.call("meldsim", "run", "fails.meld", "--world", "w.toml", "--quiet", "--digest", "-", "-n", n, code=4)
            self.assertEqual(out, "")
            self.assertIn("counter", err)


class Endings(Case):
    def ends(self, program, *, code, says, limits="", processes=(1, 3), lines=1):
        """The same single message on any number of processes; returns it."""
        self.write("d.meld", program)
        self.write("limits.toml", SQUARE + limits)
        for n in processes:
            self.refused("meldsim", "run", "d.meld", "--world", "limits.toml", "--quiet", "-n", n, code=code, says=says, lines=lines)

    def test_ping_pong_of_linear_facts(self):
        self.ends("type linear a(node).\ntype linear b(node).\na(@1).\na(A) -o b(A).\nb(A) -o a(A).\n", code=4,
                  says=["in one tick in rule", "at catom @1 in tick 1", "max_derivations_per_tick"])

    def test_view_that_grows_at_one_catom(self):
        self.ends("type d(node, int).\nd(@2, 0).\nd(A, N + 1) :- d(A, N).\n", code=4,
                  says=["more than 10000 facts of one predicate in rule d@3 at catom @2 in tick 1"], lines=None)

    def test_view_that_grows_over_links(self):
        self.ends("type d(node, int).\nd(@0, 0).\nd(B, N + 1) :- neighbor(A, B), d(A, N).\n", limits="[limits]\nmax_facts_per_catom = 50\n",
                  code=4, says=["more than 50 facts", "at catom @", "max_facts_per_catom"], lines=None)

    def test_list_that_doubles(self):
        self.ends("type linear l(node, list int).\nl(@0, [1, 2, 3]).\nl(A, L) -o l(A, L ++ L).\n", limits="[limits]\nmax_list = 100\n",
                  code=4, says=["a list has 192 items, and the maximum is 100 in rule l@3 at catom @0 in tick 1", "max_list"])

    def test_list_that_grows_for_ever_in_scratch_memory(self):
        self.ends("type linear l(node, list int).\nl(@0, []).\nl(A, L) -o l(A, [1 | L]).\n", code=4, processes=(1,),
                  says=["the rules of a catom take more than 1 GiB of memory in one tick in rule l@3 at catom @0 in tick 1"])

    def test_given_list_that_is_too_long(self):
        self.write("d.meld", "type l(node, list int).\ntype n(node, int).\nn(A, llength(L)) :- l(A, L).\n")
        self.write("long.toml", SQUARE + "[limits]\nmax_list = 2\n[facts]\nl = { args = [[1, 2, 3]] }\n")
        for n in (1, 2):
            self.refused("meldsim", "run", "d.meld", "--world", "long.toml", "--quiet", "-n", n, code=4,
                         says=["an argument of l has a list of 3 items, and the maximum is 2", "max_list"])

    def test_arguments_that_the_program_does_not_read(self):
        self.write("d.meld", "type n(node).\nn(@0).\n")
        self.refused("meldsim", "run", "d.meld", "--quiet", "--arg", "1", code=2, says="the program does not read the argument @arg1")
        self.refused("meldsim", "run", "d.meld", "--quiet", *["--arg", "1"] * 10, code=2, says="no more than nine")

    def test_token_that_never_rests(self):
        self.ends("type linear t(node).\nt(@0).\nt(A), neighbor(A, B) -o t(B).\n", limits="[limits]\nmax_ticks = 200\n", code=4,
                  says=["was not quiescent after 200 ticks", "`t` changed in each", "d.meld:3: t(A), neighbor(A, B) -o t(B)."], lines=None)

    def test_facts_of_runs_that_fail(self):
        token = "type linear t(node).\ntype at(node, int).\nt(@0).\nt(A), neighbor(A, B) -o t(B).\nat(A, N) :- tick(A, N).\n"
        self.write("t.meld", token)
        self.write("ten.toml", SQUARE + "[limits]\nmax_ticks = 10\n")
        self.call("meldsim", "run", "t.meld", "--world", "ten.toml", "--ticks", 10, "--facts-out", "ten.facts", "--quiet")
        # A tick whose rules trap is half done: nothing is written, and what is there stays.
        self.write("d.meld", "type p(node, int).\ntype q(node, int).\nq(A, T) :- tick(A, T).\np(A, 1 / (3 - T)) :- tick(A, T).\n")
        for n in (1, 2):
            self.refused("meldsim", "run", "t.meld", "--world", "ten.toml", "--facts-out", f"{n}.facts", "--quiet", "-n", n, code=4,
                         says="was not quiescent after 10 ticks", lines=None)
            self.assertEqual((self.folder / f"{n}.facts").read_text(), (self.folder / "ten.facts").read_text())
            self.write("old.facts", "old")
            self.refused("meldsim", "run", "d.meld", "--world", "w.toml", "--facts-out", "old.facts", "--record", f"{n}.vtkhdf", "--quiet",
                         "--strict", "-n", n, code=1,
                         says=["1 is divided by zero", "No facts are written, since tick 3 ended in the middle of changing them"])
            self.assertEqual((self.folder / "old.facts").read_text(), "old")
            with h5py.File(self.folder / f"{n}.vtkhdf") as recording:
                self.assertEqual(list(recording["VTKHDF/Steps/Values"]), [0, 1, 2])

    def test_arithmetic_that_goes_wrong_names_operands_rule_catom_and_tick(self):
        where = "at catom @1 in tick 1"
        for body, says in (("1 / (N - 1)", "1 is divided by zero in rule p@2"), ("7 % (N - 1)", "7 is divided by zero in rule p@2"),
                           ("9223372036854775807 + N", "too large"), ("-9223372036854775807 - 1 - N", "too large"),
                           ("(N * 9223372036854775807) * 2", "too large"), ("(-9223372036854775807 - N) / -1", "too large"),
                           ("truncate(1e30 * N)", "1e+30 has no such value as an int"), ("(N + 1) ^ (64 * N)", "too large")):
            self.ends(f"type p(node, int).\np(A, {body}) :- id(A, N), N = 1.\n", code=1, says=[says, where], processes=(1,))
        self.ends("type p(node, float).\np(A, sqrt(0.0 - N)) :- id(A, N), N = 1.\n", code=1, says=["not a number", where])
        self.ends("type p(node, sum int).\np(A, 9223372036854775807) :- id(A, 1), neighbor(A, _).\n", code=1, says=["too large", where])

    def test_functions_without_a_value_name_rule_and_catom(self):
        where = "at catom @1 in tick 1"
        calls = (("lnth([4, 5], N + 1)", "there is no element 2 in a list of 2 in rule p@2"),
                 ("lhead(ltail([N]))", "there is no element 0 in a list of 0"),
                 ("lmax(ltake([N], 0))", "there is no element 0 in a list of 0"), ('str2int("1x")', '"1x" is no int'),
                 ('str2int("9223372036854775808")', '"9223372036854775808" is no int'),
                 ("lsum([9223372036854775807, N])", "too large"), ("down(N)", "functions call each other more than 10000 deep in rule p@2"))
        for body, says in calls:
            self.ends(f"type p(node, int).\np(A, {body}) :- id(A, N), N = 1.\nfun down(int N) : int = 1 + down(N + 1).\n", code=1,
                      says=[says, where], processes=(1,), lines=None)
        for body in ("[log(0.0 - N)]", "[1, acos(2 * N)]", "normalize([sqrt(0.0 - N)])"):
            self.ends(f"type p(node, list float).\np(A, {body}) :- id(A, N), N = 1.\n", code=1, says=["not a number", where],
                      processes=(1,))

    def test_function_that_needs_much_stack_at_each_call(self):
        # Each call keeps a list of 400 elements on the stack; the limit is on bytes, not on calls alone.
        elements = ", ".join(f"f(N + {i})" for i in range(1, 400))
        self.ends(f"type p(node, int).\np(@1, f(0)).\nfun f(int N) : int = llength([{elements}]).\n", code=1,
                  says=["functions call each other more than", "at catom @1"], processes=(1,))

    def test_linked_files_that_are_wrong(self):
        self.write("e.meld", "extern int f(int).\ntype p(node, int).\np(A, f(1)).\n")
        self.write("bad.c", "int f( { return 1; }\n")
        self.write("f.c", "#include <stdint.h>\nint64_t f(int64_t x) { return x + 1; }\n")
        self.refused("meldc", "compile", "e.meld", "--link", "bad.c", code=1, says="bad.c does not compile", lines=None)
        self.refused("meldc", "compile", "e.meld", "--link", "none.c", code=2, says="there is no file none.c")
        self.refused("meldc", "compile", "e.meld", "--link", "e.meld", code=2, says="it is not a C or C++ file")
        first, _ = self.call("meldc", "compile", "e.meld", "--link", "f.c")
        self.write("f.c", "#include <stdint.h>\nint64_t f(int64_t x) { return x + 2; }\n")
        second, _ = self.call("meldc", "compile", "e.meld", "--link", "f.c")
        self.assertNotEqual(first, second, "a changed file must not find the module of the old one")

    def interrupt(self, *more):
        self.write("for ever.meld", FOREVER)
        # Its own session, so that a signal to the group is what Ctrl-C sends: to the command and all it started.
        run = self.begin("meldsim", "run", "for ever.meld", "--world", "w.toml", *more,
                         stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True, text=True)
        try:
            # The digest file exists as soon as ticks are made.
            self.wait_for(lambda: (self.folder / "d").exists() and (self.folder / "d").stat().st_size > 0)
            os.killpg(run.pid, signal.SIGINT)
            out, err = run.communicate(timeout=60)
        finally:
            if run.poll() is None:
                os.killpg(run.pid, signal.SIGKILL)
                run.wait()
        self.assertEqual(run.returncode, 130, out + err)
        self.assertEqual(out.count("interrupted"), 1, out + err)
        last = (self.folder / "d").read_text()
        self.assertTrue(last.endswith("\n"))
        ticks = int(last.splitlines()[-1].split()[1])
        self.assertIn(f"{ticks:,}", out)

    def test_interrupt_ends_at_a_tick_boundary_with_the_summary(self):
        self.interrupt("--digest", "d")

    def test_timeout_ends_a_run_after_a_tick_with_its_facts(self):
        self.write("p.meld", FOREVER)
        for n in (1, 2):
            self.refused("meldsim", "run", "p.meld", "--world", "w.toml", "-n", n, "--timeout", 2, "--facts-out", "f", "--quiet", code=4,
                         says="the time limit of 2 s has passed")
            self.assertEqual((self.folder / "f").read_text().count("\n"), 4)

    def test_timeout_ends_a_compilation(self):
        self.write("p.meld", "type p(node, int).\n" + "".join(f"p(A, {i} + X * {i}) :- p(A, X), X < {i}.\n" for i in range(2_000)))
        err = self.refused("meldc", "compile", "p.meld", "--timeout", 0.3, "--quiet", code=4, says="the time limit of 0.3 s has passed")
        self.assertEqual(err.count("\n"), 1)
        self.refused("meldsim", "run", "p.meld", "--timeout", 0.3, "--quiet", code=4, says="meldc: the time limit of 0.3 s has passed")

    def test_interrupt_with_two_processes(self):
        self.interrupt("--digest", "d", "-n", "2")


class Hostile(Case):
    def check(self, text, code, says=""):
        self.write("h.meld", text)
        out, err = self.call("meldc", "check", "h.meld", code=code)
        self.assertEqual(out, "")
        self.assertIn(says, err)
        return err

    def run_facts(self, text):
        self.write("h.meld", text)
        self.call("meldsim", "run", "h.meld", "--world", "w.toml", "--quiet", "--facts-out", "f")
        return (self.folder / "f").read_text()

    def test_empty_program(self):
        for text in ("", "\n\n", "// Nothing.", "/* Nothing. */"):
            self.check(text, 0)
            self.assertEqual(self.run_facts(text), "")

    def test_text_that_is_none(self):
        self.check(b"type p(node).\np(@0\0).\n", 1, "E0105")
        self.check(b"type p(node).\n// \xff\xfe\np(@0).\n", 1, "E0105")
        self.check(bytes(range(256)) * 40, 1, "error")

    def test_deep_nesting(self):
        for deep in ("(" * 100_000 + "1" + ")" * 100_000, "-" * 100_000 + "1", "(1 + " * 100_000 + "1", "if true then " * 100_000 + "1",
                     "abs(" * 100_000):
            self.check(f"type p(node, int).\np(@0, {deep}).\n", 1, "error[E01")
        self.check("/*" * 100_000, 1, "E0102")
        self.check("type p(node).\np(A) :- " + "not (" * 100_000, 1, "error[E01")

    def test_deep_bodies_compile_on_any_stack(self):
        program = "type p(node, int).\ntype q(node).\nq(A) :- p(A, 1), " + "not (" * 400 + "p(A, 2)" + ")" * 400 + ".\n"
        self.write("h.meld", program)
        self.call("meldc", "compile", "h.meld", "--quiet", "-o", "h.so")
        self.call("bash", "-c", 'ulimit -s 1024 && "$0" check h.meld && "$0" compile h.meld --quiet -O1', TOOLS.meldc)

    def test_long_chains(self):
        self.check("type p(node, int).\np(@0, 1" + " + 1" * 100_000 + ").\n", 0)
        for order in (1, -1):
            chain = ["const c0 = 1.\n"] + [f"const c{i} = c{i - 1} + 1.\n" for i in range(1, 20_000)]
            self.check("".join(chain[::order]) + "type p(node, int).\np(@0, c19999).\n", 0)
        ring = [f"const c{i} = c{(i + 1) % 20_000} + 1.\n" for i in range(20_000)]
        self.check("".join(ring), 1, "E0207")
        names = ["type int t0.\n"] + [f"type list t{i - 1} t{i}.\n" for i in range(1, 20_000)]
        for order in (1, -1):
            self.check("".join(names[::order]), 1, "E0112")
        doubled = "".join(f"type :(t{i - 1}, t{i - 1}) t{i}.\n" for i in range(1, 60))
        self.assertEqual(self.check("type int t0.\n" + doubled + "type p(node, t59).\n", 1, "E0112").count("error["), 1)

    def test_costs_are_about_linear(self):
        # Each takes about a second; with the square of its size it would take a minute.
        count = 10_000
        chain = "".join(f"type p{i}(node, int).\n" for i in range(count))
        chain += "".join(f"p{i}(A, X + 1) :- p{i - 1}(A, X), X < 5.\n" for i in range(1, count)) + "p0(A, 1).\n"
        body = "type p(node, int).\ntype q(node).\nq(A) :- " + ", ".join(f"p(A, {i})" for i in range(count)) + ".\n"
        joined = "type p(node, int, int).\ntype q(node).\nq(A) :- " + ", ".join(f"p(A, X{i}, X{i + 1})" for i in range(2 * count)) + ".\n"
        for text in (chain, body, joined):
            self.write("h.meld", text)
            self.call("meldc", "check", "h.meld", seconds=25)
        plan, _ = self.call("meldc", "compile", "h.meld", "--emit=plan")
        self.assertLess(len(plan), 400 * count)

    def test_facts_in_turn_are_one_table_for_each_predicate(self):
        facts = "".join(f"{'pq'[i % 2]}(@{i % 4}, {i}).\n" for i in range(2_000))
        self.write("h.meld", "type p(node, int).\ntype q(node, int).\n" + facts)
        out, _ = self.call("meldc", "compile", "h.meld", "--emit=plan")
        self.assertEqual(out.count("and 999 more facts"), 2, out[:2000])
        self.assertEqual(self.run_facts("type p(node, int).\ntype q(node, int).\n" + facts).count("\n"), 2_000)

    def test_deep_worlds(self):
        for text in ("[" + ".".join("a" * 50_000) + "]\n", ".".join("a" * 50_000) + " = 1\n", "x = " + "[" * 50_000,
                     "x = " + "{a=" * 50_000):
            self.write("deep.toml", 'lattice = "square"\n# a.b "\nradius = 0.5\n' + text)
            self.refused("meldsim", "world", "deep.toml", code=2, says="deep.toml:4:")

    def test_little_memory_is_one_line_and_code_4(self):
        self.write("h.meld", "type p(node, int).\n" + "".join(f"p(A, {i} + X) :- p(A, X), X < {i}.\n" for i in range(3_000)))
        out, err = self.call("bash", "-c", 'ulimit -v 90000 && exec "$0" compile h.meld --emit=cpp', TOOLS.meldc, code=4)
        self.assertEqual(out, "")
        self.assertRegex(err, r"\Ameldc: out of memory.*\n\Z")

    def test_many_facts(self):
        facts = "".join(f"p(@{i % 4}, {i}).\n" for i in range(20_000))
        self.check("type p(node, int).\n" + facts, 0)

    def test_one_long_line(self):
        self.check("type p(node, int).\n" + "p(@0, 1). " * 5_000, 0)
        err = self.check("type p(node, int).\n" + "p(@0, 1). " * 5_000 + "q(@0).\n", 1, "E0301")
        self.assertLess(len(err), 2_000)

    def test_text_that_would_break_the_emitted_comments(self):
        rules = ["p(A, 1) :- neighborCount(A, _). // ends in a backslash \\",
                 "p(A, 2) :- neighborCount(A, _). // trigraph ??/",
                 "p(A, 3) :- neighborCount(A, _) /* a \\\n */ .",
                 "p(A, 4) /* // */ :- neighborCount(A, _). // */ #error no"]
        program = "type p(node, int).\n" + "\n".join(rules) + "\n"
        self.assertEqual(self.run_facts(program), "".join(f"p(@{c}, {i}).\n" for c in range(4) for i in (1, 2, 3, 4)))

    def test_program_that_looks_like_a_raw_string_or_format(self):
        program = 'type p(node, int).\n// )__MELD__" R"x( {} {0} %s %n "quoted\\" \\0 \u2603 ??/\np(A, 1) :- neighborCount(A, _).\n'
        self.assertEqual(self.run_facts(program), "".join(f"p(@{c}, 1).\n" for c in range(4)))

    def test_windows_line_ends(self):
        self.assertEqual(self.run_facts(COUNT.replace("\n", "\r\n")), "".join(f"p(@{c}, 2).\n" for c in range(4)))

    def test_file_name_that_is_no_name(self):
        for name in ("1 + 1.meld", "class.meld", "a\"b.meld", "x;touch y.meld", "-p.meld"):
            self.write(name, COUNT)
            self.call("meldsim", "run", "./" + name, "--world", "w.toml", "--quiet")
        self.assertNotIn("y", self.files())


if __name__ == "__main__":
    main("meldc", "meldsim")
