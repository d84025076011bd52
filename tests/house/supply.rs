//! Where the code comes from that Boscage is built of, and what it may do.
//!
//! `cargo deny` knows more (known vulnerabilities, yanked versions) but takes minutes to build and a
//! network to ask; what can be known from the lock file and the manifests on this disk is checked
//! here, against the same `deny.toml`. Our own source is read for what it must not contain: code that
//! the compiler cannot check, and the network.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The only place that crates may come from.
const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";

/// Files that may hold code which the compiler cannot check, each with its reason.
const MAY_BE_UNSAFE: [(&str, &str); 1] = [(
    "base/memory.rs",
    "memory that cannot be had is told to an allocator only",
)];

/// Words of the standard library and of others that open connections.
const NETWORK: [&str; 8] = [
    "std::net",
    "TcpStream",
    "TcpListener",
    "UdpSocket",
    "ToSocketAddrs",
    "UnixStream",
    "UnixListener",
    "UnixDatagram",
];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn text(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap()
}

/// The strings of the list `key = [ … ]` in `deny.toml`; of tables the value of `crate`.
fn listed(key: &str) -> BTreeSet<String> {
    let file = text("deny.toml");
    let start = format!("\n{key} = [");
    let list = file
        .split_once(&start)
        .unwrap()
        .1
        .split_once("\n]")
        .unwrap()
        .0;
    let lines = list.lines().map(|line| line.split('#').next().unwrap());
    lines
        .filter_map(|line| line.split('"').nth(1))
        .map(str::to_owned)
        .collect()
}

/// The packages that the program of this machine is built of, as cargo tells them without a network.
fn packages() -> Vec<Value> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--offline", "--locked", "--format-version", "1"])
        .args(["--filter-platform", &host()])
        .current_dir(root())
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{told}");
    let mut metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let nodes = metadata["resolve"]["nodes"].as_array().unwrap();
    let used: BTreeSet<String> = nodes.iter().map(|node| string(&node["id"])).collect();
    let Value::Array(packages) = metadata["packages"].take() else {
        panic!("no packages");
    };
    let is_used = |package: &Value| used.contains(package["id"].as_str().unwrap());
    packages.into_iter().filter(is_used).collect()
}

fn host() -> String {
    let rustc = std::env::var_os("RUSTC").unwrap_or("rustc".into());
    let output = Command::new(rustc).arg("-vV").current_dir(root()).output();
    let output = String::from_utf8(output.unwrap().stdout).unwrap();
    let host = output.lines().find_map(|line| line.strip_prefix("host: "));
    host.unwrap().to_owned()
}

fn string(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

/// Whether the licence expression of a package can be met with the licences in `allowed`.
///
/// As in SPDX, AND binds tighter than OR; an old "/" between names means OR; an exception behind
/// WITH only takes conditions away.
fn is_met(expression: &str, allowed: &BTreeSet<String>) -> bool {
    let spaced = expression.replace('(', " ( ").replace(')', " ) ");
    let spaced = spaced.replace('/', " OR ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let mut at = 0;
    let met = any_of(&words, &mut at, allowed);
    met && at == words.len()
}

fn any_of(words: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let mut met = all_of(words, at, allowed);
    while words.get(*at) == Some(&"OR") {
        *at += 1;
        met |= all_of(words, at, allowed);
    }
    met
}

fn all_of(words: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let mut met = one_of(words, at, allowed);
    while words.get(*at) == Some(&"AND") {
        *at += 1;
        met &= one_of(words, at, allowed);
    }
    met
}

fn one_of(words: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let Some(word) = words.get(*at) else {
        return false;
    };
    *at += 1;
    if *word == "(" {
        let met = any_of(words, at, allowed);
        let is_closed = words.get(*at) == Some(&")");
        *at += 1;
        return met && is_closed;
    }
    if words.get(*at) == Some(&"WITH") {
        *at += 2;
    }
    allowed.contains(*word)
}

#[test]
fn licence_expressions_mean_what_they_mean_in_spdx() {
    let allowed: BTreeSet<String> = ["MIT", "Zlib", "Apache-2.0"].map(str::to_owned).into();
    let met = |expression| is_met(expression, &allowed);
    assert!(met("MIT") && met("GPL-3.0 OR MIT") && met("MIT/GPL-2.0"));
    assert!(met("(GPL-3.0 OR Zlib) AND MIT") && met("Apache-2.0 WITH LLVM-exception"));
    assert!(met("GPL-3.0 AND BSL-1.0 OR MIT") && !met("GPL-3.0 AND (BSL-1.0 OR MIT)"));
    assert!(!met("MIT AND GPL-3.0") && !met("") && !met("MIT MIT") && !met("(MIT"));
}

#[test]
fn all_licences_are_on_the_list() {
    let allowed = listed("allow");
    assert!(allowed.contains("MIT") && allowed.len() > 3);
    let packages = packages();
    assert!(packages.len() > 100);
    let excepted = listed("exceptions");
    let is_excepted = |package: &&Value| excepted.contains(&string(&package["name"]));
    let refused: Vec<String> = packages
        .iter()
        .filter(|package| !is_met(&string(&package["license"]), &allowed))
        .filter(|package| !is_excepted(package))
        .map(|package| format!("{} {}", package["name"], package["license"]))
        .collect();
    assert!(refused.is_empty(), "{refused:#?}");
}

#[test]
fn nothing_banned_is_built_in() {
    let banned = listed("deny");
    assert!(banned.contains("reqwest"));
    let found: Vec<String> = packages()
        .iter()
        .map(|package| string(&package["name"]))
        .filter(|name| banned.contains(name))
        .collect();
    assert!(found.is_empty(), "{found:?}");
}

/// The entries `[[package]]` of the lock file by their fields.
fn locked() -> Vec<BTreeMap<String, String>> {
    let file = text("Cargo.lock");
    let entries = file.split("[[package]]").skip(1);
    let field = |line: &str| {
        let (key, value) = line.split_once(" = ")?;
        Some((key.to_owned(), value.trim_matches('"').to_owned()))
    };
    entries
        .map(|entry| entry.lines().filter_map(field).collect())
        .collect()
}

#[test]
fn every_crate_comes_from_the_registry_with_a_checksum() {
    let locked = locked();
    assert!(locked.len() > 100);
    for package in locked {
        if package["name"] == env!("CARGO_PKG_NAME") {
            assert!(!package.contains_key("source"));
            continue;
        }
        assert_eq!(package.get("source").unwrap(), REGISTRY, "{package:?}");
        assert_eq!(package["checksum"].len(), 64, "{package:?}");
    }
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The lines of our source, with place and without comments.
fn lines() -> Vec<(String, String)> {
    let src = root().join("src");
    let mut lines = Vec::new();
    for path in sources(&src) {
        let name = path.strip_prefix(&src).unwrap().display().to_string();
        let code = fs::read_to_string(&path).unwrap();
        for (number, line) in (1..).zip(code.lines()) {
            let line = line.split("//").next().unwrap();
            lines.push((format!("{name}:{number}"), line.to_owned()));
        }
    }
    lines
}

#[test]
fn no_code_is_unsafe_outside_the_listed_files() {
    assert!(text("Cargo.toml").contains("unsafe_code = \"deny\""));
    let may = |place: &str| {
        let file = place.split(':').next().unwrap();
        MAY_BE_UNSAFE.iter().any(|(listed, _)| *listed == file)
    };
    let found: Vec<String> = lines()
        .into_iter()
        .filter(|(place, line)| {
            let is_unsafe = line.contains("unsafe ") || line.contains("(unsafe_code");
            is_unsafe && !may(place)
        })
        .map(|(place, line)| format!("{place}: {}", line.trim()))
        .collect();
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn our_source_opens_no_connection() {
    let found: Vec<String> = lines()
        .into_iter()
        .filter(|(_, line)| NETWORK.iter().any(|word| line.contains(word)))
        .map(|(place, line)| format!("{place}: {}", line.trim()))
        .collect();
    assert!(found.is_empty(), "{found:#?}");
}
