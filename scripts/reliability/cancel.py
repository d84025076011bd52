#!/usr/bin/env python3
"""Stops every long command at random moments: by SIGTERM, which must end it within 100 ms with exit code 3
and one line, and by SIGKILL, after which --resume must make the bytes of a run that nobody stopped.

usage: cancel.py BOSCAGE [--times 10] [--only vary,crown] [--limit-ms 100]
Prints a line a command: how often, how long it took to end, what was wrong."""
import argparse, hashlib, os, random, shutil, signal, struct, subprocess, sys, tempfile, time, zlib

from inputs import photo_and_mask

COMMANDS = {
    # name: (arguments, what it writes, which is behind --out if OUT does not say otherwise)
    "vary": ("vary --library trees --count 12 --maps labels,normal,depth,ao,translucency", "out"),
    "morph": ("morph trees/a.png trees/b.png --steps 12", "out"),
    "table": ("table --library trees", "out.png"),
    "inspect": ("inspect trees/a.png --dump dump --json", None),
    "segment": ("segment trees/a.png trees/b.png trees/c.png", "out"),
    "warp": ("warp trees/a.png --from from.json --to to.json --size 900 900 --exact", "out.png"),
    "recolor": ("recolor trees/a.png --like trees/b.png", "out.png"),
    "inflate": ("inflate mask.png --size 1024 --k 1+2*j", "out.obj"),
    "synthesize": ("synthesize photo.png --mask mask.png --width 1056 --height 320", "out.png"),
    "cubemap": ("cubemap photo.png --mask mask.png --size 256", "out"),
    "crown": ("crown photo.png --mask mask.png --photo-front", "out"),
    "render relief": ("render crown --backend cpu --mode relief --size 900 900", "out.png"),
    "render leaves": ("render crown --backend cpu --mode leaves --size 900 900", "out.png"),
    "export": ("export new --preset unreal --textures png,dds,ktx2 --maps normal,depth,ao --atlas", "out"),
    "export crown": ("export crown --preset web", "out"),
    "samples": ("samples --height 512", "out"),
    "season autumn": ("season trees --season autumn --snow 0.4", "out"),
    "season winter": ("season trees --season winter", "out"),
    "score": ("score new --against trees --sheet OUT", "out.png"),
    "render card": ("render crown --backend gpu --mode leaves --size 900 900", "out.png"),
    "demo": ("demo", "out"),
}


def digest(path):
    """Of all files at `path`, with their names; hidden halves of killed runs do not count."""
    sums = []
    for folder, _, names in os.walk(path):
        for name in names:
            if not name.startswith(".boscage-"):
                file = os.path.join(folder, name)
                sums.append((os.path.relpath(file, path), hashlib.sha256(open(file, "rb").read()).hexdigest()))
    if os.path.isfile(path):
        sums.append(hashlib.sha256(open(path, "rb").read()).hexdigest())
    return sorted(sums)


def work_ms(pid):
    """Time that all threads of a process have worked."""
    sums = 0
    for task in os.listdir(f"/proc/{pid}/task"):
        try:
            sums += int(open(f"/proc/{pid}/task/{task}/schedstat").read().split()[0])
        except OSError:
            pass
    return sums / 1e6


def remove(path):
    if os.path.isdir(path):
        shutil.rmtree(path)
    elif os.path.exists(path):
        os.remove(path)


def prepared(boscage, folder):
    run = lambda text: subprocess.run([boscage, *text.split()], cwd=folder, check=True, capture_output=True)
    run("samples --bundled --out trees")
    for name, tree in zip("abcd", ["oak_01", "pine_01", "birch_01", "maple_01"]):
        os.rename(f"{folder}/trees/{tree}.png", f"{folder}/trees/{name}.png")
    for file in os.listdir(folder + "/trees"):
        if len(file) > 5:
            os.remove(f"{folder}/trees/{file}")
    photo_and_mask(folder, 800)
    square = '{"points":[[0,0],[900,0],%s,[800,900],[0,900]]}'
    open(folder + "/from.json", "w").write(square % "[900,400]")
    open(folder + "/to.json", "w").write(square % "[700,450]")
    run("vary --library trees --count 4 --size 512 --out new")
    run("crown photo.png --mask mask.png --size 128 --out crown")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("boscage")
    parser.add_argument("--times", type=int, default=10)
    parser.add_argument("--only", default="")
    parser.add_argument("--limit-ms", type=float, default=100)
    parser.add_argument("--busy", action="store_true", help="count the time of its own threads, not of the clock")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    boscage, chance, failed = os.path.abspath(options.boscage), random.Random(options.seed), False
    with tempfile.TemporaryDirectory() as folder:
        os.environ["BOSCAGE_CACHE"] = folder + "/cache"
        prepared(boscage, folder)
        for name, (text, out) in COMMANDS.items():
            if not options.only or name.split()[0] in options.only.split(","):
                failed |= tried(boscage, folder, name, text, out, options, chance)
    sys.exit(failed)


def tried(boscage, folder, name, text, out, options, chance):
    command = [boscage, *text.replace("OUT", out or "").split(), "--threads", "2"]
    if out and "OUT" not in text:
        command += ["--out", out]
    path = os.path.join(folder, out or "dump")
    start = time.time()
    whole = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    seconds = time.time() - start
    if whole.returncode:
        print(f"cancel {name}: does not run: {whole.stderr.strip()[:200]}")
        return True
    expected = digest(path)
    remove(path)
    late, wrong, ends = [], [], 0
    for _ in range(options.times):
        process = subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        time.sleep(0.005 + chance.random() * seconds)
        then, before = time.time(), work_ms(process.pid)
        os.kill(process.pid, signal.SIGTERM)
        said = process.stderr.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        took = 1000 * (time.time() - then)
        if options.busy:
            # Others have the processors: what it still worked is what it would have taken.
            took = max(0, 1000 * (usage.ru_utime + usage.ru_stime) - before)
        if process.returncode == 3:
            late.append(took)
            if [line for line in said.splitlines() if not line.startswith("warning:")] != ["error: cancelled"]:
                wrong.append("said " + repr(said[-80:]))
            left = [file for file in digest(path) if file not in expected]
            if left and os.path.isdir(path):
                wrong.append(f"left {left[:2]}")
            elif os.path.isfile(path):
                wrong.append("left a file")
        elif process.returncode == 0 or (process.returncode == -signal.SIGTERM and took < options.limit_ms):
            ends += 1  # It was done, or had not begun to listen.
        else:
            wrong.append(f"exit code {process.returncode}")
        remove(path)
    for _ in range(max(1, options.times // 3)):
        process = subprocess.Popen(command + ["--resume"], cwd=folder, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        time.sleep(0.005 + chance.random() * seconds)
        process.kill()
        process.wait()
        again = subprocess.run(command + ["--resume"], cwd=folder, capture_output=True, text=True)
        if again.returncode or digest(path) != expected:
            wrong.append(f"resumed otherwise: {again.stderr.strip()[:100]}")
    remove(path)
    late.sort()
    over = [ms for ms in late if ms > options.limit_ms]
    median, most = (late[len(late) // 2], late[-1]) if late else (0, 0)
    print(
        f"cancel {name}: {len(late)} times stopped ({ends} had ended), median {median:.0f} ms{' of work' * options.busy}, longest {most:.0f} ms, "
        f"{len(over)} over {options.limit_ms:.0f} ms; wrong: {'; '.join(sorted(set(wrong))) or 'nothing'}",
        flush=True,
    )
    return bool(wrong or over)


main()
