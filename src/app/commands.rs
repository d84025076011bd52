//! The commands: everything in the studio that has a name.
//!
//! One table gives each its place in the menus, its label, its help and its key; menus, palette,
//! shortcut sheet and keyboard all read it. To add one: give it a variant, a row, and an arm in
//! [`super::act`].

use super::live::Drawn;
use super::studio::{Tool, Workspace};
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
    /// Takes up a tool.
    Take(Tool),
    /// A larger brush.
    LargerBrush,
    /// A smaller brush.
    SmallerBrush,
    /// Turns erasing on and off.
    ToggleEraser,
    /// Paints crown or trunk.
    SwapLabel,
    /// Shows another workspace.
    Show(Workspace),
    /// Shows all of the picture.
    ZoomToFit,
    /// One pixel of the picture on one of the screen.
    ZoomToPixels,
    /// Shows the labels over the photograph or hides them.
    ToggleMask,
    /// Shows the whole tree.
    FrameTree,
    /// Turns the tree round and round.
    Turntable,
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
pub(super) const TABLE: &[Row] = &[
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
    row(Command::InvertMask, Menu::Mask, "Invert", "What was crown becomes background, and the other way round.", COMMAND, Key::I),
    row(Command::Take(Tool::Brush), Menu::Tools, "Brush", "Paints the label. Ctrl erases; [ and ] change the size.", NONE, Key::B),
    row(Command::Take(Tool::Hand), Menu::Tools, "Hand", "Moves the picture. With any tool: Space and drag, or the middle button.", NONE, Key::H),
    row(Command::ToggleEraser, Menu::Tools, "Eraser", "Turns erasing on and off, whatever the tool.", NONE, Key::E),
    row(Command::LargerBrush, Menu::Tools, "Larger Brush", "Makes the brush larger by an eighth.", NONE, Key::CloseBracket),
    row(Command::SmallerBrush, Menu::Tools, "Smaller Brush", "Makes the brush smaller by an eighth.", NONE, Key::OpenBracket),
    row(Command::SwapLabel, Menu::Tools, "Swap Crown and Trunk", "Paints trunk instead of crown, or crown again.", NONE, Key::X),
    row(Command::Show(Workspace::Crown), Menu::View, "Crown Workspace", "Paint a mask on a photograph and see its crown.", COMMAND, Key::Num1),
    row(Command::Show(Workspace::Variations), Menu::View, "Variations Workspace", "Make new trees from several.", COMMAND, Key::Num2),
    row(Command::Show(Workspace::Library), Menu::View, "Library Workspace", "All pictures of the project.", COMMAND, Key::Num3),
    row(Command::ZoomToFit, Menu::View, "Zoom to Fit", "Shows all of the picture.", NONE, Key::Num0),
    row(Command::ZoomToPixels, Menu::View, "Zoom to Pixels", "Shows each pixel of the picture on one of the screen.", COMMAND, Key::Num0),
    row(Command::ToggleMask, Menu::View, "Mask Tint", "Shows the labels over the photograph, or hides them.", NONE, Key::Q),
    row(Command::FrameTree, Menu::Tree, "Frame Tree", "Moves the camera so that the whole tree is seen.", NONE, Key::F),
    row(Command::Turntable, Menu::Tree, "Turntable", "Turns the tree round and round, or stops it.", NONE, Key::T),
    row(Command::Draw(Drawn::Relief), Menu::Tree, "Draw Relief", "Draws the surface of the crown with its relief.", NONE, Key::F5),
    row(Command::Draw(Drawn::Leaves), Menu::Tree, "Draw Leaves", "Draws the crown with twigs and leaves.", NONE, Key::F6),
    row(Command::Draw(Drawn::Mesh), Menu::Tree, "Draw Mesh", "Draws the triangles of the crown's surface.", NONE, Key::F7),
    row(Command::Draw(Drawn::Wireframe), Menu::Tree, "Draw Wireframe", "Draws the triangles with their edges.", NONE, Key::F8),
    row(Command::SavePicture, Menu::Tree, "Save Picture…", "Writes what the 3D view shows to a PNG file.", NONE, Key::F12),
    row(Command::ToggleTheme, Menu::View, "Dark or Light", "Changes between the dark and the light theme.", COMMAND_SHIFT, Key::L),
    row(Command::RestoreLayout, Menu::View, "Restore Default Layout", "Puts all panels back where they came from.", COMMAND_SHIFT, Key::R),
    row(Command::Palette, Menu::Help, "Command Palette…", "Finds any command by its name.", COMMAND_SHIFT, Key::P),
    row(Command::ShortcutSheet, Menu::Help, "Keyboard Shortcuts", "Shows all keys.", SHIFT, Key::Questionmark),
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
