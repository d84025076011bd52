//! What names of pictures tell of the leaves of a crown.

use crate::branches::leaf_name::LeafName;
use crate::variation::{has_fronds, named};

/// Words in names of pictures, and the leaves of such trees: of those that there are the likest. The first
/// that occurs counts. From where a whole crown is seen, twigs of short needles look like lobed leaves:
/// conifers without tiers have tufts.
const LEAVES_BY_NAME: [(&str, LeafName); 28] = [
    ("broadleaf", LeafName::Ovate),
    ("pine", LeafName::Tuft),
    ("pinus", LeafName::Tuft),
    ("spruce", LeafName::Bough),
    ("picea", LeafName::Bough),
    ("fir", LeafName::Bough),
    ("abies", LeafName::Bough),
    ("larch", LeafName::Bough),
    ("larix", LeafName::Bough),
    ("cedar", LeafName::Bough),
    ("conifer", LeafName::Bough),
    ("cypress", LeafName::Tuft),
    ("juniper", LeafName::Tuft),
    ("thuja", LeafName::Tuft),
    ("yew", LeafName::Tuft),
    ("sequoia", LeafName::Bough),
    ("metasequoia", LeafName::Bough),
    ("redwood", LeafName::Bough),
    ("hemlock", LeafName::Bough),
    ("taxodium", LeafName::Bough),
    ("oak", LeafName::Lobed),
    ("quercus", LeafName::Lobed),
    ("maple", LeafName::Palmate),
    ("acer", LeafName::Palmate),
    ("willow", LeafName::Lance),
    ("salix", LeafName::Lance),
    ("linden", LeafName::Round),
    ("poplar", LeafName::Round),
];

/// The leaves of a tree whose picture has that file name, if it tells.
///
/// ```
/// use boscage::{branches::leaf_name::LeafName, pipeline::leaf_of_picture};
/// assert_eq!(leaf_of_picture("Quercus robur 3.jpg"), Some(LeafName::Lobed));
/// assert_eq!(leaf_of_picture("twin_palm_04.png"), Some(LeafName::Frond));
/// assert_eq!(leaf_of_picture("redwood_young_01.jpg"), Some(LeafName::Bough));
/// assert_eq!(leaf_of_picture("IMG_1234.jpg"), None);
/// ```
pub fn leaf_of_picture(name: &str) -> Option<LeafName> {
    named(name, &LEAVES_BY_NAME).or_else(|| has_fronds(name).then_some(LeafName::Frond))
}
