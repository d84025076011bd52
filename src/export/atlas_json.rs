//! The lists that go with an atlas, in the two JSON forms of TexturePacker, which most engines read.
//!
//! Nothing is rotated. `sourceSize` and `spriteSourceSize` tell the untrimmed picture at the scale
//! of the atlas; `anchor` is the trunk's foot as a share of the *untrimmed* size, y down.

use crate::raster::Rect;
use serde_json::{Map, Value, json};

/// A sprite in the list of a page.
#[derive(Debug, Clone, PartialEq)]
pub struct AtlasSprite {
    /// Its name, which is its key in the hash form.
    pub name: String,
    /// Its pixels on the page.
    pub frame: Rect,
    /// Where they lay in the untrimmed picture.
    pub in_source: Rect,
    /// Width and height of the untrimmed picture.
    pub source: [u32; 2],
    /// The foot, in shares of the untrimmed picture's sides.
    pub anchor: [f64; 2],
}

impl AtlasSprite {
    fn fields(&self) -> Map<String, Value> {
        let rect = |r: Rect| json!({"x": r.x, "y": r.y, "w": r.width, "h": r.height});
        let [width, height] = self.source;
        let trimmed = [self.frame.width, self.frame.height] != self.source;
        let fields = json!({
            "frame": rect(self.frame),
            "rotated": false,
            "trimmed": trimmed,
            "spriteSourceSize": rect(self.in_source),
            "sourceSize": {"w": width, "h": height},
            "anchor": {"x": self.anchor[0], "y": self.anchor[1]},
        });
        match fields {
            Value::Object(fields) => fields,
            _ => unreachable!("written as an object just above"),
        }
    }
}

fn meta(image: &str, size: [u32; 2]) -> Value {
    json!({
        "app": "boscage",
        "version": env!("CARGO_PKG_VERSION"),
        "image": image,
        "format": "RGBA8888",
        "size": {"w": size[0], "h": size[1]},
        "scale": "1",
    })
}

fn text(list: &Value) -> String {
    let written = serde_json::to_string_pretty(list);
    written.unwrap_or_else(|_| unreachable!("a value is always written")) + "\n"
}

/// The list of a page whose picture is the file `image`, sprites keyed by name.
pub fn atlas_json_hash(sprites: &[AtlasSprite], image: &str, size: [u32; 2]) -> String {
    let frames: Map<String, Value> = sprites
        .iter()
        .map(|sprite| (sprite.name.clone(), Value::Object(sprite.fields())))
        .collect();
    text(&json!({"frames": frames, "meta": meta(image, size)}))
}

/// The same as an array, each sprite with its `filename`.
pub fn atlas_json_array(sprites: &[AtlasSprite], image: &str, size: [u32; 2]) -> String {
    let frames: Vec<Value> = sprites
        .iter()
        .map(|sprite| {
            let mut fields = Map::from_iter([("filename".to_owned(), json!(sprite.name))]);
            fields.extend(sprite.fields());
            Value::Object(fields)
        })
        .collect();
    text(&json!({"frames": frames, "meta": meta(image, size)}))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_say_the_same() {
        let sprite = AtlasSprite {
            name: "tree_0000".to_owned(),
            frame: Rect {
                x: 8,
                y: 8,
                width: 20,
                height: 30,
            },
            in_source: Rect {
                x: 6,
                y: 2,
                width: 20,
                height: 30,
            },
            source: [32, 32],
            anchor: [0.5, 1.0],
        };
        let parsed = |text: String| serde_json::from_str::<Value>(&text).unwrap();
        let sprites = [sprite];
        let hash = parsed(atlas_json_hash(&sprites, "atlas.png", [64, 64]));
        let array = parsed(atlas_json_array(&sprites, "atlas.png", [64, 64]));
        assert_eq!(hash["meta"]["scale"], "1");
        assert_eq!(hash["meta"], array["meta"]);
        assert_eq!(array["frames"][0]["filename"], "tree_0000");
        for key in [
            "frame",
            "rotated",
            "trimmed",
            "spriteSourceSize",
            "sourceSize",
            "anchor",
        ] {
            assert_eq!(
                hash["frames"]["tree_0000"][key], array["frames"][0][key],
                "{key}"
            );
        }
        assert_eq!(hash["frames"]["tree_0000"]["trimmed"], true);
    }
}
