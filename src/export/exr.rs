//! OpenEXR files of 32-bit floats: one part, scan lines, no compression.
//!
//! Source: *OpenEXR File Layout* (Academy Software Foundation). Of the format this is the part that
//! every reader takes; faces of cubemaps are small, and radii barely compress.

use crate::raster::{Image, Straight};
use crate::render::linear;

/// 32-bit floats.
const FLOAT: i32 = 2;

/// A picture of one channel, `Y`.
pub fn encode_exr_values(image: &Image<f32>) -> Vec<u8> {
    encoded(image, &["Y"], |&value| [value])
}

/// A picture's colours in linear light, channels `R`, `G`, `B`; its alpha is left out.
pub fn encode_exr_colors(image: &Image<Straight>) -> Vec<u8> {
    // Channels stand in the order of their names.
    encoded(image, &["B", "G", "R"], |&Straight([r, g, b, _])| {
        [b, g, r].map(linear)
    })
}

fn encoded<P: Copy, const N: usize>(
    image: &Image<P>,
    names: &[&str; N],
    values: impl Fn(&P) -> [f32; N],
) -> Vec<u8> {
    let mut file = header([image.width(), image.height()], names);
    let line_bytes = 8 + image.width() as usize * N * 4;
    let first = file.len() + 8 * image.height() as usize;
    for y in 0..image.height() as usize {
        file.extend(((first + y * line_bytes) as u64).to_le_bytes());
    }
    for y in 0..image.height() {
        file.extend(y.to_le_bytes());
        file.extend(((line_bytes - 8) as u32).to_le_bytes());
        let line: Vec<[f32; N]> = image.row(y).iter().map(&values).collect();
        for channel in 0..N {
            file.extend(line.iter().flat_map(|pixel| pixel[channel].to_le_bytes()));
        }
    }
    file
}

/// Magic number, version and the attributes that the format demands.
fn header([width, height]: [u32; 2], names: &[&str]) -> Vec<u8> {
    let mut file = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        for text in [name, kind] {
            file.extend(text.as_bytes());
            file.push(0);
        }
        file.extend((value.len() as u32).to_le_bytes());
        file.extend(value);
    };
    let integers = |values: &[i32]| -> Vec<u8> {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes());
        bytes.collect()
    };
    let mut channels = Vec::new();
    for name in names {
        channels.extend(name.as_bytes());
        channels.push(0);
        // Linear to the eye, reserved; every pixel has a sample.
        channels.extend(integers(&[FLOAT, 0, 1, 1]));
    }
    channels.push(0);
    let window = integers(&[0, 0, width as i32 - 1, height as i32 - 1]);
    attribute("channels", "chlist", &channels);
    attribute("compression", "compression", &[0]);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1.0f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1.0f32.to_le_bytes());
    file.push(0);
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_stand_where_the_table_says_channel_by_channel() {
        let pixels = vec![Straight([255, 0, 0, 255]), Straight([0, 255, 0, 255])];
        let file = encode_exr_colors(&Image::from_pixels(1, 2, pixels));
        let number = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
        let length = file.len();
        // Two lines of 8 + 12 bytes at the end, the table of two offsets before.
        let table = length - 2 * 20 - 16;
        assert_eq!(number(table) as usize, length - 40);
        assert_eq!(number(table + 8) as usize, length - 20);
        assert_eq!((number(length - 20), number(length - 16)), (1, 12));
        let last: Vec<f32> = (0..3)
            .map(|i| f32::from_bits(number(length - 12 + 4 * i)))
            .collect();
        assert_eq!(last, [0.0, 1.0, 0.0], "blue, green, red");
        let values = encode_exr_values(&Image::from_pixels(1, 1, vec![7.25]));
        assert_eq!(values[values.len() - 4..], 7.25f32.to_le_bytes());
    }
}
