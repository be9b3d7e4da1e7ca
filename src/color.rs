//! Colours as they are written, in sRGB, and as light adds up.

use glam::Vec3;

/// 8-bit sRGB to linear light.
pub fn linear(color: [u8; 3]) -> Vec3 {
    Vec3::from(color.map(|channel| {
        let encoded = f32::from(channel) / 255.0;
        if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
    }))
}

/// Linear light to opaque 8-bit sRGB.
pub fn encode(light: Vec3) -> [u8; 4] {
    let channel = |linear: f32| {
        let linear = linear.clamp(0.0, 1.0);
        let encoded = if linear <= 0.003_130_8 {
            linear * 12.92
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        };
        (encoded * 255.0).round() as u8
    };
    [channel(light.x), channel(light.y), channel(light.z), 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_survive_the_way_to_linear_and_back() {
        for value in 0..=255u8 {
            assert_eq!(encode(linear([value, 0, 255])), [value, 0, 255, 255]);
        }
    }
}
