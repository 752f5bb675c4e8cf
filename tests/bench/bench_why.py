#!/usr/bin/env python3
"""How long questions about a settled gradient take, once the run is there: why, why-not, a query of one catom.

Usage: bench_why.py BIN_DIR EXAMPLES_DIR [CATOMS ...]      prints wall milliseconds, the median of five
"""
import statistics
import subprocess
import sys
import tempfile
import time


def main():
    bin_dir, examples = sys.argv[1:3]
    for catoms in [int(float(n)) for n in sys.argv[3:]] or [1000, 10**6]:
        side = round(catoms ** (1 / 3))
        last = side**3 - 1
        with tempfile.TemporaryDirectory() as folder:
            world = f"{folder}/world.toml"
            with open(world, "w") as out:
                out.write(f'lattice = "cubic"\n[[body]]\nshape = "box({side}, {side}, {side})"\n[facts]\nsource = ["id == 0"]\n')
            command = [f"{bin_dir}/meldsim", "debug", f"{examples}/gradient.meld", "--world", world, "--json", "--quiet", "--history", "0"]
            session = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)

            def ask(line):
                begin = time.perf_counter()
                session.stdin.write(line + "\n")
                session.stdin.flush()
                answer = session.stdout.readline()
                assert '"error"' not in answer, answer
                return (time.perf_counter() - begin) * 1000

            ask("run")
            print(f"{side**3} catoms")
            for question in (f"query dist(@{last}, D)", f"why dist(@{last}, _)", f"why --depth 0 dist(@{last}, _)",
                             f"why-not dist(@{last}, 3)"):
                print(f"  {question:34} {statistics.median(ask(question) for _ in range(5)):6.1f} ms")
            session.stdin.close()
            assert session.wait() == 0


if __name__ == "__main__":
    main()
