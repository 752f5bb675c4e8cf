"""`cmake --install` into a folder that is moved afterwards: the programs, manual pages and completion work from there.

    install_test.py --build FOLDER [unittest options]
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import OPEN_MPI, TOOLS, main  # noqa: E402

# What examples/extensions/pile.cpp does, as rules.
PILE_AS_RULES = """
type linear greeting(node, node From, string Words, list float At).
type linear greetings(node, int Count).
type met(node, node Whom, string Words, float Height).
type linear go(node).
greetings(A, 0).
greeting(A, B, Words, [_, _, Z]), greetings(A, N) -o greetings(A, N + 1), met(A, B, Words, Z).
go(A).
go(A), position(A, X, Y, Z) -o go(A)@+1, {B | neighbor(A, B) | greeting(B, A, "hello", [X, Y, Z])}.
moveTo(A, 0, 0, T) :- tick(A, T), cell(A, _, _, 0).
print(A, "arrived after " ++ int2str(Z) ++ " requests") :- tick(A, T), cell(A, _, _, Z), Z > 0, Z = T - 1.
"""


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="meld install "))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        first, cls.prefix = cls.folder / "first", cls.folder / "moved"
        subprocess.run(["cmake", "--install", TOOLS.build, "--prefix", first], check=True, capture_output=True)
        first.rename(cls.prefix)
        cls.environment = {"PATH": f"{cls.prefix / 'bin'}:/usr/bin:/bin", "HOME": str(cls.folder),
                           "CLAYMELD_CACHE": str(cls.folder / "cache"), **OPEN_MPI}

    def call(self, *command):
        done = subprocess.run(command, env=self.environment, cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout}{done.stderr}")
        return done.stdout

    def test_programs_have_one_version(self):
        versions = {program: self.call(program, "--version").split() for program in ("meldc", "meldc-lsp", "meldsim")}
        self.assertEqual([name for name, _ in versions.values()], list(versions))
        self.assertEqual(len({number for _, number in versions.values()}), 1)

    def test_programs_find_each_other_and_the_backend(self):
        program = self.prefix / "share/claymeld/examples/gradient.meld"
        facts = self.call("meldsim", "run", str(program), "--quiet", "--facts-out", "-")
        self.assertEqual(facts.count("dist("), 8000)

    def test_without_the_part_for_pictures_all_else_works(self):
        lean = self.folder / "lean"
        subprocess.run(["cmake", "--install", TOOLS.build, "--prefix", lean, "--component", "claymeld"], check=True, capture_output=True)
        self.assertEqual([path.name for path in (lean / "lib/claymeld").iterdir()], ["libmeld_backend.so"])
        missing = {path.relative_to(self.prefix).as_posix() for path in self.prefix.rglob("*") if path.is_file()} - {
            path.relative_to(lean).as_posix() for path in lean.rglob("*") if path.is_file()}
        self.assertEqual(missing, {"lib/claymeld/libmeld_view.so"})
        environment = {**self.environment, "PATH": f"{lean / 'bin'}:/usr/bin:/bin"}
        (self.folder / "study.toml").write_text(f'program = "{lean}/share/claymeld/examples/leader.meld"\nseeds = [1, 2]\n')
        program = str(lean / "share/claymeld/examples/leader.meld")

        def lean_call(*words):
            return subprocess.run(["meldsim", *words], env=environment, cwd=self.folder, capture_output=True, text=True, check=False)

        for words in (["run", program, "-n", "2", "--quiet", "--record", "lean.vtkhdf"],
                      ["view", program, "--share", "lean.html", "--quiet"], ["query", program, "elected(A)"],
                      ["export", program, "-o", "lean.ply", "--quiet"]):
            done = lean_call(*words)
            self.assertEqual(done.returncode, 0, f"{words}\n{done.stderr}")
        self.assertIn("<!doctype html>", (self.folder / "lean.html").read_text()[:100])
        for words in (["shot", program, "-o", "lean.png"], ["shot", "lean.vtkhdf", "--steps", "-o", "lean.png"],
                      ["movie", program, "-o", "lean/"], ["view", program, "--no-open"], ["view", program, "-n", "2", "--no-open"],
                      ["world", program.replace(".meld", ".toml"), "--shot", "lean.png"],
                      ["sweep", "study.toml", "-o", "results", "--plot", "ticks~seed"]):
            done = lean_call(*words)
            self.assertEqual(done.returncode, 2, f"{words}\n{done.stdout}{done.stderr}")
            self.assertEqual(done.stderr.count("this meldsim has no pictures and no viewer"), 1, done.stderr)
            self.assertEqual(done.stderr.count("Install the package claymeld-view"), 1, done.stderr)
        self.assertFalse((self.folder / "lean.png").exists())
        # With the other part in its place it has them.
        subprocess.run(["cmake", "--install", TOOLS.build, "--prefix", lean, "--component", "view"], check=True, capture_output=True)
        done = lean_call("shot", program, "-o", "lean.png", "--quiet", "--size", "80x60")
        self.assertEqual((done.returncode, (self.folder / "lean.png").read_bytes()[:4]), (0, b"\x89PNG"), done.stderr)

    def test_python_package_reads_facts(self):
        program = self.prefix / "share/claymeld/examples/gradient.meld"
        self.call("meldsim", "run", str(program), "--quiet", "--facts-out", "gradient.h5")
        package = f"import sys; sys.path.insert(0, {str(self.prefix / 'share/claymeld/python')!r}); import claymeld; "
        self.assertEqual(self.call("/usr/bin/python3", "-B", "-c", package + "print(len(claymeld.facts('gradient.h5', 'dist')))"), "8000\n")
        # The package finds the meldsim of its prefix.
        runs = package + f"print(claymeld.run({str(program)!r}).facts('dist')['D'].max(), claymeld.find_meldsim())"
        out = self.call("/usr/bin/env", "-u", "CLAYMELD_MELDSIM", "PATH=/usr/bin:/bin", "/usr/bin/python3", "-B", "-c", runs)
        self.assertEqual(out, f"57 {self.prefix / 'bin/meldsim'}\n")

    def test_manual_pages_have_every_option(self):
        for program, command, options in (("meldc", "compile", ["--emit", "--link"]), ("meldsim", "run", ["--ticks", "--facts-out"])):
            page = (self.prefix / f"share/man/man1/{program}.1").read_text().replace("\\-", "-")
            self.assertIn(f".SS {program} {command} ", page)
            for option in options:
                self.assertIn(f"\\fB{option}\\fR", page)
        if shutil.which("man"):
            done = subprocess.run(["man", "--warnings", "-l", self.prefix / "share/man/man1/meldsim.1"], capture_output=True, text=True,
                                  check=True, env=dict(os.environ, MANWIDTH="100"))
            self.assertEqual(done.stderr, "")

    def complete(self, program, *words):
        script = self.prefix / "share/bash-completion/completions" / program
        line = " ".join(f"'{word}'" for word in (program, *words))
        run = f'. "$0"; COMP_WORDS=({line}) COMP_CWORD={len(words)}; _{program}; echo "${{COMPREPLY[@]}}"'
        return self.call("bash", "-c", run, str(script)).split()

    def test_bash_completes_commands_options_and_words(self):
        self.assertEqual(self.complete("meldsim", "wo"), ["world"])
        self.assertEqual(self.complete("meldsim", "run", "p.meld", "--th"), ["--threads"])
        self.assertEqual(self.complete("meldc", "compile", "--emit", "to"), ["tokens"])
        self.assertEqual(self.complete("meldc", "compile", "--emit", "=", "to"), ["tokens"])
        self.assertEqual(self.complete("meldc", "explain", "E0501"), ["E0501"])
        self.assertEqual(self.complete("meldsim", "help", "ru"), ["run"])
        self.assertEqual(self.complete("meldsim", "run", "p.me"), [])

    def test_every_shell_has_its_script(self):
        for program in ("meldc", "meldsim"):
            for path in (f"zsh/vendor-completions/_{program}", f"fish/vendor_completions.d/{program}.fish"):
                self.assertIn("--help" if "zsh" in path else "-l help", (self.prefix / "share" / path).read_text())

    def built_extensions(self):
        source, build = self.prefix / "share/claymeld/extensions", self.folder / "extensions"
        self.call("cmake", "-S", str(source), "-B", str(build), f"-DCMAKE_PREFIX_PATH={self.prefix}")
        self.call("cmake", "--build", str(build))
        return source, build

    def test_extensions_are_built_against_what_is_installed(self):
        source, build = self.built_extensions()
        flood = ["run", str(source / "flood.meld"), "--ticks", "4", "--extension", str(build / "examples.so")]
        world = str(source / "flood.toml")
        facts = self.call("meldsim", *flood, "--world", world, "--quiet", "--facts-out", "-")
        # 16 catoms in each of 8 layers, from z = -4 to 3; the level is 0.5 in tick 4.
        self.assertEqual((facts.count("depth("), facts.count("odometer("), facts.count("wet(")), (128, 128, 80))
        # The odometer reads `wet` as the tick before left it, when the level was 1.5.
        self.assertEqual((facts.count('"wet", ['), facts.count('"dry", [')), (96, 32))
        summary = json.loads(self.call("meldsim", *flood, "--world", world, "--json"))
        self.assertIn("at most 128 catoms", summary["outcomes"])
        self.call("meldsim", *flood, "--world", world, "--quiet", "-n", "2", "--facts-out", "two.facts")
        self.assertEqual((self.folder / "two.facts").read_text(), facts)

    def run_pile(self, program, *options):
        """The printed lines, and the facts that both programs have."""
        lines = self.call("meldsim", "run", str(program), "--ticks", "12", "--quiet", "--facts-out", "pile.facts", *options)
        facts = (self.folder / "pile.facts").read_text().splitlines()
        return lines, [fact for fact in facts if fact.startswith(("met(", "greeting"))]

    def test_what_an_extension_does_and_sends_is_as_if_rules_did(self):
        source, build = self.built_extensions()
        (self.folder / "rules.meld").write_text(PILE_AS_RULES)
        body = (source / "pile.toml").read_text().split("[components]")[0]
        (self.folder / "rules.toml").write_text(body)
        lines, facts = self.run_pile("rules.meld", "--world", "rules.toml")
        # One catom arrives in each tick but the first. Links on the plate and within the pile carry greetings.
        self.assertEqual(lines.count("arrived"), 11)
        self.assertIn('@10: arrived after 11 requests', lines)
        self.assertGreater(len(facts), 100)
        pile = ["--world", str(source / "pile.toml"), "--extension", str(build / "examples.so")]
        for options in ([], ["--threads", "2"], ["-n", "2"], ["-n", "3"]):
            self.assertEqual(self.run_pile(source / "pile.meld", *pile, *options), (lines, facts), options)
        # What a module asks for comes before what the rules of the same catom ask for, of which only the first can be granted.
        program = (source / "pile.meld").read_text()
        (self.folder / "both.meld").write_text(program + "moveTo(A, 2, 2, T) :- tick(A, T), cell(A, _, _, 0).\n")
        for options in ([], ["-n", "2"]):
            self.assertEqual(self.run_pile("both.meld", *pile, *options), (lines, facts), options)
        for before, after, says in (("linear greeting(", "greeting(", "no predicate greeting with 3 arguments"),
                                    ("greeting(node, node From, ", "greeting(node, ", "no predicate greeting with 3 arguments"),
                                    ("linear greeting(", "linear greetin(", "did you mean 'greetin'?"),
                                    ("action moveTo(node, int X, int Y, int Z)", "other(node)", "no predicate moveTo with 3 arguments")):
            self.assertIn(before, program)
            declarations = program.replace(before, after).split("greetings(A, 0)")[0]
            (self.folder / "wrong.meld").write_text(declarations)
            done = subprocess.run(["meldsim", "run", "wrong.meld", "--quiet", "--ticks", "1", *pile], env=self.environment,
                                  cwd=self.folder, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(says, done.stderr)

    def test_a_predicate_that_an_extension_does_not_find_is_an_error(self):
        text = (self.prefix / "share/claymeld/examples/thermometer.meld").read_text().replace("temperature", "temperatur")
        (self.folder / "lacking.meld").write_text(text)
        (self.folder / "lacking.toml").write_text('[[body]]\nshape = "box(2, 2, 2)"\n[components]\nthermometer = "plane"\n')
        done = subprocess.run(["meldsim", "run", "lacking.meld", "--quiet"], env=self.environment, cwd=self.folder, capture_output=True,
                              text=True, check=False)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("no predicate temperature with 1 argument", done.stderr)
        self.assertIn("did you mean 'temperatur'?", done.stderr)

    def test_an_unknown_name_or_file_of_an_extension_is_an_error(self):
        source = self.prefix / "share/claymeld/extensions"
        program, world = str(source / "flood.meld"), str(source / "flood.toml")
        for options, code, says in (([], 2, "there is no interface 'census'"),
                                    (["--extension", "none.so"], 2, "there is no file none.so"),
                                    (["--extension", str(self.prefix / "lib/claymeld/libmeld_backend.so")], 5, "is not an extension")):
            done = subprocess.run(["meldsim", "run", program, "--world", world, "--quiet", *options], env=self.environment,
                                  cwd=self.folder, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(says, done.stderr)

    def test_what_is_to_be_read_is_there(self):
        for path in ("library/gradient.meld", "examples/shape_change.meld", "editors/vscode/package.json"):
            self.assertTrue((self.prefix / "share/claymeld" / path).exists(), path)
        self.assertTrue((self.prefix / "share/doc/claymeld/language.md").exists())


if __name__ == "__main__":
    main("build")
