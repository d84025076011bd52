#!/usr/bin/env python3
"""Makes a library in shards that are killed at random and queued again, and compares it, byte by byte, with
the library of a single undisturbed run.

usage: farm.py BOSCAGE [--shards 8] [--count 40] [--kills 30] [--slurm]
Without --slurm the tasks run here, two at once. With it they are the tasks of an array of the Slurm that
runs here, which also gets them killed: their processes at random, whole tasks by `scontrol requeue`."""
import argparse, hashlib, os, random, signal, subprocess, sys, tempfile, time

HERE = os.path.dirname(os.path.abspath(__file__))


def digest(folder):
    files = sorted(os.listdir(folder))
    return {f: hashlib.sha256(open(os.path.join(folder, f), "rb").read()).hexdigest() for f in files}


def here(command, options, chance, folder):
    """A queue of shards, two workers, and a killer."""
    queue, running, kills, tries = list(range(options.shards)), {}, 0, 0
    while queue or running:
        while queue and len(running) < 2:
            shard = queue.pop(0)
            tries += 1
            arguments = [*command, "--out", "new", "--resume", "--shard", f"{shard}/{options.shards}", "--threads", "1", "--progress", "json"]
            running[shard] = subprocess.Popen(arguments, cwd=folder, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        time.sleep(chance.random() * 2 * options.pace)
        if kills < options.kills and running:
            shard = chance.choice(sorted(running))
            running[shard].send_signal(chance.choice([signal.SIGKILL, signal.SIGTERM]))
            kills += 1
        for shard, process in list(running.items()):
            if process.poll() is None:
                continue
            lines = process.communicate()[1].splitlines()
            del running[shard]
            if process.returncode == 0:
                continue
            assert process.returncode in (3, -signal.SIGKILL, -signal.SIGTERM), (process.returncode, lines[-1:])
            queue.append(shard)
    return kills, tries


def slurm(command, options, chance, folder):
    script = os.path.join(HERE, "../../docs/farm/array.sbatch")
    environment = {**os.environ, "BOSCAGE": command[0], "BOSCAGE_TRIES": "1000"}
    sbatch = ["sbatch", "--parsable", f"--array=0-{options.shards - 1}", f"--output={folder}/task-%a.log", script, *command[1:], "--out", "new"]
    job = subprocess.run(sbatch, cwd=folder, env=environment, check=True, capture_output=True, text=True).stdout.strip()
    kills = 0
    while True:
        listed = subprocess.run(["squeue", "-h", "-r", "-j", job, "-o", "%i %T"], capture_output=True, text=True).stdout.split("\n")
        tasks = [line.split() for line in listed if line.strip()]
        if not tasks:
            break
        running = [task for task, state in tasks if state == "RUNNING"]
        time.sleep(chance.random() * 2 * options.pace)
        if kills < options.kills and running:
            task = chance.choice(running)
            if chance.random() < 0.5:
                subprocess.run(["scontrol", "requeue", task], capture_output=True)
            else:
                # The program itself, as an out-of-memory killer would.
                pids = subprocess.run(["pgrep", "-f", f"{command[0]} vary.*--out new.*--resume"], capture_output=True, text=True).stdout.split()
                if pids:
                    os.kill(int(chance.choice(pids)), signal.SIGKILL)
            kills += 1
    tries = sum(open(f"{folder}/task-{i}.log").read().count('"prepare","done":0') for i in range(options.shards))
    return kills, tries


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("boscage")
    parser.add_argument("--shards", type=int, default=8)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--kills", type=int, default=30)
    parser.add_argument("--pace", type=float, default=0.3, help="mean seconds between kills")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--slurm", action="store_true")
    options = parser.parse_args()
    boscage, chance = os.path.abspath(options.boscage), random.Random(options.seed)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["BOSCAGE_CACHE"] = folder + "/cache"
        run = lambda *words: subprocess.run([boscage, *words], cwd=folder, check=True, capture_output=True)
        run("samples", "--bundled", "--out", "trees")
        vary = ["vary", "--library", "trees", "--count", str(options.count), "--size", str(options.size), "--maps", "labels,normal"]
        run(*vary, "--out", "whole")
        kills, tries = (slurm if options.slurm else here)([boscage, *vary], options, chance, folder)
        # What was left half-written counts as nobody's after some seconds.
        time.sleep(11)
        run(*vary, "--out", "new", "--resume")
        same = digest(folder + "/whole") == digest(folder + "/new")
        where = "Slurm array" if options.slurm else "queue of its own"
        print(f"farm ({where}): {options.shards} shards, {options.count} trees, {kills} kills, {tries} tries: "
              f"{'identical to' if same else 'DIFFERS from'} a single run")
        sys.exit(not same)


main()
