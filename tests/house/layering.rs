//! The structure of the source, checked by reading it: which module imports which, who may name a
//! window or a graphics card, who opens files, what a module is called, how long a file gets.
//!
//! The order of the modules is that of the `pub mod` lines in `src/lib.rs`.

use std::fs;
use std::path::{Path, PathBuf};

/// Files that may open files: one place for the plain ones, loaders and writers with a reason (the
/// store of projects keeps backups, locks and autosaves beside them).
const MAY_OPEN_FILES: [&str; 5] = [
    "base/file.rs",
    "base/part.rs",
    "batch/",
    "cli/",
    "document/store/",
];

/// Words of paths that open, list or remove files.
const OPENING: [&str; 4] = ["std::fs", "File::", "OpenOptions", "fs::"];

/// Crates that know windows.
const WINDOWS: [&str; 8] = [
    "egui",
    "eframe",
    "egui_extras",
    "egui_plot",
    "egui_tiles",
    "egui_winit",
    "rfd",
    "softbuffer",
];

/// What changes the project; how it is looked at is no change.
const CHANGING: [&str; 8] = [
    "document.abort",
    "document.apply",
    "document.begin",
    "document.commit",
    "document.mark_saved",
    "document.mark_unsaved",
    "document.redo",
    "document.undo",
];

/// Most lines of a file without its tests.
const LONGEST_FILE: usize = 800;

/// A source file: its path below `src/` and its lines without comments, strings' contents and
/// tests, each with its number.
struct Source {
    path: String,
    lines: Vec<(usize, String)>,
}

impl Source {
    fn new(path: String, text: &str) -> Self {
        let lines = without_tests(text)
            .map(|(number, line)| (number, code_of(line)))
            .collect();
        Self { path, lines }
    }

    /// The module of the top level that the file belongs to, `main` and `lib` included.
    fn module(&self) -> &str {
        let first = self.path.split('/').next().unwrap_or_default();
        first.strip_suffix(".rs").unwrap_or(first)
    }

    /// The lines that name one of `words` as a path or the start of one.
    fn naming<'a>(&'a self, words: &'a [&str]) -> impl Iterator<Item = String> + 'a {
        self.lines.iter().filter_map(|(number, line)| {
            let word = words.iter().find(|word| names(line, word))?;
            Some(format!("src/{}:{number} names {word}", self.path))
        })
    }
}

/// The numbered lines of `text` but those of a trailing `mod tests { … }`.
fn without_tests(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines: Vec<&str> = text.lines().collect();
    let end = lines
        .iter()
        .position(|line| line.trim() == "mod tests {")
        .unwrap_or(lines.len());
    (1..).zip(lines.into_iter().take(end))
}

/// `line` without its comment and without what stands between quotes.
fn code_of(line: &str) -> String {
    let mut code = String::new();
    for (index, part) in line.split('"').enumerate() {
        if index % 2 == 0 {
            if let Some((before, _)) = part.split_once("//") {
                code.push_str(before);
                break;
            }
            code.push_str(part);
        } else {
            code.push_str("\"\"");
        }
    }
    code
}

/// Whether `word` stands in `line` as a whole word (at its left end; at its right too if it ends in
/// a letter).
fn names(line: &str, word: &str) -> bool {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    line.match_indices(word).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        let after = line[at + word.len()..].chars().next();
        let goes_on = word.ends_with(is_word) && after.is_some_and(is_word);
        !goes_on && !before.is_some_and(is_word)
    })
}

/// The modules that `line` names after `crate::` or `boscage::`, also several in braces.
fn imported(line: &str) -> Vec<String> {
    let mut modules = Vec::new();
    for root in ["crate::", "boscage::"] {
        for (at, _) in line.match_indices(root) {
            let rest = &line[at + root.len()..];
            match rest.strip_prefix('{') {
                Some(list) => modules.extend(heads_of(list)),
                None => modules.extend(identifier(rest)),
            }
        }
    }
    modules
}

/// The first word of each item of a list in braces, not of lists within it.
fn heads_of(list: &str) -> Vec<String> {
    let (mut heads, mut depth, mut at_head) = (Vec::new(), 0, true);
    for (at, character) in list.char_indices() {
        match character {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => at_head = true,
            c if at_head && !c.is_whitespace() => {
                heads.extend(identifier(&list[at..]));
                at_head = false;
            }
            _ => {}
        }
    }
    heads
}

fn identifier(text: &str) -> Option<String> {
    let end = text
        .find(|c: char| !(c.is_alphanumeric() || c == '_'))
        .unwrap_or(text.len());
    (end > 0).then(|| text[..end].to_owned())
}

fn source_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Every file of the source in the order of its path, with its path below `src/` and its text.
fn texts() -> Vec<(String, String)> {
    fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).expect("src/ is readable") {
            let path = entry.expect("src/ is readable").path();
            if path.is_dir() {
                collect(&path, files);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    let root = source_folder();
    let mut files = Vec::new();
    collect(&root, &mut files);
    files.sort();
    let relative = |path: &Path| {
        let parts = path
            .strip_prefix(&root)
            .expect("found below it")
            .components();
        let parts: Vec<_> = parts.map(|p| p.as_os_str().to_string_lossy()).collect();
        parts.join("/")
    };
    let is_test = |path: &String| path.ends_with("/tests.rs") || path.contains("/tests/");
    files
        .iter()
        .map(|path| {
            (
                relative(path),
                fs::read_to_string(path).expect("sources are UTF-8"),
            )
        })
        .filter(|(path, _)| !is_test(path))
        .collect()
}

fn sources() -> Vec<Source> {
    let sources = texts().into_iter();
    sources
        .map(|(path, text)| Source::new(path, &text))
        .collect()
}

/// The modules in the order of `src/lib.rs`.
fn order() -> Vec<String> {
    let lib = fs::read_to_string(source_folder().join("lib.rs")).expect("the library exists");
    let lines = lib.lines();
    let names = lines.filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
    names.map(str::to_owned).collect()
}

fn check(complaints: &[String]) {
    assert!(complaints.is_empty(), "\n{}\n", complaints.join("\n"));
}

/// What `source` imports though it does not stand above it in `order`.
fn imports_from_below(source: &Source, order: &[String]) -> Vec<String> {
    let place = |module: &str| order.iter().position(|known| known == module);
    let Some(own) = place(source.module()) else {
        // lib.rs and main.rs stand below all modules.
        return Vec::new();
    };
    // A `use` may run over several lines: each statement is read as one.
    let mut complaints = Vec::new();
    let (mut statement, mut start) = (String::new(), 0);
    for (number, line) in &source.lines {
        if statement.is_empty() {
            start = *number;
        }
        statement.push_str(line);
        statement.push(' ');
        let open = statement.matches('{').count() > statement.matches('}').count();
        let importing = statement.contains("crate::{") || statement.contains("boscage::{");
        if importing && open {
            continue;
        }
        for module in imported(&statement) {
            if place(&module).is_some_and(|place| place > own) {
                let path = &source.path;
                complaints.push(format!("src/{path}:{start} imports {module} from below"));
            }
        }
        statement.clear();
    }
    complaints
}

#[test]
fn modules_import_only_from_above() {
    let order = order();
    assert!(order.len() > 1, "no `pub mod` lines in src/lib.rs");
    let sources = sources();
    let all = sources.iter().flat_map(|s| imports_from_below(s, &order));
    check(&all.collect::<Vec<_>>());
}

#[test]
fn every_folder_is_listed_in_the_library() {
    let order = order();
    let listed = |source: &&Source| {
        ["lib", "main"].contains(&source.module()) || order.iter().any(|m| m == source.module())
    };
    let sources = sources();
    let strangers = sources.iter().filter(|source| !listed(source));
    let complaints = strangers.map(|s| format!("src/{} is in no module of src/lib.rs", s.path));
    check(&complaints.collect::<Vec<_>>());
}

#[test]
fn windows_and_graphics_cards_are_named_only_where_they_belong() {
    let mut complaints = Vec::new();
    for source in sources() {
        if source.module() != "app" {
            complaints.extend(source.naming(&WINDOWS));
        }
        if source.module() != "render" && source.path != "app/viewport.rs" {
            complaints.extend(source.naming(&["wgpu"]));
        }
    }
    check(&complaints);
}

#[test]
fn the_window_changes_the_project_in_two_places_only() {
    let mut complaints = Vec::new();
    for source in sources() {
        let may = ["app/act", "app/outcome"]
            .iter()
            .any(|at| source.path.starts_with(at));
        if source.module() == "app" && !may {
            complaints.extend(source.naming(&CHANGING));
        }
    }
    check(&complaints);
}

#[test]
fn files_are_opened_only_by_loaders_writers_and_commands() {
    let mut complaints = Vec::new();
    for source in sources() {
        let may = |allowed: &&str| source.path.starts_with(*allowed);
        if !MAY_OPEN_FILES.iter().any(may) {
            complaints.extend(source.naming(&OPENING));
        }
    }
    check(&complaints);
}

#[test]
fn no_module_has_a_name_that_says_nothing() {
    const EMPTY_NAMES: [&str; 8] = [
        "utils", "util", "helpers", "helper", "manager", "managers", "common", "misc",
    ];
    let empty = |path: &str| {
        let mut parts = path.trim_end_matches(".rs").split('/');
        parts.any(|part| EMPTY_NAMES.contains(&part))
    };
    let files = texts().into_iter().map(|(path, _)| path);
    check(&files.filter(|path| empty(path)).collect::<Vec<_>>());
}

#[test]
fn no_file_is_too_long() {
    let too_long = |(path, text): (String, String)| {
        let lines = without_tests(&text).count();
        (lines > LONGEST_FILE).then(|| format!("src/{path} has {lines} lines without its tests"))
    };
    check(&texts().into_iter().filter_map(too_long).collect::<Vec<_>>());
}

/// The checks themselves, on source that breaks the rules.
mod on_bad_source {
    use super::*;

    fn complaints(path: &str, text: &str) -> Vec<String> {
        let order = ["base", "raster", "app"].map(str::to_owned);
        imports_from_below(&Source::new(path.to_owned(), text), &order)
    }

    #[test]
    fn imports_are_found_in_braces_and_over_lines() {
        let text = "use crate::{\n    base::Seed,\n    raster::{Image, Mask},\n    app,\n};\n";
        let found = complaints("raster/read.rs", text);
        assert_eq!(found, ["src/raster/read.rs:1 imports app from below"]);
        let inline = complaints(
            "base/file.rs",
            "fn f() -> u8 {\n    crate::raster::size()\n}",
        );
        assert_eq!(inline, ["src/base/file.rs:2 imports raster from below"]);
        assert!(complaints("app/mod.rs", "use crate::raster::Image;").is_empty());
    }

    #[test]
    fn comments_strings_and_tests_may_name_anything() {
        let text = "// crate::app\nlet s = \"crate::app\";\n#[cfg(test)]\nmod tests {\n    use crate::app;\n}";
        assert!(complaints("base/file.rs", text).is_empty());
    }

    #[test]
    fn only_whole_words_count() {
        assert!(names("use egui::Ui;", "egui") && !names("let my_egui_like = 1;", "egui"));
        assert!(names("std::fs::read(path)", "fs::") && !names("let x = offs::new()", "fs::"));
        assert!(names("File::open(path)", "File::") && !names("MyFile::open()", "File::"));
    }
}
