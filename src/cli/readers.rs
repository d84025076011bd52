//! The readers of files that only commands know, as functions of bytes: for fuzz targets, which stand
//! outside this package. Each gives what was wrong with the bytes, in one line.

use super::{polygons, records::LibraryRecord, regions};

/// `POLY.json` of `boscage warp`.
///
/// # Errors
/// What is wrong.
pub fn polygon_file(bytes: &[u8]) -> Result<(), String> {
    polygons::parsed(bytes).map(drop)
}

/// The regions of `boscage inflate` and `boscage crown`.
///
/// # Errors
/// What is wrong.
pub fn region_file(bytes: &[u8]) -> Result<(), String> {
    regions::regions_in(bytes).map(drop)
}

/// `library.json` of `boscage vary` and `boscage export`.
///
/// # Errors
/// What is wrong.
pub fn library_record(bytes: &[u8]) -> Result<(), String> {
    LibraryRecord::of_bytes(bytes).map(drop)
}
