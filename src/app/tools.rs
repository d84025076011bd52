//! What the hand holds over the canvas, and how it is set.

use crate::paint::CROWN;

/// What the hand holds over the canvas.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Tool {
    /// Paints labels.
    #[default]
    Brush,
    /// Goes round what is to be labelled.
    Lasso,
    /// Goes round it in straight lines.
    Polygon,
    /// Goes round it along edges of the picture.
    Livewire,
    /// Takes what has the colour of the place that was clicked.
    Flood,
    /// Finds the outline between strokes inside and strokes outside.
    Smart,
    /// Drags handles on the silhouette: how deep the crown is there.
    Depth,
    /// Moves the picture.
    Hand,
}

impl Tool {
    /// In the order of the tool column.
    pub const ALL: [Self; 8] = [
        Self::Brush,
        Self::Lasso,
        Self::Polygon,
        Self::Livewire,
        Self::Flood,
        Self::Smart,
        Self::Depth,
        Self::Hand,
    ];

    /// Whether the brush's size matters to it.
    pub fn has_size(self) -> bool {
        matches!(self, Self::Brush | Self::Smart)
    }

    /// Whether it changes labels.
    pub fn paints(self) -> bool {
        !matches!(self, Self::Depth | Self::Hand)
    }
}

/// The tools and how they are set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tools {
    /// The one in hand.
    pub tool: Tool,
    /// What it paints.
    pub label: u8,
    /// Whether it erases instead.
    pub is_erasing: bool,
    /// Radius of the brush, pixels of the photograph.
    pub radius_px: f64,
    /// Hardness of the brush, 0 to 1.
    pub hardness: f64,
    /// How far the brush calms the hand, 0 to 1.
    pub smoothing: f64,
    /// How different colours may be that flood takes for one, 0 to 255.
    pub tolerance: u8,
    /// Whether flood takes only what hangs together.
    pub is_contiguous: bool,
    /// How far *Grow*, *Shrink* and *Smooth* go, pixels.
    pub amount_px: u32,
    /// What *Remove Specks* and *Fill Holes* take for one, at most this many pixels.
    pub speck_px: u64,
}

impl Default for Tools {
    fn default() -> Self {
        Self {
            tool: Tool::default(),
            label: CROWN,
            is_erasing: false,
            radius_px: 24.0,
            hardness: 1.0,
            smoothing: 0.3,
            tolerance: 24,
            is_contiguous: true,
            amount_px: 4,
            speck_px: 400,
        }
    }
}

/// A setting of a tool or of a mask command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToolOption {
    /// How different colours may be that flood takes for one, 0 to 255.
    Tolerance(u8),
    /// Whether flood takes only what hangs together.
    Contiguous(bool),
    /// How far *Grow*, *Shrink* and *Smooth* go, pixels.
    Amount(u32),
    /// The largest speck and the largest hole, pixels.
    Speck(u64),
}

/// Radius of the strokes of smart select, as shares of the picture's longer side: thinner ones cannot
/// be seen, thicker ones say more than the hand means.
const HINT_RADII: (f64, f64) = (1.0 / 160.0, 1.0 / 40.0);

impl Tools {
    /// Radius of the strokes of smart select on a picture with this longer side.
    pub(super) fn hint_radius_px(&self, longer_px: u32) -> f64 {
        let longer = f64::from(longer_px);
        self.radius_px
            .clamp(longer * HINT_RADII.0, longer * HINT_RADII.1)
    }

    pub(super) fn set(&mut self, option: ToolOption) {
        match option {
            ToolOption::Tolerance(tolerance) => self.tolerance = tolerance,
            ToolOption::Contiguous(is_contiguous) => self.is_contiguous = is_contiguous,
            ToolOption::Amount(amount) => self.amount_px = amount.clamp(1, 128),
            ToolOption::Speck(pixels) => self.speck_px = pixels.clamp(1, 100_000_000),
        }
    }
}

/// The name of a label.
pub(super) fn label_name(label: u8) -> String {
    match label {
        0 => "Background".to_owned(),
        1 => "Crown".to_owned(),
        2 => "Trunk".to_owned(),
        _ => format!("Sub-crown {}", label - 2),
    }
}

/// What is drawn over the photograph besides the tint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Overlay {
    /// The labels' colours.
    Tint,
    /// The line around what is labelled, pixel by pixel.
    Silhouette,
    /// The resampled outline that new trees are made from.
    Contour,
    /// Foot and shoulders of the trunk.
    Pins,
    /// The row where the crown begins.
    Baseline,
    /// k all over the crown, in colours.
    Heat,
}

/// Which overlays are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Overlays {
    shown: [bool; 6],
}

impl Default for Overlays {
    fn default() -> Self {
        let mut overlays = Self { shown: [false; 6] };
        overlays.toggle(Overlay::Tint);
        overlays
    }
}

impl Overlays {
    pub(super) fn has(self, overlay: Overlay) -> bool {
        self.shown[overlay as usize]
    }

    pub(super) fn toggle(&mut self, overlay: Overlay) {
        self.shown[overlay as usize] ^= true;
    }

    /// Whether any of those is shown that are drawn from the tree's shape.
    pub(super) fn need_shape(self) -> bool {
        let of_shape = [Overlay::Contour, Overlay::Pins, Overlay::Baseline];
        of_shape.into_iter().any(|overlay| self.has(overlay))
    }
}
