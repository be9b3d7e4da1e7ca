//! Meshes as OFF: points and polygons in text.

use std::io::Write;
use std::path::Path;

use super::mesh::{About, Soup};
use super::text::{Row, Rows, point};
use crate::error::Result;
use crate::mesh::Mesh;

/// Reads vertices and faces, a line each; normals and colours that follow them are passed over.
pub(super) fn read(text: &str, path: &Path) -> Result<Soup> {
    let mut rows = Rows::new(text, path).without_comments('#');
    let mut header = rows.next("", || "the word OFF".to_owned())?;
    if keyword(&header)? {
        header.words.remove(0);
    }
    if header.words.is_empty() {
        header = rows.next("", || "the numbers of vertices and faces".to_owned())?;
    }
    let [vertices, faces] =
        [header.count(0, "the number of vertices")?, header.count(1, "the number of faces")?];
    let mut soup = Soup::default(); // no capacity from counts that may be wrong
    for vertex in 0..vertices {
        let row = rows.next("", || format!("vertex {vertex} of {vertices}"))?;
        let point = point(&mut row.words.iter().copied()).map_err(|what| row.error(what))?;
        soup.points.push(point);
    }
    for face in 0..faces {
        let row = rows.next("", || format!("face {face} of {faces}"))?;
        let count = row.count(0, "the number of a face's vertices")?;
        if row.words.len() <= count {
            let what = format!("a face promises {count} vertices, and fewer follow on its line");
            return Err(row.error(what));
        }
        let corners = (1..=count).map(|word| row.index(word, vertices));
        soup.polygon(&corners.collect::<Result<Vec<_>>>()?);
    }
    Ok(soup)
}

/// Whether a row begins with the word that says what vertices have.
fn keyword(row: &Row) -> Result<bool> {
    let Some(flags) = row.words.first().and_then(|word| word.strip_suffix("OFF")) else {
        return Ok(false);
    };
    if flags.contains(['4', 'n']) {
        return Err(row.error("its points are not in three dimensions: export it as plain OFF"));
    }
    match row.words.get(1) {
        Some(&"BINARY") => Err(row.error("binary OFF is not read: export it as text")),
        _ => Ok(true),
    }
}

/// Writes all triangles, without their labels.
pub fn write(mesh: &Mesh, about: &About, out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(out, "OFF")?;
    for line in about.lines() {
        writeln!(out, "# {line}")?;
    }
    writeln!(out, "{} {} 0", mesh.vertices.len(), mesh.triangles.len())?;
    for vertex in &mesh.vertices {
        writeln!(out, "{} {} {}", vertex.x, vertex.y, vertex.z)?;
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(out, "3 {a} {b} {c}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_comments_and_counts_beside_the_keyword_are_read() {
        let text = "# by hand\nCOFF 4 1 0 # counts\n\n0 0 0 255 0 0 1\n1 0 0 0 0 0 1\n1 1 0\n0 1 0\n\
                    4 0 1 2 3 0.5 0.5 0.5\n";
        let soup = read(text, Path::new("a.off")).unwrap();
        assert_eq!((soup.points.len(), &soup.triangles[..]), (4, &[[0, 1, 2], [0, 2, 3]][..]));
        let error = |text: &str| read(text, Path::new("a.off")).unwrap_err().to_string();
        assert!(error("OFF BINARY\n").contains("binary OFF"));
        assert!(error("4OFF\n1 0 0\n0 0 0 0").contains("three dimensions"));
        assert!(error("OFF\n99999999999999 1 0\n0 0 0\n").contains("vertex 1 of 99999999999999"));
        assert!(error("OFF\n1 1 0\n0 0 0\n3 0 0\n").contains("line 4: a face promises 3"));
        assert!(error("OFF\n1 1 0\n0 0 0\n3 0 0 1\n").contains("out of range"));
    }
}
