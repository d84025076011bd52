#!/usr/bin/env python3
"""Drives the real studio like a hand and measures how soon it answers.

Needs Xvfb, xdotool, ImageMagick and a Vulkan driver (Mesa's lavapipe counts). Opens a picture, paints
on it with mouse moves, drags k, kills the studio without warning and recovers what was painted; then
opens the sample project, fills the gallery, writes trees and a crown for an engine, and saves. Prints a
table; ends with 1 when something did not happen.

    scripts/drive.py target/release/boscage photo.jpg [--out FOLDER] [--guide docs/pictures]
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

# Places in a window of that size with the layout it comes with.
CANVAS = (460, 460)
VIEW = (960, 560)
SAMPLE_BUTTON = (720, 292)
FIXED_K = (1261, 104)
K_RAIL = ((1196, 1352), 158)
SKIP_TOUR = (101, 835)
# The right of the sample's outline.
OUTLINE = (709, 545)


class Studio:
    """The program in a display of its own; `frames` are (when it was made, inputs it saw, how long it
    took), in seconds."""

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
            [program, *map(str, files)], env=self.environment, stderr=subprocess.PIPE, text=True
        )
        threading.Thread(target=self.listen, daemon=True).start()

    def listen(self):
        for line in self.process.stderr:
            words = line.split()
            if len(words) == 4 and words[0] == "frame":
                at, events, took = map(int, words[1:])
                self.frames.append((at / 1e6, events, took / 1e6))
            elif words[:1] != ["drawn"]:
                print("studio:", line.rstrip(), file=sys.stderr)

    def first_frame(self):
        wait_for(lambda: self.frames, "the first frame")
        wait_for(self.has_focus, "the window")
        return self.frames[0][0] - self.started

    def has_focus(self):
        """Gives the window the keyboard, which nobody does without a window manager; whether it
        was there to take it."""
        found = subprocess.run(
            ["xdotool", "search", "--name", "Boscage", "windowfocus"],
            env=self.environment,
            stderr=subprocess.DEVNULL,
        )
        return found.returncode == 0

    def hand(self, *words):
        """Moves the mouse or presses a key; when it was done."""
        subprocess.run(["xdotool", *map(str, words)], env=self.environment, check=True)
        return time.time()

    def click(self, place):
        self.hand("mousemove", *place)
        time.sleep(0.2)
        self.hand("click", 1)
        time.sleep(0.4)

    def answer_to(self, *words):
        """Seconds from an input to the end of the frame that saw it."""
        count = len(self.frames)
        begun = time.time()
        self.hand(*words)
        saw = lambda: [at for at, events, _ in self.frames[count:] if events and at > begun]
        wait_for(saw, f"a frame after {words}")
        return max(saw()[0] - begun, 0.0)

    def processor_share(self, seconds):
        """Share of a core that it takes while nothing is done to it."""
        before = self.processor_seconds()
        time.sleep(seconds)
        return (self.processor_seconds() - before) / seconds

    def processor_seconds(self):
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def picture(self, path):
        subprocess.run(["import", "-window", "root", str(path)], env=self.environment, check=True)

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()


def wait_for(is_so, what, patience=120.0):
    until = time.time() + patience
    while not is_so():
        if time.time() > until:
            sys.exit(f"did not happen: {what}")
        time.sleep(0.005)


def settle(studio, quiet=2.0, patience=240.0):
    """Waits until nothing has been drawn for a while."""
    until = time.time() + patience
    while time.time() < until:
        count = len(studio.frames)
        time.sleep(quiet)
        if len(studio.frames) == count:
            return
    sys.exit("the window does not come to rest")


class Table:
    def __init__(self):
        self.rows = []

    def tell(self, name, value):
        self.rows.append((name, value))
        print(f"{name}: {value}", flush=True)

    def answers(self, name, seconds):
        seconds = sorted(seconds)
        middle, late = seconds[len(seconds) // 2], seconds[int(len(seconds) * 0.95)]
        self.tell(f"{name}, median", f"{middle * 1e3:.0f} ms")
        self.tell(f"{name}, 95 of 100", f"{late * 1e3:.0f} ms")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("photo")
    parser.add_argument("--out", help="folder for screenshots")
    parser.add_argument("--guide", help="folder for the guide's pictures")
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
    table = Table()
    try:
        start = lambda *files: Studio(arguments.program, display, config, files)
        crash_and_recover(start, arguments.photo, config, out, table)
        sample(start, config, out, table, arguments.guide)
    finally:
        server.terminate()
        shutil.rmtree(config, ignore_errors=True)
    print(f"screenshots: {out}")


def crash_and_recover(start, photo, config, out, table):
    studio = start(photo)
    table.tell("start to first frame", f"{studio.first_frame() * 1e3:.0f} ms")
    settle(studio)
    studio.click(SKIP_TOUR)
    settle(studio)
    studio.picture(out / "1-opened.png")
    table.tell("processor while nothing changes", f"{studio.processor_share(5.0) * 100:.1f} %")

    x, y = CANVAS
    studio.hand("key", "b")
    studio.hand("mousemove", x, y - 120, "mousedown", 1)
    way = [(x + (step % 10) * 8 - 40, y - 120 + step * 6) for step in range(40)]
    answers = [studio.answer_to("mousemove", *place) for place in way]
    studio.hand("mouseup", 1)
    table.answers("mouse move to frame while painting", answers)
    settle(studio)
    studio.picture(out / "2-painted.png")

    studio.click(FIXED_K)
    settle(studio)
    (left, right), rail_y = K_RAIL
    studio.hand("mousemove", left + 40, rail_y, "mousedown", 1)
    places = [left + 40 + step * (right - left - 40) // 30 for step in range(30)]
    answers = [studio.answer_to("mousemove", place, rail_y) for place in places]
    studio.hand("mouseup", 1)
    table.answers("mouse move to frame while dragging k", answers)
    settle(studio)
    studio.picture(out / "3-another-k.png")

    # The autosave comes within 30 seconds; then the studio dies without a word.
    recovery = config / "recovery"
    begun = time.time()
    wait_for(lambda: list(recovery.glob("*/document.boscage")), "an autosave", 60.0)
    table.tell("change to autosave", f"{time.time() - begun:.0f} s after the crown came to rest")
    settle(studio)
    share = studio.processor_share(5.0)
    table.tell("processor while a change waits to be saved", f"{share * 100:.1f} %")
    studio.kill()
    left_behind = next(recovery.glob("*/document.boscage")).parent

    studio = start()
    studio.first_frame()
    settle(studio)
    studio.picture(out / "4-after-crash.png")
    for y in range(380, 560, 8):
        if not left_behind.exists():
            break
        studio.hand("mousemove", 500, y, "click", 1)
        time.sleep(0.5)
    wait_for(lambda: not left_behind.exists(), "the recovery", 20.0)
    settle(studio)
    studio.picture(out / "5-recovered.png")
    table.tell("recovered after SIGKILL", "yes")
    studio.kill()
    shutil.rmtree(recovery, ignore_errors=True)


def sample(start, config, out, table, guide):
    """Trees and crowns of the sample project, to folders; then the project to a file."""
    studio = start()
    studio.first_frame()
    settle(studio)
    studio.click(SAMPLE_BUTTON)
    settle(studio)
    studio.hand("mousemove", *VIEW)
    settle(studio)
    studio.picture(out / "6-crown.png")
    keep(out / "6-crown.png", guide, "studio-crown")

    studio.hand("mousemove", *CANVAS, "key", "k")
    studio.hand("key", "shift+w")
    time.sleep(1.0)
    x, y = OUTLINE
    studio.hand("mousemove", x, y, "mousedown", 1)
    for step in range(8):
        studio.hand("mousemove", x + 4 * step, y)
        time.sleep(0.1)
    settle(studio)
    studio.picture(out / "7-depth.png")
    keep(out / "7-depth.png", guide, "studio-depth")
    studio.hand("mouseup", 1)
    studio.hand("key", "shift+w")
    studio.hand("key", "b")
    settle(studio)

    crown = config / "crown"
    asked(studio, "ctrl+e", crown)
    wait_for(lambda: (crown / "library.json").exists(), "the export of a crown", 600.0)
    table.tell("exported a crown", "yes")
    settle(studio)

    studio.hand("key", "ctrl+2")
    settle(studio, 4.0, 600.0)
    studio.picture(out / "8-variations.png")
    keep(out / "8-variations.png", guide, "studio-variations")

    trees = config / "trees"
    asked(studio, "ctrl+m", trees)
    count, begun = len(studio.frames), time.time()
    while not (trees / "library.json").exists():
        place = 500 + int(time.time() * 300) % 300
        studio.hand("mousemove", place, 800)
        if time.time() > begun + 600.0:
            sys.exit("did not happen: a batch of trees")
    during = studio.frames[count:]
    took = sorted(took for _, _, took in during)
    table.tell("a batch of 50 trees", f"{time.time() - begun:.1f} s")
    table.tell("longest frame meanwhile", f"{took[-1] * 1e3:.0f} ms of {len(took)} frames")
    settle(studio)

    project = config / "wald.boscage"
    studio.hand("key", "ctrl+s")
    time.sleep(1.5)
    studio.hand("type", str(project))
    studio.hand("key", "Return")
    wait_for(project.exists, "a saved project")
    table.tell("saved", f"{project.stat().st_size / 1e6:.1f} MB")
    studio.kill()


def asked(studio, key, folder):
    """Opens a dialog that writes to a folder, and has it write to `folder`."""
    studio.hand("key", key)
    time.sleep(2.0)
    # The folder's field has the keyboard; in it stands where was written last.
    studio.hand("key", "ctrl+a")
    studio.hand("type", str(folder))
    time.sleep(0.5)
    studio.hand("key", "Return")
    time.sleep(1.0)


def keep(picture, guide, name):
    """A picture for the guide."""
    if guide:
        target = pathlib.Path(guide) / f"{name}.jpg"
        subprocess.run(["convert", str(picture), "-quality", "88", str(target)], check=True)


if __name__ == "__main__":
    main()
