#!/usr/bin/env python3
"""Drives the real studio like a hand and measures how soon it answers.

Needs Xvfb, xdotool and a Vulkan driver (Mesa's lavapipe counts). Opens a picture, paints on it with
mouse moves, saves, kills the studio without warning, and recovers what was painted after. Prints a
table; ends with 1 when something did not happen.

    scripts/drive.py target/release/boscage photo.jpg [--out FOLDER]
"""
import argparse
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

SIZE = (1440, 900)
CANVAS = (460, 460)


class Studio:
    """The program in a display of its own; `frames` are the times (s) at which it drew."""

    def __init__(self, program, display, config, files):
        self.environment = dict(
            os.environ,
            DISPLAY=display,
            BOSCAGE_CONFIG=str(config),
            BOSCAGE_TRACE_FRAMES="1",
            XDG_RUNTIME_DIR=str(config),
        )
        self.frames = []
        self.started = time.time()
        self.process = subprocess.Popen(
            [program, *files], env=self.environment, stderr=subprocess.PIPE, text=True
        )
        threading.Thread(target=self.listen, daemon=True).start()

    def listen(self):
        for line in self.process.stderr:
            words = line.split()
            if len(words) == 3 and words[0] == "frame":
                self.frames.append((int(words[1]) / 1e6, int(words[2])))
            else:
                print("studio:", line.rstrip(), file=sys.stderr)

    def first_frame(self):
        wait_for(lambda: self.frames, "the first frame")
        return self.frames[0][0] - self.started

    def hand(self, *words):
        """Moves the mouse or presses a key; when it was done."""
        subprocess.run(["xdotool", *map(str, words)], env=self.environment, check=True)
        return time.time()

    def answer_to(self, *words):
        """Seconds from an input to the end of the frame that saw it."""
        count = len(self.frames)
        begun = time.time()
        self.hand(*words)
        wait_for(lambda: any(events for _, events in self.frames[count:]), f"a frame after {words}")
        drawn = next(at for at, events in self.frames[count:] if events)
        return max(drawn - begun, 0.0)

    def processor_seconds(self):
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def picture(self, path):
        subprocess.run(["import", "-window", "root", str(path)], env=self.environment, check=True)

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()


def wait_for(is_so, what, patience=60.0):
    until = time.time() + patience
    while not is_so():
        if time.time() > until:
            sys.exit(f"did not happen: {what}")
        time.sleep(0.005)


def settle(studio, quiet=1.5):
    """Waits until nothing has been drawn for a while."""
    while True:
        count = len(studio.frames)
        time.sleep(quiet)
        if len(studio.frames) == count:
            return


def median(values):
    return sorted(values)[len(values) // 2]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("photo")
    parser.add_argument("--out", help="folder for screenshots")
    arguments = parser.parse_args()
    out = pathlib.Path(arguments.out or tempfile.mkdtemp())
    out.mkdir(parents=True, exist_ok=True)
    config = pathlib.Path(tempfile.mkdtemp())
    display = f":{os.getpid() % 500 + 100}"
    server = subprocess.Popen(
        ["Xvfb", display, "-screen", "0", f"{SIZE[0]}x{SIZE[1]}x24"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    time.sleep(1.0)
    rows = []
    try:
        drive(arguments, display, config, out, rows)
    finally:
        server.terminate()
        shutil.rmtree(config, ignore_errors=True)
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        print(f"{name:<{width}}  {value}")
    print(f"screenshots: {out}")


def drive(arguments, display, config, out, rows):
    studio = Studio(arguments.program, display, config, [arguments.photo])
    rows.append(("start to first frame", f"{studio.first_frame() * 1e3:.0f} ms"))
    settle(studio)
    studio.picture(out / "1-opened.png")
    before = studio.processor_seconds()
    time.sleep(5.0)
    idle = (studio.processor_seconds() - before) / 5.0
    rows.append(("processor while nothing changes", f"{idle * 100:.1f} %"))

    x, y = CANVAS
    studio.hand("key", "b")
    studio.hand("mousemove", x, y - 120, "mousedown", 1)
    answers = []
    for step in range(40):
        place = (x + (step % 10) * 8 - 40, y - 120 + step * 6)
        answers.append(studio.answer_to("mousemove", *place))
    studio.hand("mouseup", 1)
    answers.sort()
    rows.append(("mouse move to frame while painting, median", f"{median(answers) * 1e3:.0f} ms"))
    rows.append(("the same, 95 of 100", f"{answers[int(len(answers) * 0.95)] * 1e3:.0f} ms"))
    settle(studio)
    studio.picture(out / "2-painted.png")

    # The autosave comes within 30 seconds; then the studio dies without a word.
    recovery = config / "recovery"
    begun = time.time()
    wait_for(lambda: list(recovery.glob("*/document.boscage")), "an autosave", 40.0)
    rows.append(("change to autosave", f"{time.time() - begun:.0f} s"))
    studio.kill()
    left = next(recovery.glob("*/document.boscage")).parent

    studio = Studio(arguments.program, display, config, [])
    studio.first_frame()
    settle(studio)
    studio.picture(out / "3-after-crash.png")
    recover(studio, left, out)
    rows.append(("recovered after SIGKILL", "yes"))
    studio.kill()


def recover(studio, left, out):
    """Clicks "Recover" on the start screen, wherever it is; then the old autosave goes."""
    for y in range(400, 520, 8):
        studio.hand("mousemove", 500, y, "click", 1)
        time.sleep(0.5)
        if not left.exists():
            break
    wait_for(lambda: not left.exists(), "the recovery", 10.0)
    settle(studio)
    studio.picture(out / "4-recovered.png")


if __name__ == "__main__":
    main()
