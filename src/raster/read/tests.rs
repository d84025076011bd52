use super::*;
use image::{DynamicImage, ImageBuffer, ImageFormat};
use proptest::prelude::*;
use std::io::Cursor;

const PIXELS: [[u8; 4]; 6] = [
    [255, 0, 0, 255],
    [0, 255, 0, 128],
    [0, 0, 255, 1],
    [10, 20, 30, 0],
    [200, 100, 50, 254],
    [0, 0, 0, 255],
];

const WITH_ALPHA: [(ImageFormat, &str); 5] = [
    (ImageFormat::Png, "tree.png"),
    (ImageFormat::WebP, "tree.webp"),
    (ImageFormat::Tga, "tree.TGA"),
    (ImageFormat::Tiff, "tree.tif"),
    (ImageFormat::Bmp, "tree.bmp"),
];

fn read(bytes: &[u8], name: &str) -> Result<Image<Straight>, ImageError> {
    read_image_from_memory(bytes, Path::new(name), ReadLimits::default())
}

fn refusal(bytes: &[u8], name: &str) -> Refusal {
    match read(bytes, name) {
        Err(ImageError::Refused { reason, .. }) => reason,
        other => panic!("{name}: {other:?}"),
    }
}

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn sample() -> DynamicImage {
    DynamicImage::ImageRgba8(ImageBuffer::from_vec(3, 2, PIXELS.as_flattened().to_vec()).unwrap())
}

fn as_png(image: impl Into<DynamicImage>) -> Vec<[u8; 4]> {
    let bytes = encoded(&image.into(), ImageFormat::Png);
    rgba(&read(&bytes, "a.png").unwrap())
}

fn rgba(image: &Image<Straight>) -> Vec<[u8; 4]> {
    image.pixels().iter().map(|pixel| pixel.0).collect()
}

/// A PNG of `width` × `height` pixels by its own account, with hardly any content.
fn hollow_png(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    // The two bytes that begin a zlib stream; the end chunk comes when the writer goes.
    writer.write_chunk(png::chunk::IDAT, &[0x78, 0x9c]).unwrap();
    drop(writer);
    bytes
}

#[test]
fn every_format_with_alpha_comes_back_as_it_was() {
    for (format, name) in WITH_ALPHA {
        let image = read(&encoded(&sample(), format), name).unwrap();
        assert_eq!((image.width(), image.height()), (3, 2), "{name}");
        assert_eq!(rgba(&image), PIXELS, "{name}");
    }
}

#[test]
fn a_jpeg_comes_back_nearly() {
    let flat = image::RgbImage::from_pixel(9, 5, image::Rgb([200, 120, 40]));
    let image = read(&encoded(&flat.into(), ImageFormat::Jpeg), "a.jpg").unwrap();
    assert_eq!((image.width(), image.height()), (9, 5));
    for [r, g, b, a] in rgba(&image) {
        assert!(r.abs_diff(200) < 4 && g.abs_diff(120) < 4 && b.abs_diff(40) < 4 && a == 255);
    }
}

#[test]
fn grey_and_deep_pixels_become_8_bit_rgba() {
    let grey = ImageBuffer::from_vec(2, 1, vec![0u8, 77]).unwrap();
    let expected = [[0, 0, 0, 255], [77, 77, 77, 255]];
    assert_eq!(as_png(DynamicImage::ImageLuma8(grey)), expected);
    let grey_alpha = ImageBuffer::from_vec(1, 1, vec![7u8, 8]).unwrap();
    assert_eq!(
        as_png(DynamicImage::ImageLumaA8(grey_alpha)),
        [[7, 7, 7, 8]]
    );
    // 128 is the last that rounds down to 0; 32768 lies nearest to 128 · 257.
    let deep = ImageBuffer::from_vec(1, 1, vec![128u16, 129, 32768, 65535]).unwrap();
    assert_eq!(as_png(DynamicImage::ImageRgba16(deep)), [[0, 1, 128, 255]]);
    let deep_grey = ImageBuffer::from_vec(1, 1, vec![257u16 * 9]).unwrap();
    assert_eq!(
        as_png(DynamicImage::ImageLuma16(deep_grey)),
        [[9, 9, 9, 255]]
    );
    let float = ImageBuffer::from_vec(1, 1, vec![-0.5f32, 0.5, 4.0]).unwrap();
    let bytes = encoded(&DynamicImage::ImageRgb32F(float), ImageFormat::Tiff);
    assert_eq!(rgba(&read(&bytes, "a.tif").unwrap()), [[0, 128, 255, 255]]);
}

#[test]
fn a_palette_keeps_its_transparency() {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 3, 1);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Two);
    encoder.set_palette(vec![1, 2, 3, 4, 5, 6, 7, 8, 9]);
    encoder.set_trns(vec![255, 40]);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&[0b00_01_10_00]).unwrap();
    drop(writer);
    let expected = [[1, 2, 3, 255], [4, 5, 6, 40], [7, 8, 9, 255]];
    assert_eq!(rgba(&read(&bytes, "a.png").unwrap()), expected);
}

#[test]
fn pictures_are_turned_upright() {
    // What a viewer shows of the stored rows "abc", "def", for orientation 1 to 8.
    let shown: [&[&str]; 8] = [
        &["abc", "def"],
        &["cba", "fed"],
        &["fed", "cba"],
        &["def", "abc"],
        &["ad", "be", "cf"],
        &["da", "eb", "fc"],
        &["fc", "eb", "da"],
        &["cf", "be", "ad"],
    ];
    for (orientation, rows) in (1u8..).zip(shown) {
        let mut info = png::Info::with_size(3, 2);
        info.color_type = png::ColorType::Grayscale;
        let mut exif = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\0\0\0\0\0\0\0\0".to_vec();
        exif[18] = orientation;
        info.exif_metadata = Some(exif.into());
        let mut bytes = Vec::new();
        let encoder = png::Encoder::with_info(&mut bytes, info).unwrap();
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(b"abcdef").unwrap();
        drop(writer);
        let image = read(&bytes, "a.png").unwrap();
        let expected: Vec<u8> = rows.iter().flat_map(|row| row.bytes()).collect();
        let red: Vec<u8> = rgba(&image).iter().map(|pixel| pixel[0]).collect();
        assert_eq!(red, expected, "orientation {orientation}");
        assert_eq!(image.height() as usize, rows.len());
    }
}

#[test]
fn the_content_decides_and_the_name_only_for_tga() {
    let png = encoded(&sample(), ImageFormat::Png);
    assert!(read(&png, "a.tga").is_ok());
    assert!(read(&png, "no name").is_ok());
    let tga = encoded(&sample(), ImageFormat::Tga);
    assert!(matches!(refusal(&tga, "a.png"), Refusal::Unknown { .. }));
    let signed = [&tga[..], &[0; 8], b"TRUEVISION-XFILE.\0"].concat();
    assert!(read(&signed, "a.png").is_ok());
    assert_eq!(refusal(b"", "a.png"), Refusal::Empty);
    let pointer = refusal(b"version https://git-lfs.github.com/spec/v1\n", "a.png");
    assert!(pointer.to_string().contains("git lfs pull"));
}

#[test]
fn huge_headers_are_refused_for_what_they_claim() {
    let refused = refusal(&hollow_png(65_535, 65_535), "a.png");
    assert!(
        matches!(refused, Refusal::TooManyPixels { .. }),
        "{refused}"
    );
    assert!(read(&hollow_png(0x7fff_ffff, 0x7fff_ffff), "a.png").is_err());
    let refused = refusal(&hollow_png(20_000, 20_000), "a.png");
    assert!(matches!(refused, Refusal::Bomb { .. }), "{refused}");
    let limits = ReadLimits {
        pixels: 5,
        ..ReadLimits::default()
    };
    let png = encoded(&sample(), ImageFormat::Png);
    let error = read_image_from_memory(&png, Path::new("a.png"), limits).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a.png: 3×2 pixels are more than the limit of 5 in all"
    );
}

#[test]
fn a_flat_mask_of_the_largest_size_is_no_bomb() {
    let largest = (20_000, 20_000);
    let judged = |channels, bytes| check_size(largest, channels, bytes, ReadLimits::default());
    assert_eq!(judged(1, 48_685), Ok(()), "one bit a pixel");
    assert!(matches!(judged(1, 40_000), Err(Refusal::Bomb { .. })));
    assert!(matches!(judged(4, 1_555_211), Err(Refusal::Bomb { .. })));
    assert_eq!(judged(3, 55_000_000), Ok(()));
}

#[test]
fn half_a_file_is_no_picture() {
    let noise = image::RgbImage::from_fn(40, 40, |x, y| {
        let value = (x * 7919 + y * 104_729) % 251;
        image::Rgb([value as u8, (value * 3) as u8, (x * y) as u8])
    });
    let noise = DynamicImage::ImageRgb8(noise);
    for (format, name) in [(ImageFormat::Jpeg, "a.jpg")].into_iter().chain(WITH_ALPHA) {
        let bytes = encoded(&noise, format);
        assert!(read(&bytes, name).is_ok(), "{name}");
        for percent in [1, 20, 50, 90] {
            let cut = &bytes[..bytes.len() * percent / 100];
            assert!(read(cut, name).is_err(), "{name} cut to {percent} %");
        }
    }
}

#[test]
fn an_error_is_one_visible_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a\u{202e}b\n\x1b[31m.png");
    let missing = read_image(&path, ReadLimits::default()).unwrap_err();
    std::fs::write(&path, b"\x89PNG\r\n\x1a\n").unwrap();
    let broken = read_image(&path, ReadLimits::default()).unwrap_err();
    for line in [missing.to_string(), broken.to_string()] {
        assert!(!line.contains(char::is_control), "{line:?}");
        assert!(!line.contains('\u{202e}'), "{line:?}");
    }
}

proptest! {
    #[test]
    fn no_bytes_panic(tail in proptest::collection::vec(any::<u8>(), 0..300), magic in 0usize..9) {
        let magics: [&[u8]; 9] = [
            b"", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"RIFF\0\0\0\0WEBPVP8 ", b"II*\0",
            b"MM\0*", b"BM", b"DDS |\0\0\0", b"\0\0\x02",
        ];
        let bytes = [magics[magic], &tail].concat();
        if let Err(error) = read(&bytes, "a.tga") {
            prop_assert!(!error.to_string().contains(char::is_control));
        }
    }

    #[test]
    fn no_damage_panics(
        format in 0usize..5,
        damage in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let (format, name) = WITH_ALPHA[format];
        let mut bytes = encoded(&sample(), format);
        for (at, value) in damage {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Err(error) = read(&bytes, name) {
            prop_assert!(!error.to_string().contains(char::is_control));
        }
    }
}
