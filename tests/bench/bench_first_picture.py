#!/usr/bin/env python3
"""From the start of `meldsim view` to the first picture of a live run in Chromium: cubes of catoms, a program compiled before, a browser
that has started before.

Usage: bench_first_picture.py BIN_DIR EXAMPLES_DIR [--times N] [--size 1440x900] [CATOMS ...]

Prints medians of wall milliseconds: until the link is printed, which is when the run is ready; from there until the page has asked for
its first frame; until it has it; until it is drawn; and all together. Then how long processors have been at work for it, in meldsim and in
Chromium, which says more where other programs run: with a processor to itself each, it is a bound for all together.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "view"))

TICK_ms = 1000 / os.sysconf("SC_CLK_TCK")
STAGES = ("link", "asked", "received", "drawn", "all", "processors")
# When the page sends and receives what, on its own clock.
WATCH = """
    window.marks = {};
    const mark = (name) => { window.marks[name] ??= performance.timeOrigin + performance.now(); };
    const send = WebSocket.prototype.send;
    WebSocket.prototype.send = function (text) {
        const what = JSON.parse(text).do;
        this.addEventListener("message", ({data}) => { if (typeof data !== "string") mark("received"); });
        if (what === "frame") mark("asked");
        return send.call(this, text);
    };
    const read = WebGL2RenderingContext.prototype.readPixels;
    // The page waits for the graphics after each picture.
    WebGL2RenderingContext.prototype.readPixels = function (...all) {
        read.apply(this, all);
        if (window.marks.received) mark("drawn");
    };"""


def world_of(catoms):
    side = round(catoms ** (1 / 3))
    return f'lattice = "cubic"\n[[body]]\nshape = "box({side}, {side}, {side})"\n[facts]\nsource = "id == 0"\n', side ** 3


def below(process):
    """A process and all that it has started."""
    children = []
    for thread in pathlib.Path(f"/proc/{process}/task").glob("*/children"):
        try:
            children += thread.read_text().split()
        except OSError:
            continue
    return [process, *(each for child in children for each in below(int(child)))]


def processor_ms(*processes):
    total = 0
    for process in [each for one in processes for each in below(one)]:
        try:
            fields = pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        total += (int(fields[11]) + int(fields[12])) * TICK_ms
    return total


def first_picture(browser, meldsim, program, world):
    chromium = browser.service.process.pid
    before = processor_ms(chromium)
    begun = time.time() * 1000
    server = subprocess.Popen([meldsim, "view", program, "--world", world, "--json", "--no-open"], stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True)
    try:
        link = json.loads(server.stdout.readline())["link"]
        ready = time.time() * 1000
        browser.get(link)
        end = time.monotonic() + 60
        while not (marks := browser.execute_script("return window.marks")).get("drawn"):
            if time.monotonic() > end:
                sys.exit(f"no picture after 60 s: {marks}")
            time.sleep(0.02)
        spent = processor_ms(chromium, server.pid) - before
    finally:
        server.terminate()
        server.wait()
    at = [begun, ready, marks["asked"], marks["received"], marks["drawn"]]
    return [*(b - a for a, b in zip(at, at[1:])), at[-1] - at[0], spent]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bin")
    parser.add_argument("examples")
    parser.add_argument("catoms", nargs="*", type=float, default=[1000, 1e6])
    parser.add_argument("--times", type=int, default=7)
    parser.add_argument("--size", default="1440x900")
    options = parser.parse_intermixed_args()
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    from pages import FLAGS
    chrome = webdriver.ChromeOptions()
    for flag in FLAGS:
        chrome.add_argument(f"--window-size={options.size.replace('x', ',')}" if flag.startswith("--window-size") else flag)
    browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=chrome)
    try:
        browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": WATCH})
        with tempfile.TemporaryDirectory() as folder:
            program = f"{options.examples}/gradient.meld"
            for catoms in options.catoms:
                text, catoms = world_of(catoms)
                world = pathlib.Path(folder) / "world.toml"
                world.write_text(text)
                # The first makes the module and is the first page of the browser.
                times = [first_picture(browser, f"{options.bin}/meldsim", program, world) for _ in range(options.times + 1)][1:]
                medians = [statistics.median(column) for column in zip(*times)]
                print(f"{catoms:,} catoms: " + ", ".join(f"{name} {ms:.0f} ms" for name, ms in zip(STAGES, medians)), flush=True)
    finally:
        browser.quit()


if __name__ == "__main__":
    main()
