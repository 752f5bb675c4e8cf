"""Runs that are told to end, at every time of their lives: they end soon, say so once, exit with 130 or 143, leave no process and no
file behind, and what they wrote is whole.

    signals_test.py --meldc PATH --meldsim PATH [--runs N] [unittest options]

--runs: how many runs are ended at random moments.
"""
import os
import pathlib
import random
import shutil
import signal
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import OPEN_MPI, TOOLS, main  # noqa: E402
from running import Running, processes_of  # noqa: E402


class Interrupts(Running):
    OUTPUTS = ("--world", "small.toml", "--digest", "d", "--facts-out", "f", "--record", "r")

    def test_while_ticks_are_made(self):
        for n in (1, 2):
            for sent, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
                with self.subTest(n=n, sent=sent):
                    self.forget_outputs()
                    run = self.start("forever.meld", "-n", n, *self.OUTPUTS)
                    self.ticks_are_made(run)
                    run.send_signal(sent)
                    out, err = self.ended(run, [code])
                    self.assertEqual((out + err).count("interrupted"), 1, out + err)
                    self.assertIsNotNone(self.check_outputs(), "facts are written")

    def test_control_c_reaches_all_processes_of_a_terminal(self):
        for n in (1, 2):
            self.forget_outputs()
            run = self.start("forever.meld", "-n", n, *self.OUTPUTS)
            self.ticks_are_made(run)
            os.killpg(run.pid, signal.SIGINT)
            self.ended(run, [130])
            self.assertIsNotNone(self.check_outputs())

    def test_in_a_long_tick(self):
        for n in (1, 2):
            with self.subTest(n=n):
                run = self.start("long.meld", "-n", n, "--world", "large.toml", "--facts-out", "f")
                time.sleep(3)
                run.send_signal(signal.SIGINT)
                _, err = self.ended(run, [130])
                self.assertIn("interrupted", err)
                self.assertNotIn("f", self.files())

    def test_time_limit_in_a_long_tick(self):
        for n in (1, 2):
            run = self.start("long.meld", "-n", n, "--world", "large.toml", "--facts-out", "f", "--timeout", 2)
            _, err = run.communicate(timeout=60)
            self.assertEqual(run.returncode, 4, err)
            self.assertEqual(err.count("the time limit of 2 s has passed"), 1, err)
            self.assertNotIn("f", self.files())

    def test_the_second_ends_at_once(self):
        for n in (1, 2):
            run = self.start("long.meld", "-n", n, "--world", "large.toml")
            time.sleep(2)
            for _ in range(2):
                run.send_signal(signal.SIGTERM)
                time.sleep(0.2)
            self.ended(run, [143])

    def test_while_it_compiles(self):
        rules = "".join(f"type q{i}(node, int, string).\nq{i}(A, N * {i} + 1, \"a\" ++ int2str(N)) :- neighborCount(A, N), N > {i % 7}.\n"
                        for i in range(400))
        for n in (1, 2):
            with self.subTest(n=n):
                self.write("slow.meld", rules + f"// {n}\n")
                run = self.start("slow.meld", "-n", n, "--world", "small.toml", "--new", "-O", "3")
                self.wait_for(lambda run=run: len(processes_of(run.pid)) > 1, run)
                time.sleep(0.5)
                self.assertIsNone(run.poll(), "it should be compiling still")
                run.send_signal(signal.SIGTERM)
                self.ended(run, [143])
                self.assertEqual([p.name for p in (self.folder / "cache").glob("tmp-*")], [])

    def test_what_was_switched_off_stays_so(self):
        """As nohup does, and a shell without job control for what it starts in the background."""
        ignore = self.start("forever.meld", *self.OUTPUTS, "--quiet", launcher=("env", "--ignore-signal=INT"))
        self.ticks_are_made(ignore)
        for _ in range(2):
            ignore.send_signal(signal.SIGINT)
            time.sleep(0.2)
        self.assertIsNone(ignore.poll())
        ignore.send_signal(signal.SIGTERM)
        self.ended(ignore, [143])


class Launcher(Running):
    """Whatever mpirun makes of it: a script in its place that says what the next one does."""
    OUTPUTS = (*Interrupts.OUTPUTS, "--quiet")

    def put_in_place_of_mpirun(self, script, bin_folder="bin"):
        folder = self.folder / bin_folder
        folder.mkdir(exist_ok=True)
        path = folder / "mpirun"
        path.write_text(f"#!/bin/bash\nreal={shutil.which('mpirun')}\n{script}\n")
        path.chmod(0o755)
        return {"PATH": f"{folder}:{os.environ['PATH']}"}

    def mpirun_of(self, run):
        return next(pid for pid in processes_of(run.pid) if pathlib.Path(f"/proc/{pid}/comm").read_text() == "mpirun\n")

    def test_that_hears_nothing(self):
        for sent, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            run = self.start("forever.meld", "-n", 2, *self.OUTPUTS,
                             environment=self.put_in_place_of_mpirun("trap '' TERM INT HUP USR1\ntouch begun\nsleep 1000"))
            self.wait_for((self.folder / "begun").exists, run)
            run.send_signal(sent)
            _, err = self.ended(run, [code])
            self.assertEqual(err, "meldsim: interrupted before its end\n")
            (self.folder / "begun").unlink()

    def test_that_loses_the_first_signal(self):
        run = self.start("forever.meld", "-n", 2, *self.OUTPUTS,
                         environment=self.put_in_place_of_mpirun('trap "" USR1\ntouch begun\nsleep 0.3\nexec $real "$@"'))
        self.wait_for((self.folder / "begun").exists, run)
        (self.folder / "begun").unlink()
        run.send_signal(signal.SIGTERM)
        self.ended(run, [143])

    # Starts the first process only when it is to end the run, and hands that on as soon as the process answers by itself.
    IS_LATE = """trap 'end=1' TERM
touch begun
until [ -n "$end" ]; do sleep 0.02; done
OMPI_COMM_WORLD_SIZE=1 OMPI_COMM_WORLD_LOCAL_SIZE=1 OMPI_COMM_WORLD_RANK=0 "${@:6}" &
until [[ $(readlink /proc/$!/exe) == */meldsim ]] && (( 0x$(awk '/SigCgt/ { print $2 }' /proc/$!/status) & 0x4000 )); do :; done
kill -TERM $!
wait $!
exit"""

    def test_that_is_late_with_the_processes(self):
        """They say that they were interrupted, although they were never told by the launcher itself."""
        run = self.start("forever.meld", "-n", 2, *self.OUTPUTS, environment=self.put_in_place_of_mpirun(self.IS_LATE))
        self.wait_for((self.folder / "begun").exists, run)
        (self.folder / "begun").unlink()
        run.send_signal(signal.SIGTERM)
        _, err = self.ended(run, [143])
        self.assertEqual(err.count("interrupted"), 1, err)

    def test_that_does_not_end_when_the_processes_have(self):
        run = self.start("forever.meld", "-n", 2, *self.OUTPUTS,
                         environment=self.put_in_place_of_mpirun('trap "" USR1 TERM\n$real "$@"\nsleep 1000'))
        self.ticks_are_made(run)
        run.send_signal(signal.SIGINT)
        self.ended(run, [130])
        self.assertIsNotNone(self.check_outputs())

    def test_has_a_folder_of_its_own(self):
        """In one that is shared, a run that ends removes what another one has just begun to use."""
        run = self.start("forever.meld", "-n", 2, *self.OUTPUTS)
        self.ticks_are_made(run)
        self.assertTrue(list((self.folder / "shm").glob("claymeld-*/ompi.*/pid.*")))
        run.send_signal(signal.SIGTERM)
        self.ended(run, [143])

    def test_that_is_stopped(self):
        self.forget_outputs()
        run = self.start("forever.meld", "-n", 2, *self.OUTPUTS)
        self.ticks_are_made(run)
        os.kill(self.mpirun_of(run), signal.SIGSTOP)
        run.send_signal(signal.SIGTERM)
        self.ended(run, [143])
        self.assertIsNotNone(self.check_outputs())

    def test_that_is_killed(self):
        run = self.start("forever.meld", "-n", 2, *self.OUTPUTS)
        self.ticks_are_made(run)
        os.kill(self.mpirun_of(run), signal.SIGKILL)
        _, err = self.ended(run, [137])
        self.assertIn("mpirun itself was ended by signal 9", err)

    # It starts the first process itself, which is killed when the supervisor knows of it, and does not wait for it; the next time, mpirun.
    LOSES_ONE = """if [ -e "$0.once" ]; then exec $real "$@"; fi
touch "$0.once"
OMPI_COMM_WORLD_SIZE=2 OMPI_COMM_WORLD_LOCAL_SIZE=2 OMPI_COMM_WORLD_RANK=0 "${@:6}" &
until grep -q claymeld-liveness /proc/$!/maps; do :; done
kill -KILL $!
exec sleep 1000"""

    def test_that_does_not_notice_the_end_of_processes(self):
        lost = "a process was killed or crashed, which mpirun did not notice,"
        # A run with checkpoints is started again by itself.
        cases = (("a", self.LOSES_ONE, (), 137, f"meldsim: {lost} and the others were ended before the first tick. Start the run again"),
                 ("b", self.LOSES_ONE, ("--checkpoint", "kept", "--heartbeat", "off"), 0,
                  f"warning: {lost} before the first tick; restart 1 of 3, from the start"),
                 ("c", '$real "$@"\nexec sleep 1000', (), 137, "meldsim: mpirun itself was ended by signal 9"))
        runs = [self.start("p.meld", "--world", "w.toml", "-n", 2, "--quiet", *options,
                           environment=self.put_in_place_of_mpirun(script, bin_folder)) for bin_folder, script, options, *_ in cases]
        for run, (bin_folder, _, _, code, says) in zip(runs, cases):
            with self.subTest(bin_folder):
                _, err = run.communicate(timeout=60)
                self.assertEqual(run.returncode, code, err)
                # The process that was started by itself has a daemon of its own, which may tell of its end first.
                self.assertTrue(any(line.startswith(says) for line in err.splitlines()), err)
                self.assertEqual(processes_of(run.pid), set())

    def test_with_processes_that_are_stopped(self):
        run = self.start("forever.meld", "-n", 2, *self.OUTPUTS)
        self.ticks_are_made(run)
        mpirun = self.mpirun_of(run)
        for pid in processes_of(run.pid) - {run.pid, mpirun}:
            os.kill(pid, signal.SIGSTOP)
        run.send_signal(signal.SIGTERM)
        self.ended(run, [143])


class UsersOwn(Running):
    def test_mpirun(self):
        """Its exit code is its own affair."""
        for sent in (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1):
            with self.subTest(sent=sent):
                self.forget_outputs()
                run = self.start("forever.meld", *Interrupts.OUTPUTS, launcher=("mpirun", "-n", "2"), environment=OPEN_MPI)
                self.ticks_are_made(run)
                run.send_signal(sent)
                out, err = self.ended(run, [1, 130, 143])
                self.assertEqual(out.count("interrupted"), 1, out + err)
                self.assertIsNotNone(self.check_outputs(), out + err)


class Random(Running):
    def test_at_random_moments(self):
        generator = random.Random(TOOLS.seed)
        whole, longest = 0, (0, "")
        for turn in range(TOOLS.runs):
            n, sent = generator.choice((1, 2)), generator.choice((signal.SIGINT, signal.SIGTERM))
            delay, group = generator.uniform(0, 1.5), generator.random() < 0.3
            with self.subTest(turn=turn, n=n, sent=sent, delay=delay, group=group):
                self.forget_outputs()
                run = self.start("forever.meld", "-n", n, *Interrupts.OUTPUTS, "--quiet")
                time.sleep(delay)
                begin = time.monotonic()
                (os.killpg if group else os.kill)(run.pid, sent)
                # Before it has come to handle them, a signal ends it as the system does.
                _, err = self.ended(run, [130 if sent == signal.SIGINT else 143, -sent])
                self.assertLessEqual(err.count("interrupted"), 1, err)
                longest = max(longest, (time.monotonic() - begin, f"{n} processes, {sent.name} after {delay:.3f} s, group: {group}"))
                whole += self.check_outputs() is not None
        print(f"{TOOLS.runs} runs, {whole} of them had begun and wrote their facts; "
              f"the longest end took {longest[0]:.2f} s, of {longest[1]}", file=sys.stderr)
        self.assertGreater(whole, 0)


class Stopped(Running):
    def test_a_stopped_process_is_told_of_and_goes_on(self):
        for which in (0, 1):
            with self.subTest(which=which):
                self.forget_outputs()
                run = self.start("forever.meld", "-n", 2, "--world", "small.toml", "--digest", "d", "--quiet")
                self.ticks_are_made(run)
                parts = [pid for pid in processes_of(run.pid)
                         if pid != run.pid and os.readlink(f"/proc/{pid}/exe") == os.path.realpath(TOOLS.meldsim)]
                self.assertEqual(len(parts), 2)
                part = next(pid for pid in parts
                            if f"OMPI_COMM_WORLD_RANK={which}\0" in pathlib.Path(f"/proc/{pid}/environ").read_text(errors="replace"))
                os.kill(part, signal.SIGSTOP)
                told = run.stderr.readline()
                self.assertRegex(told, rf"process {which} has been stopped for .* `kill -CONT {part}` lets it go on")
                before = (self.folder / "d").stat().st_size
                os.kill(part, signal.SIGCONT)
                self.assertRegex(run.stderr.readline(), rf"process {which} answers again, after ")
                self.wait_for(lambda before=before: (self.folder / "d").stat().st_size > before, run)
                run.send_signal(signal.SIGINT)
                self.ended(run, [130])


if __name__ == "__main__":
    main("meldc", "meldsim", runs={"type": int, "default": 6}, seed={"type": int, "default": 1})
