//! Meshes as STL: loose triangles, in binary with single precision, or as text.

use std::io::Write;
use std::path::Path;

use glam::{DVec3, Vec3};

use super::mesh::{About, Soup};
use super::text::point;
use crate::error::{Error, Result};
use crate::mesh::Mesh;

/// Length of the header, which must not begin with "solid".
const HEADER: usize = 80;

/// Bytes of a triangle: its normal, its corners and two more.
const TRIANGLE: usize = 50;
/// Where a file is looked at for bytes that no text has.
const BEGIN: usize = 1024;

/// Reads triangles from binary or text, whatever the case of its words.
pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Soup> {
    let text = super::without_mark(bytes).trim_ascii_start();
    let is_solid = text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let is_binary = !is_solid || bytes[..bytes.len().min(BEGIN)].contains(&0);
    match is_binary || promised(bytes).is_some_and(|length| length == bytes.len() as u64) {
        true => read_binary(bytes).map_err(|what| Error::file(path, what)),
        false => read_text(&String::from_utf8_lossy(super::without_mark(bytes)), path),
    }
}

/// How long a binary file says that it is.
fn promised(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER..)?.first_chunk::<4>()?;
    Some((HEADER + 4) as u64 + TRIANGLE as u64 * u64::from(u32::from_le_bytes(*count)))
}

fn read_binary(bytes: &[u8]) -> std::result::Result<Soup, String> {
    let length = promised(bytes).ok_or("this is no STL: export it again")?;
    if length > bytes.len() as u64 {
        return Err(format!(
            "its triangles take {length} bytes, and there are {}: it is cut off or no STL, export \
             it again",
            bytes.len()
        ));
    }
    let mut soup = Soup::default();
    for triangle in bytes[HEADER + 4..length as usize].chunks_exact(TRIANGLE) {
        let numbers = triangle[12..48].as_chunks::<4>().0;
        let corners = numbers.as_chunks::<3>().0;
        triangle_of(
            &mut soup,
            corners
                .iter()
                .map(|corner| Vec3::from_array(corner.map(f32::from_le_bytes)).as_dvec3()),
        );
    }
    Ok(soup)
}

fn triangle_of(soup: &mut Soup, corners: impl Iterator<Item = DVec3>) {
    let first = soup.points.len();
    soup.points.extend(corners);
    let corners: Vec<u32> = (first..soup.points.len()).map(|corner| corner as u32).collect();
    soup.polygon(&corners);
}

fn read_text(text: &str, path: &Path) -> Result<Soup> {
    let mut soup = Soup::default();
    let mut corners: Vec<DVec3> = Vec::new();
    for (number, line) in text.split(['\n', '\r']).enumerate() {
        let mut words = line.split_ascii_whitespace();
        while let Some(word) = words.next() {
            if word.eq_ignore_ascii_case("vertex") {
                let error = |what| Error::input(path, format!("line {}", number + 1), what);
                corners.push(point(&mut words).map_err(error)?);
            } else if word.eq_ignore_ascii_case("endloop") {
                triangle_of(&mut soup, corners.drain(..));
            } else if ["solid", "endsolid"].iter().any(|name| word.eq_ignore_ascii_case(name)) {
                // A name follows, of any words.
                break;
            }
        }
    }
    match corners.is_empty() {
        true => Ok(soup),
        false => {
            Err(Error::file(path, "it ends within a triangle: it is cut off, export it again"))
        }
    }
}

/// Writes all triangles, without their labels: a closed surface when the mesh
/// has one material, the whole network when it has several.
pub fn write(mesh: &Mesh, about: &About, out: &mut dyn Write) -> std::io::Result<()> {
    let Ok(count) = u32::try_from(mesh.triangles.len()) else {
        return Err(std::io::Error::other(
            "STL cannot count this many triangles: write another kind",
        ));
    };
    let mut header = about.lines().join("; ").into_bytes();
    header.resize(HEADER, b' ');
    out.write_all(&header)?;
    out.write_all(&count.to_le_bytes())?;
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for vector in [normal, a, b, c] {
            for number in vector.as_vec3().to_array() {
                out.write_all(&number.to_le_bytes())?;
            }
        }
        out.write_all(&[0; 2])?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_read_in_either_case_and_binary_by_its_length() {
        let text = "solid a vertex by name\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n\
                    vertex 1e0 0 0\nvertex 0 -1 0\nendloop\nendfacet\nendsolid\n";
        let expected = [DVec3::ZERO, DVec3::X, DVec3::NEG_Y];
        for text in [text.to_owned(), text.to_uppercase(), text.replace('\n', " \r\n\t")] {
            let soup = read(text.as_bytes(), Path::new("a.stl")).unwrap();
            assert_eq!((&soup.points[..], soup.triangles.len()), (&expected[..], 1), "{text}");
        }
        let error = |bytes: &[u8]| read(bytes, Path::new("a.stl")).unwrap_err().to_string();
        let cut = text.find("1e0 0").expect("a vertex") + 5;
        assert!(error(&text.as_bytes()[..cut]).contains("line 5: a vertex has fewer"));
        assert!(error(text.replace("endloop", "").as_bytes()).contains("within a triangle"));
        // A binary file whose header says solid is binary by its length.
        let mut binary = b"solid".to_vec();
        binary.resize(HEADER, b' ');
        binary.extend(1u32.to_le_bytes());
        binary.extend(
            [[0.0; 3], [0.0; 3], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]
                .iter()
                .flatten()
                .flat_map(|number: &f32| number.to_le_bytes()),
        );
        binary.extend([0; 2]);
        assert_eq!(read(&binary, Path::new("a.stl")).unwrap().points, expected);
        binary[0] = b'x';
        assert!(error(&binary[..100]).contains("134 bytes, and there are 100"));
    }
}
