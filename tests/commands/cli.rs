//! The real binary, as pipelines call it: exit codes, messages, files.

use boscage::raster::{
    Compression, Image, ReadLimits, Straight, encode_grey_png, encode_png, read_image,
};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A folder to play in, with a few pictures.
struct Place(TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        for (name, leaf) in [("oak", 90), ("pine", 140), ("ash", 200)] {
            place.write(
                &format!("{name}.png"),
                &encode_png(&tree(leaf), Compression::Fast),
            );
        }
        place.write("broken.png", b"\x89PNG\r\n\x1a\nno more");
        place.write("from.json", br#"{"points":[[4,4],[4,60],[60,60],[60,4]]}"#);
        place.write("to.json", br#"{"points":[[8,2],[1,62],[50,50],[62,9]]}"#);
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        fs::write(self.path(name), bytes).unwrap();
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    /// Runs `boscage` in this folder on words separated by spaces.
    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_boscage"));
        command
            .current_dir(self.0.path())
            .args(line.split_whitespace());
        command
    }

    fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }

    fn succeed(&self, line: &str) -> Output {
        let output = self.run(line);
        assert_eq!(output.status.code(), Some(0), "{line}: {}", errors(&output));
        output
    }

    /// Runs a command that must fail with `code`; its one line on stderr.
    fn fail(&self, line: &str, code: i32) -> String {
        let output = self.run(line);
        let message = errors(&output);
        assert_eq!(output.status.code(), Some(code), "{line}: {message}");
        assert_eq!(message.lines().count(), 1, "{line}: {message}");
        assert!(message.starts_with("error: "), "{line}: {message}");
        assert!(output.stdout.is_empty(), "{line}");
        message
    }

    fn picture(&self, name: &str) -> Image<Straight> {
        read_image(&self.path(name), ReadLimits::default()).unwrap()
    }

    fn files(&self, folder: &str) -> Vec<String> {
        let names = fs::read_dir(self.path(folder)).into_iter().flatten();
        let mut names: Vec<String> = names
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

/// A block on a post, in a green that tells it from others.
fn tree(leaf: u8) -> Image<Straight> {
    let mut image = Image::filled(64, 64, Straight([0; 4]));
    for y in 4..60 {
        for x in if y < 40 { 8..56 } else { 28..36 } {
            let shade = ((x * 5 + y * 3) % 40) as u8;
            let colour = match y < 40 {
                true => [shade, leaf + shade, shade / 2, 255],
                false => [90 + shade / 4, 60, 40, 255],
            };
            image.set(x, y, Straight(colour));
        }
    }
    image
}

fn errors(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn answer(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn usage_errors_are_one_line_and_help_is_none() {
    let place = Place::new();
    for line in ["--help", "--version", "help", "warp --help"] {
        assert!(!place.succeed(line).stdout.is_empty());
    }
    for command in ["segment", "warp", "recolor"] {
        let help = place.succeed(&format!("{command} --help")).stdout;
        let help = String::from_utf8(help).unwrap();
        assert!(
            help.contains(&format!("Example: boscage {command}")),
            "{help}"
        );
    }
    for line in [
        "frobnicate",
        "segment",
        "segment oak.png",
        "segment oak.png --out o --nonsense",
        "segment oak.png --out o --threads 0",
        "segment oak.png --out o --shard 2/2",
        "segment oak.png --out o --shard 0/0",
        "segment oak.png --out o --seed -1",
        "segment oak.png --out o --overwrite --resume",
        "segment oak.png --out o --json --progress openjd",
        "segment oak.png --out o --segmenter classical --model m.onnx",
        "segment oak.png --out o --model m.onnx",
        "segment oak.png --out o --model oak.png",
        "warp oak.png --from from.json --to to.json --out w.png --size 0 5",
        "warp oak.png --from from.json --to to.json --out w.png --at from.json",
        "--backend cpu segment oak.png --out o",
    ] {
        place.fail(line, 2);
    }
    assert!(place.files("o").is_empty());
    if cfg!(target_os = "linux") {
        // Alone it opens the studio, which needs a desktop, whoever draws.
        for line in ["", "--backend cpu"] {
            let mut alone = place.command(line);
            let alone = alone.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
            let output = alone.output().unwrap();
            assert_eq!(output.status.code(), Some(1));
            assert_eq!(errors(&output).lines().count(), 1, "{}", errors(&output));
        }
    }
}

#[test]
fn segment_writes_labels_of_the_pictures_size() {
    let place = Place::new();
    let output =
        place.succeed("segment oak.png pine.png --segmenter classical --out deep/labels --json");
    assert_eq!(
        place.files("deep/labels"),
        ["oak.labels.png", "pine.labels.png"]
    );
    let labels = place.picture("deep/labels/oak.labels.png");
    assert_eq!((labels.width(), labels.height()), (64, 64));
    let greys = [(0, 0, 0), (32, 20, 255), (32, 50, 128)];
    for (x, y, grey) in greys {
        assert_eq!(labels.at(x, y).0, [grey, grey, grey, 255], "{x}, {y}");
    }
    let answer = answer(&output);
    assert_eq!(answer["images"][0]["file"], "oak.png");
    assert_eq!(answer["images"][0]["source"], "classical");
    assert_eq!(answer["images"][0]["trunk_pixels"], 8 * 20);
    assert_eq!(answer["images"][0]["baseline_y"], 39);
    assert!(answer["seconds"]["segment"].as_f64().unwrap() >= 0.0);
    assert!(output.stderr.is_empty());
}

#[test]
fn a_broken_picture_among_others_is_warned_of() {
    let place = Place::new();
    let output = place.succeed("segment oak.png broken.png missing.png --out o --json");
    let warnings = errors(&output);
    assert_eq!(warnings.lines().count(), 2, "{warnings}");
    assert!(warnings.lines().all(|line| line.starts_with("warning: ")));
    assert!(warnings.contains("broken.png: ") && warnings.contains("missing.png: "));
    assert_eq!(place.files("o"), ["oak.labels.png"]);
    assert_eq!(answer(&output)["refused"].as_array().unwrap().len(), 2);

    assert!(
        place
            .fail("segment broken.png --out p", 2)
            .contains("broken.png: ")
    );
    assert!(
        place
            .fail("segment no/such.png --out p", 2)
            .contains("such.png: ")
    );
    let none = place.run("segment broken.png missing.png --out p");
    assert_eq!(none.status.code(), Some(2));
    assert!(errors(&none).ends_with("error: none of the 2 inputs can be used\n"));
    assert!(place.files("p").is_empty());
}

#[test]
fn a_clear_picture_has_clear_labels_and_a_warning() {
    let place = Place::new();
    let clear = Image::filled(7, 5, Straight([9, 9, 9, 8]));
    place.write("clear.png", &encode_png(&clear, Compression::Fast));
    let output = place.succeed("segment clear.png --out o");
    assert!(errors(&output).starts_with("warning: clear.png: "));
    let labels = place.picture("o/clear.labels.png");
    assert!(labels.pixels().iter().all(|p| p.0 == [0, 0, 0, 255]));
}

#[test]
fn names_that_clash_are_refused_before_anything_is_written() {
    let place = Place::new();
    fs::create_dir(place.path("other")).unwrap();
    place.write("other/oak.png", &place.read("oak.png"));
    let message = place.fail("segment pine.png oak.png other/oak.png --out o", 2);
    assert!(message.contains("oak.png"));
    assert!(place.files("o").is_empty());
}

#[test]
fn what_exists_is_refused_before_the_work() {
    let place = Place::new();
    place.succeed("segment oak.png --out o");
    let before = place.read("o/oak.labels.png");
    let message = place.fail("segment pine.png oak.png --out o", 2);
    assert!(
        message.contains("oak.labels.png: exists already"),
        "{message}"
    );
    assert_eq!(place.files("o"), ["oak.labels.png"]);

    place.write(
        "oak.png",
        &encode_png(&Image::filled(5, 5, Straight([1; 4])), Compression::Fast),
    );
    place.succeed("segment oak.png --out o --overwrite");
    assert_ne!(place.read("o/oak.labels.png"), before);
    // A folder in the place of a file is in the way whatever is allowed.
    fs::create_dir(place.path("o/ash.labels.png")).unwrap();
    place.fail("segment ash.png --out o --overwrite", 2);
    // A file in the place of the folder.
    place.fail("segment ash.png --out oak.png", 2);
}

#[test]
fn resuming_makes_what_is_missing_changed_or_damaged() {
    let place = Place::new();
    let all = "segment oak.png pine.png ash.png --out o";
    place.succeed(all);
    let complete: Vec<Vec<u8>> = labels(&place);
    let mark = |name: &str| fs::metadata(place.path(name)).unwrap().modified().unwrap();
    let kept = mark("o/oak.labels.png");

    // As after a kill: one is missing, one was cut short.
    fs::remove_file(place.path("o/pine.labels.png")).unwrap();
    let whole = place.read("o/ash.labels.png");
    place.write("o/ash.labels.png", &whole[..whole.len() / 2]);
    place.succeed(&format!("{all} --resume"));
    assert_eq!(labels(&place), complete);
    assert_eq!(mark("o/oak.labels.png"), kept, "made again without need");

    // Another picture, a picture that only looks like a result, a file of another origin.
    place.write("pine.png", &encode_png(&tree(10), Compression::Fast));
    place.write(
        "o/ash.labels.png",
        &encode_grey_png(&Image::filled(64, 64, 7), Compression::Fast),
    );
    place.succeed(&format!("{all} --resume"));
    assert_eq!(mark("o/oak.labels.png"), kept);
    assert_eq!(place.read("o/ash.labels.png"), whole);
    assert_ne!(place.read("o/pine.labels.png"), complete[1]);
}

fn labels(place: &Place) -> Vec<Vec<u8>> {
    ["o/oak.labels.png", "o/pine.labels.png", "o/ash.labels.png"]
        .map(|name| place.read(name))
        .to_vec()
}

#[test]
fn a_changed_setting_is_made_again() {
    let place = Place::new();
    let warp = "warp oak.png --from from.json --to to.json --out w.png --resume";
    place.succeed(warp);
    let first = place.read("w.png");
    place.succeed(&format!("{warp} --size 32 40"));
    assert_eq!(place.picture("w.png").height(), 40);
    place.succeed(warp);
    assert_eq!(place.read("w.png"), first);
}

#[test]
fn shards_and_threads_never_show_in_the_files() {
    let place = Place::new();
    let all = "segment oak.png pine.png ash.png --out";
    place.succeed(&format!("{all} o"));
    for shard in ["0/2", "1/2"] {
        place.succeed(&format!("{all} s --shard {shard} --threads 1"));
    }
    // A shard beyond the end has nothing to do.
    place.succeed(&format!("{all} t --shard 3/4"));
    assert_eq!(place.files("t").len(), 0);
    assert_eq!(place.files("s"), place.files("o"));
    for name in place.files("o") {
        assert_eq!(
            place.read(&format!("o/{name}")),
            place.read(&format!("s/{name}"))
        );
    }
    for threads in [1, 3] {
        let line = "warp oak.png --from from.json --to to.json";
        place.succeed(&format!("{line} --threads {threads} --out w{threads}.png"));
    }
    assert_eq!(place.read("w1.png"), place.read("w3.png"));
}

#[test]
fn progress_is_told_as_asked() {
    let place = Place::new();
    let json = place.succeed("segment oak.png pine.png broken.png --out o --progress json");
    let lines = errors(&json);
    assert!(
        lines.starts_with("{\"stage\":\"segment\",\"done\":0,\"total\":3}\n"),
        "{lines}"
    );
    assert!(
        lines.ends_with("{\"stage\":\"segment\",\"done\":3,\"total\":3}\n"),
        "{lines}"
    );
    let values: Vec<Value> = lines
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(
        values
            .iter()
            .filter(|line| line["warning"].is_string())
            .count(),
        1
    );

    let line = "warp oak.png --from from.json --to to.json --out w.png --progress openjd";
    let output = place.succeed(line);
    let stdout = String::from_utf8(output.stdout).unwrap();
    let percentages: Vec<f64> = stdout
        .lines()
        .filter_map(|line| line.strip_prefix("openjd_progress: ")?.parse().ok())
        .collect();
    assert!(
        percentages.is_sorted() && percentages.last() == Some(&100.0),
        "{stdout}"
    );
    assert!(stdout.contains("openjd_status: warp\n"));
    let failed = place.run(line);
    assert!(
        String::from_utf8(failed.stdout)
            .unwrap()
            .contains("openjd_fail: w.png: exists")
    );
    // Without a terminal there is no bar.
    assert!(
        place
            .succeed("segment ash.png --out o --progress bar")
            .stderr
            .is_empty()
    );
}

#[test]
fn warp_moves_the_picture_and_tells_coordinates() {
    let place = Place::new();
    let line = "warp oak.png --from from.json --to from.json --out same.png --exact";
    place.succeed(line);
    let (before, after) = (place.picture("oak.png"), place.picture("same.png"));
    for (x, y) in [(20, 20), (32, 50), (5, 5)] {
        assert_eq!(before.at(x, y), after.at(x, y));
    }
    place.write("at.json", br#"{"points":[[32,32],[4,4]]}"#);
    let line = "warp oak.png --from to.json --to from.json --at at.json --out b.png --json";
    let answer = answer(&place.succeed(line));
    let centre = &answer["coordinates"][0];
    for weight in centre.as_array().unwrap() {
        assert!((weight.as_f64().unwrap() - 0.25).abs() < 1e-12, "{centre}");
    }
    assert_eq!(
        answer["coordinates"][1],
        serde_json::json!([1.0, 0.0, 0.0, 0.0])
    );
    assert_eq!(answer["mapped"][1], serde_json::json!([8.0, 2.0]));
}

#[test]
fn bad_polygons_are_named() {
    let place = Place::new();
    place.write("three.json", br#"{"points":[[1,1],[1,9],[9,1]]}"#);
    place.write("flat.json", br#"{"points":[[1,1],[2,2],[3,3],[4,4]]}"#);
    place.write("none.json", b"{}");
    place.write("cut.json", br#"{"points":[[1,"#);
    for name in ["three", "flat", "none", "cut", "missing"] {
        let line = format!("warp oak.png --from from.json --to {name}.json --out w.png");
        assert!(place.fail(&line, 2).contains(&format!("{name}.json")));
    }
    assert!(!place.path("w.png").exists());
}

#[test]
fn recolor_takes_the_colours_and_leaves_alpha() {
    let place = Place::new();
    place.succeed("recolor oak.png --like ash.png --out r.png");
    assert_eq!(place.picture("r.png"), place.picture("ash.png"));
    let clear = Image::filled(4, 4, Straight([5, 6, 7, 0]));
    place.write("clear.png", &encode_png(&clear, Compression::Fast));
    assert!(
        place
            .fail("recolor oak.png --like clear.png --out s.png", 2)
            .contains("clear.png: ")
    );
    let unchanged = place.succeed("recolor clear.png --like oak.png --out s.png");
    assert!(errors(&unchanged).starts_with("warning: clear.png: "));
    assert_eq!(place.picture("s.png"), clear);
}

/// A line of 2,000 points around the picture: with `--exact`, many seconds of work.
fn slow_warp(place: &Place) -> &'static str {
    let points = (0..2000).map(|i| {
        let angle = f64::from(i) * std::f64::consts::TAU / 2000.0;
        format!(
            "[{},{}]",
            750.0 + 700.0 * angle.cos(),
            750.0 - 700.0 * angle.sin()
        )
    });
    let text = format!("{{\"points\":[{}]}}", points.collect::<Vec<_>>().join(","));
    place.write("circle.json", text.as_bytes());
    fs::create_dir(place.path("o")).unwrap();
    "warp oak.png --from circle.json --to circle.json --size 1500 1500 --exact --out o/w.png"
}

#[cfg(unix)]
#[test]
fn signals_cancel_and_leave_nothing() {
    use std::io::{BufRead as _, BufReader};
    use std::process::Stdio;
    let place = Place::new();
    let line = slow_warp(&place);
    for signal in ["-TERM", "-INT"] {
        let mut command = place.command(&format!("{line} --progress json"));
        let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let begun = lines.find(|line| line.as_ref().unwrap().contains("\"warp\""));
        assert!(begun.is_some());
        let pid = child.id().to_string();
        assert!(
            Command::new("kill")
                .args([signal, &pid])
                .status()
                .unwrap()
                .success()
        );
        assert_eq!(child.wait().unwrap().code(), Some(3), "{signal}");
        assert_eq!(lines.next().unwrap().unwrap(), "error: cancelled");
        assert!(place.files("o").is_empty(), "{:?}", place.files("o"));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_takes_nothing_is_the_environments_fault() {
    let place = Place::new();
    // No file may grow beyond one block of 512 bytes: writing fails as on a full disk.
    let boscage = env!("CARGO_BIN_EXE_boscage");
    let limited = format!("trap '' XFSZ; ulimit -f 0; exec {boscage} segment oak.png --out o");
    let mut shell = Command::new("sh");
    let output = shell
        .current_dir(place.0.path())
        .args(["-c", &limited])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", errors(&output));
    assert!(errors(&output).starts_with("error: o/oak.labels.png: cannot be written"));
    assert!(place.files("o").is_empty());
}

#[cfg(target_os = "linux")]
#[test]
fn a_canvas_beyond_the_memory_is_the_environments_fault() {
    let place = Place::new();
    let boscage = env!("CARGO_BIN_EXE_boscage");
    let line = "warp oak.png --from from.json --to to.json --size 20000 20000 --out w.png";
    let limited = format!("ulimit -v 2000000; exec {boscage} {line}");
    let mut shell = Command::new("sh");
    let shell = shell.current_dir(place.0.path()).args(["-c", &limited]);
    let output = shell.output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", errors(&output));
    assert_eq!(errors(&output).lines().count(), 1);
}

#[test]
fn names_with_control_characters_stay_on_one_line() {
    let place = Place::new();
    let name = "a\nb\u{1b}[2J.png";
    let mut command = place.command("segment --out o");
    let output = command.arg(Path::new(name)).output().unwrap();
    let message = errors(&output);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(!message.contains('\u{1b}'));
}
