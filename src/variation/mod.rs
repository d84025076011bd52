//! New trees from old ones: exemplars, their outlines combined, their colours warped and mixed.
//!
//! After Argudo, Andújar & Chica, *Tree Variations* (2017); what we do otherwise is said where it
//! is done.
//!
//! Imports `base`, `raster`, `geometry`, `contour`, `segment`, `branches`.

mod cache;
mod cells;
mod choice;
mod compatibility;
mod distortion;
mod evolve;
mod exemplar;
mod fan;
mod finish;
mod followed;
mod forecast;
mod fronds;
mod gaps;
mod habit;
mod histogram;
mod hsl;
mod individual;
mod joint;
mod leaf_size;
mod library;
mod library_map;
mod limbs;
mod maker;
mod matched;
mod mean_value;
mod measures;
mod mix;
mod mixing_map;
mod names;
mod noise;
mod normalize;
mod palette;
mod repetition;
mod rim;
mod rounded;
mod sampling;
mod seams;
mod season;
mod spire;
mod stem;
mod sway;
mod synthesis;
mod tiers;
mod warp;
mod warp_image;
mod wood;

pub use choice::{ChoiceError, ChoiceSettings, Chosen, Coloring, Part, chosen, parts_near};
pub use compatibility::{CompatibilityGraph, Neighbour, are_of_a_kind};
pub use distortion::Distortion;
pub use evolve::{Aspect, Brood, Decided, Genome};
pub use exemplar::{Exemplar, ExemplarError, ExemplarSettings, Outlined, Shape};
pub use finish::{Finish, Reshaping, SeasonChoice, evergreen_by_name};
pub use forecast::{Forecast, Foreseen};
pub use fronds::has_fronds;
pub use habit::stands_straight;
pub use histogram::{Histogram, Transfer};
pub use hsl::{HslShift, hsl, rgb};
pub use individual::{IndividualSettings, make_individual, mirrored, reshape};
pub use library::{Entry, Library, LibraryError, LibraryPicture, Refused};
pub use library_map::library_places;
pub use maker::{Draft, Drafts, Tree, TreeMaker};
pub use matched::combined_outline;
pub use mean_value::{Cage, CageError, coordinates, mapped_exactly};
pub use mixing_map::MixingMap;
pub use names::named;
pub use normalize::{Normalized, Placement, normalized};
pub use palette::Palette;
pub use repetition::{Likeness, Look, MOST_COMPARED, Pair, Repetition};
pub use season::{Season, SeasonSettings, is_evergreen, named_evergreen, put_in_season};
pub use synthesis::{Layout, Leaves, Source, Variation, synthesized};
pub use warp::{Warp, WarpPrecision};
pub use warp_image::{inside_polygons, warped};
