//! Writes the bundled example, `examples/phantom.json`: sections through a
//! made-up torso whose organs fork, have holes, lie in one another and share
//! borders.
//!
//! ```text
//! anatomy (what is where) ─► contours (on planes) ─► simplify ─► sections ─► JSON
//! ```
//!
//! `cargo run --release --example phantom [FILE]`

mod anatomy;
mod bodies;
mod contours;
mod planes;
mod simplify;

use std::path::PathBuf;
use std::process::ExitCode;

use glam::{DVec2, DVec3};

use transect::error::{Error, Result};
use transect::io::json;
use transect::plane::Plane;
use transect::section::{Rules, Section, Sections};

fn main() -> ExitCode {
    let path = std::env::args_os().nth(1).map_or_else(bundled, PathBuf::from);
    let written = phantom().and_then(|sections| {
        let text = text(&sections)?;
        std::fs::write(&path, text).map_err(|error| Error::file(&path, error))
    });
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn bundled() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "examples", "phantom.json"].iter().collect()
}

fn text(sections: &Sections) -> Result<Vec<u8>> {
    let mut text = Vec::new();
    json::write(sections, &mut text)?;
    Ok(text)
}

/// The phantom's sections.
fn phantom() -> Result<Sections> {
    let cuts = planes::planes();
    let sections =
        cuts.iter().map(|(name, plane)| section(name, plane)).collect::<Result<Vec<Section>>>()?;
    let mut sections = Sections::new(sections, &strict())?;
    sections.name_materials(anatomy::materials());
    sections.units = "mm".to_owned();
    sections.frame = "LPS".to_owned();
    Ok(sections)
}

fn section(name: &str, plane: &Plane) -> Result<Section> {
    /// A torso's size, in mm.
    const DIAGONAL: f64 = 430.0;
    let borders = contours::borders(plane, &anatomy::label_at);
    let edges = simplify::simplified(&borders);
    let points: Vec<DVec3> = borders.points.iter().map(|&point| rounded(plane, point)).collect();
    Section::from_graph(name, *plane, &points, &edges, DIAGONAL, &strict())
        .map(|(section, _)| section)
}

/// The point on the plane whose kept coordinates are whole micrometres.
fn rounded(plane: &Plane, point: DVec3) -> DVec3 {
    let kept = plane.project(point);
    plane.lift(DVec2::new((kept.x * 1000.0).round() / 1000.0, (kept.y * 1000.0).round() / 1000.0))
}

fn strict() -> Rules {
    Rules { strict: true, ..Rules::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect::label::Label;

    #[test]
    fn the_committed_file_is_what_this_code_writes() {
        let committed = std::fs::read(bundled()).expect("examples/phantom.json is committed");
        let written = text(&phantom().expect("a phantom")).expect("writing to memory");
        assert!(committed == written, "run: cargo run --release --example phantom");
    }

    #[test]
    fn organs_are_where_they_should_be() {
        let at = |x, y, z| anatomy::label_at(DVec3::new(x, y, z));
        assert_eq!(at(0.0, 58.0, 0.0), Label(2), "the vertebral column");
        assert_eq!(at(0.0, 85.0, 0.0), Label(7), "its canal is no bone");
        assert_eq!(at(0.0, 100.0, 0.0), Label(2), "behind the canal is bone again");
        assert_eq!(at(-40.0, -5.0, 39.0), Label(1), "a vessel within the liver");
        assert_eq!(at(200.0, 0.0, 0.0), Label::OUTSIDE);
    }

    #[test]
    fn every_organ_is_cut_and_planes_are_not_parallel() {
        let sections = phantom().expect("a phantom").sections;
        for id in 1..=7 {
            let cut = sections.iter().filter(|section| section.labels().contains(&Label(id)));
            assert!(cut.count() >= 5, "label {id}");
        }
        for (i, one) in sections.iter().enumerate() {
            for other in &sections[..i] {
                let [a, b] = [one, other].map(|section| section.plane().unit_normal());
                assert!(a.cross(b).length() > 1e-3, "{} and {}", one.name(), other.name());
            }
        }
    }

    #[test]
    fn contours_are_on_the_organs_borders() {
        // A step of 0.3 mm to either side of a vertex of the body's contour,
        // which lies within 0.1 mm of its border, leaves and enters the body.
        let (name, plane) = &planes::planes()[7];
        let section = section(name, plane).expect("a section");
        let mut seen = 0;
        for edge in section.edges().iter().filter(|edge| edge.right == Label::OUTSIDE) {
            let point = section.point(edge.start);
            let outward = (point - DVec3::new(0.0, 8.0, 0.0)).normalize();
            assert_eq!(anatomy::label_at(point + 0.3 * outward), Label::OUTSIDE);
            assert_eq!(anatomy::label_at(point - 0.3 * outward), Label(7));
            seen += 1;
        }
        assert!(seen > 10);
    }
}
