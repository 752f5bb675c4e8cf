"""What the commands say of wrong command lines, wrong worlds and programs with many mistakes, and which warnings no option hides.

    messages_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import frame  # noqa: E402
from frame import COUNT, main, square  # noqa: E402

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

    def test_the_box_holds_listed_positions(self):
        self.write("listed.toml", '[[body]]\npositions = [[0, 0, 0], [1.6, -3, 4]]\n[motion]\nkind = "bodies"\n')
        self.assertIn("2 catoms, within cells (0, -3, 0) to (2, 0, 4)", self.call("meldsim", "world", "listed.toml")[0])


class Runs(Case):
    def test_no_ticks_show_the_catoms(self):
        for n in (1, 2):
            out = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", "0", "-n", n)[0]
            self.assertRegex(out, r"catoms +4\n")

    def test_the_summary_names_the_world(self):
        self.assertRegex(self.call("meldsim", "run", "p.meld", "--world", "w.toml")[0], r"(?m)^  world +w\.toml$")
        self.assertRegex(self.call("meldsim", "run", "p.meld")[0], r"(?m)^  world +the default, a cube of 1,000 catoms$")
        self.assertEqual(json.loads(self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--json")[0])["world"], "w.toml")

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


if __name__ == "__main__":
    main("meldc", "meldsim")
