//! The choice of a crown's leaves.

use super::super::action::Gesture;
use super::crown::Change;
use crate::branches::leaf_name::LeafName;
use crate::document::CrownSettings;
use crate::pipeline::leaf_of_picture;
use egui::{ComboBox, Ui};

/// What leaves are called.
pub(in super::super) fn leaf_title(leaf: LeafName) -> &'static str {
    match leaf {
        LeafName::Ovate => "Egg-shaped: birch, apple",
        LeafName::Round => "Round: aspen, lime",
        LeafName::Lobed => "Lobed: oak",
        LeafName::Palmate => "Palmate: maple",
        LeafName::Lance => "Narrow: willow",
        LeafName::Brush => "Short needles: yew, juniper",
        LeafName::Tuft => "Long needles: pine",
        LeafName::Frond => "Fronds: palm",
        LeafName::Bough => "Boughs: spruce, fir",
    }
}

/// The leaves of the crown of the photograph `photo`.
pub(super) fn leaf_row(
    ui: &mut Ui,
    photo: &str,
    settings: &mut CrownSettings,
    change: &mut Option<Change>,
) {
    let own = leaf_title(leaf_of_picture(photo).unwrap_or_default());
    let by_name = format!("Automatic ({own})");
    ui.horizontal(|ui| {
        let label = ui.label("Leaves");
        let title = match settings.leaf {
            Some(leaf) => leaf_title(leaf),
            None => by_name.as_str(),
        };
        let combo = ComboBox::from_id_salt("leaf").selected_text(title);
        // Names may be longer than the panel is wide.
        let combo = combo.width(ui.available_width().min(190.0)).truncate();
        let response = combo.height(320.0).show_ui(ui, |ui| {
            let leaf = &mut settings.leaf;
            let mut is_changed = ui.selectable_value(leaf, None, by_name.as_str()).changed();
            for other in LeafName::ALL {
                let title = leaf_title(other);
                is_changed |= ui.selectable_value(leaf, Some(other), title).changed();
            }
            if is_changed {
                *change = Some(Change {
                    label: "Leaves",
                    gesture: Gesture::Whole,
                });
            }
        });
        response.response.labelled_by(label.id).on_hover_text(
            "What the crown is drawn and exported with. Automatic goes by the photograph's name.",
        );
    });
}
