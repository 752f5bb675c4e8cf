"""Random cases that must come out alike however a run is divided."""

import pathlib
import subprocess
import tempfile


class Divided:
    """A program and a world, run on several numbers of processes and threads."""

    def __init__(self, meldsim, name, settings, options):
        self.meldsim = meldsim
        self.name = name
        self.settings = settings
        self.options = options

    def outcome(self, folder, processes, threads):
        """How the run ended and what it wrote to standard output; what it said of an error."""
        command = [self.meldsim, "run", folder / f"{self.name}.meld", "--world", folder / f"{self.name}.toml", "--quiet",
                   "-n", str(processes), "--threads", str(threads), *self.options]
        done = subprocess.run(command, capture_output=True, text=True, timeout=600)
        return done.returncode, done.stdout, "" if done.returncode == 0 else done.stderr

    def compare(self, cases, does_something):
        """The exit code for these cases, (seed, program, world): not 0 where one fails or differs, or where nothing has happened in any
        of them, as does_something(output) says."""
        failures = count = happened = 0
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch)
            for seed, program, world in cases:
                count += 1
                (folder / f"{self.name}.meld").write_text(program)
                (folder / f"{self.name}.toml").write_text(world)
                outcomes = [self.outcome(folder, *setting) for setting in self.settings]
                happened += does_something(outcomes[0][1])
                if outcomes[0][0] == 0 and outcomes.count(outcomes[0]) == len(outcomes):
                    continue
                failures += 1
                print(f"seed {seed}:\n{program}{world}")
                for (processes, threads), (code, output, errors) in zip(self.settings, outcomes):
                    print(f"-- on {processes} processes with {threads} threads: exit code {code}\n{output}{errors}")
        if happened == 0:
            print("in no world of any seed did anything happen: the worlds test nothing")
        print(f"{failures} of {count} seeds differ")
        return 1 if failures or happened == 0 else 0
