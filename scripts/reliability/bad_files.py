#!/usr/bin/env python3
"""Gives every reader of Boscage bad files: those of a corpus that others wrote, and some made here (records
that lie, paths that lead elsewhere, names in any script, pipes and devices where files should be).

usage: bad_files.py BOSCAGE [--corpus DIR] [--every N] [--memory-mb 2048] [--seconds 20] [--jobs 2]
Each run must end in time and within the memory, without a signal; when it fails, with exit code 1 or 2, one
line on stderr beside warnings, and nothing written. Prints a line a reader, and one for each failure."""
import argparse, collections, concurrent.futures, json, os, re, resource, shutil, signal, struct, subprocess, sys, tempfile, zlib

from inputs import photo_and_mask

ODD = re.compile("[\x00-\x08\x0b-\x1f\x7f\u202a-\u202e]")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("boscage")
    parser.add_argument("--corpus")
    parser.add_argument("--every", type=int, default=1, help="only each N-th file of the corpus")
    parser.add_argument("--readers", default="", help="only these, by the first words of their names")
    parser.add_argument("--memory-mb", type=int, default=2048)
    parser.add_argument("--seconds", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    boscage = os.path.abspath(options.boscage)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["BOSCAGE_CACHE"] = folder + "/cache"
        good = prepared(boscage, folder)
        cases = [*made_here(folder, good), *from_corpus(options, good)]
        wanted = tuple(options.readers.split(",")) if options.readers else ("",)
        cases = [case for case in cases if case[0].startswith(wanted)]
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            outcomes = list(pool.map(lambda case: tried(boscage, case, options), cases))
    counts = collections.defaultdict(collections.Counter)
    for (reader, name, _), (code, wrong) in zip(cases, outcomes):
        counts[reader]["files"] += 1
        counts[reader][{0: "read", 1: "refused", 2: "refused"}.get(code, "wrong")] += 1
        if wrong:
            counts[reader]["failed"] += 1
            print(f"FAIL {reader} {name}: {wrong}")
    for reader, count in counts.items():
        print(f"bad files, {reader}: {count['files']} files, {count['read']} read, {count['refused']} refused in a line, {count['failed']} failed")
    sys.exit(any(count["failed"] for count in counts.values()))


def tried(boscage, case, options):
    _, _, arguments = case
    out = tempfile.mkdtemp()
    def limited():
        resource.setrlimit(resource.RLIMIT_AS, (options.memory_mb << 20,) * 2)
        resource.setrlimit(resource.RLIMIT_CPU, (options.seconds,) * 2)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 30,) * 2)
    command = [boscage.encode(), *[a if isinstance(a, bytes) else a.replace("{out}", out).encode() for a in arguments]]
    try:
        done = subprocess.run(command, capture_output=True, timeout=20 * options.seconds, preexec_fn=limited, stdin=subprocess.DEVNULL)
    except subprocess.TimeoutExpired:
        return "time", f"took longer than {20 * options.seconds} s"
    finally:
        left = os.listdir(out)
        shutil.rmtree(out, ignore_errors=True)
    said = done.stderr.decode("utf8", "replace")
    lines = [line for line in said.splitlines() if line.strip() and not line.startswith("warning: ")]
    if done.returncode == -signal.SIGXCPU:
        return "time", f"worked longer than {options.seconds} s"
    if done.returncode not in (0, 1, 2):
        return done.returncode, f"exit code {done.returncode}: {said[-200:]!r}"
    if "panicked" in said:
        return "panic", repr(said[:200])
    if any(ODD.search(line) or len(line) > 1000 for line in said.splitlines()):
        return "line", f"a line that is long or odd: {said[:300]!r}"
    if done.returncode and (len(lines) != 1 or not lines[0].startswith("error: ")):
        return "lines", f"not one line: {said[:300]!r}"
    if done.returncode and left:
        return "left", f"left {left}"
    return done.returncode, None


def prepared(boscage, folder):
    run = lambda *words: subprocess.run([boscage, *words], cwd=folder, check=True, capture_output=True)
    run("samples", "--bundled", "--out", "samples")
    os.mkdir(folder + "/trees")
    for source, name in [("oak_01.png", "a.png"), ("pine_01.png", "b.png")]:
        shutil.copy(f"{folder}/samples/{source}", f"{folder}/trees/{name}")
    photo_and_mask(folder, 128)
    open(folder + "/polygon.json", "w").write('{"points":[[0,0],[90,0],[90,90],[0,90]]}')
    run("vary", "--library", "trees", "--count", "2", "--size", "96", "--out", "new")
    run("crown", "photo.png", "--mask", "mask.png", "--size", "32", "--out", "crown")
    return {
        "folder": folder, "tree": f"{folder}/trees/a.png", "photo": f"{folder}/photo.png", "mask": f"{folder}/mask.png",
        "trees": f"{folder}/trees", "record": json.load(open(folder + "/new/library.json")),
        "polygon": f"{folder}/polygon.json", "new": f"{folder}/new", "crown": f"{folder}/crown",
    }


def readers(good, path):
    """Every command that reads a picture, with `path` in the place of one."""
    yield "inspect", ["inspect", path, "--size", "128", "--json"]
    yield "segment", ["segment", path, "--out", "{out}"]
    yield "warp", ["warp", path, "--from", good["polygon"], "--to", good["polygon"], "--out", "{out}/a.png"]
    yield "recolor", ["recolor", good["tree"], "--like", path, "--out", "{out}/a.png"]
    yield "inflate", ["inflate", path, "--size", "32", "--out", "{out}/a.obj"]
    yield "crown", ["crown", good["photo"], "--mask", path, "--size", "16", "--out", "{out}"]
    yield "synthesize", ["synthesize", path, "--mask", good["mask"], "--width", "32", "--height", "32", "--out", "{out}/a.png"]
    yield "vary --target", ["vary", "--library", good["trees"], "--target", path, "--size", "64", "--count", "1", "--out", "{out}"]


def from_corpus(options, good):
    if not options.corpus:
        return
    files = []
    for folder, _, names in sorted(os.walk(options.corpus)):
        files += [os.path.join(folder, name) for name in sorted(names)]
    for path in files[:: options.every]:
        name = os.path.relpath(path, options.corpus)
        ending = path.rsplit(".", 1)[-1].lower()
        if ending in ("json", "jsonl", "txt", "zip"):
            for reader, arguments in text_readers(good, path):
                yield reader, name, arguments
        elif ending != "onnx":
            for reader, arguments in readers(good, path):
                yield reader, name, arguments
    lines = [path for path in files if "expressions" in path]
    for path in lines:
        for number, line in enumerate(open(path, encoding="utf8", errors="replace")):
            try:
                value = json.loads(line)
            except ValueError:
                continue
            text = value if isinstance(value, str) else value.get("expr") or value.get("expression") or str(value)
            if "\0" not in text:
                yield "inflate --k", f"line {number}", ["inflate", good["mask"], f"--k={text}", "--size", "24", "--out", "{out}/a.obj"]


def text_readers(good, path):
    yield "warp --from", ["warp", good["tree"], "--from", path, "--to", path, "--out", "{out}/a.png"]
    yield "inflate --profile", ["inflate", good["mask"], "--profile", path, "--size", "24", "--out", "{out}/a.obj"]
    yield "inflate --regions", ["inflate", good["mask"], "--regions", path, "--size", "24", "--out", "{out}/a.obj"]
    yield "vary --recipe", ["vary", "--recipe", path + "#tree_0000", "--library", good["trees"], "--out", "{out}"]
    yield "crown --recipe", ["crown", "--recipe", path, "--out", "{out}"]


def changed(value, change):
    """A deep copy of `value` with `change` done to it."""
    value = json.loads(json.dumps(value))
    change(value)
    return value


def made_here(folder, good):
    write = lambda path, text: (os.makedirs(os.path.dirname(path), exist_ok=True), open(path, "w").write(text))[0]
    put = lambda *keys: lambda v, new: deep_set(v, keys, new)
    places = {
        ("settings", "size"): [0, 1, 15, 8193, 10**9, 4294967296, -1, 1e300, None, "x"],
        ("settings", "threshold"): [0, 1, -1, 1e300, None],
        ("settings", "points"): [0, 9, 10**12, -5],
        ("settings", "simplified"): [0, 3, 10**12],
        ("trees", 0, "file"): ["../a.png", "/etc/passwd", "..", "", ".", "a/../../b.png", "C:x.png", "a\0b.png", "a\nb.png", "x" * 5000, "\u202egnp.png"],
        ("trees", 0, "exemplars", 0, "file"): ["../../etc/passwd", "/dev/zero", "/dev/stdin", "/proc/self/mem", "", "x" * 5000, "\0"],
        ("trees", 0, "exemplars", 0, "digest"): ["", "0" * 64, "zz", "x" * 10**6],
        ("trees", 0, "exemplars"): [[], [{"file": "a.png", "digest": ""}] * 5000],
        ("trees", 0, "contour_weights"): [[], [2, -1], [1e308, -1e308], [0.5], [1e-320, 1]],
        ("trees", 0, "color_weights"): [[], [1e308, 1e308]],
        ("trees", 0, "pins", "B"): [[1e308, 1e308], [-1e308, 0], [1e9, 1e9]],
        ("trees", 0, "size"): [[0, 0], [4294967295, 4294967295]],
        ("trees", 0, "like"): [{"file": "/dev/zero", "digest": ""}, {"file": "../trees/a.png", "digest": "00"}],
        ("trees",): [[], None, {}],
        ("version",): [0, 2, 10**30],
        ("library",): ["/", "/dev/zero", "..", "\0"],
    }
    count = 0
    for keys, values in places.items():
        for value in values:
            count += 1
            library = f"{folder}/lies/{count}"
            shutil.copytree(good["new"], library)
            record = changed(good["record"], lambda record: put(*keys)(record, value))
            write(library + "/library.json", json.dumps(record))
            name = f"{'.'.join(map(str, keys))} = {str(value)[:30]!r}"
            yield "vary --recipe", name, ["vary", "--recipe", library + "/library.json#tree_0000", "--library", good["trees"], "--out", "{out}"]
            for preset in ("web", "flightgear"):
                yield "export", name, ["export", library, "--preset", preset, "--out", "{out}/e"]
    record = json.load(open(good["crown"] + "/crown.json"))
    lies = [("size", 0), ("size", 10**9), ("radius_max_m", 1e39), ("radius_max_m", -1), ("center_m", [1e308] * 3), ("faces", []), ("recipe", {"a": 1}), ("recipe", None), ("version", 7)]
    for number, (key, value) in enumerate(lies):
        crown = f"{folder}/crowns/{number}"
        shutil.copytree(good["crown"], crown)
        write(crown + "/crown.json", json.dumps({**record, key: value}))
        for reader, arguments in crown_readers(crown):
            yield reader, f"{key} = {value}", arguments
    for number, file in enumerate(sorted(os.listdir(good["crown"]))):
        crown = f"{folder}/cut/{number}"
        shutil.copytree(good["crown"], crown)
        content = open(f"{crown}/{file}", "rb").read()
        open(f"{crown}/{file}", "wb").write(content[: len(content) // 2])
        for reader, arguments in crown_readers(crown):
            yield reader, f"half of {file}", arguments
    yield from odd_files(folder, good)


def crown_readers(crown):
    yield "render", ["render", crown, "--backend", "cpu", "--size", "32", "32", "--out", "{out}/a.png"]
    yield "export of a crown", ["export", crown, "--preset", "web", "--no-impostors", "--out", "{out}/e"]
    yield "crown --recipe", ["crown", "--recipe", crown + "/crown.json", "--out", "{out}/c"]


def deep_set(value, keys, new):
    for key in keys[:-1]:
        value = value[key]
    value[keys[-1]] = new


def odd_files(folder, good):
    odd = folder + "/odd"
    os.makedirs(odd)
    tree = open(good["tree"], "rb").read()
    names = ["дерево.png", "木.png", "شجرة.png", "e\u0301.png", "a b'\"$(x).png", "-rf.png", "\u202egnp.exe.png", "new\nline.png", "x" * 250 + ".png", "\ud83c\udf33.png".encode("utf-16", "surrogatepass").decode("utf-16")]
    for name in [*map(str.encode, names), b"\xff\xfe.png", b"caf\xe9.png"]:
        path = odd.encode() + b"/" + name
        open(path, "wb").write(tree)
        for reader, arguments in readers(good, "{path}"):
            yield reader, f"name {name!r}", [path if word == "{path}" else word for word in arguments]
    special = {"a loop of links": "loop.png", "a pipe": "pipe.png", "a folder": "folder.png", "a link to nothing": "nothing.png", "a link to a device": "zero.png", "a sparse terabyte": "sparse.png", "no right to read": "secret.png", "empty": "empty.png"}
    os.symlink("loop.png", odd + "/loop.png")
    os.mkfifo(odd + "/pipe.png")
    os.mkdir(odd + "/folder.png")
    os.symlink("/nowhere/at/all", odd + "/nothing.png")
    os.symlink("/dev/zero", odd + "/zero.png")
    with open(odd + "/sparse.png", "wb") as file:
        file.truncate(1 << 40)
    open(odd + "/secret.png", "wb").write(tree)
    os.chmod(odd + "/secret.png", 0)
    open(odd + "/empty.png", "wb")
    for what, name in special.items():
        for reader, arguments in readers(good, f"{odd}/{name}"):
            yield reader, what, arguments
        for reader, arguments in text_readers(good, f"{odd}/{name}"):
            yield reader, what, arguments
    fixture = open(os.path.join(os.path.dirname(__file__), "../../tests/fixtures/v1.boscage"), "rb").read()
    for at in range(0, len(fixture), max(1, len(fixture) // 40)):
        changed = bytearray(fixture)
        changed[at] ^= 0x55
        for name, content in [(f"cut at {at}", fixture[:at]), (f"changed at {at}", bytes(changed))]:
            path = f"{odd}/{name.replace(' ', '_')}.boscage"
            open(path, "wb").write(content)
            yield "export of a project", name, ["export", path, "--preset", "godot", "--no-impostors", "--out", "{out}/out"]
    for what, name in special.items():
        os.symlink(f"{odd}/{name}", f"{odd}/{name}.boscage")
        yield "export of a project", what, ["export", f"{odd}/{name}.boscage", "--preset", "godot", "--out", "{out}/out"]
    texts = {"deep": "[" * 10**6, "deep object": '{"a":' * 10**5, "nan": '{"points":[[NaN,1]]}', "inf": '{"points":[[1e999,1]]}', "bom": '\ufeff{"points":[[0,0],[1,0],[0,1]]}', "same points": '{"points":[[1,1],[1,1],[1,1]]}', "line": '{"points":[[0,0],[1,1],[2,2]]}', "one": '{"points":[[0,0]]}', "crossed": '{"points":[[0,0],[9,9],[9,0],[0,9]]}', "tiny": '{"points":[[0,0],[1e-300,0],[0,1e-300]]}', "zero": "0", "null": "null", "text": '"' + "x" * 10**6 + '"'}
    for name, text in texts.items():
        path = f"{odd}/{name}.json"
        open(path, "w").write(text)
        for reader, arguments in text_readers(good, path):
            yield reader, name, arguments
    for text in ["1/0", "0", "-1", "1e308*1e308", "0/0", "sqrt(-1)", "(" * 500, "-" * 900, "1" * 999, "i" * 999, "", " ", "k", "2^2^2^2^2^2", "exp(exp(exp(9)))", "1e-320", "1+(", "ａ", "i;rm -rf", "pow(0,-1)"]:
        yield "inflate --k", text[:20], ["inflate", good["mask"], f"--k={text}", "--size", "24", "--out", "{out}/a.obj"]
        yield "crown --k", text[:20], ["crown", good["photo"], "--mask", good["mask"], f"--k={text}", "--size", "16", "--out", "{out}"]
    for flag, values in {"--height": ["nan", "inf", "-1", "0", "1e300", "1e-300"], "--relief": ["nan", "-1", "1e300", "inf"], "--size": ["0", "99999999"], "--copies": ["0", "99999999"], "--trunk-height": ["nan", "inf", "1e300", "-1"]}.items():
        for value in values:
            yield f"crown {flag}", value, ["crown", good["photo"], "--mask", good["mask"], "--size", "16", f"{flag}={value}", "--out", "{out}"]
    for flag in ["--yaw", "--pitch", "--distance", "--sun-yaw"]:
        for value in ["nan", "inf", "-inf", "1e300", "1e-300", "0"]:
            yield f"render {flag}", value, ["render", good["crown"], "--backend", "cpu", "--size", "32", "32", f"{flag}={value}", "--out", "{out}/a.png"]


main()
