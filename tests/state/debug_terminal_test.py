"""`meldsim debug` at a terminal: lines that are typed, edited and kept, signals, and the terminal as it was.

    debug_terminal_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import fcntl
import os
import pty
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from debug_test import GRADIENT, OWN, DebugTest  # noqa: E402
from frame import TOOLS, main, square  # noqa: E402
from running import LONG_TICK, SECONDS  # noqa: E402


class AtATerminal(DebugTest):
    def start(self, *arguments, output=None, cores=None, **variables):
        pid, self.terminal = pty.fork()
        if pid == 0:
            if cores is not None:
                os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:cores])
            if output is not None:
                os.dup2(output, 1)
            # The files of whoever runs the tests are not theirs.
            variables = {**os.environ, "HOME": str(self.folder), "XDG_STATE_HOME": "", "TERM": "xterm", **variables}
            os.execve(TOOLS.meldsim, ["meldsim", "debug", *map(str, arguments)], variables)
        self.pid, self.shown = pid, ""
        self.addCleanup(self.leave, pid, self.terminal)
        self.resize(200)

    def resize(self, columns):
        fcntl.ioctl(self.terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 50, columns, 0, 0))

    def leave(self, pid, terminal):
        if pid == self.pid:
            os.kill(pid, signal.SIGKILL)
            os.waitpid(pid, 0)
        os.close(terminal)

    def expect(self, text, seconds=20):
        """What was shown up to this text."""
        end = time.monotonic() + seconds
        while text not in self.shown:
            ready, _, _ = select.select([self.terminal], [], [], max(0, end - time.monotonic()))
            try:
                more = os.read(self.terminal, 4096).decode() if ready else ""
            except OSError:
                more = ""
            self.assertTrue(more, f"'{text}' is missing in {self.shown!r}")
            self.shown += more
        before, _, self.shown = self.shown.partition(text)
        return before

    def edits(self, prompt="> "):
        """The prompt is there, and what is typed is the editor's."""
        shown = self.expect(prompt)
        self.wait_for(lambda: not termios.tcgetattr(self.terminal)[3] & termios.ICANON, seconds=20)
        return shown

    def rest(self):
        """What it shows until it ends."""
        shown, self.shown = self.shown, ""
        while select.select([self.terminal], [], [], 20)[0]:
            try:
                shown += os.read(self.terminal, 4096).decode()
            except OSError:
                return shown
        self.fail(f"it goes on after {shown!r}")

    def say(self, text):
        os.write(self.terminal, text.encode())

    def interrupt_a_run(self):
        self.say("run\n")
        self.expect("run")
        time.sleep(0.4)
        self.say("\x03")
        self.expect(": interrupted")
        self.expect("> ")

    def ends(self, code):
        found = []
        self.wait_for(lambda: found or self.has_ended(found), seconds=20)
        self.pid = None
        self.assertEqual(os.waitstatus_to_exitcode(found[0]), code)

    def has_ended(self, found):
        pid, status = os.waitpid(self.pid, os.WNOHANG)
        if pid != 0:
            found.append(status)
        return pid != 0

    def test_a_session(self):
        self.start(GRADIENT)
        self.expect("tick 0> ")
        self.say("step 9\n")
        self.expect("tick 9> ")
        self.say("\n")
        self.expect("tick 10> ")
        self.say("bakc\n")
        self.expect("Did you mean 'back'?")
        self.expect("tick 10> ")
        self.say("facts\n")
        shown = self.expect("more")
        self.assertEqual(shown.count("dist(@"), 40)
        self.expect("tick 10> ")
        # Ctrl-C drops what was typed, and Ctrl-D ends.
        self.say("run\x03")
        self.expect("tick 10> ")
        self.say("where\n")
        self.expect("catoms   8000")
        self.expect("tick 10> ")
        self.say("\x04")
        self.ends(0)

    def test_a_session_on_several_processes(self):
        """The terminal is that of the process which has started them."""
        self.start(OWN / "waiting.meld", "--ticks", 10**9, "-n", 2)
        self.expect("tick 0> ")
        self.say("step 2\n\nbakc\n")
        self.expect("tick 3> ")
        self.expect("Did you mean 'back'?")
        self.say("facts\n")
        self.expect("more")
        self.expect("tick 3> ")
        for _ in range(2):
            self.interrupt_a_run()
        self.say("to 5\n")
        self.expect("tick 5\r\n")
        self.expect("tick 5> ")
        self.say("\x04")
        self.ends(0)

    def goes_on_and_ends(self):
        self.expect("tick 0> ")
        self.say("step 2\n")
        self.expect("tick 2\r\n")
        self.expect("tick 2> ")
        self.say("\x04")
        self.ends(0)

    def test_ctrl_c_at_the_prompt_is_over_with_the_prompt(self):
        for processes in (1, 2):
            self.start(GRADIENT, "-n", processes)
            for _ in range(2):
                self.expect("tick 0> ")
                self.say("\x03")
            self.goes_on_and_ends()

    def test_ctrl_c_as_soon_as_there_is_a_prompt(self):
        """All processes share one core, so that some are slow to come as far as the one that shows the prompt."""
        for _ in range(8):
            self.start(GRADIENT, "-n", 2, cores=1)
            self.expect("tick 0> ")
            self.say("\x03")
            self.goes_on_and_ends()

    def test_sigterm_ends_a_session(self):
        for processes in (1, 2):
            self.start(GRADIENT, "-n", processes)
            self.expect("tick 0> ")
            self.say("\x03")
            self.expect("tick 0> ")
            os.kill(self.pid, signal.SIGTERM)
            self.assertEqual(self.rest().count("interrupted"), 1)
            self.ends(143)

    def test_the_second_ctrl_c_ends_a_long_tick(self):
        program, world = self.write("long.meld", LONG_TICK), self.write("large.toml", square(600))
        for processes in (1, 2):
            self.start(program, "--world", world, "-n", processes)
            self.expect("tick 0> ")
            self.say("step\n")
            for _ in range(2):
                time.sleep(0.5)
                self.say("\x03")
            self.ends(130)

    def test_where_nobody_reads_its_answers_it_ends(self):
        for processes in (1, 2):
            read, write = os.pipe()
            self.start(GRADIENT, "-n", processes, output=write)
            os.close(write)
            self.assertEqual(os.read(read, 100), b"tick 0> ")
            os.close(read)
            self.say("where\n")
            self.expect("cannot write standard output")
            self.ends(4)

    LEFT, RIGHT, UP, DOWN, HOME, DELETE = "\x1b[D", "\x1b[C", "\x1b[A", "\x1b[B", "\x1b[H", "\x1b[3~"
    HISTORY = ".local/state/claymeld/debug-history"

    def test_lines_are_edited(self):
        self.start(GRADIENT)
        for typed, tick in (("sep 9" + 4 * self.LEFT + "t", 9), (self.UP, 18), ("back 3", 15), (2 * self.UP + self.DOWN, 12),
                            ("xback 12" + self.HOME + self.DELETE, 0), ("step 4 nonsense" + 9 * "\x7f", 4), ("4" + self.HOME + "step ", 8),
                            ("st\0ep", 9), ("stäp" + self.LEFT + "\x7fe", 10), ("\x12ck 3", 7)):
            self.edits("> ")
            self.say(typed + "\n")
            self.expect(f"tick {tick}\r\n")
        self.say("quit\n")
        self.ends(0)

    def test_tab_completes(self):
        self.start(GRADIENT)
        for typed, shows in (("st\t2", ["tick 2\r\n"]), ("facts @4 di\t", ["dist(@4, 1)."]), ("query so\tA)", ["A\r\n@0"]),
                             ("query dist(@796\t, D)", ["7969", "no rows"]), ("break 1\t", ["1: break 1"]),
                             ("break grad\t10 if so\tA)", ["2: break gradient.meld:10 if source(A)"]),
                             ("help save-e\t", ["save-events"]), ("why --d\t1 dist(@0\t, 0)", ["dist(@0, 0)"])):
            self.edits("> ")
            self.say(typed + "\n")
            for text in shows:
                self.expect(text)
        self.edits("> ")
        self.say("wh\t")
        self.assertEqual(self.expect("tick 2> wh").split("\n")[1].split(), ["where", "why", "why-not"])
        self.say("y dist(@7\t")
        self.assertEqual(self.expect("and more").split("\n", 1)[1].split()[0], "7")
        self.expect("tick 2> why dist(@7")
        self.say(f"\x15save-events {self.folder}/de\t")
        self.expect("/de")
        (self.folder / "deep").mkdir()
        self.say("\tfile.toml\n")
        self.expect("deep/file.toml: 0 events")
        self.say("\x04")
        self.ends(0)
        self.assertTrue((self.folder / "deep/file.toml").exists())

    def session_of(self, *lines, **variables):
        self.start(GRADIENT, **variables)
        for line in lines:
            self.expect("> ")
            self.say(line + "\n")
        self.expect("> ")
        self.say("\x04")
        self.ends(0)

    def test_lines_are_kept_for_later_sessions(self):
        self.session_of("step 3", "", "where", "where", "bakc")
        self.assertEqual(self.read(self.HISTORY).decode(), "step 3\nwhere\nbakc\n")
        for path in ("", "..", "../.."):
            self.assertEqual((self.folder / self.HISTORY).parent.joinpath(path).resolve().stat().st_mode & 0o777, 0o700)
        self.assertEqual((self.folder / self.HISTORY).stat().st_mode & 0o777, 0o600)
        self.start(GRADIENT)
        self.edits("> ")
        self.say(3 * self.UP + "0\n")
        self.expect("tick 30\r\n")
        self.say("\x04")
        self.ends(0)
        self.assertEqual(self.read(self.HISTORY).decode(), "step 3\nwhere\nbakc\nstep 30\n")

    def test_a_history_that_is_elsewhere_long_or_not_to_be_had(self):
        elsewhere = self.folder / "state/claymeld/debug-history"
        self.write("state/claymeld/debug-history", "".join(f"to {i}\n" for i in range(2001)) + "a\x1bb\n")
        elsewhere.chmod(0o644)
        self.session_of("step 3", XDG_STATE_HOME=str(self.folder / "state"))
        lines = elsewhere.read_text().splitlines()
        self.assertEqual((len(lines), lines[0], lines[-2:]), (1001, "to 1001", ["to 2000", "step 3"]))
        self.assertEqual(elsewhere.stat().st_mode & 0o777, 0o600)
        os.mkfifo(self.folder / "state/pipe")
        elsewhere.unlink()
        elsewhere.symlink_to(self.folder / "state/pipe")
        self.session_of("step 3", XDG_STATE_HOME=str(self.folder / "state"))
        for nowhere in (str(self.write("file", "")), "/proc/none"):
            self.session_of("step 3", XDG_STATE_HOME=nowhere)
        self.assertFalse((self.folder / ".local").exists())

    def test_a_terminal_that_cannot_be_edited_on(self):
        self.session_of("st\tep 3", TERM="dumb")
        self.assertFalse((self.folder / ".local").exists())

    def test_ctrl_c_and_ctrl_d_while_a_line_is_edited(self):
        self.start(GRADIENT)
        self.edits("tick 0> ")
        self.say("step 5\x03")
        self.edits("tick 0> ")
        self.say("step 3" + self.LEFT + "\x04" + "2\n")
        self.expect("tick 2\r\n")
        self.edits("tick 2> ")
        self.say("\x04")
        self.ends(0)

    def test_the_terminal_changes_its_size(self):
        self.start(GRADIENT)
        self.edits("tick 0> ")
        self.say("to 3\n")
        self.edits("tick 3> ")
        text = "query dist(A, 1), dist(B, 0), A <> B"
        for columns, whole in ((30, False), (120, True)):
            self.resize(columns)
            # The signal is answered before what is typed after it.
            time.sleep(0.3)
            self.say(text)
            shown = self.expect("B", 5) + self.rest_of_line()
            self.assertEqual(text in shown, whole, shown)
            self.say("\n")
            self.expect("3 rows")
            self.edits("> ")
        self.say("\x04")
        self.ends(0)

    def test_what_is_typed_before_the_prompt(self):
        """The terminal keeps Ctrl-D as a byte that is zero."""
        self.start(GRADIENT)
        self.say("step 2\nstep\n\x04")
        self.expect("tick 2\r\n")
        self.expect("tick 3\r\n")
        self.ends(0)

    def rest_of_line(self):
        shown = "B"
        while select.select([self.terminal], [], [], 0.5)[0]:
            self.shown += os.read(self.terminal, 4096).decode()
        shown, self.shown = shown + self.shown, ""
        return shown

    def test_the_terminal_is_as_it_was(self):
        """While a command runs, and however the session ends."""
        def mode():
            return termios.tcgetattr(self.terminal)[:4]
        for signals, code in (([], 0), ([signal.SIGTERM], 143), ([signal.SIGSTOP, signal.SIGTERM, signal.SIGTERM, signal.SIGCONT], 143),
                              ([signal.SIGQUIT], -signal.SIGQUIT), ([signal.SIGABRT], -signal.SIGABRT)):
            self.start(OWN / "waiting.meld", "--ticks", 10**9)
            before = mode()
            self.expect("tick 0> ")
            self.wait_for(lambda: mode() != before, seconds=5)
            self.say("run\n")
            self.wait_for(lambda: mode() == before, seconds=5)
            self.say("\x03")
            self.expect("> ")
            self.wait_for(lambda: mode() != before, seconds=5)
            for each in signals:
                os.kill(self.pid, each)
            if not signals:
                self.say("\x04")
            self.ends(code)
            self.assertEqual(mode(), before)

    def test_a_session_that_is_stopped_goes_on(self):
        self.start(GRADIENT)
        before = termios.tcgetattr(self.terminal)
        self.expect("tick 0> ")
        self.say("ste")
        self.expect("ste")
        os.kill(self.pid, signal.SIGSTOP)
        edits = termios.tcgetattr(self.terminal)
        # As a shell does it.
        termios.tcsetattr(self.terminal, termios.TCSANOW, before)
        os.kill(self.pid, signal.SIGCONT)
        self.wait_for(lambda: termios.tcgetattr(self.terminal)[:4] == edits[:4], seconds=5)
        os.kill(self.pid, signal.SIGTSTP)
        self.say("p 4\n")
        self.expect("tick 4\r\n")
        self.say("\x04")
        self.ends(0)

    def test_ctrl_c_stops_between_two_ticks(self):
        self.start(OWN / "waiting.meld", "--ticks", 10**9)
        self.expect("> ")
        for _ in range(2):
            self.interrupt_a_run()
        self.say("to 5\n")
        self.expect("tick 5\r\n")
        self.say("facts longest\n")
        self.expect("> ")
        os.kill(self.pid, signal.SIGTERM)
        self.ends(143)

    def test_a_pipe_is_interrupted(self):
        for processes in (1, 2):
            self.interrupt(processes)

    def interrupt(self, processes):
        run = subprocess.Popen([TOOLS.meldsim, "debug", OWN / "waiting.meld", "--ticks", str(10**9), "--quiet", "-n", str(processes)],
                               stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        run.stdin.write("step 3\nrun\nwhere\n")
        run.stdin.flush()
        self.assertEqual(run.stdout.readline(), "tick 3\n")
        time.sleep(0.3)
        run.send_signal(signal.SIGINT)
        out, err = run.communicate(timeout=20)
        self.assertEqual(run.returncode, 130)
        self.assertRegex(out, r"^tick \d+: interrupted\n$")
        self.assertRegex(err, r"^meldsim: interrupted after tick \d+\n$")

    def test_what_takes_long_is_interrupted(self):
        """A pipe with commands that nobody writes, and a tick of minutes."""
        os.mkfifo(self.folder / "pipe")
        long = self.write("long.meld", LONG_TICK)
        world = self.write("large.toml", square(600))
        self.write("step.txt", "step\n")
        for processes, commands, seconds in ((1, "pipe", 1), (2, "step.txt", 3)):
            run = self.begin("meldsim", "debug", long, "--world", world, "--quiet", "-n", processes, "--commands", commands,
                             stderr=subprocess.PIPE, text=True)
            time.sleep(seconds)
            run.terminate()
            _, err = run.communicate(timeout=SECONDS)
            self.assertEqual((run.returncode, err.count("interrupted")), (143, 1), err)


if __name__ == "__main__":
    main("meldc", "meldsim")
