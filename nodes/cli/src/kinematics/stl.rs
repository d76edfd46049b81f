//! STL files as closed meshes.

use anyhow::Context;
use models::hybrid::Mesh;
use models::hybrid::mesh::Triangle;
use nalgebra::Vector3;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Reads a part, binary or ASCII, and places it on the table; `unit_m` is the length of one unit of the file.
///
/// # Errors
/// A file that cannot be read or is no STL file; a mesh that is not closed.
pub fn read(path: &Path, unit_m: f64) -> anyhow::Result<Mesh> {
    let name = || path.display().to_string();
    let mut file = BufReader::new(File::open(path).with_context(name)?);
    let mesh = stl_io::read_stl(&mut file).with_context(|| format!("{}: no STL file", name()))?;
    let corner = |index: usize| {
        let vertex = mesh.vertices[index].0.map(|value| f64::from(value) * unit_m);
        Vector3::from(vertex)
    };
    let triangles: Vec<Triangle> = mesh.faces.iter().map(|face| face.vertices.map(corner)).collect();
    Ok(Mesh::closed(triangles).with_context(name)?.on_the_table())
}
