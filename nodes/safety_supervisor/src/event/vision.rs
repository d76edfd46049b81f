//! What the camera's judge says.

/// A defect that the camera's judge names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Defect {
    /// Too little material.
    Under,
    /// Too much material.
    Over,
    /// Loose strands.
    Spaghetti,
    /// Layers beside those below: shown, the offset is judged by its own measure.
    Shift,
    /// Strings between parts: shown, not acted upon.
    Stringing,
    /// Lumps: shown, not acted upon.
    Blobs,
    /// Anything else: shown, not acted upon.
    Other,
}

impl Defect {
    /// By the judge's name of the class; `None` for `ok`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "ok" => None,
            "under" => Some(Self::Under),
            "over" => Some(Self::Over),
            "spaghetti" => Some(Self::Spaghetti),
            "shift" => Some(Self::Shift),
            "stringing" => Some(Self::Stringing),
            "blobs" => Some(Self::Blobs),
            _ => Some(Self::Other),
        }
    }
}

/// What one frame says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VisionReport {
    /// The frame could be judged; nothing else counts where not.
    pub usable: bool,
    /// Fused confidence of a defect, `[0, 1]`.
    pub confidence: f64,
    /// The defect that carries the confidence; `None` where nothing seems wrong.
    pub defect: Option<Defect>,
    /// Enough frames agree on it.
    pub confirmed: bool,
    /// This frame could tell of it; where not, what earlier ones said stands.
    pub told: bool,
    /// Offset of what was laid before, x and y `[m]`, where the frame tells.
    pub offset_m: Option<[f64; 2]>,
}
