//! A gallery: a page that opens from disk, without a server or the network, in which trees can be
//! turned round.
//!
//! Browsers do not let a page from disk read files beside it, nor use its pictures in WebGL; scripts
//! may be loaded. So each tree is a script that holds its pictures as data, loaded when the tree is
//! looked at; the page shows the plain PNG files as thumbnails. The viewer (`gallery/viewer.js`)
//! raises the picture by its depth map, front and back, and lights it by its normal map; without a
//! depth map it crosses three cards. Of a crown the script holds the GLB file, of which the viewer
//! draws the finest level.

use super::record::{PresetCrown, PresetTree};
use serde_json::{Value, json};

const PAGE: &str = include_str!("gallery/index.html");
const VIEWER: &str = include_str!("gallery/viewer.js");

/// A tree and its pictures as PNG files.
#[derive(Debug, Clone, Copy)]
pub struct GalleryTree<'a> {
    /// What is told of it.
    pub record: &'a PresetTree,
    /// Colour and alpha.
    pub albedo: &'a [u8],
    /// Normals, Y+.
    pub normal: Option<&'a [u8]>,
    /// Height towards the viewer.
    pub depth: Option<&'a [u8]>,
}

/// The page, `index.html`, with its viewer.
pub fn gallery_page(title: &str) -> String {
    let escaped = title
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;");
    PAGE.replace("{{title}}", &escaped)
        .replace("{{viewer}}", VIEWER)
}

/// The list of all trees and crowns, `gallery.js`.
pub fn gallery_list(trees: &[PresetTree], crowns: &[PresetCrown]) -> String {
    let tree = |tree: &PresetTree| {
        json!({
            "name": tree.name,
            "thumbnail": tree.files.get("albedo"),
            "script": tree.files.get("gallery"),
            "size_m": tree.size_m,
        })
    };
    let crown = |crown: &PresetCrown| {
        json!({
            "name": crown.name,
            "thumbnail": crown.files.get("thumbnail"),
            "script": crown.files.get("gallery"),
            "size_m": &crown.size_m[..2],
        })
    };
    let crowns = crowns.iter().map(crown);
    let list: Vec<Value> = trees.iter().map(tree).chain(crowns).collect();
    format!("gallery.trees({});\n", script_safe(&json!(list)))
}

/// The script of the crown `name` from its model, a GLB file whose finest level is `NAME_LOD0`.
pub fn gallery_crown(name: &str, glb: &[u8]) -> String {
    let value = json!({"name": name, "glb": base64(glb)});
    format!("gallery.tree({});\n", script_safe(&value))
}

/// The script of one tree.
pub fn gallery_tree(tree: &GalleryTree<'_>) -> String {
    let data = |png: &[u8]| format!("data:image/png;base64,{}", base64(png));
    let record = tree.record;
    let value = json!({
        "name": record.name,
        "size_px": record.size_px,
        "frame": record.frame,
        "pivot_px": record.pivot_px,
        "metres_per_pixel": record.metres_per_pixel,
        "depth_m": record.depth_m,
        "albedo": data(tree.albedo),
        "normal": tree.normal.map(data),
        "depth": tree.depth.map(data),
    });
    format!("gallery.tree({});\n", script_safe(&value))
}

/// JSON that is also a JavaScript value.
fn script_safe(value: &Value) -> String {
    value
        .to_string()
        .replace('<', "\\u003c")
        .replace('\u{2028}', "\\u2028")
        .replace('\u{2029}', "\\u2029")
}

/// RFC 4648, with padding.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            if digit > chunk.len() {
                out.push('=');
            } else {
                let index = bits >> (18 - 6 * digit) & 63;
                out.push(char::from(DIGITS[index as usize]));
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        // RFC 4648, section 10.
        for (plain, coded) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn the_page_names_nothing_outside_its_folder() {
        let page = gallery_page("A <b> & co");
        assert!(page.contains("A &lt;b&gt; &amp; co"));
        assert!(!page.contains("{{") && !page.contains("http"));
    }
}
