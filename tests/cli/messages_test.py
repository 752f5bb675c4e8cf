"""What the commands say of wrong command lines, wrong worlds and programs with many mistakes, and which warnings no option hides.

    messages_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import frame  # noqa: E402
from frame import COUNT, TOOLS, main, no_file_above, square  # noqa: E402

LINE = 'lattice = "square"\n[[body]]\nshape = "box(4, 1, 1)"\n'


class Case(frame.Case):
    FILES = {"w.toml": square(2), "p.meld": COUNT}


class Options(Case):
    def says(self, tool, *arguments, text):
        self.assertEqual(self.refused(tool, *arguments, code=2, says=text), text + "\n")

    def test_a_bad_value_is_named_with_its_option_and_what_is_allowed(self):
        self.says("meldsim", "run", "p.meld", "--ticks", "abc",
                  text="meldsim run: --ticks takes a whole number from 0 to 9223372036854775806, not 'abc'. see 'meldsim run --help'")
        self.says("meldsim", "run", "p.meld", "-n", "2.5",
                  text="meldsim run: -n, --processes takes a whole number from 1 to 100000, not '2.5'. see 'meldsim run --help'")
        self.says("meldc", "compile", "p.meld", "-O", "9",
                  text="meldc compile: -O takes a whole number from 0 to 3, not '9'. see 'meldc compile --help'")
        for tool, command, option in (("meldsim", "run", "--timeout"), ("meldsim", "view", "--for"), ("meldc", "compile", "--timeout")):
            self.says(tool, command, "p.meld", option, "nan",
                      text=f"{tool} {command}: {option} takes seconds from 0.001 to 1e9, not 'nan'. see '{tool} {command} --help'")
        self.refused("meldc", "compile", "p.meld", environment={"CLAYMELD_OPTIMIZATION": "fast"}, code=2,
                     says="CLAYMELD_OPTIMIZATION is a whole number from 0 to 3, not 'fast'")
        self.says("meldsim", "movie", "p.meld", "-o", "a.mp4", "--turn", "abc",
                  text="meldsim movie: --turn takes a number, not 'abc'. see 'meldsim movie --help'")
        self.says("meldsim", "shot", "p.meld", "-o", "a.png", "--zoom", "1,5",
                  text="meldsim shot: --zoom takes a number, not '1,5'. see 'meldsim shot --help'")

    def test_options_of_the_server_do_not_go_with_a_page_without_one(self):
        for option in ("--port=8080", "--for=3", "--no-open"):
            name = option.split("=")[0]
            self.refused("meldsim", "view", "p.meld", "--share", "a.html", option, code=2, says=(name, "--share"))
        self.refused("meldsim", "view", "p.meld", "q.meld", "--share", "a.html", code=2, says="--share")

    def test_a_missing_a_repeated_and_an_unwanted_value(self):
        self.says("meldsim", "run", "p.meld", "--facts-out",
                  text="meldsim run: --facts-out needs a value, its FILE. see 'meldsim run --help'")
        self.says("meldsim", "run", "p.meld", "--ticks", "3", "--ticks", "4",
                  text="meldsim run: --ticks is given 2 times, and may be given only once. see 'meldsim run --help'")
        self.says("meldsim", "run", "p.meld", "--json=yes", text="meldsim run: --json takes no value. see 'meldsim run --help'")

    def test_an_unknown_option_comes_before_what_it_leaves_over(self):
        self.says("meldsim", "run", "p.meld", "x", "--fact-out",
                  text="meldsim run: there is no option '--fact-out'. did you mean '--facts-out'?")
        self.says("meldsim", "run", "p.meld", "-x", text="meldsim run: there is no option '-x'. 'meldsim run --help' lists the options")

    def test_an_option_with_a_name_that_studies_or_other_programs_have_for_it(self):
        for given, meant in (("--until", "--watch"), ("--export", "--facts-out"), ("--csv=a", "--facts-out"), ("--ranks", "--processes"),
                             ("--max-ticks", "--ticks"), ("--invariant", "--never")):
            option = given.split("=")[0]
            self.says("meldsim", "run", "p.meld", given, text=f"meldsim run: there is no option '{option}'. did you mean '{meant}'?")
        # Of this command there is nothing like it.
        self.says("meldsim", "world", "p.toml", "--until",
                  text="meldsim world: there is no option '--until'. 'meldsim world --help' lists the options")

    def test_a_question_about_a_predicate_that_is_not_there(self):
        """It cannot be declared there, so the names that there are help more."""
        self.write("two.meld", "type p(node).\ntype other(node, int).\np(A) :- other(A, 1).\n")
        for body in ("hops(A, 1)", "p(A), not hops(A, 1)"):
            err = self.refused("meldsim", "query", "two.meld", body, code=2, lines=None,
                               says=("no predicate `hops`", "declares `other`, `p`"))
            self.assertNotIn("declare it", err)

    def test_commands_of_the_other_program_and_forgotten_ones(self):
        self.says("meldsim", "check", "p.meld", text="meldsim: 'check' is a command of meldc. write 'meldc check'")
        self.says("meldc", "run", "p.meld", text="meldc: 'run' is a command of meldsim. write 'meldsim run'")
        self.says("meldsim", "p.meld", text="meldsim: 'p.meld' is no command. did you mean 'meldsim run p.meld'?")

    def test_help_behind_a_command(self):
        self.assertEqual(self.call("meldsim", "run", "help"), self.call("meldsim", "run", "--help"))
        self.assertEqual(self.call("meldc", "explain", "help"), self.call("meldc", "help", "explain"))
        self.write("help", LINE)  # A file of that name is a file.
        self.assertIn("4 catoms", self.call("meldsim", "world", "help")[0])


class Worlds(Case):
    def wrong(self, text, says):
        """Both commands report it alike."""
        self.write("wrong.toml", text)
        self.write("none.meld", "type none(node).\nnone(@0).\n")
        first = self.call("meldsim", "world", "wrong.toml", code=2)[1]
        self.assertEqual(first, "meldsim: " + says + "\n")
        self.assertEqual(self.call("meldsim", "run", "none.meld", "--world", "wrong.toml", code=2)[1], first)

    def test_what_a_run_refuses_the_world_command_refuses(self):
        self.wrong(LINE + '[motion]\nkind = "latice"\n',
                   "wrong.toml: [motion] kind: there is no implementation 'latice' of motion. did you mean 'lattice'?")
        self.wrong(LINE + '[components]\nthermometer = "plan"\n',
                   "wrong.toml: [components] there is no implementation 'plan' of thermometer. did you mean 'plane'?")
        self.wrong("held = 3\n" + LINE + '[motion]\nkind = "lattice"\n',
                   "wrong.toml:1:8: held = 3 is more than a catom can hold, [motion] capacity = 1")

    def test_common_mistakes_in_toml_have_a_cure(self):
        for text, cure in (('lattice = cubic\n', 'write a text in quotes: lattice = "square"'), ("lattice: cubic\n", "write key = value"),
                           ('lattice = "cubic\n', "is its second quote missing?"),
                           ('lattice = "hex"\nlattice = "cubic"\n', "give each key once")):
            self.write("wrong.toml", text)
            self.refused("meldsim", "world", "wrong.toml", code=2, says=["wrong.toml:", cure])

    def test_a_world_that_does_not_fit_is_counted_and_refused(self):
        self.write("huge.toml", '[[body]]\nshape = "box(3000, 3000, 3000)"\n[limits]\nmemory = "16GiB"\n')
        out, err = self.call("meldsim", "world", "huge.toml", code=4)
        self.assertIn("about 27 G catoms", out)
        self.assertIn("16 GiB are allowed", err)

    def test_the_box_is_that_of_the_catoms(self):
        """Not the one that a shape was asked to fill, in which there may be none at the border."""
        self.write("p.meld", "type p(node).\n")
        shapes = ("box(40, 24, 1)", "minus(box(9, 9, 3), move(box(9, 9, 3), 2, 0, 0))", "sphere(5)",
                  "move(cylinder(r=12, h=2), 0.3, -40, 7)", "union(box(1, 1, 1), move(box(2, 3, 1), -9, 4, 0))")
        for lattice in ("square", "hex", "cubic", "fcc"):
            for shape in shapes[:-2] if lattice in ("square", "hex") else shapes:
                with self.subTest(lattice=lattice, shape=shape):
                    self.write("w.toml", f'lattice = "{lattice}"\n[[body]]\nshape = "{shape}"\n')
                    out = self.call("meldsim", "world", "w.toml")[0]
                    sides = ["C, _, _"] * 2 + ["_, C, _"] * 2 + ["_, _, C"] * 2
                    ends = zip("PQRSTU", ["min", "max"] * 3, sides)
                    body = ", ".join(f"{name} = {end} C : {{ cell(_, {at}) }}" for name, end, at in ends)
                    seen = self.call("meldsim", "query", "p.meld", body, "--world", "w.toml", "--quiet")[0]
                    numbers = seen.splitlines()[1].split()
                    self.assertIn(f"within cells ({', '.join(numbers[::2])}) to ({', '.join(numbers[1::2])})\n", out)

    def test_the_box_holds_listed_positions(self):
        self.write("listed.toml", '[[body]]\npositions = [[0, 0, 0], [1.6, -3, 4]]\n[motion]\nkind = "bodies"\n')
        self.assertIn("2 catoms, within cells (0, -3, 0) to (2, 0, 4)", self.call("meldsim", "world", "listed.toml")[0])


class Runs(Case):
    def test_no_ticks_show_the_catoms(self):
        for n in (1, 2):
            out = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", "0", "-n", n)[0]
            self.assertRegex(out, r"catoms +4\n")

    def test_the_summary_names_the_world(self):
        self.assertRegex(self.call("meldsim", "run", "p.meld", "--world", "w.toml")[0], r"(?m)^  world +w\.toml, 4 catoms$")
        self.assertRegex(self.call("meldsim", "run", "p.meld")[0], r"(?m)^  world +the default, a cube of 1,000 catoms$")
        for world, wanted in ((("--world", "w.toml"), ("w.toml", False, 4)), ((), ("the default, a cube of 1,000 catoms", True, 1000))):
            summary = self.summary("p.meld", *world)
            self.assertEqual(tuple(summary[key] for key in ("world", "default_world", "world_catoms")), wanted)

    def summary(self, program, *arguments):
        return json.loads(self.call("meldsim", "run", program, *arguments, "--json")[0])

    def test_the_summary_names_what_was_never_given(self):
        self.write("g.meld", """type source(node).
type hint(node, int).
type linear token(node).
type linear fuel(node).
type stated(node).
type dist(node, min int).
type linear seen(node, int).
type unread(node).
stated(@0).
dist(A, 0) :- source(A), stated(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
dist(A, N) :- hint(A, N).
token(A), fuel(A) -o seen(A, 0).
failed(A, K) -o seen(A, K).
""")
        out = self.call("meldsim", "run", "g.meld")[0]
        self.assertRegex(out, r"(?m)^  never given +source, hint, token, fuel: no rule, fact or world makes any$")
        self.assertEqual(self.summary("g.meld")["never_given"], ["source", "hint", "token", "fuel"])
        self.write("g.toml", LINE + '[facts]\nsource = ["id == 0"]\n[[event]]\ntick = 2\ngive = { fuel = ["id == 1"] }\n')
        self.assertEqual(self.summary("g.meld")["never_given"], ["hint", "token"])
        self.write("two.meld", "type p(node).\ntype p(node, int).\ntype q(node).\np(@0).\nq(A) :- p(A), p(A, 1).\n")
        self.assertEqual(self.summary("two.meld")["never_given"], ["p/2"])
        # What comes back is given by nobody, and made.
        self.write("back.meld", "type route friend(node, node).\ntype linear token(node, int).\n"
                                "type linear undelivered-token(node, node To, int).\ntype lost(node, node, int).\nfriend(@0, @3).\n"
                                "token(@0, 7).\ntoken(A, N), friend(A, B) -o token(B, N).\nundelivered-token(A, B, N) -o lost(A, B, N).\n")
        self.write("back.toml", LINE + '[motion]\nkind = "lattice"\n')
        self.assertIn("lost(@0, @3, 7).", self.call("meldsim", "run", "back.meld", "--quiet", "--facts-out", "-")[0])
        self.assertEqual(self.summary("back.meld")["never_given"], [])
        # Modules in C++ may give what they like.
        self.write("t.meld", "type sensed temperature(node, float).\ntype hint(node).\ntype warm(node).\n"
                             "warm(A) :- temperature(A, T), T > 1.0, hint(A).\n")
        self.assertEqual(self.summary("t.meld")["never_given"], ["hint"])
        self.write("t.toml", LINE + '[components]\nthermometer = "weather"\n')
        self.assertEqual(self.summary("t.meld")["never_given"], [])
        # Whoever has all is told nothing.
        self.assertNotIn("never given", self.call("meldsim", "run", "p.meld")[0])

    def test_the_summary_says_which_actions_were_refused_and_why(self):
        self.write("r.meld", """type linear ask(node, int).
ask(@0, 1). ask(@1, 2). ask(@3, 3). ask(@4, 3).
ask(A, 1) -o
  create(A, 9), create(A, 1), moveTo(A, 5000000000, 0, 0), moveTo(A, 1, 1, 1), moveTo(A, 3, 0, 0), slide(A, 9, 0), slide(A, 0, 0),
  slide(A, 3, 0), turn(A, 0, 1), give(A, @1), destroy(A, @3), moveAround(A, @3, @1), moveAround(A, @1, @1), magnet(A, 0, 1),
  force(A, 1.0, 0.0, 0.0).
ask(A, 2) -o slide(A, 2, 1), moveTo(A, 40, 0, 0), moveTo(A, 41, 0, 0).
ask(A, 3) -o moveTo(A, 50, 0, 0).
""")
        self.write("r.toml", 'lattice = "square"\n[[body]]\ncells = [[0, 0], [1, 0], [0, 1], [2, 0], [3, 0]]\n'
                             '[motion]\nkind = "lattice"\nkeep_connected = true\n')
        wanted = [("create", "no_such_port", 1), ("create", "no_unit", 1), ("destroy", "not_a_neighbour", 1), ("give", "no_unit", 1),
                  ("moveTo", "outside", 2), ("moveTo", "occupied", 1), ("moveTo", "repeated", 1), ("moveTo", "conflict", 1),
                  ("slide", "no_such_port", 1), ("slide", "not_at_right_angles", 1), ("slide", "no_support", 1),
                  ("slide", "disconnects", 1), ("turn", "occupied", 1), ("moveAround", "not_a_neighbour", 1),
                  ("moveAround", "no_path", 1), ("magnet", "not_in_this_world", 1), ("force", "not_in_this_world", 1)]
        for n, threads in ((1, 1), (2, 2), (4, 1)):
            summary = self.summary("r.meld", "--ticks", 3, "-n", n, "--threads", threads, "--quiet")
            self.assertEqual([tuple(each.values()) for each in summary["refused_actions"]], wanted, f"{n} processes")
        self.assertEqual(list(summary["refused_actions"][0]), ["action", "reason", "count"])
        out, err = self.call("meldsim", "run", "r.meld", "--ticks", 3)
        self.assertRegex(out, r"(?m)^  refused +2 moveTo: the cell was none of the lattice$")
        self.assertEqual(out.count("  refused  "), len(wanted))
        self.assertIn('warning: 2 actions were not carried out, since nothing in this world does so: give it [motion] kind = "bodies"', err)

    def test_what_the_moves_of_the_world_forbid_is_refused_in_their_name(self):
        self.write("m.meld", "move(@2, 1, 0, 0). slide(@2, 3, 0). move(@0, 0, 1, 0).\n")
        square = 'lattice = "square"\n[[body]]\ncells = [[0, 1], [0, 0], [1, 0], [0, 2]]\n[motion]\nkind = "lattice"\n'
        jump = "[[motion.move]]\nby = [-1, 0]\nfull = [[0, 1]]\n"
        for keys, name in (('moves = "pivoting"\n', 'the moves "pivoting"'), ("[[motion.move]]\nby = [1, 1]\n", "the moves of the world"),
                           (f'moves = "pivoting"\n{jump}symmetries = "none"\n', 'the moves "pivoting" and those of the world')):
            self.write("m.toml", square + keys)
            for n in (1, 2):
                out, _ = self.call("meldsim", "run", "m.meld", "-n", n)
                self.assertRegex(out, rf"(?m)^  refused +1 slide: not allowed by {name}$")
                self.assertRegex(out, rf"(?m)^  refused +2 move: not allowed by {name}$")
            summary = self.summary("m.meld", "--quiet")
            self.assertEqual(summary["moves"], name)
            self.assertEqual([each["reason"] for each in summary["refused_actions"]], ["not_allowed", "not_allowed"])
        self.write("m.toml", square)
        summary = self.summary("m.meld", "--quiet")
        self.assertNotIn("moves", summary)
        self.assertEqual(summary["refused_actions"], [{"action": "move", "reason": "no_moves", "count": 2}])

    def test_possible_moves_need_a_world_that_names_them(self):
        self.write("p.meld", "type p(node).\np(A) :- possible(A, 1, _, _).\n")
        for world in (LINE, LINE + '[motion]\nkind = "lattice"\n'):
            self.write("p.toml", world)
            for n in (1, 2):
                _, err = self.call("meldsim", "run", "p.meld", "--world", "p.toml", "-n", n, code=2)
                self.assertIn("meldsim: the program reads `possible`, and p.toml does not say which moves there are. Write moves = ", err)

    def test_no_room_and_no_feature(self):
        self.write("full.meld", "destroy(@0, @1). give(@1, @0). magnet(@0, 7, 1).\n")
        self.write("full.toml", 'held = 1\n' + LINE + '[motion]\nkind = "lattice"\n')
        self.write("ball.toml", '[[body]]\npositions = [[0, 0, 0], [2, 0, 0]]\n[motion]\nkind = "bodies"\ngravity = [0, 0, 0]\n')
        for world, wanted in (("full.toml", {"destroy": "no_room", "give": "no_room", "magnet": "not_in_this_world"}),
                              ("ball.toml", {"destroy": "not_in_this_world", "give": "not_in_this_world", "magnet": "no_such_feature"})):
            for n in (1, 2):
                refused = self.summary("full.meld", "--world", world, "--ticks", 3, "-n", n)["refused_actions"]
                self.assertEqual({each["action"]: each["reason"] for each in refused}, wanted)

    def test_actions_that_no_world_like_this_carries_out_are_a_warning_that_nothing_hides(self):
        self.write("m.meld", "moveTo(A, 9, 0, 0) :- id(A, _).\n")
        for n in (1, 2):
            out, err = self.call("meldsim", "run", "m.meld", "--world", "w.toml", "--quiet", "-n", n)
            self.assertEqual(out, "")
            self.assertEqual(err, "warning: 4 actions were not carried out, since nothing in this world does so: give it [motion] kind = "
                                  '"lattice"\n')

    def test_routes_that_lead_nowhere_are_counted_however_a_run_ends(self):
        self.write("d.meld", "type route edge(node, node).\ntype p(node).\ntype q(node).\np(@0).\nedge(A, @0) :- id(A, I), I > 0.\n"
                             "q(A) :- edge(A, B), p(B).\n")
        self.write("line.toml", LINE)
        self.write("moves.toml", LINE + '[motion]\nkind = "lattice"\n')
        first = "edge(@2, @0) is a route that leads nowhere, since @2 and @0 do not touch"
        for world, ticks, warned in (("line.toml", (), 1), ("line.toml", ("--ticks", 1), 1), ("moves.toml", (), 0)):
            for n in (1, 2):
                out, err = self.call("meldsim", "run", "d.meld", "--world", world, *ticks, "-n", n, "--json", "--quiet")
                self.assertEqual(json.loads(out)["dead_routes"], {"count": 2, "first": first})
                self.assertEqual(err.count(f"warning: {first} (and 1 more)"), warned)
            self.assertIn(f"  dead routes       {first} (and 1 more)\n", self.call("meldsim", "run", "d.meld", "--world", world, *ticks)[0])

    def test_dropped_facts_are_a_warning_that_nothing_hides(self):
        self.write("moves.toml", LINE + '[motion]\nkind = "lattice"\n')
        self.write("m.meld", "type linear ball(node).\ntype route to(node, node).\nball(@0). to(@0, @3).\nball(A), to(A, B) -o ball(B).\n")
        for n in (1, 2):
            out, err = self.call("meldsim", "run", "m.meld", "--world", "moves.toml", "--quiet", "-n", n)
            self.assertEqual(out, "")
            self.assertIn("warning: 1 linear fact was dropped", err)


class ManyMistakes(Case):
    def test_fifty_messages_the_errors_first(self):
        rules = [f"p(A) :- q(A, X{i}).\n" for i in range(60)] + [f"p(A) :- none{i}(A).\n" for i in range(40)]
        self.write("many.meld", "type p(node).\ntype q(node, int).\n" + "".join(rules))
        err = self.call("meldc", "check", "many.meld", code=1)[1]
        self.assertEqual((err.count("error["), err.count("warning[")), (40, 10))
        self.assertTrue(err.endswith("\n40 errors and 60 warnings in all; 50 are shown, and `meldc check many.meld --all` shows the others"
                                     "\n"))
        err = self.call("meldc", "check", "many.meld", "--all", code=1)[1]
        self.assertEqual((err.count("error["), err.count("warning[")), (40, 60))
        self.assertEqual(len(json.loads(self.call("meldc", "check", "many.meld", "--json", code=1)[0])), 100)


class Pages(Case):
    def test_a_cure_that_declares_what_it_uses_compiles(self):
        """And is not refused in turn by another message."""
        table = (pathlib.Path(__file__).resolve().parents[2] / "compiler/diagnostics/kinds.def").read_text()
        tried = 0
        for code in re.findall(r'^MELD_KIND\(\w+, "(E\w+)"', table, re.MULTILINE):
            page = self.call("meldc", "explain", code)[0].rstrip("\n").splitlines()
            at = len(page)
            while page[at - 1].startswith("    ") or not page[at - 1]:
                at -= 1
            cure = "".join(line[4:] + "\n" for line in page[at:])
            if not cure.lstrip("\n").startswith("type "):
                continue
            self.write("cure.meld", cure)
            done = self.run_tool("meldc", "check", "--json", "cure.meld").stdout
            found = {each["code"] for each in json.loads(done) if each["severity"] == "error"}
            # What it reads may be declared elsewhere.
            if found <= {"E0301", "E0302", "E0305"} and found:
                continue
            tried += 1
            with self.subTest(code=code):
                self.assertEqual(found, set(), cure)
        self.assertGreater(tried, 10)


class SeveralPrograms(Case):
    FILES = {"good.meld": COUNT, "wrong.meld": "type p(node).\np(A) :- none(A).\n",
             "shared.meld": "type s(node).\ns(A) :- nowhere(A).\n", "a.meld": 'include "shared.meld".\n',
             "b.meld": 'include "shared.meld".\ntype p(node).\np(A) :- id(A, N).\n'}

    def test_the_worst_decides_and_a_line_sums_up(self):
        self.assertEqual(self.call("meldc", "check", "good.meld", "good.meld")[1], "2 programs: no errors\n")
        err = self.call("meldc", "check", "good.meld", "wrong.meld", "good.meld", code=1)[1]
        self.assertIn("no predicate `none`", err)
        self.assertTrue(err.endswith("\n\n3 programs, 1 with errors: 1 error\n"), err)
        err = self.call("meldc", "check", "gone.meld", "wrong.meld", "good.meld", code=2)[1]
        self.assertIn("gone.meld", err.split("\n")[0])
        self.assertTrue(err.endswith("\n\n3 programs, 1 with errors, 1 not read: 1 error\n"), err)
        self.assertIn("2 programs, 1 not read: no errors in the others\n", self.call("meldc", "check", "gone.meld", "good.meld", code=2)[1])

    def test_a_message_in_a_file_that_two_include_is_shown_once(self):
        err = self.call("meldc", "check", "a.meld", "b.meld", code=1)[1]
        self.assertEqual(err.count("no predicate `nowhere`"), 1)
        self.assertTrue(err.endswith("\n2 programs, 2 with errors: 1 error and 1 warning\n"), err)

    def test_json_is_one_array(self):
        messages = json.loads(self.call("meldc", "check", "--json", "a.meld", "wrong.meld", "b.meld", code=1)[0])
        self.assertEqual([(m["path"], m["code"]) for m in messages],
                         [("shared.meld", "E0301"), ("wrong.meld", "E0301"), ("b.meld", "W0402")])
        self.assertEqual(json.loads(self.call("meldc", "check", "--json", "good.meld", "good.meld")[0]), [])
        out, err = self.call("meldc", "check", "--json", "gone.meld", "wrong.meld", code=2)
        self.assertEqual([m["code"] for m in json.loads(out)], ["E0301"])
        self.assertIn("gone.meld", err)


class Fixes(Case):
    MISSING = "type p(node, integer)  // how far\ntype q(node).\np(A, 1) :- q(A)\nq(@0).\n"

    def fixed(self, text, *more, code=0, name="f.meld"):
        """The text after `check --fix`, and what it said."""
        self.write(name, text)
        err = self.call("meldc", "check", "--fix", name, *more, code=code)[1]
        return self.read(name).decode(), err

    def test_safe_fixes_are_written_and_the_rest_is_shown(self):
        text, err = self.fixed(self.MISSING)
        self.assertEqual(text, "type p(node, int).  // how far\ntype q(node).\np(A, 1) :- q(A).\nq(@0).\n")
        self.assertEqual(err, "f.meld: 3 fixes applied\nf.meld: no errors\n")
        text, err = self.fixed("type p(node)\nr(A) :- p(A).\n", code=1)
        self.assertEqual(text, "type p(node).\nr(A) :- p(A).\n")
        self.assertIn("no predicate `r`", err)

    def test_guesses_are_left_to_the_author(self):
        program = "type p(node).\np(A) :- neighbour(A, B).\n"
        self.write("g.meld", program)
        fixes = [fix for m in json.loads(self.call("meldc", "check", "--json", "g.meld", code=1)[0]) for fix in m["fixes"]]
        self.assertEqual([(fix["title"], fix["safe"]) for fix in fixes],
                         [("Write `neighbor`", False), ("Declare `type neighbour(node, int).`", False)])
        self.assertEqual(self.fixed(program, code=1)[0], program)

    def test_capitals_for_the_variables_of_original_meld(self):
        text, _ = self.fixed("type p(node, int).\ntype q(node, int).\nconst n = 3.\nq(a, last-one) :- p(a, last-one), last-one > n.\n"
                             "q(a, m + 1) :- p(a, m).\n")
        self.assertEqual(text.split("\n")[3:5], ["q(A, Last_one) :- p(A, Last_one), Last_one > n.", "q(A, M + 1) :- p(A, M)."])
        clash = "type p(node, int).\ntype q(node, int).\nq(a, X) :- p(a, x), X = x + 1.\n"
        self.assertEqual(self.fixed(clash)[0], clash)

    def test_fixes_in_each_others_way_are_applied_one_after_the_other(self):
        text, err = self.fixed("type linear go(node, int).\ntype done(node).\n"
                               "go(A, N) -o done(A), set-static(A), set-cpu(A, N % @cpus), set-moving(A).\n")
        self.assertEqual(text, "type linear go(node, int).\ntype done(node).\ngo(A, N) -o done(A).\n")
        self.assertIn("`N` is used once", err)
        self.assertEqual(self.fixed("type linear go(node).\ngo(A) -o set-static(A).\n")[0], "type linear go(node).\ngo(A) -o 1.\n")
        self.assertEqual(self.fixed("type go(node).\nset-cpu(@1, 2).\ngo(@0).\n")[0], "type go(node).\ngo(@0).\n")

    def test_what_may_mean_something_else_is_left_to_the_author(self):
        for text in ("q(A) :- p(A) ;\n        r(A).\n", "p(A) => q(A).\n", "type p(node, number).\n",
                     "type d(node, int).\ntype n(node, int).\ntype f(node, int).\nf(a, n) :- d(a, n), n(a, n), m = proved(a, n), m > 0.\n"):
            self.write("g.meld", text)
            messages = json.loads(self.run_tool("meldc", "check", "--json", "g.meld").stdout)
            self.assertTrue(messages, text)
            self.assertEqual([m for m in messages if any(fix["safe"] for fix in m["fixes"])], [], text)
            self.write("f.meld", text)
            self.run_tool("meldc", "check", "--fix", "f.meld")
            self.assertEqual(self.read("f.meld").decode(), text)

    def test_signs_of_other_languages_lose_no_comment(self):
        declared = "type p(node).\ntype q(node).\n"
        for text, after in (("p(@1) /* the source */ ;\nq(A) :- p(A).\n", "p(@1) /* the source */.\nq(A) :- p(A).\n"),
                            ("p(A) /* to */ <- /* from */ q(A).\n", "p(A) /* to */ :- /* from */ q(A).\n"),
                            ("p(A)<-q(A).\n", "p(A):-q(A).\n")):
            self.assertEqual(self.fixed(declared + text)[0], declared + after)
        self.assertEqual(self.fixed("type d(node);\n")[0], "type d(node).\n")

    def test_signs_go_and_no_names_grow_together(self):
        declared = "type linear d(node).\ntype tok(node).\ntype linear e(node).\n"
        self.assertEqual(self.fixed(declared + "d(A) -o $tok(A).\n")[0], declared + "d(A) -o tok(A).\n")
        self.assertEqual(self.fixed(declared + "d(A), not $tok(A) -o e(A).\n")[0], declared + "d(A), not tok(A) -o e(A).\n")

    def test_values_in_brackets_are_joined_within_them(self):
        for value, *joined in (('"a" + (B + 1)', '"a" ++ int2str(B + 1)'), ('("a" + B)', '("a" ++ int2str(B))'),
                               ('"a" + ("b" + "c")', '"a" ++ ("b" + "c")', '"a" + ("b" ++ "c")')):
            self.write("g.meld", f"type p(node, string).\np(A, {value}) :- id(A, B).\n")
            messages = json.loads(self.call("meldc", "check", "--json", "g.meld", code=1)[0])
            line = self.read("g.meld").decode().split("\n")[1]
            fixed = [line[:e["column"] - 1] + e["text"] + line[e["end_column"] - 1:] for m in messages for fix in m["fixes"]
                     for e in fix["edits"]]
            self.assertEqual(fixed, [f"p(A, {text}) :- id(A, B)." for text in joined])

    def test_all_are_applied_however_many(self):
        text, err = self.fixed("".join(f"# comment {i}\n" for i in range(500)) + COUNT)
        self.assertEqual(text, "".join(f"// comment {i}\n" for i in range(500)) + COUNT)
        self.assertIn("f.meld: 500 fixes applied\n", err)

    def test_included_files_are_fixed_once_for_all_programs(self):
        self.write("part.meld", "type p(node)\ntype q(node).\n")
        self.write("a.meld", 'include "part.meld".\np(A) :- q(A).\n')
        self.write("b.meld", 'include "./part.meld".\nq(A) :- p(A)\n')
        err = self.call("meldc", "check", "--fix", "a.meld", "b.meld")[1]
        self.assertEqual(self.read("part.meld"), b"type p(node).\ntype q(node).\n")
        self.assertEqual(self.read("b.meld"), b'include "./part.meld".\nq(A) :- p(A).\n')
        self.assertIn("part.meld: 1 fix applied\n", err)
        self.assertIn("b.meld: 1 fix applied\n", err)

    def test_what_it_does_not_touch(self):
        self.write("fine.meld", COUNT)
        path = self.folder / "fine.meld"
        before = path.stat()
        self.call("meldc", "check", "--fix", "fine.meld")
        self.assertEqual((path.stat().st_ino, path.stat().st_mtime_ns), (before.st_ino, before.st_mtime_ns))
        self.assertEqual(self.call("meldc", "check", "--fix", "gone.meld", code=2)[1].count("\n"), 1)
        for text in ("type p(node)", "type p(node, foo)."):
            piped = self.run_tool("bash", "-c", f"printf '{text}\\n' | {TOOLS.meldc} check --fix /dev/stdin")
            self.assertEqual((piped.returncode, piped.stderr), (2, "meldc: cannot fix /dev/stdin: it is not a file\n"))

    def test_a_file_that_cannot_be_written(self):
        self.write("full.meld", "type p(node)\n" + "// " + "x" * 9000 + "\n")
        before = self.read("full.meld")
        self.refused("meldc", "check", "--fix", "full.meld", code=4, says="full.meld", preexec_fn=no_file_above(4096))
        self.assertEqual(self.read("full.meld"), before)


if __name__ == "__main__":
    main("meldc", "meldsim")
