//! The commands: everything in the studio that has a name.
//!
//! One table gives each its place in the menus, its label, its help and its key; menus, palette,
//! shortcut sheet and keyboard all read it. To add one: give it a variant, a row, and an arm in
//! [`super::act`].

use super::live::Drawn;
use super::mask_action::MaskCommand;
use super::studio::Workspace;
use super::tools::{Overlay, Tool};
use egui::{Key, KeyboardShortcut, Modifiers};

/// A menu of the menu bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Menu {
    /// Projects and files.
    File,
    /// History and labels.
    Edit,
    /// The painted mask.
    Mask,
    /// What the hand holds.
    Tools,
    /// Crowns and variations.
    Tree,
    /// How things are shown.
    View,
    /// Explanations.
    Help,
}

impl Menu {
    /// In the order of the bar.
    pub const ALL: [Self; 7] = [
        Self::File,
        Self::Edit,
        Self::Mask,
        Self::Tools,
        Self::Tree,
        Self::View,
        Self::Help,
    ];

    /// What stands in the bar.
    pub fn title(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Edit => "Edit",
            Self::Mask => "Mask",
            Self::Tools => "Tools",
            Self::Tree => "Tree",
            Self::View => "View",
            Self::Help => "Help",
        }
    }
}

/// Something with a name that the user can ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Command {
    /// An empty project.
    New,
    /// A project from a file.
    Open,
    /// The project that comes with the studio.
    OpenSample,
    /// Pictures into the project.
    AddPhotos,
    /// Writes the project.
    Save,
    /// Writes the project to another file.
    SaveAs,
    /// Ends the studio.
    Quit,
    /// Takes the last step back.
    Undo,
    /// Makes it again.
    Redo,
    /// Takes the shown photograph out of the project.
    RemovePhoto,
    /// Clears the labels.
    ClearMask,
    /// Crown becomes background and background crown.
    InvertMask,
    /// Changes labels, or brings them in and out.
    Mask(MaskCommand),
    /// Chooses what tools paint.
    Label(u8),
    /// Takes up a tool.
    Take(Tool),
    /// A larger brush.
    LargerBrush,
    /// A smaller brush.
    SmallerBrush,
    /// A brush larger by ten pixels.
    MuchLargerBrush,
    /// A brush smaller by ten pixels.
    MuchSmallerBrush,
    /// Turns erasing on and off.
    ToggleEraser,
    /// Paints crown or trunk.
    SwapLabel,
    /// Draws the gallery again.
    RollTrees,
    /// Writes many trees to a folder.
    MakeTrees,
    /// Writes trees for an engine.
    ExportTrees,
    /// Shows another workspace.
    Show(Workspace),
    /// Shows all of the picture.
    ZoomToFit,
    /// One pixel of the picture on one of the screen.
    ZoomToPixels,
    /// Comes nearer to the picture.
    ZoomIn,
    /// Goes away from the picture.
    ZoomOut,
    /// Shows something else over the photograph or hides it.
    Overlay(Overlay),
    /// Shows the labels over the photograph or hides them.
    ToggleMask,
    /// Shows the whole tree.
    FrameTree,
    /// Turns the tree round and round.
    Turntable,
    /// Makes the crown anew while the user paints, or leaves it as it is.
    ToggleLiveCrown,
    /// Draws the crown in this way.
    Draw(Drawn),
    /// Writes what the 3D view shows to a file.
    SavePicture,
    /// Dark or light.
    ToggleTheme,
    /// Puts all panels where they came from.
    RestoreLayout,
    /// All commands, by name.
    Palette,
    /// All keys.
    ShortcutSheet,
    /// The first steps.
    Tour,
    /// Names a library that runs networks faster.
    ChooseRuntime,
    /// Names a model that tells crown from trunk.
    ChooseModel,
    /// Goes back to the model that is built in.
    UseBuiltInModel,
    /// What the studio is.
    About,
}

/// A command's row.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// The command.
    pub command: Command,
    /// Where it stands.
    pub menu: Menu,
    /// Its name.
    pub label: &'static str,
    /// What it does, in a sentence.
    pub help: &'static str,
    /// Its key.
    pub shortcut: KeyboardShortcut,
}

const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const COMMAND: Modifiers = Modifiers::COMMAND;
const COMMAND_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

const fn row(
    command: Command,
    menu: Menu,
    label: &'static str,
    help: &'static str,
    modifiers: Modifiers,
    key: Key,
) -> Row {
    Row {
        command,
        menu,
        label,
        help,
        shortcut: KeyboardShortcut::new(modifiers, key),
    }
}

/// All commands, in the order of the menus.
#[rustfmt::skip]
pub const TABLE: &[Row] = &[
    row(Command::New, Menu::File, "New Project", "Starts an empty project.", COMMAND, Key::N),
    row(Command::Open, Menu::File, "Open…", "Opens a project, or adds pictures to this one.", COMMAND, Key::O),
    row(Command::OpenSample, Menu::File, "Open Sample Project", "Opens a project with trees that come with Boscage.", COMMAND_SHIFT, Key::O),
    row(Command::AddPhotos, Menu::File, "Add Pictures…", "Adds photographs and cut-out trees to the project.", COMMAND, Key::P),
    row(Command::Save, Menu::File, "Save", "Writes the project; the version before stays beside it.", COMMAND, Key::S),
    row(Command::SaveAs, Menu::File, "Save As…", "Writes the project to another file.", COMMAND_SHIFT, Key::S),
    row(Command::Quit, Menu::File, "Quit", "Ends Boscage.", COMMAND, Key::Q),
    row(Command::Undo, Menu::Edit, "Undo", "Takes the last step back.", COMMAND, Key::Z),
    row(Command::Redo, Menu::Edit, "Redo", "Makes the step again that was taken back.", COMMAND_SHIFT, Key::Z),
    row(Command::RemovePhoto, Menu::Edit, "Remove Picture", "Takes the shown picture out of the project, with its mask.", COMMAND, Key::Delete),
    row(Command::ClearMask, Menu::Mask, "Clear", "Makes everything background.", COMMAND_SHIFT, Key::A),
    row(Command::InvertMask, Menu::Mask, "Invert", "What has the chosen label becomes background, and the other way round.", COMMAND, Key::I),
    row(Command::Mask(MaskCommand::Propose), Menu::Mask, "Propose Mask", "Labels crown and trunk, of photographs too; correct them by hand. Where no tree is found it takes up Smart Select.", SHIFT, Key::P),
    row(Command::Mask(MaskCommand::Grow), Menu::Mask, "Grow", "Widens the chosen label over background, by the amount in the canvas's options.", SHIFT, Key::G),
    row(Command::Mask(MaskCommand::Shrink), Menu::Mask, "Shrink", "Narrows the chosen label, by the amount in the canvas's options.", SHIFT, Key::K),
    row(Command::Mask(MaskCommand::Smooth), Menu::Mask, "Smooth", "Rounds the outline of the chosen label: details smaller than the amount go.", SHIFT, Key::S),
    row(Command::Mask(MaskCommand::FillHoles), Menu::Mask, "Fill Holes", "Gives the chosen label to background that labels enclose, up to the size in the options.", SHIFT, Key::H),
    row(Command::Mask(MaskCommand::RemoveSpecks), Menu::Mask, "Remove Specks", "Clears pieces of the chosen label up to the size in the options.", SHIFT, Key::D),
    row(Command::Mask(MaskCommand::Flip), Menu::Mask, "Flip", "Left and right change places.", SHIFT, Key::F),
    row(Command::Mask(MaskCommand::MirrorLeft), Menu::Mask, "Mirror Left Half", "The right half becomes the mirror image of the left.", SHIFT, Key::M),
    row(Command::Mask(MaskCommand::MirrorRight), Menu::Mask, "Mirror Right Half", "The left half becomes the mirror image of the right.", SHIFT, Key::N),
    row(Command::Mask(MaskCommand::Import), Menu::Mask, "Import Mask…", "Reads labels from a picture file: white is crown, mid grey trunk, black background.", SHIFT, Key::I),
    row(Command::Mask(MaskCommand::Export), Menu::Mask, "Export Mask…", "Writes the labels to a grey PNG file.", SHIFT, Key::E),
    row(Command::Take(Tool::Brush), Menu::Tools, "Brush", "Paints the label. Ctrl erases; [ and ] change the size.", NONE, Key::B),
    row(Command::Take(Tool::Hand), Menu::Tools, "Hand", "Moves the picture. With any tool: Space and drag, or the middle button.", NONE, Key::H),
    row(Command::Take(Tool::Lasso), Menu::Tools, "Lasso", "Labels what a line drawn by hand goes round. Ctrl erases.", NONE, Key::L),
    row(Command::Take(Tool::Polygon), Menu::Tools, "Polygon", "Labels what a line from click to click goes round. Enter or a double click closes it, Backspace takes a click back.", SHIFT, Key::L),
    row(Command::Take(Tool::Livewire), Menu::Tools, "Livewire", "A line that clings to edges from click to click. Enter closes it.", NONE, Key::I),
    row(Command::Take(Tool::Flood), Menu::Tools, "Flood", "Labels what has the colour of the place that is clicked.", NONE, Key::G),
    row(Command::Take(Tool::Smart), Menu::Tools, "Smart Select", "Draw strokes inside, and with Ctrl or the right button outside; the outline between them is found. Enter takes it.", NONE, Key::S),
    row(Command::Take(Tool::Depth), Menu::Tools, "Depth Handles", "Drag the outline of the crown: outwards makes it deeper there, inwards flatter. With Shift handles slide along it; a double click adds one or takes one away.", NONE, Key::K),
    row(Command::ToggleEraser, Menu::Tools, "Eraser", "Turns erasing on and off, whatever the tool.", NONE, Key::E),
    row(Command::LargerBrush, Menu::Tools, "Larger Brush", "Makes the brush larger by an eighth.", NONE, Key::CloseBracket),
    row(Command::SmallerBrush, Menu::Tools, "Smaller Brush", "Makes the brush smaller by an eighth.", NONE, Key::OpenBracket),
    row(Command::MuchLargerBrush, Menu::Tools, "Larger Brush by 10", "Makes the brush's radius ten pixels larger.", SHIFT, Key::CloseCurlyBracket),
    row(Command::MuchSmallerBrush, Menu::Tools, "Smaller Brush by 10", "Makes the brush's radius ten pixels smaller.", SHIFT, Key::OpenCurlyBracket),
    row(Command::Label(1), Menu::Tools, "Paint Crown", "Tools paint foliage.", NONE, Key::Num1),
    row(Command::Label(2), Menu::Tools, "Paint Trunk", "Tools paint the stem and main limbs below the foliage.", NONE, Key::Num2),
    row(Command::Label(3), Menu::Tools, "Paint Sub-crown 1", "Tools paint the first part of the crown that is a crown of its own.", NONE, Key::Num3),
    row(Command::Label(4), Menu::Tools, "Paint Sub-crown 2", "Tools paint the second sub-crown.", NONE, Key::Num4),
    row(Command::Label(5), Menu::Tools, "Paint Sub-crown 3", "Tools paint the third sub-crown.", NONE, Key::Num5),
    row(Command::Label(6), Menu::Tools, "Paint Sub-crown 4", "Tools paint the fourth sub-crown.", NONE, Key::Num6),
    row(Command::Label(7), Menu::Tools, "Paint Sub-crown 5", "Tools paint the fifth sub-crown.", NONE, Key::Num7),
    row(Command::Label(8), Menu::Tools, "Paint Sub-crown 6", "Tools paint the sixth sub-crown.", NONE, Key::Num8),
    row(Command::Label(9), Menu::Tools, "Paint Sub-crown 7", "Tools paint the seventh sub-crown.", NONE, Key::Num9),
    row(Command::SwapLabel, Menu::Tools, "Swap Crown and Trunk", "Paints trunk instead of crown, or crown again.", NONE, Key::X),
    row(Command::ExportTrees, Menu::File, "Export…", "Writes trees as models and textures that an engine takes as they are.", COMMAND, Key::E),
    row(Command::MakeTrees, Menu::Tree, "Make Trees…", "Writes many trees of these settings to a folder, as boscage vary does.", COMMAND, Key::M),
    row(Command::RollTrees, Menu::Tree, "Roll Again", "Draws all trees of the gallery again but those that are locked.", COMMAND, Key::R),
    row(Command::Show(Workspace::Crown), Menu::View, "Crown Workspace", "Paint a mask on a photograph and see its crown.", COMMAND, Key::Num1),
    row(Command::Show(Workspace::Variations), Menu::View, "Variations Workspace", "Make new trees from several.", COMMAND, Key::Num2),
    row(Command::Show(Workspace::Library), Menu::View, "Library Workspace", "All pictures of the project.", COMMAND, Key::Num3),
    row(Command::ZoomToFit, Menu::View, "Zoom to Fit", "Shows all of the picture.", NONE, Key::Num0),
    row(Command::ZoomToPixels, Menu::View, "Zoom to Pixels", "Shows each pixel of the picture on one of the screen.", COMMAND, Key::Num0),
    row(Command::ZoomIn, Menu::View, "Zoom In", "Comes nearer to the picture. The wheel does so at the pointer.", NONE, Key::Plus),
    row(Command::ZoomOut, Menu::View, "Zoom Out", "Shows more of the picture. The wheel does so at the pointer.", NONE, Key::Minus),
    row(Command::Overlay(Overlay::Silhouette), Menu::View, "Silhouette Line", "Shows the line around what is labelled, pixel by pixel.", SHIFT, Key::Q),
    row(Command::Overlay(Overlay::Contour), Menu::View, "Contour", "Shows the outline that new trees are made from.", SHIFT, Key::C),
    row(Command::Overlay(Overlay::Pins), Menu::View, "Pins", "Shows the foot of the tree and the shoulders of its trunk: the places that match on all trees.", SHIFT, Key::T),
    row(Command::Overlay(Overlay::Baseline), Menu::View, "Baseline", "Shows where the crown begins above the trunk.", SHIFT, Key::B),
    row(Command::Overlay(Overlay::Heat), Menu::View, "Heat Map of k", "Shows how steep the crown is all over it: dark blue is flat, yellow steep.", SHIFT, Key::W),
    row(Command::ToggleMask, Menu::View, "Mask Tint", "Shows the labels over the photograph, or hides them.", NONE, Key::Q),
    row(Command::FrameTree, Menu::Tree, "Frame Tree", "Moves the camera so that the whole tree is seen.", NONE, Key::F),
    row(Command::Turntable, Menu::Tree, "Turntable", "Turns the tree round and round, or stops it.", NONE, Key::T),
    row(Command::Draw(Drawn::Relief), Menu::Tree, "Draw Relief", "Draws the surface of the crown with its relief.", NONE, Key::F5),
    row(Command::Draw(Drawn::Leaves), Menu::Tree, "Draw Leaves", "Draws the crown with twigs and leaves.", NONE, Key::F6),
    row(Command::Draw(Drawn::Mesh), Menu::Tree, "Draw Mesh", "Draws the triangles of the crown's surface.", NONE, Key::F7),
    row(Command::Draw(Drawn::Wireframe), Menu::Tree, "Draw Wireframe", "Draws the triangles with their edges.", NONE, Key::F8),
    row(Command::ToggleLiveCrown, Menu::Tree, "Live Crown", "Makes the crown anew with every stroke, or leaves it as it is while you paint.", NONE, Key::F9),
    row(Command::SavePicture, Menu::Tree, "Save Picture…", "Writes what the 3D view shows to a PNG file.", NONE, Key::F12),
    row(Command::ToggleTheme, Menu::View, "Dark or Light", "Changes between the dark and the light theme.", COMMAND_SHIFT, Key::L),
    row(Command::RestoreLayout, Menu::View, "Restore Default Layout", "Puts all panels back where they came from.", COMMAND_SHIFT, Key::R),
    row(Command::Palette, Menu::Help, "Command Palette…", "Finds any command by its name.", COMMAND_SHIFT, Key::P),
    row(Command::ShortcutSheet, Menu::Help, "Keyboard Shortcuts", "Shows all keys.", SHIFT, Key::Questionmark),
    row(Command::Tour, Menu::Help, "Tour", "Shows the way from a picture to a tree in six steps.", NONE, Key::F1),
    row(Command::ChooseRuntime, Menu::Help, "Use ONNX Runtime…", "Names the library that finds crown and trunk several times faster; from the next start on.", COMMAND_SHIFT, Key::F2),
    row(Command::ChooseModel, Menu::Help, "Use Segmentation Model…", "Names a model of your own (ONNX) that finds crown and trunk; it is tried out first.", COMMAND_SHIFT, Key::F3),
    row(Command::UseBuiltInModel, Menu::Help, "Use Built-in Model", "Finds crown and trunk with the model that comes with Boscage again.", COMMAND_SHIFT, Key::F4),
    row(Command::About, Menu::Help, "About Boscage", "Version, graphics card, licences.", COMMAND_SHIFT, Key::F1),
];

impl Command {
    /// Its row in the table.
    pub fn row(self) -> &'static Row {
        let row = TABLE.iter().find(|row| row.command == self);
        row.expect("every command has a row")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn names_and_keys_are_unique() {
        let labels: BTreeSet<_> = TABLE.iter().map(|row| row.label).collect();
        assert_eq!(labels.len(), TABLE.len());
        for (index, row) in TABLE.iter().enumerate() {
            let same = TABLE[..index]
                .iter()
                .find(|other| other.shortcut == row.shortcut);
            assert!(same.is_none(), "{} and {}", row.label, same.unwrap().label);
        }
    }
}
