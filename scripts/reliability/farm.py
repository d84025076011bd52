#!/usr/bin/env python3
"""Does long jobs in shards that are killed at random and queued again, and compares what they made, byte by
byte, with what a single undisturbed run made.

usage: farm.py BOSCAGE [--jobs vary,segment,export,crown] [--shards 8] [--kills 30] [--slurm]
Without --slurm the tasks run here, two at once. With it they are the tasks of an array of the Slurm that
runs here, which also gets them killed: their processes at random, whole tasks by `scontrol requeue`."""
import argparse, hashlib, os, random, signal, subprocess, sys, tempfile, time

from inputs import photo_and_mask

HERE = os.path.dirname(os.path.abspath(__file__))
CROWNS = os.path.join(HERE, "../../docs/farm/crowns.sh")


def jobs(count, size):
    """For each job its arguments, with OUT where the results go; `crown` is made by docs/farm/crowns.sh."""
    return {
        "vary": ["vary", "--library", "trees", "--count", str(count), "--size", str(size), "--maps", "labels,normal", "--out", "OUT"],
        "segment": ["segment", *(f"trees/{name}" for name in sorted(os.listdir("trees"))), "--out", "OUT"],
        "export": ["export", "library", "--preset", "unreal", "--textures", "png,dds,ktx2", "--maps", "normal,depth,ao", "--atlas", "--out", "OUT"],
        "crown": ["photos", "OUT", "--size", "48"],
    }


def digest(folder):
    files = {}
    for place, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(place, name)
            files[os.path.relpath(path, folder)] = hashlib.sha256(open(path, "rb").read()).hexdigest()
    return files


def here(command, options, chance):
    """A queue of shards, two workers, and a killer."""
    queue, running, kills, tries = list(range(options.shards)), {}, 0, 0
    while queue or running:
        while queue and len(running) < 2:
            shard = queue.pop(0)
            tries += 1
            arguments = [*command, "--resume", "--shard", f"{shard}/{options.shards}", "--threads", "1", "--progress", "json"]
            running[shard] = subprocess.Popen(arguments, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        time.sleep(chance.random() * 2 * options.pace)
        if kills < options.kills and running:
            shard = chance.choice(sorted(running))
            # Of crowns the program itself: the script is what a farm would queue again.
            pid = chance.choice(children(running[shard].pid) or [running[shard].pid])
            try:
                os.kill(pid, chance.choice([signal.SIGKILL, signal.SIGTERM]))
                kills += 1
            except ProcessLookupError:
                pass
        for shard, process in list(running.items()):
            if process.poll() is None:
                continue
            lines = process.communicate()[1].splitlines()
            del running[shard]
            if process.returncode == 0:
                continue
            assert process.returncode in (3, 128 + 9, 128 + 15, -9, -15), (process.returncode, lines[-1:])
            queue.append(shard)
    return kills, tries


def children(pid):
    try:
        return [int(child) for child in open(f"/proc/{pid}/task/{pid}/children").read().split()]
    except OSError:
        return []


def workers(boscage):
    """The processes of the program that work in this folder."""
    found = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            if os.readlink(f"/proc/{pid}/exe") == os.path.realpath(boscage) and os.readlink(f"/proc/{pid}/cwd") == os.getcwd():
                found.append(int(pid))
        except OSError:
            pass
    return found


def slurm(name, command, options, chance):
    script = os.path.join(HERE, "../../docs/farm/array.sbatch")
    environment = {**os.environ, "BOSCAGE": command[0], "BOSCAGE_TRIES": "1000"}
    log = f"{os.getcwd()}/{name}-%a.log"
    sbatch = ["sbatch", "--parsable", f"--array=0-{options.shards - 1}", f"--output={log}", script, *command[1:]]
    job = subprocess.run(sbatch, env=environment, check=True, capture_output=True, text=True).stdout.strip()
    kills = tries = 0
    while True:
        listed = subprocess.run(["squeue", "-h", "-r", "-j", job, "-o", "%i %T"], capture_output=True, text=True).stdout.split("\n")
        tasks = [line.split() for line in listed if line.strip()]
        if not tasks:
            break
        running = [task for task, state in tasks if state == "RUNNING"]
        time.sleep(chance.random() * 2 * options.pace)
        if kills < options.kills and running:
            if chance.random() < 0.5:
                task = chance.choice(running)
                kills += subprocess.run(["scontrol", "requeue", task], capture_output=True).returncode == 0
            elif pids := workers(options.boscage):
                # The program itself, as an out-of-memory killer would.
                os.kill(chance.choice(pids), signal.SIGKILL)
                kills += 1
    for shard in range(options.shards):
        tries += open(log.replace("%a", str(shard))).read().count("begins try")
    return kills, tries


def prepared(run, options):
    run("samples", "--bundled", "--out", "trees")
    run("vary", "--library", "trees", "--count", str(max(8, options.count // 4)), "--size", "512", "--out", "library")
    os.mkdir("photos")
    for number in range(max(4, options.count // 4)):
        photo_and_mask("photos", 96 + 8 * number)
        os.rename("photos/photo.png", f"photos/tree{number:02}.png")
        os.rename("photos/mask.png", f"photos/tree{number:02}.mask.png")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("boscage")
    parser.add_argument("--jobs", default="vary,segment,export,crown")
    parser.add_argument("--shards", type=int, default=8)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--kills", type=int, default=30)
    parser.add_argument("--pace", type=float, default=0.3, help="mean seconds between kills")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--slurm", action="store_true")
    options = parser.parse_args()
    options.boscage = os.path.abspath(options.boscage)
    chance, failed = random.Random(options.seed), False
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        os.environ["BOSCAGE_CACHE"] = folder + "/cache"
        os.environ["BOSCAGE_PROGRAM"] = options.boscage
        run = lambda *words: subprocess.run([options.boscage, *words], check=True, capture_output=True)
        prepared(run, options)
        for name, arguments in jobs(options.count, options.size).items():
            if name not in options.jobs.split(","):
                continue
            program = CROWNS if name == "crown" else options.boscage
            into = lambda out: [program, *(word.replace("OUT", out) for word in arguments)]
            whole, new = f"{name}-whole", f"{name}-new"
            subprocess.run(into(whole), check=True, capture_output=True)
            # An atlas shows all trees: the last run makes it.
            part = [word for word in into(new) if word != "--atlas"]
            kills, tries = slurm(name, part, options, chance) if options.slurm else here(part, options, chance)
            # What was left half-written counts as nobody's after some seconds.
            time.sleep(11)
            subprocess.run([*into(new), "--resume"], check=True, capture_output=True)
            expected = digest(whole)
            same = expected == digest(new)
            failed |= not same
            where = "Slurm array" if options.slurm else "queue of its own"
            print(f"farm ({where}), {name}: {options.shards} shards, {len(expected)} files, {kills} kills, {tries} tries, "
                  f"{'identical to' if same else 'DIFFERS from'} a single run", flush=True)
        os.chdir("/")
    sys.exit(failed)


main()
