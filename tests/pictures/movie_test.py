"""meldsim movie: which frames a film has, that they do not depend on how it is made, and what becomes of one that cannot be finished.

    movie_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import numpy as np  # noqa: E402

from frame import FOREVER, FRONT, Case, main, no_file_above, square  # noqa: E402
from png import read_png  # noqa: E402

DIST = ("--colour", "dist(A, D)")
SMALL = ("--size", "64x48", "--samples", "1")
PURPLE, YELLOW = (0x44, 0x01, 0x54), (0xFD, 0xE7, 0x25)
# In place of ffmpeg: keeps what it gets, or breaks as it is told.
ENCODER = """#!/bin/bash
for path; do :; done
echo "$@" > "$LOG"
case "$BREAKS" in
    at-once) echo "Unknown encoder 'libx264'" >&2; exit 1 ;;
    at-the-end) cat > /dev/null; echo "av_interleaved_write_frame(): No space left on device" >&2; exit 0 ;;
esac
cat > "${path#file:}"
"""


def coloured(pixels, colour):
    return (np.abs(pixels[:, :, :3].astype(int) - colour).max(axis=2) <= 20).sum()


class Movies(Case):
    FILES = {"front.meld": FRONT, "front.toml": square(4), "forever.meld": FOREVER, "forever.toml": square(2)}

    def frames(self, folder="frames"):
        names = sorted(self.files(folder))
        self.assertEqual(names, [f"{i:05}.png" for i in range(len(names))])
        return [self.read(f"{folder}/{name}") for name in names]

    def film(self, *options, target="front.meld", folder="frames", size=SMALL, **how):
        shutil.rmtree(self.folder / folder, ignore_errors=True)
        self.call("meldsim", "movie", target, "-o", f"{folder}/", *size, "--quiet", *options, **how)
        return self.frames(folder)

    def with_encoder(self, **environment):
        self.write("bin/ffmpeg", ENCODER).chmod(0o755)
        return {"environment": {"PATH": f"{self.folder / 'bin'}:/usr/bin:/bin", "LOG": self.folder / "log", **environment}}

    def test_which_ticks_are_shown(self):
        for options, ticks in (((), list(range(9))), (("--every", 3), [0, 3, 6, 8]), (("--every", 4), [0, 4, 8]),
                               (("--from", 2, "--to", 4), [2, 3, 4]), (("--from", "end"), [8]),
                               (("--seconds", 1, "--fps", 4), [0, 3, 6, 8]), (("--from", 5, "--every", 100), [5, 8])):
            with self.subTest(options=options):
                shutil.rmtree(self.folder / "f", ignore_errors=True)
                out, _ = self.call("meldsim", "movie", "front.meld", "-o", "f/", *SMALL, *options, "--json")
                self.assertEqual(json.loads(out)["ticks"], ticks)
                self.assertEqual(len(self.frames("f")), len(ticks))
        shutil.rmtree(self.folder / "f")
        out, _ = self.call("meldsim", "movie", "front.meld", "-o", "f/", *SMALL, "--hold", 1)
        self.assertEqual(out, "f/: 64 x 48 pixels, 39 frames, 1.3 s, 16 of 16 catoms, ticks 0 to 8\n")

    def test_colours_and_places_mean_the_same_in_all_frames(self):
        frames = [read_png(frame) for frame in self.film(*DIST, "--bare")]
        # The first catom has the colour of the least number in all frames from its tick on, which is not the greatest in any but the last.
        self.assertEqual([coloured(pixels, PURPLE) > 0 for pixels in frames], [False] + [True] * 8)
        self.assertEqual([coloured(pixels, YELLOW) > 0 for pixels in frames].index(True), 7)
        # Nothing moves, so all are in the same pixels; a picture of one tick has its catoms there too.
        inside = [(pixels < 250).any(axis=2) for pixels in frames]
        for mask in inside[1:]:
            self.assertTrue((mask == inside[0]).all())
        self.call("meldsim", "shot", "front.meld", "-o", "a.png", *SMALL, *DIST, "--bare", "--quiet")
        self.assertTrue(((read_png(self.read("a.png")) < 250).any(axis=2) == inside[0]).all())

    def test_it_is_the_picture_of_its_tick(self):
        options = ("--angle", 30, "--elevation", 40, "--range", "0:9", *DIST, "--ground", "--bare")
        film = self.film(*options)
        for tick in (0, 3, 8):
            self.call("meldsim", "shot", "front.meld", "-o", "a.png", "--tick", tick, *SMALL, *options, "--quiet")
            difference = np.abs(read_png(self.read("a.png")).astype(int) - read_png(film[tick]).astype(int))
            self.assertLess(difference.mean(), 0.5, tick)

    def test_it_is_the_same_from_wherever_it_is_made(self):
        options = (*DIST, "--turn", 90, "--elevation", 30, "--hold", 0.1)
        wanted = self.film(*options)
        self.assertEqual(len(set(wanted)), len(wanted))
        for processes in (2, 3):
            self.assertEqual(self.film(*options, "-n", processes, folder="g"), wanted)
        self.assertEqual(self.film(*options, "--threads", 2, folder="g"), wanted)
        # As many threads paint as there are processors.
        one = min(os.sched_getaffinity(0))
        self.assertEqual(self.film(*options, folder="g", preexec_fn=lambda: os.sched_setaffinity(0, {one})), wanted)
        self.call("meldsim", "run", "front.meld", "--record", "run.vtkhdf", "--quiet")
        self.call("meldsim", "run", "front.meld", "--ticks", 3, "--checkpoint", "kept", "--quiet")
        self.assertEqual(self.film(*options, target="run.vtkhdf", folder="g"), wanted)
        from_there = self.film(*DIST, "--from", 3, "--to", 5)
        for processes in (1, 2):
            self.assertEqual(self.film(*DIST, "--to", 5, "-n", processes, target="kept", folder="g"), from_there)

    def test_the_camera_turns_and_follows_keys(self):
        at = ("--elevation", 30, "--bare", "--range", "0:9", *DIST)
        turned = self.film(*at, "--from", "end", "--hold", 0.1, "--turn", 360)
        self.assertEqual(len(set(turned)), 4)
        # A whole turn goes on where it began; this square looks the same from two sides, but for its colours.
        insides = [(read_png(frame) < 250).any(axis=2) for frame in turned]
        self.assertTrue((insides[0] == insides[2]).mean() > 0.99)
        keyed = self.film(*at[2:], "--from", 4, "--to", 8, "--key", "8,30,30", "--key", "4,-90,30,1")
        self.assertEqual(len(set(keyed)), 5)
        # Before and after its keys the camera stays.
        still = self.film(*at[2:], "--key", "20,-90,30,2", "--key", "30,0,30,2")
        masks = [(read_png(frame) < 250).any(axis=2) for frame in still]
        self.assertTrue(all((mask == masks[0]).all() for mask in masks))

    def test_a_film_is_encoded(self):
        with self.subTest("what the encoder gets"):
            self.call("meldsim", "movie", "front.meld", "-o", "a.mp4", *SMALL, "--quiet", "--fps", 12.5, **self.with_encoder())
            raw = np.frombuffer(self.read("a.mp4"), np.uint8).reshape(-1, 48, 64, 4)
            wanted = [read_png(frame) for frame in self.film()]
            self.assertEqual(len(raw), len(wanted))
            for frame, pixels in zip(raw, wanted):
                self.assertTrue((frame[:, :, 2::-1] == pixels).all())
            self.assertIn("-framerate 12.5", self.read("log").decode())
        self.assertIsNotNone(shutil.which("ffprobe"), "ffmpeg is not installed: see scripts/install")
        for name, codec in (("b.mp4", "h264"), ("b.webm", "vp9")):
            with self.subTest(name):
                self.call("meldsim", "movie", "front.meld", "-o", name, "--size", "128x96", *DIST, "--quiet")
                done = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_streams", "-of", "json", self.folder / name],
                                      capture_output=True, check=True)
                stream, = json.loads(done.stdout)["streams"]
                said = [stream[key] for key in ("codec_name", "width", "height", "nb_read_frames", "r_frame_rate", "color_space")]
                self.assertEqual(said, [codec, 128, 96, "9", "30/1", "bt709"])
                # Colours are those of the pictures, but for what the encoder leaves out.
                done = subprocess.run(["ffmpeg", "-v", "error", "-i", self.folder / name, "-vf", "scale=in_color_matrix=bt709",
                                       "-f", "rawvideo", "-pix_fmt", "rgb24", "-"], capture_output=True, check=True)
                last = np.frombuffer(done.stdout, np.uint8).reshape(-1, 96, 128, 3)[-1].astype(int)
                self.film(*DIST, size=("--size", "128x96"))
                self.assertLess(np.abs(last - read_png(self.frames()[-1])).mean(), 4)
        self.assertEqual({name for name in self.files() if ".part-" in name}, set())

    def test_a_file_is_whole_or_as_it_was(self):
        self.write("a.mp4", "as it was")
        for says, code, how in ((["ffmpeg cannot make a.mp4: Unknown encoder 'libx264'"], 4, {"BREAKS": "at-once"}),
                                (["cannot write a.mp4: No space left on device", "Free some space"], 4, {"BREAKS": "at-the-end"}),
                                (["there is no ffmpeg", "-o FOLDER/"], 2, {"PATH": self.folder / "none"})):
            for processes in (1, 2) if "PATH" not in how else (1,):
                with self.subTest(how=how, processes=processes):
                    environment = {**self.with_encoder()["environment"], **how}
                    self.refused("meldsim", "movie", "front.meld", "-o", "a.mp4", *SMALL, "--quiet", "-n", processes, code=code, says=says,
                                 environment=environment)
                    self.assertEqual(self.read("a.mp4"), b"as it was")
        self.refused("meldsim", "movie", "front.meld", "-o", "a.mp4", "--size", "640x480", "--quiet", code=4,
                     says=["cannot write a.mp4", "Raise the limit"], preexec_fn=no_file_above(2048))
        self.assertEqual(self.read("a.mp4"), b"as it was")
        self.refused("meldsim", "movie", "front.meld", "-o", "f/", "--size", "640x480", "--quiet", code=4,
                     says=["cannot write f/00000.png", "Raise the limit"], preexec_fn=no_file_above(2048))
        self.assertEqual({name for name in self.files() if ".part-" in name}, set())

    def test_an_interrupted_film_ends_there(self):
        for processes in (1, 2):
            with self.subTest(processes=processes):
                shutil.rmtree(self.folder / "f", ignore_errors=True)
                run = self.begin("meldsim", "movie", "forever.meld", "-o", "f/", "--every", 1, *SMALL, "--quiet", "-n", processes,
                                 "--to", 3000, stderr=subprocess.PIPE, start_new_session=True)
                self.wait_for(lambda: (self.folder / "f" / "00005.png").exists(), run)
                run.send_signal(signal.SIGINT)
                _, said = run.communicate(timeout=30)
                self.assertEqual(run.returncode, 130, said)
                frames = self.frames("f")
                self.assertIn(f"interrupted: f/ ends with frame {len(frames)} of 3001".encode(), said)
                read_png(frames[-1])
        # ffmpeg gets the same signal from a terminal.
        run = self.begin("meldsim", "movie", "forever.meld", "-o", "f.mp4", "--to", 3000, "--every", 1, *SMALL, stderr=subprocess.PIPE,
                         start_new_session=True)
        self.wait_for(lambda: any(".part-" in name for name in self.files()), run)
        time.sleep(1)
        os.killpg(run.pid, signal.SIGINT)
        _, said = run.communicate(timeout=30)
        self.assertEqual(run.returncode, 130, said)
        self.assertIn(b"interrupted: f.mp4 ends with frame", said)
        subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_streams", self.folder / "f.mp4"], check=True, capture_output=True)

    def test_mistakes(self):
        for says, *options in (("did you mean `dist`?", "--colour", "dits(A, D)"), ("--size: '10' is no size", "--size", "10"),
                               ("--from: 'x' is no tick", "--from", "x"), ("--to: tick 2 is before tick 4", "--from", "4", "--to", "2"),
                               ("the run ends with tick 8, before tick 20", "--to", "20"), ("before tick 20", "--from", "20"),
                               ("--key: '3' is no place of the camera", "--key", "3"),
                               ("--key: there are two for tick 3", "--key", "3,1,1", "--key", "3,2,2"),
                               ("--key: elevation: 95 is not from -90 to 90", "--key", "3,1,95"), ("--fps: 0 is not", "--fps", "0"),
                               ("--seconds: 0 is not", "--seconds", "0"), ("--hold: -1 is not", "--hold=-1"),
                               ("--every", "--every", "2", "--seconds", "3"), ("--key", "--key", "3,1,1", "--turn", "3"),
                               ("--key", "--key", "3,1,1", "--zoom", "3")):
            with self.subTest(options=options):
                self.refused("meldsim", "movie", "front.meld", "-o", "f/", "--quiet", *options, code=2, says=[], lines=None)
                _, err = self.call("meldsim", "movie", "front.meld", "-o", "f/", "--quiet", *options, code=2)
                self.assertIn(says, err)
                self.assertFalse((self.folder / "f").exists() and self.files("f"))
        for says, name, *options in (("a film is an .mp4 or .webm file, or a folder, and a.avi is none", "a.avi"),
                                     ("--size 66x48", "a.mp4", "--size", "65x48"),
                                     ("a film has no transparent one", "a.mp4", "--background", "transparent"),
                                     ("cannot write no/where.mp4", "no/where.mp4")):
            with self.subTest(name=name, options=options):
                self.refused("meldsim", "movie", "front.meld", "-o", name, "--quiet", *options, code=2, says=says)
        self.film()
        self.refused("meldsim", "movie", "front.meld", "-o", "frames", "--quiet", code=2,
                     says="there are frames in frames already, such as 0000")


if __name__ == "__main__":
    main("meldc", "meldsim")
