//! Meshes as PLY, with the labels on both sides of every triangle.

mod header;
mod values;

use std::io::{Error as IoError, Write};
use std::path::Path;

use glam::DVec3;

use self::header::{Element, Header};
use self::values::Values;
use super::mesh::About;
use crate::error::{Error, Result};
use crate::label::Label;
use crate::mesh::{Mesh, back_and_front};

/// Writes binary PLY: double coordinates and a colour for each vertex; for each face its
/// vertices, the labels behind and in front of it, and the colour of the label behind.
pub fn write(mesh: &Mesh, about: &About, out: &mut dyn Write) -> std::io::Result<()> {
    write!(out, "ply\nformat binary_little_endian 1.0\n")?;
    for line in about.lines() {
        writeln!(out, "comment {line}")?;
    }
    writeln!(out, "element vertex {}", mesh.vertices.len())?;
    write!(out, "property double x\nproperty double y\nproperty double z\n")?;
    write!(out, "property uchar red\nproperty uchar green\nproperty uchar blue\n")?;
    writeln!(out, "element face {}", mesh.triangles.len())?;
    writeln!(out, "property list uchar int vertex_indices")?;
    write!(out, "property int label_back\nproperty int label_front\n")?;
    write!(out, "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n")?;
    for (vertex, label) in mesh.vertices.iter().zip(shown(mesh)) {
        for number in vertex.to_array() {
            out.write_all(&number.to_le_bytes())?;
        }
        out.write_all(&about.color(label))?;
    }
    for (triangle, sides) in mesh.triangles.iter().zip(&mesh.sides) {
        out.write_all(&[3])?;
        for number in triangle.iter().copied().chain(sides.map(|label| label.0)) {
            let number = i32::try_from(number)
                .map_err(|_| IoError::other(format!("the number {number} is too large for PLY")))?;
            out.write_all(&number.to_le_bytes())?;
        }
        out.write_all(&about.color(sides[0]))?;
    }
    Ok(())
}

/// The label whose colour a vertex has, for programs that know no colours of faces. Where labels
/// meet it is one that is seen from outside, and of several the smallest.
fn shown(mesh: &Mesh) -> Vec<Label> {
    let mut best = vec![(true, Label::UNKNOWN); mesh.vertices.len()];
    for (triangle, [back, front]) in mesh.triangles.iter().zip(&mesh.sides) {
        for &vertex in triangle {
            let best = &mut best[vertex as usize];
            *best = (*best).min((front.is_material(), *back));
        }
    }
    best.into_iter().map(|(_, label)| label).collect()
}

/// Reads text or binary PLY, of ours and of others.
///
/// # Errors
/// Where the file ends early or is not what its header promises.
pub fn read(bytes: &[u8], path: &Path) -> Result<Mesh> {
    let at = |place: String, what: String| Error::input(path, place, what);
    let (header, body) = Header::read(bytes).map_err(|what| at("the header".into(), what))?;
    header.require_room(body.len()).map_err(|what| at("the header".into(), what))?;
    let mut values = Values::new(header.encoding, body);
    let mut mesh = Mesh::default();
    for element in &header.elements {
        for number in 0..element.count {
            let read = match element.name.as_str() {
                "vertex" => read_vertex(element, &mut values, &mut mesh),
                "face" => read_face(element, &mut values, &mut mesh),
                _ => element
                    .properties
                    .iter()
                    .try_for_each(|property| values.read(property).map(|_| ())),
            };
            read.map_err(|what| at(format!("{} {number}", element.name), what))?;
        }
    }
    let count = mesh.vertices.len() as u32;
    if let Some(face) =
        mesh.triangles.iter().position(|corners| corners.iter().any(|&c| c >= count))
    {
        let what = format!("there is no vertex {:?} among {count}", mesh.triangles[face]);
        return Err(at(format!("triangle {face}"), what));
    }
    Ok(mesh)
}

fn read_vertex(
    element: &Element,
    values: &mut Values,
    mesh: &mut Mesh,
) -> std::result::Result<(), String> {
    let mut point = [None; 3];
    for property in &element.properties {
        let found = values.read(property)?;
        if let Some(axis) = ["x", "y", "z"].iter().position(|name| *name == property.name) {
            point[axis] = found.first().copied();
        }
    }
    let [Some(x), Some(y), Some(z)] = point else {
        return Err("it has no x, y and z".to_owned());
    };
    mesh.vertices.push(DVec3::new(x, y, z));
    Ok(())
}

fn read_face(
    element: &Element,
    values: &mut Values,
    mesh: &mut Mesh,
) -> std::result::Result<(), String> {
    let mut corners = None;
    let mut sides = [Label(1), Label::OUTSIDE];
    for property in &element.properties {
        let found = values.read(property)?;
        match property.name.as_str() {
            "vertex_indices" | "vertex_index" => corners = Some(indices(&found)?),
            "label_back" => sides[0] = Label(index(found.first())?),
            "label_front" => sides[1] = Label(index(found.first())?),
            _ => {}
        }
    }
    let corners = corners.ok_or("it has no list of vertex_indices")?;
    // Others may have put the labels the other way round.
    let ordered = back_and_front(sides[0], sides[1]);
    for pair in corners.get(1..).unwrap_or_default().windows(2) {
        let (second, third) =
            if ordered == sides { (pair[0], pair[1]) } else { (pair[1], pair[0]) };
        mesh.triangles.push([corners[0], second, third]);
        mesh.sides.push(ordered);
    }
    Ok(())
}

fn indices(values: &[f64]) -> std::result::Result<Vec<u32>, String> {
    values.iter().map(|value| index(Some(value))).collect()
}

fn index(value: Option<&f64>) -> std::result::Result<u32, String> {
    match value {
        Some(&value) if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) => {
            Ok(value as u32)
        }
        Some(value) => Err(format!("{value} is no number from 0 on: correct it")),
        None => Err("a label is a list: it must be a number".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\n\
        property float z\nproperty float x\nproperty uchar shade\nproperty float y\n\
        element face 2\nproperty list uchar uint vertex_index\nproperty int label_back\n\
        property int label_front\nelement edge 1\nproperty int vertex1\nend_header\n\
        0 0 7 0\n0 1 7 0\n0 1 7 1\n0.5 0 7 1\n4 0 1 2 3 2 0\n3 0 1 2 2 1\n9\n";

    #[test]
    fn files_of_others_are_read() {
        let mesh = read(TEXT.as_bytes(), Path::new("hand.ply")).unwrap();
        assert_eq!(mesh.vertices[3], DVec3::new(0.0, 1.0, 0.5));
        // A square in two halves; then a triangle turned round, so that the
        // smaller label is behind it.
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 2, 1]]);
        let (outside, one, two) = (Label::OUTSIDE, Label(1), Label(2));
        assert_eq!(mesh.sides, [[two, outside], [two, outside], [one, two]]);
    }

    #[test]
    fn vertices_show_what_is_seen_from_outside() {
        use crate::io::bodies::tests::two_tetrahedra;
        let mut mesh = two_tetrahedra();
        // The corners of the wall, then the tops of both.
        assert_eq!(shown(&mesh), [1, 1, 1, 1, 4].map(Label));
        for sides in &mut mesh.sides {
            *sides = [Label(4), Label::OUTSIDE];
        }
        mesh.sides[0] = [Label(1), Label(4)];
        assert_eq!(shown(&mesh), [Label(4); 5]);
    }

    #[test]
    fn big_endian_files_are_read() {
        let mut bytes = b"ply\r\nformat binary_big_endian 1.0\r\nelement vertex 3\r\n\
            property float x\r\nproperty double y\r\nproperty short z\r\nelement face 1\r\n\
            property list uchar ushort vertex_indices\r\nend_header\r\n"
            .to_vec();
        for vertex in 0..3u8 {
            bytes.extend(f32::from(vertex).to_be_bytes());
            bytes.extend(0.25f64.to_be_bytes());
            bytes.extend((-i16::from(vertex)).to_be_bytes());
        }
        bytes.extend([3, 0, 0, 0, 1, 0, 2]);
        let mesh = read(&bytes, Path::new("big.ply")).unwrap();
        assert_eq!(mesh.vertices[2], DVec3::new(2.0, 0.25, -2.0));
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn damage_is_named_with_its_place() {
        let error =
            |text: &str| read(text.as_bytes(), Path::new("bad.ply")).unwrap_err().to_string();
        let cut = &TEXT[..TEXT.len() - 30];
        assert!(error(cut).contains("bad.ply: vertex 3"), "{}", error(cut));
        assert!(error(&TEXT.replace("3 0 1 2 2 1", "3 0 1 9 2 1")).contains("triangle 2"));
        assert!(error(&TEXT.replace("2 0\n3", "2 -1\n3")).contains("face 0"));
        assert!(error(&TEXT.replace("property float x\n", "")).contains("vertex 0"));
        assert!(error(&TEXT.replace("float x", "quad x")).contains("header"));
        assert!(error("solid").contains("header"));
        let edges = |text: &str| error(&TEXT.replace("edge 1\nproperty int vertex1", text));
        assert!(edges("a 18446744073709551615").contains("\"a\" has no properties"));
        let found = edges("a 18446744073709551615\nproperty int b");
        assert!(found.contains("header: it promises 18446744073709551615"), "{found}");
    }
}
