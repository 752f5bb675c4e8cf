"""What a user may trust: modules are their own, files that others wrote can neither hang a command nor speak to a terminal, and the
processes of a run are of one mind.

    trust_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import os
import pathlib
import pwd
import resource
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import frame  # noqa: E402
from frame import COUNT, OPEN_MPI, TOOLS, main, square  # noqa: E402

# A terminal would change its title, turn red, go back to the start of the line, and read backwards.
EVIL = "\x1b]0;owned\x07\x1b[31m\r\x7f\u009b2J\u202e"
OBEYED = ("\x1b", "\x07", "\r", "\x7f", "\u009b", "\u202e")


class Case(frame.Case):
    FILES = {"w.toml": square(2), "p.meld": COUNT}


class Cache(Case):
    def compile(self, code, says="", **changes):
        out, err = self.call("meldc", "compile", "p.meld", environment={"CLAYMELD_CACHE": None} | changes, code=code)
        self.assertIn(says, err)
        return out.strip()

    def test_it_is_never_a_folder_in_tmp(self):
        module = self.compile(0, HOME=None, XDG_CACHE_HOME=None) if os.access(pwd.getpwuid(os.geteuid()).pw_dir, os.W_OK) else "/"
        self.assertFalse(module.startswith("/tmp/claymeld-"), module)

    def test_the_folder_is_for_its_user_alone(self):
        module = self.compile(0, XDG_CACHE_HOME=self.folder / "c")
        cache = os.path.dirname(module)
        self.assertEqual(os.stat(cache).st_mode & 0o777, 0o700)
        for mode in (0o777, 0o770, 0o755):
            os.chmod(cache, mode)
            self.compile(2, f"chmod 700 {cache}", XDG_CACHE_HOME=self.folder / "c")
        os.chmod(cache, 0o700)
        self.assertEqual(self.compile(0, XDG_CACHE_HOME=self.folder / "c"), module)

    def test_a_folder_of_another_user_is_refused(self):
        cache = self.folder / "c"
        cache.mkdir(mode=0o700)
        try:
            os.chown(cache, 12345, 12345)
        except PermissionError:  # Only root gives folders away; the others find one of root's.
            cache = "/usr"
        self.compile(2, f"belongs to another user (number {os.stat(cache).st_uid})", CLAYMELD_CACHE=cache)

    def test_what_is_no_module_is_replaced_unread(self):
        module = self.compile(0, XDG_CACHE_HOME=self.folder / "c")
        for make in (os.mkfifo, lambda path: os.symlink("/dev/zero", path)):
            os.unlink(module)
            make(module)
            self.assertEqual(self.compile(0, XDG_CACHE_HOME=self.folder / "c"), module)
            self.assertTrue(os.path.isfile(module) and not os.path.islink(module))


class Inputs(Case):
    """Nothing that a file names may keep a command waiting or fill its memory."""

    def setUp(self):
        super().setUp()
        os.mkfifo(self.folder / "pipe")
        os.symlink("/dev/zero", self.folder / "zero.meld")
        os.truncate(os.open(self.folder / "huge", os.O_CREAT | os.O_WRONLY), 1 << 42)

    def test_programs(self):
        for path, says in (("/dev/zero", "/dev/zero is a device, not a file"), ("zero.meld", "is a device"), ("huge", "larger than 64")):
            self.refused("meldc", "check", path, code=2, says=says)
            self.refused("meldsim", "run", path, code=2, says=says)
            self.refused("meldc", "fmt", path, code=2, says=says)

    def test_includes(self):
        for path, says in (("pipe", "is a pipe, not a file"), ("/dev/zero", "is a device, not a file"), ("huge", "larger than 64")):
            for word in ("include", "import p from"):
                self.write("i.meld", f'{word} "{path}".\n' + COUNT)
                self.refused("meldc", "check", "i.meld", code=1, says=["E0113", says], lines=None)

    def test_linked_files(self):
        self.write("e.meld", "extern int f(int).\ntype p(node, int).\np(A, f(1)).\n")
        os.mkfifo(self.folder / "f.c")
        self.refused("meldc", "compile", "e.meld", "--link", "f.c", code=2, says="f.c is a pipe, not a file")

    def test_worlds_and_what_they_name(self):
        free = '[motion]\nkind = "bodies"\n[[body]]\npositions = "{}"\n'
        listed = 'lattice = "cubic"\n[[body]]\ncells = "{}"\n'
        for path, says in (("pipe", "pipe is a pipe, not a file"), ("/dev/zero", "is a device, not a file"), ("huge", "larger than 4 GiB")):
            for text in (free, listed):
                self.write("w.toml", text.format(path))
                self.refused("meldsim", "world", "w.toml", code=2, says=says)
                self.refused("meldsim", "run", "p.meld", "--world", "w.toml", code=2, says=says)
        for path, says in (("/dev/zero", "is a device"), ("huge", "larger than 256")):
            self.refused("meldsim", "run", "p.meld", "--world", path, code=2, says=says)

    def test_graphs_and_further_programs(self):
        for path, says in (("pipe", "is a pipe, not a file"), ("/dev/zero", "is a device, not a file"), ("huge", "larger than 16 GiB")):
            for text in ('links = "{}"\n', 'links = "e.csv"\nnodes = "{}"\n'):
                self.write("e.csv", "0,1\n")
                self.write("g.toml", 'lattice = "graph"\n' + text.format(path))
                self.refused("meldsim", "world", "g.toml", code=2, says=says)
        for path, says in (("pipe", "pipe is a pipe, not a file"), ("/dev/zero", "is a device, not a file"), ("huge", "larger than 64")):
            self.write("g.toml", square(2) + f'[[program]]\nwhere = "all"\nfile = "{path}"\n')
            self.refused("meldsim", "run", "p.meld", "--world", "g.toml", code=2, says=says)

    def test_a_file_that_memory_does_not_hold(self):
        os.truncate(os.open(self.folder / "large", os.O_CREAT | os.O_WRONLY), 1 << 31)
        self.write("w.toml", 'lattice = "graph"\nlinks = "large"\n')
        self.refused("meldsim", "world", "w.toml", code=4, says=["large takes 2 GiB of memory", "left by ulimit -d"],
                     preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_DATA, (1 << 30, 1 << 30)))

    def test_modules_and_extensions(self):
        os.mkfifo(self.folder / "m.so")
        self.refused("meldsim", "run", "./m.so", "--world", "w.toml", code=2, says="m.so is a pipe, not a file")
        self.refused("meldsim", "run", "p.meld", "--world", "w.toml", "--extension", "m.so", code=2, says="m.so is not a file")

    def test_recordings(self):
        for path in ("pipe", "/dev/zero"):
            self.refused("meldsim", "replay", path, code=2, says=f"cannot read {path}: it is no regular file")

    def test_a_pipe_that_the_user_names_is_read(self):
        for command in ('"$1" check <(cat p.meld)', '"$2" run p.meld --quiet --world <(cat w.toml) --facts-out f'):
            self.call("bash", "-c", command, "bash", TOOLS.meldc, TOOLS.meldsim)
        self.assertEqual((self.folder / "f").read_text().count("p(@"), 4)


class Terminal(Case):
    """What a file or its name says is shown and not obeyed."""

    def shows_nothing_obeyed(self, tool, *arguments, code, holds=""):
        for text in self.call(tool, *arguments, code=code):
            for obeyed in OBEYED:
                self.assertNotIn(obeyed, text)
            if holds and holds in text:
                holds = ""
        self.assertEqual(holds, "", "something is not said")

    def test_messages_of_the_compiler(self):
        self.write(f"a{EVIL}.meld", f'type p(node).\np(A) :- q(A). // {EVIL}\n"{EVIL}"\n')
        self.shows_nothing_obeyed("meldc", "check", f"a{EVIL}.meld", code=1, holds="a\\x1b]0;owned\\x07")
        self.shows_nothing_obeyed("meldc", "check", f"none{EVIL}", code=2, holds="none\\x1b]0;")
        self.shows_nothing_obeyed("meldc", "check", "--json", f"a{EVIL}.meld", code=1)
        self.write("i.meld", f'include "{EVIL}".\n' + COUNT)
        self.shows_nothing_obeyed("meldc", "check", "i.meld", code=1)
        self.shows_nothing_obeyed("meldc", f"{EVIL}", code=2)
        self.shows_nothing_obeyed("meldc", "explain", f"{EVIL}", code=2)

    def test_messages_of_a_run(self):
        self.write("w.toml", square(2) + f"[set]\n\"{json.dumps(EVIL)[1:-1]}\" = 1\n")
        self.shows_nothing_obeyed("meldsim", "run", "p.meld", "--world", "w.toml", code=2)
        self.shows_nothing_obeyed("meldsim", "run", "p.meld", "--world", f"none{EVIL}", code=2)
        self.write(f"w{EVIL}.toml", square(2))
        self.shows_nothing_obeyed("meldsim", "world", f"w{EVIL}.toml", code=0, holds="w\\x1b]0;")

    def test_what_catoms_print(self):
        self.write("say.meld", f'print(@0, "{EVIL}").\nwrite-string(@1, "tab\\t, {EVIL} and Größe").\n')
        for n in (1, 2):
            self.shows_nothing_obeyed("meldsim", "run", "say.meld", "--world", "w.toml", "--quiet", "-n", n, code=0,
                                      holds="tab\t, \\x1b]0;owned\\x07\\x1b[31m\\x0d\\x7f\\xc2\\x9b2J\\xe2\\x80\\xae and Größe\n")

    def test_names_of_nodes(self):
        self.write("e.csv", "from,to,w" + EVIL.replace("\r", "") + "\na" + EVIL.replace("\r", "") + ",b,1\n")
        self.write("g.toml", 'lattice = "graph"\nlinks = "e.csv"\n')
        self.write("n.meld", "type name(node, string).\ntype w(node, node, int).\nprint(A, N) :- name(A, N).\n")
        for command in (("world", "g.toml"), ("run", "n.meld", "--world", "g.toml", "--facts-out", "-"),
                        ("query", "n.meld", "name(A, N)", "--world", "g.toml")):
            self.shows_nothing_obeyed("meldsim", *command, code=0, holds="" if command[0] == "world" else "owned\\x07")
        self.write("n.meld", "type name(node, string).\ntype link(node, node, bool).\np(A) :- name(A, _), link(A, _, _).\ntype p(node).\n")
        self.shows_nothing_obeyed("meldsim", "run", "n.meld", "--world", "g.toml", code=2)

    def test_facts(self):
        self.write("f.meld", f'type p(node, string).\np(@0, "{EVIL}").\n')
        self.shows_nothing_obeyed("meldsim", "run", "f.meld", "--world", "w.toml", "--quiet", "--facts-out", "-", code=0,
                                  holds="owned\\x07")


class Agreement(Case):
    """A launcher may start each process with a command of its own."""

    def run_together(self, *commands, code, says=""):
        words = []
        for arguments in commands:
            words += [":"] * bool(words) + ["-n", "1", TOOLS.meldsim, "run", *arguments]
        _, err = self.call("mpirun", "--quiet", "--bind-to", "none", *words, environment=OPEN_MPI, code=code)
        self.assertEqual(err.count("meldsim:"), 1 if says else 0, err)
        for text in [says] if isinstance(says, str) else says:
            self.assertIn(text, err)

    def setUp(self):
        super().setUp()
        self.write("k.meld", "type p(node, int).\nconst k = 1.\np(A, k) :- neighborCount(A, _).\n")
        self.same = ["k.meld", "--world", "w.toml", "--quiet", "--facts-out", "f"]

    def test_one_mind(self):
        self.run_together(self.same, self.same, self.same, code=0)
        self.run_together([*self.same, "--threads", "2"], self.same, code=0)
        self.assertEqual((self.folder / "f").read_text(), "".join(f"p(@{i}, 1).\n" for i in range(4)))

    def test_other_parameters(self):
        self.run_together([*self.same, "--set", "k=5"], [*self.same, "--set", "k=7"], code=2,
                          says="differ in the parameters (k=5 on process 0, k=7 on process 1)")
        self.run_together(self.same, self.same, [*self.same, "--seed", "9"], code=2,
                          says="the seed (1 on processes 0 and 1, 9 on process 2)")
        self.assertNotIn("f", self.files())

    def test_other_options(self):
        self.run_together(self.same, [*self.same, "--ticks", "3"], code=2, says="--ticks (none on process 0, 3 on process 1)")
        self.run_together(self.same, self.same[:-2], code=2, says="--facts-out (f on process 0, none on process 1)")
        self.run_together(self.same, [*self.same, "--digest", "d"], code=2, says="--digest (none on process 0, d on process 1)")
        self.run_together(self.same, [*self.same, "--timeout", "60"], code=2, says="--timeout (none on process 0, 60 on process 1)")

    def test_other_programs(self):
        self.write("other.meld", (self.folder / "k.meld").read_text() + "// Another one.\n")
        self.run_together(self.same, ["other.meld", *self.same[1:]], code=2, says="the program (k.meld on process 0, other.meld on")
        self.call("meldc", "compile", "k.meld", "-o", "a.so")
        self.call("meldc", "compile", "p.meld", "-o", "b.so")
        self.run_together(["./a.so", *self.same[1:]], ["./b.so", *self.same[1:]], code=2,
                          says="the program (./a.so on process 0, ./b.so on process 1)")

    def test_other_worlds(self):
        self.write("c.csv", "0,0\n1,0\n")
        self.write("w.toml", 'lattice = "square"\n[[body]]\ncells = "c.csv"\n')
        for name, cells in (("same", "0,0\n1,0\n"), ("other", "0,0\n1,0\n2,0\n")):
            (self.folder / name).mkdir()
            self.write(f"{name}/c.csv", cells)
            self.write(f"{name}/w.toml", (self.folder / "w.toml").read_text())
        there = [word.replace("w.toml", "same/w.toml") for word in self.same]
        self.run_together(self.same, there, code=0)
        there = [word.replace("w.toml", "other/w.toml") for word in self.same]
        self.run_together(self.same, there, code=2, says="the world (w.toml on process 0, other/w.toml on process 1)")

    def test_what_one_process_cannot_read_ends_all(self):
        for more in (["--world", "none.toml"], ["--extension", "none.so"]):
            self.run_together(["k.meld"], ["k.meld", *more], code=2, says=["on process 1: there is no file none."])


if __name__ == "__main__":
    main("meldc", "meldsim")
