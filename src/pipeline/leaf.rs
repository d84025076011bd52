//! What names of pictures tell of the leaves of a crown.

use crate::branches::leaf_name::LeafName;
use crate::variation::{has_fronds, named};

/// Words in names of pictures, and the leaves of such trees: of those that there are the likest. The first
/// that occurs counts. From where a whole crown is seen, combs of short needles look like lobed leaves:
/// conifers have tufts.
const LEAVES_BY_NAME: [(&str, LeafName); 28] = [
    ("broadleaf", LeafName::Ovate),
    ("pine", LeafName::Tuft),
    ("pinus", LeafName::Tuft),
    ("spruce", LeafName::Tuft),
    ("picea", LeafName::Tuft),
    ("fir", LeafName::Tuft),
    ("abies", LeafName::Tuft),
    ("larch", LeafName::Tuft),
    ("larix", LeafName::Tuft),
    ("cedar", LeafName::Tuft),
    ("conifer", LeafName::Tuft),
    ("cypress", LeafName::Tuft),
    ("juniper", LeafName::Tuft),
    ("thuja", LeafName::Tuft),
    ("yew", LeafName::Tuft),
    ("sequoia", LeafName::Tuft),
    ("metasequoia", LeafName::Tuft),
    ("redwood", LeafName::Tuft),
    ("hemlock", LeafName::Tuft),
    ("taxodium", LeafName::Tuft),
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
/// assert_eq!(leaf_of_picture("redwood_young_01.jpg"), Some(LeafName::Tuft));
/// assert_eq!(leaf_of_picture("IMG_1234.jpg"), None);
/// ```
pub fn leaf_of_picture(name: &str) -> Option<LeafName> {
    named(name, &LEAVES_BY_NAME).or_else(|| has_fronds(name).then_some(LeafName::Frond))
}
