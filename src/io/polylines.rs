//! Closed polylines of Wavefront OBJ, as sections: `l` lines, by the planes they lie on.

use std::io::{self, Write};
use std::path::Path;

use glam::DVec3;

use super::mesh::{About, welded};
use super::obj::{corner, statements};
use super::polygons;
use super::text::{point, shortest};
use super::{unwritten, writable};
use crate::error::{Error, Result};
use crate::label::{Label, Material};
use crate::section::{Region, Rules, Sections, Warning};

/// The polylines of an object or a group, which is a material.
struct Part {
    /// Empty where there is none.
    name: String,
    /// The line of the first polyline.
    line: usize,
    pieces: Vec<Vec<u32>>,
}

/// Reads the text of an `.obj` file; `file` is for errors.
///
/// # Errors
/// Where it holds a surface and no polylines, is damaged, or a contour lies on no plane.
pub fn read(text: &str, file: &Path, rules: &Rules) -> Result<Sections> {
    let (mut points, mut parts, mut faces) = (Vec::<DVec3>::new(), Vec::<Part>::new(), 0);
    let mut name = String::new();
    for (line, statement) in statements(text) {
        let at = |what| Error::input(file, format!("line {line}"), what);
        let mut words = statement.split_whitespace();
        match words.next() {
            Some("v") => points.push(point(&mut words).map_err(at)?),
            Some("f") => faces += 1,
            Some("o" | "g") => name = words.collect::<Vec<_>>().join(" "),
            Some("l") => {
                let count = points.len();
                let piece = words.map(|word| corner(word, count));
                let piece = piece.collect::<std::result::Result<Vec<_>, _>>().map_err(at)?;
                if let Some(missing) = piece.iter().find(|&&own| own as usize >= count) {
                    let missing = u64::from(*missing) + 1;
                    return Err(at(format!("there is no vertex {missing} before it: correct it")));
                }
                let part = match parts.iter().position(|part| part.name == name) {
                    Some(part) => part,
                    None => {
                        parts.push(Part { name: name.clone(), line, pieces: Vec::new() });
                        parts.len() - 1
                    }
                };
                parts[part].pieces.push(piece);
            }
            _ => (),
        }
    }
    if parts.is_empty() {
        return Err(Error::file(
            file,
            match faces {
                0 => "there is no polyline in it: export the contours again",
                _ => {
                    "it holds a surface and no polylines: cut it by planes first (transect slice), or \
                 export its contours as lines"
                }
            },
        ));
    }
    let (points, same) = welded(points.iter().copied());
    let (mut polygons, mut materials, mut left) = (Vec::new(), Vec::new(), 0);
    for (part, id) in parts.into_iter().zip(1..) {
        let pieces = part.pieces.into_iter();
        let pieces = pieces.map(|piece| piece.into_iter().map(|own| same[own as usize]).collect());
        let place = format!("the polylines from line {} on", part.line);
        let (found, open) = polygons::joined(file, &place, Label(id), pieces.collect(), &points)?;
        left += open;
        polygons.extend(found);
        let name = if part.name.is_empty() { format!("label {id}") } else { part.name };
        materials.push(Material { name, ..Material::numbered(Label(id)) });
    }
    let mut sections = polygons::sections(file, polygons, rules)?;
    let mut leave_out = |what: String| {
        sections.left_out.push(Warning { section: String::new(), what });
    };
    if left > 0 {
        leave_out(format!("{left} polylines that do not close"));
    }
    if faces > 0 {
        leave_out(format!("{faces} faces: only polylines are contours"));
    }
    sections.name_materials(super::volume::distinct(materials));
    Ok(sections)
}

/// Writes the boundaries of all regions as closed polylines, an object for each material.
///
/// # Errors
/// Where a section has unknown regions, or reaches to infinity with a material, and where writing
/// fails.
pub fn write(sections: &Sections, out: &mut dyn Write) -> Result<()> {
    let regions = sections.sections.iter().map(|own| writable(own, ".obj"));
    let regions = regions.collect::<Result<Vec<_>>>()?;
    write_all(sections, &regions, out).map_err(|error| unwritten(".obj", &error))
}

fn write_all(sections: &Sections, regions: &[Vec<Region>], out: &mut dyn Write) -> io::Result<()> {
    for line in About::from(sections).lines() {
        writeln!(out, "# {line}")?;
    }
    // Vertices count from 1 through the whole file.
    let mut firsts = vec![1];
    for section in &sections.sections {
        let count = section.vertices().len();
        for vertex in 0..count {
            writeln!(out, "v {}", section.point(vertex as u32).to_array().map(shortest).join(" "))?;
        }
        firsts.push(firsts[firsts.len() - 1] + count);
    }
    for material in &sections.materials {
        let name = material.name.replace(char::is_control, " ");
        let names = sections.materials.iter().filter(|other| other.name == material.name);
        match names.count() {
            1 => writeln!(out, "o {name}")?,
            // Objects of one name would be one.
            _ => writeln!(out, "o {name} {}", material.id)?,
        }
        for (first, regions) in firsts.iter().zip(regions) {
            let own = regions.iter().filter(|region| region.label == Label(material.id));
            for walk in own.flat_map(|region| region.outer.iter().chain(&region.holes)) {
                let around = walk.iter().chain(walk.first());
                let corners = around.map(|&vertex| (first + vertex as usize).to_string());
                writeln!(out, "l {}", corners.collect::<Vec<_>>().join(" "))?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Plane;

    const OBJ: &str = "# two planes\no left lung\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nl 1 2 3 \\\n4 1\n\
        v 1 1 0\nv 2 1 0\nv 2 2 0\nl 5 6\nl 6 7\nl 5 7\np 1\ng a\nv 9 0 1\nv 9 3 1\nv 9 3 5\nl -3 -2\nl -2 -1 -3\n\
        l 1 2\n";

    fn read_text(text: &str) -> Result<Sections> {
        read(text, Path::new("a.obj"), &Rules::default())
    }

    #[test]
    fn closed_polylines_are_regions_by_plane_and_name() {
        for text in [OBJ.to_owned(), OBJ.replace('\n', "\r\n")] {
            let sections = read_text(&text).expect("sections");
            let planes: Vec<Plane> = sections.sections.iter().map(|own| *own.plane()).collect();
            let expected = [(DVec3::Z, 0.0), (DVec3::X, 9.0)];
            assert_eq!(planes, expected.map(|(normal, offset)| Plane { normal, offset }));
            let names: Vec<&str> = sections.materials.iter().map(|own| own.name.as_str()).collect();
            assert_eq!(names, ["left lung", "a"]);
            let area = |section: usize, label: u32| -> f64 {
                let regions = sections.sections[section].regions().expect("regions");
                regions.iter().filter(|own| own.label == Label(label)).map(|own| own.area).sum()
            };
            assert_eq!((area(0, 1), area(1, 2)), (15.5, 6.0));
            assert!(sections.left_out[0].what.contains("1 polylines that do not close"));
        }
    }

    #[test]
    fn what_is_no_drawing_is_refused() {
        let error = |text: &str| read_text(text).expect_err("it is wrong").to_string();
        assert!(error("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").contains("holds a surface"));
        assert!(error("v 0 0 0\n").contains("no polyline"));
        assert!(error("v 0 0 0\nl 1 2 1\n").contains("line 2: there is no vertex 2"));
        assert!(error("v 0 0 0\nl 0 1\n").contains("line 2"));
        assert!(error("v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\n").contains("no contour encloses"));
        let star = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nl 1 2\nl 1 3\nl 1 4\n";
        assert!(error(star).contains("more than two of them meet"));
    }
}
