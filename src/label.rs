//! What a region is made of.

use serde::{Deserialize, Serialize};

/// A label: 0 is *outside*, 1… are materials, and *unknown* is a label of its
/// own that no number in a file stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct Label(pub u32);

impl Label {
    /// The null material.
    pub const OUTSIDE: Self = Self(0);
    /// The largest that files of results have room for: their labels are signed.
    pub const LARGEST: Self = Self(i32::MAX as u32);
    /// A region that nobody could segment.
    pub const UNKNOWN: Self = Self(u32::MAX);

    /// Whether this is neither outside nor unknown.
    pub fn is_material(self) -> bool {
        self != Self::OUTSIDE && self != Self::UNKNOWN
    }
}

impl std::fmt::Display for Label {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::OUTSIDE => f.write_str("outside"),
            Self::UNKNOWN => f.write_str("unknown"),
            Self(number) => write!(f, "{number}"),
        }
    }
}

/// A material's name and colour.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Material {
    /// The label's number in files, from 1.
    pub id: u32,
    /// What people call it.
    pub name: String,
    /// sRGB, 8 bits a channel.
    pub color: [u8; 3],
}

impl Material {
    /// A material known only by its number: a name made of the number, and a
    /// colour that differs from its neighbours'.
    pub fn numbered(label: Label) -> Self {
        Self { id: label.0, name: format!("label {}", label.0), color: distinct_color(label.0) }
    }

    /// The name as one word that any file may be called: what is neither
    /// letter nor digit becomes `_`.
    pub fn word(&self) -> String {
        let safe = |letter: char| letter.is_alphanumeric() || letter == '-';
        let word: String = self.name.chars().map(|c| if safe(c) { c } else { '_' }).collect();
        if word.is_empty() { format!("label_{}", self.id) } else { word }
    }
}

/// Colours of equal lightness whose hues follow the golden angle, so that any
/// run of consecutive numbers is well spread.
fn distinct_color(number: u32) -> [u8; 3] {
    const GOLDEN_ANGLE: f64 = 137.507_764;
    let hue = (15.0 + f64::from(number.wrapping_sub(1)) * GOLDEN_ANGLE).to_radians();
    // A circle in Oklab's (a, b) plane at lightness 0.75.
    let (lightness, chroma) = (0.75, 0.11);
    oklab_to_srgb([lightness, chroma * hue.cos(), chroma * hue.sin()])
}

/// Björn Ottosson's Oklab, to 8-bit sRGB.
fn oklab_to_srgb([lightness, a, b]: [f64; 3]) -> [u8; 3] {
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ]
    .map(|linear| {
        let linear = linear.clamp(0.0, 1.0);
        let encoded = if linear <= 0.003_130_8 {
            12.92 * linear
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        };
        (encoded * 255.0).round() as u8
    })
}
