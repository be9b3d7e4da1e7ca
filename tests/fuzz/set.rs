//! Sections as they are drawn, and as JSON.

use glam::DVec3;
use serde_json::{Value, json};

/// A label that stands for *unknown*.
pub const UNKNOWN: u32 = u32::MAX;

/// A closed contour around a label.
#[derive(Debug, Clone, PartialEq)]
pub struct Contour {
    pub label: u32,
    pub points: Vec<DVec3>,
}

/// One plane with what is drawn on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    pub normal: DVec3,
    pub offset: f64,
    pub extent: Vec<DVec3>,
    pub contours: Vec<Contour>,
}

/// What one reconstruction is made from.
#[derive(Debug, Clone, PartialEq)]
pub struct Set(pub Vec<Drawn>);

impl Set {
    /// The file that a user would have.
    pub fn to_json(&self) -> String {
        let points = |points: &[DVec3]| -> Vec<Value> {
            points.iter().map(|point| json!(point.to_array())).collect()
        };
        let label = |label: u32| if label == UNKNOWN { json!("unknown") } else { json!(label) };
        let section = |own: &Drawn| {
            let contour =
                |one: &Contour| json!({"label": label(one.label), "points": points(&one.points)});
            let mut section = json!({
                "normal": own.normal.to_array(),
                "offset": own.offset,
                "loops": own.contours.iter().map(contour).collect::<Vec<_>>(),
            });
            if !own.extent.is_empty() {
                section["extent"] = json!(points(&own.extent));
            }
            section
        };
        let sections: Vec<Value> = self.0.iter().map(section).collect();
        json!({"transect": "sections", "version": 1, "sections": sections}).to_string()
    }
}
