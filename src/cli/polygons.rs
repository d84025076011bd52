//! Files of points: `{"points":[[x,y],…]}`, or `{"polygons":[[[x,y],…],…]}` with the outer polygon
//! first and holes behind it.

use super::failure::Failure;
use crate::base::{Digest, read_limited};
use crate::geometry::{Point, Polygon};
use crate::variation::Cage;
use serde::Deserialize;
use std::path::Path;

/// Largest file that is read.
const LARGEST_BYTES: u64 = 16 << 20;

/// Most points of a file in all. Every pixel is compared with every point: a picture of 1024×1024
/// would already take minutes, and an outline followed pixel by pixel has fewer.
const MOST_POINTS: usize = 20_000;

/// Farthest coordinate, in pixels: beyond it, single precision has no fractions of a pixel left.
const FARTHEST: f64 = 1e6;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    points: Option<Vec<[f64; 2]>>,
    polygons: Option<Vec<Vec<[f64; 2]>>>,
}

/// The polygons of a file.
#[derive(Debug)]
pub(super) struct PolygonFile {
    name: String,
    polygons: Vec<Polygon>,
    digest: Digest,
}

impl PolygonFile {
    /// Reads a file of points or polygons.
    ///
    /// # Errors
    /// [`Failure::BadInput`] naming the file and what is wrong with it.
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let bytes = read_limited(path, LARGEST_BYTES)?;
        let name = path.display().to_string();
        Ok(Self {
            polygons: parsed(&bytes).map_err(|reason| Failure::of(&name, reason))?,
            digest: Digest::of(&bytes),
            name,
        })
    }

    /// The polygons as a cage.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when they cannot be one.
    pub(super) fn cage(&self) -> Result<Cage, Failure> {
        Cage::new(&self.polygons).map_err(|error| Failure::of(&self.name, error))
    }

    /// The polygons, as given.
    pub(super) fn polygons(&self) -> &[Polygon] {
        &self.polygons
    }

    /// All points in one list.
    pub(super) fn points(&self) -> impl Iterator<Item = Point> + '_ {
        self.polygons.iter().flatten().copied()
    }

    /// The digest of the file's content.
    pub(super) fn digest(&self) -> Digest {
        self.digest
    }

    /// The file's name, for messages.
    pub(super) fn name(&self) -> &str {
        &self.name
    }
}

pub(super) fn parsed(bytes: &[u8]) -> Result<Vec<Polygon>, String> {
    // Some editors put a byte order mark before the text.
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let content: Content = serde_json::from_slice(text).map_err(|error| error.to_string())?;
    let polygons = match (content.points, content.polygons) {
        (Some(points), None) => vec![points],
        (None, Some(polygons)) if !polygons.is_empty() => polygons,
        (None, Some(_)) => return Err("\"polygons\" is empty".to_owned()),
        (Some(_), Some(_)) => return Err("\"points\" and \"polygons\": give only one".to_owned()),
        (None, None) => return Err("neither \"points\" nor \"polygons\" is given".to_owned()),
    };
    let count: usize = polygons.iter().map(Vec::len).sum();
    if count > MOST_POINTS {
        return Err(format!(
            "{count} points are more than the limit of {MOST_POINTS}"
        ));
    }
    if let Some([x, y]) = polygons.iter().flatten().find(|point| is_far(point)) {
        return Err(format!(
            "the point [{x:e}, {y:e}] is more than {FARTHEST} pixels away"
        ));
    }
    let polygon = |points: Vec<[f64; 2]>| points.into_iter().map(Point::from).collect();
    Ok(polygons.into_iter().map(polygon).collect())
}

fn is_far(point: &[f64; 2]) -> bool {
    point.iter().any(|coordinate| coordinate.abs() > FARTHEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_and_polygons_are_read() {
        let one = parsed(br#"{"points":[[0,1],[2.5,3],[4,-5e1]]}"#).unwrap();
        assert_eq!(
            one,
            [[(0.0, 1.0), (2.5, 3.0), (4.0, -50.0)]
                .map(Point::from)
                .to_vec()]
        );
        let two = parsed(br#"{"polygons":[[[0,1],[2,3],[4,5]],[[1,1]]]}"#).unwrap();
        assert_eq!((two.len(), two[1].len()), (2, 1));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let many = format!(r#"{{"points":[{}[0,0]]}}"#, "[1,1],".repeat(MOST_POINTS));
        let deep = "[".repeat(100_000);
        let bad: [(&str, &str); 9] = [
            ("", "EOF"),
            ("[1,2]", "line 1"),
            (r#"{"points":[[1]]}"#, "length"),
            (r#"{"points":[[1,1e999]]}"#, "out of range"),
            (r#"{"points":[[1,1e9]]}"#, "away"),
            (r#"{"polygons":[]}"#, "empty"),
            (r#"{"points":[],"polygons":[]}"#, "only one"),
            (&many, "limit"),
            (&deep, "line 1"),
        ];
        for (text, expected) in bad {
            let reason = parsed(text.as_bytes()).unwrap_err();
            assert!(reason.contains(expected), "{reason}");
        }
    }
}
