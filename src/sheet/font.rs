//! Small captions: a font of single strokes, drawn for this project.
//!
//! A glyph is a few strokes on a grid 4 wide: y = 0 is the height of capitals, 6 the baseline,
//! 2 the height of small letters, 8 the depth of descenders. A stroke is a run of points, two
//! digits each; one that begins with `~` is smooth (a quadratic B-spline with its points as
//! control points, closed when it ends where it began), all others are straight. Letters without
//! a glyph show as a small box.

use super::paint::{Canvas, Rgba};
use crate::geometry::Point;
use tiny_skia::{Path, PathBuilder};

/// Grid units from one baseline to the next.
const LINE_UNITS: f64 = 11.0;

/// Grid units between two glyphs.
const GAP_UNITS: f64 = 1.5;

/// Height of a line of text whose capitals are `cap_px` high.
pub(super) fn line_height(cap_px: f64) -> f64 {
    cap_px * LINE_UNITS / 6.0
}

/// Width of `text` with capitals of `cap_px`.
pub(super) fn text_width(text: &str, cap_px: f64) -> f64 {
    let units: f64 = text.chars().map(|c| advance(c) + GAP_UNITS).sum();
    (units - GAP_UNITS).max(0.0) * cap_px / 6.0
}

/// As much of `text` as fits into `width` pixels, with two dots where it was cut.
pub(super) fn fitted(text: &str, cap_px: f64, width: f64) -> String {
    if text_width(text, cap_px) <= width {
        return text.to_owned();
    }
    let mut kept: Vec<char> = text.chars().collect();
    loop {
        let cut: String = kept.iter().chain(['.', '.'].iter()).collect();
        if kept.pop().is_none() || text_width(&cut, cap_px) <= width {
            return cut;
        }
    }
}

/// Writes `text` centred on x = `middle` with its baseline at y = `baseline`.
pub(super) fn write_centred(
    canvas: &mut Canvas,
    text: &str,
    middle: f64,
    baseline: f64,
    cap_px: f64,
    color: Rgba,
) {
    let unit = cap_px / 6.0;
    let width = (0.72 * unit).max(1.0);
    let mut left = middle - text_width(text, cap_px) / 2.0;
    for character in text.chars() {
        let origin = Point::new(left, baseline - cap_px);
        for stroke in glyph(character).split_whitespace() {
            let path = stroke_path(stroke, unit, origin);
            canvas.stroke(path.as_ref(), width, color);
        }
        left += (advance(character) + GAP_UNITS) * unit;
    }
}

/// Width of a glyph in grid units.
fn advance(character: char) -> f64 {
    let columns = glyph(character).split_whitespace().flat_map(|stroke| {
        let digits = stroke.trim_start_matches('~').as_bytes();
        digits.chunks(2).map(|pair| f64::from(pair[0] - b'0'))
    });
    columns
        .fold(None, |most: Option<f64>, x| {
            Some(most.map_or(x, |most| most.max(x)))
        })
        .unwrap_or(2.0)
}

fn stroke_path(stroke: &str, unit: f64, origin: Point) -> Option<Path> {
    let digits = stroke.trim_start_matches('~').as_bytes();
    let points: Vec<Point> = digits
        .chunks_exact(2)
        .map(|pair| Point::new(f64::from(pair[0] - b'0'), f64::from(pair[1] - b'0')))
        .map(|point| origin + point * unit)
        .collect();
    if !stroke.starts_with('~') {
        return super::paint::open(&points);
    }
    let (first, last) = (*points.first()?, *points.last()?);
    let is_ring = first == last;
    let start = if is_ring {
        first.midpoint(points[1])
    } else {
        first
    };
    let mut builder = PathBuilder::new();
    builder.move_to(start.x as f32, start.y as f32);
    let controls = &points[1..points.len() - usize::from(!is_ring)];
    for (index, control) in controls.iter().enumerate() {
        let end = match controls.get(index + 1) {
            Some(next) => control.midpoint(*next),
            None if is_ring => start,
            None => last,
        };
        let (control, end) = (control.as_vec2(), end.as_vec2());
        builder.quad_to(control.x, control.y, end.x, end.y);
    }
    builder.finish()
}

/// The strokes of a character.
fn glyph(character: char) -> &'static str {
    match character {
        'A'..='Z' | 'a'..='z' => letter(character),
        '0'..='9' => digit(character),
        ' ' => "",
        '.' => "0606",
        ',' => "0607",
        ':' => "0303 0606",
        '-' => "0424",
        '_' => "0636",
        '+' => "0444 2226",
        '=' => "0333 0535",
        '/' => "0730",
        '%' => "0640 ~000222200000 ~244446264424",
        '(' => "~200326",
        ')' => "~002306",
        '#' => "1006 3026 0242 0444",
        '×' => "0236 0632",
        '\'' => "0002",
        _ => "0131350501",
    }
}

fn digit(character: char) -> &'static str {
    match character {
        '0' => "~0040460600",
        '1' => "012026",
        '2' => "~0100404306 0646",
        '3' => "~0100404313 ~1343460605",
        '4' => "36300444",
        '5' => "400003 ~03424606",
        '6' => "~300004 ~0343460603",
        '7' => "004016",
        '8' => "~0040430300 ~0343460603",
        _ => "~0040430300 ~164642",
    }
}

fn letter(character: char) -> &'static str {
    match character {
        'A' => "062046 1535",
        'B' => "0006 00203020 ~00404303 ~03434606",
        'C' => "~414000064645",
        'D' => "0006 ~00404606",
        'E' => "40000646 0333",
        'F' => "400006 0333",
        'G' => "~414000064643 4323",
        'H' => "0006 4046 0343",
        'I' => "0006",
        'J' => "3034 ~34360605",
        'K' => "0006 400346",
        'L' => "000646",
        'M' => "0600244046",
        'N' => "06004640",
        'O' => "~0040460600",
        'P' => "0006 ~00404303",
        'Q' => "~0040460600 2446",
        'R' => "0006 ~00404303 2346",
        'S' => "~4140000343460605",
        'T' => "0040 2026",
        'U' => "0003 ~03064643 4340",
        'V' => "002640",
        'W' => "0016203640",
        'X' => "0046 4006",
        'Y' => "002340 2326",
        'Z' => "00400646",
        'a' => "~0232360602 3236",
        'b' => "~0232360602 0006",
        'c' => "~333202063635",
        'd' => "~0232360602 3036",
        'e' => "0434 ~343202063635",
        'f' => "~201012 1216 0222",
        'g' => "~0232360602 3236 ~36380807",
        'h' => "0006 ~04023234 3436",
        'i' => "0206 0000",
        'j' => "1216 ~161808 1010",
        'k' => "0006 320436",
        'l' => "0006",
        'm' => "0206 ~04022224 2426 ~24224244 4446",
        'n' => "0206 ~04023234 3436",
        'o' => "~0232360602",
        'p' => "~0232360602 0208",
        'q' => "~0232360602 3238",
        'r' => "0206 ~04022222",
        's' => "~3332020434360605",
        't' => "1014 ~141626 0222",
        'u' => "0204 ~04063634 3236",
        'v' => "022642",
        'w' => "0216233642",
        'x' => "0236 0632",
        'y' => "0226 4218",
        _ => "02320636",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stroke_is_made_of_points_on_the_grid() {
        for character in (' '..='~').chain(['×', '木']) {
            for stroke in glyph(character).split_whitespace() {
                let digits = stroke.trim_start_matches('~');
                assert_eq!(digits.len() % 2, 0, "{character}: {stroke}");
                assert!(
                    digits.bytes().all(|b| (b'0'..=b'8').contains(&b)),
                    "{character}"
                );
            }
        }
    }

    #[test]
    fn long_captions_are_cut() {
        let cut = fitted("a_rather_long_name_of_a_file", 10.0, 80.0);
        assert!(
            cut.ends_with("..") && text_width(&cut, 10.0) <= 80.0,
            "{cut}"
        );
        assert_eq!(fitted("oak", 10.0, 80.0), "oak");
    }
}
