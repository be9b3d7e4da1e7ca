//! Pictures of the result from several sides, within the page.

use std::io;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::mesh::Mesh;
use crate::picture::{PictureOptions, Side, Viewpoint, render, write_png};
use crate::section::Sections;

/// The size of the first picture, unless one is asked for, and of the others.
const FIRST: [u32; 2] = [1200, 900];
const OTHERS: [u32; 2] = [800, 600];

/// A picture.
#[derive(Debug, Clone)]
pub struct View {
    /// From where.
    pub title: &'static str,
    pub size: [u32; 2],
    /// As a `data:` address.
    pub source: String,
}

/// The picture that a `.png` would be, and such from the front, the left and the top.
///
/// # Errors
/// When a picture cannot be encoded.
pub fn views(mesh: &Mesh, sections: &Sections, picture: &PictureOptions) -> io::Result<Vec<View>> {
    let first = match picture.size == PictureOptions::default().size {
        true => PictureOptions { size: FIRST, ..picture.clone() },
        false => picture.clone(),
    };
    let title = if first.view.is_some() { "The view asked for" } else { "What shows most" };
    let from = |side| PictureOptions {
        size: OTHERS,
        view: Some(Viewpoint::Sides(vec![side])),
        ..picture.clone()
    };
    let all = [
        (title, first),
        ("From the front", from(Side::Front)),
        ("From the left", from(Side::Left)),
        ("From the top", from(Side::Top)),
    ];
    let view = |(title, options): (&'static str, PictureOptions)| {
        let mut png = Vec::new();
        write_png(&render(mesh, sections, &options), &mut png)?;
        let source = format!("data:image/png;base64,{}", STANDARD.encode(png));
        Ok(View { title, size: options.size, source })
    };
    all.into_iter().map(view).collect()
}
