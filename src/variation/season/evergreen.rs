//! Which trees keep their leaves: by name, else by how they look.

use super::leaves::Leaves;
use crate::base::{Cancel, Cancelled};
use crate::raster::{Mask, Rect, row_ends};
use crate::segment::Label;
use crate::variation::{Tree, named};

/// Words in names of pictures, and whether such trees are evergreen. The first that occurs counts;
/// deciduous conifers stand before conifers.
const WORDS: [(&str, bool); 31] = [
    ("larch", false),
    ("larix", false),
    ("taxodium", false),
    ("metasequoia", false),
    ("broadleaf", false),
    ("spruce", true),
    ("picea", true),
    ("fir", true),
    ("abies", true),
    ("pine", true),
    ("pinus", true),
    ("cedar", true),
    ("conifer", true),
    ("cypress", true),
    ("juniper", true),
    ("thuja", true),
    ("yew", true),
    ("sequoia", true),
    ("hemlock", true),
    ("palm", true),
    ("olive", true),
    ("eucalyptus", true),
    ("holly", true),
    ("evergreen", true),
    ("oak", false),
    ("birch", false),
    ("maple", false),
    ("linden", false),
    ("poplar", false),
    ("willow", false),
    ("beech", false),
];

/// What the name of a picture says of the tree in it.
///
/// ```
/// use boscage::variation::named_evergreen;
/// assert_eq!(named_evergreen("spruce_dense_01.png"), Some(true));
/// assert_eq!(named_evergreen("larch_autumn.png"), Some(false));
/// assert_eq!(named_evergreen("IMG_2031.png"), None);
/// ```
pub fn named_evergreen(name: &str) -> Option<bool> {
    named(name, &WORDS)
}

/// Whether the tree looks like a conifer: its crown tapers to a tip from a broad foot, and is green
/// and dark.
///
/// # Errors
/// [`Cancelled`].
pub fn is_evergreen(tree: &Tree, cancel: &Cancel) -> Result<bool, Cancelled> {
    let leaves = Leaves::of(tree, cancel)?;
    Ok(leaves.is_some_and(|leaves| looks_evergreen(tree, &leaves)))
}

/// The same of a tree whose leaves are known.
pub(super) fn looks_evergreen(tree: &Tree, leaves: &Leaves) -> bool {
    let crown = tree.labels.map(|label| *label == Label::Crown);
    let lights = leaves.light.pixels().iter().zip(crown.pixels());
    let (mut sum, mut count) = (0.0, 0.0f64);
    for (light, _) in lights.filter(|(_, crown)| **crown) {
        sum += f64::from(*light);
        count += 1.0;
    }
    let mean = sum / count.max(1.0);
    // Real spruces and firs have a mean light of 40 to 75 and a taper of 0.15 to 0.35; round crowns one of 0.4 and more.
    let tapers = taper(&crown, leaves.bounds) < 0.36;
    tapers && mean < 76.0 && leaves.are_green()
}

/// Mean width of the crown's upper quarter, as a share of its lower half's.
fn taper(crown: &Mask, bounds: Rect) -> f64 {
    let width = |from: f64, to: f64| {
        let row = |share: f64| bounds.y + (share * f64::from(bounds.height)) as u32;
        let rows = row(from)..row(to).max(row(from) + 1).min(bounds.y + bounds.height);
        let count = rows.len().max(1) as f64;
        let widths = rows.filter_map(|y| {
            let [first, last] = row_ends(crown.row(y), |&inside| inside)?;
            Some((last - first + 1) as f64)
        });
        widths.sum::<f64>() / count
    };
    width(0.0, 0.25) / width(0.5, 1.0).max(1.0)
}
