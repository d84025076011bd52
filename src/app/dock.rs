//! The panels of the window and where they stand.
//!
//! Each workspace has an arrangement of its own, which the user can change by dragging tabs and edges
//! and which is kept between sessions. One that no longer fits this version is forgotten.

use super::studio::Workspace;
use egui_tiles::{Container, Linear, LinearDir, Tile, TileId, Tiles, Tree};
use serde::{Deserialize, Serialize};

/// A panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Pane {
    /// All pictures as a strip.
    Pictures,
    /// The photograph and its mask.
    Canvas,
    /// The crown in three dimensions.
    View,
    /// How the crown is made.
    Crown,
    /// The pictures that new trees are mixed of.
    Exemplars,
    /// A mix by hand.
    Mix,
    /// Which exemplars go together.
    Map,
    /// New trees.
    Gallery,
    /// How new trees are made.
    Variation,
    /// What is being worked on.
    Jobs,
}

impl Pane {
    /// What stands on its tab.
    pub(super) fn title(self) -> &'static str {
        match self {
            Self::Pictures => "Pictures",
            Self::Canvas => "Canvas",
            Self::View => "3D View",
            Self::Crown => "Crown",
            Self::Exemplars => "Exemplars",
            Self::Mix => "Mix",
            Self::Map => "Map",
            Self::Gallery => "Gallery",
            Self::Variation => "Variation",
            Self::Jobs => "Jobs",
        }
    }
}

/// The arrangements of all workspaces.
#[derive(Serialize, Deserialize)]
pub(super) struct Layouts {
    crown: Tree<Pane>,
    variations: Tree<Pane>,
    library: Tree<Pane>,
}

impl Default for Layouts {
    fn default() -> Self {
        use Pane::{Canvas, Crown, Exemplars, Gallery, Jobs, Map, Mix, Pictures, Variation, View};
        Self {
            crown: arranged(
                "crown",
                &[
                    (&[Pictures], 0.13),
                    (&[Canvas], 0.38),
                    (&[View], 0.31),
                    (&[Crown, Jobs], 0.18),
                ],
            ),
            variations: arranged_in(
                "variations",
                &[
                    (&[&[Exemplars, Pictures]], 0.17),
                    (&[&[Gallery]], 0.53),
                    (&[&[Mix, Map], &[Variation, Jobs]], 0.30),
                ],
            ),
            library: arranged("library", &[(&[Pictures], 0.72), (&[Jobs], 0.28)]),
        }
    }
}

impl Layouts {
    pub(super) fn of(&mut self, workspace: Workspace) -> &mut Tree<Pane> {
        match workspace {
            Workspace::Crown => &mut self.crown,
            Workspace::Variations => &mut self.variations,
            Workspace::Library => &mut self.library,
        }
    }

    /// Whether every panel that a workspace needs is somewhere: an old file may lack one.
    pub(super) fn is_complete(&self) -> bool {
        let default = Self::default();
        let all = [
            (&self.crown, &default.crown),
            (&self.variations, &default.variations),
            (&self.library, &default.library),
        ];
        all.iter()
            .all(|(kept, wanted)| panes(wanted).all(|pane| kept.tiles.find_pane(&pane).is_some()))
    }
}

fn panes(tree: &Tree<Pane>) -> impl Iterator<Item = Pane> + '_ {
    tree.tiles.tiles().filter_map(|tile| match tile {
        Tile::Pane(pane) => Some(*pane),
        Tile::Container(_) => None,
    })
}

/// Columns from left to right, each the panels that share it as tabs, and its share of the width.
fn arranged(name: &str, columns: &[(&[Pane], f32)]) -> Tree<Pane> {
    let stacks: Vec<[&[Pane]; 1]> = columns.iter().map(|(panes, _)| [*panes]).collect();
    let shares = columns.iter().map(|(_, share)| *share);
    let columns: Vec<(&[&[Pane]], f32)> =
        stacks.iter().map(<[_; 1]>::as_slice).zip(shares).collect();
    arranged_in(name, &columns)
}

/// Columns from left to right, each a stack from top to bottom of panels that share a place as tabs,
/// and its share of the width.
fn arranged_in(name: &str, columns: &[(&[&[Pane]], f32)]) -> Tree<Pane> {
    let mut tiles = Tiles::default();
    let mut column = |stack: &[&[Pane]]| -> TileId {
        let mut places = Vec::new();
        for panes in stack {
            let ids: Vec<TileId> = panes.iter().map(|pane| tiles.insert_pane(*pane)).collect();
            places.push(tiles.insert_tab_tile(ids));
        }
        match places.as_slice() {
            [only] => *only,
            _ => tiles.insert_vertical_tile(places),
        }
    };
    let ids: Vec<TileId> = columns.iter().map(|(stack, _)| column(stack)).collect();
    let mut row = Linear::new(LinearDir::Horizontal, ids.clone());
    for (id, (_, share)) in ids.into_iter().zip(columns) {
        row.shares.set_share(id, *share);
    }
    let root = tiles.insert_container(Container::Linear(row));
    Tree::new(egui::Id::unique(("dock", name)), root, tiles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_arrangement_is_complete() {
        assert!(Layouts::default().is_complete());
    }
}
