//! STL files as closed meshes.

use anyhow::{Context, anyhow, bail};
use models::hybrid::Mesh;
use models::hybrid::mesh::Triangle;
use nalgebra::Vector3;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// Reads a part, binary or ASCII, and places it on the table; `unit_m` is the length of one unit of the file.
///
/// # Errors
/// A file that cannot be read, is larger than is read, or is no STL file; a mesh that is not closed.
pub fn read(path: &Path, unit_m: f64) -> anyhow::Result<Mesh> {
    let name = || path.display().to_string();
    let file = runtime::input::open(path).with_context(name)?;
    let length = file.metadata().with_context(name)?.len();
    if length > MOST {
        bail!("{}: {length} bytes: must be at most {MOST}, of an STL file that is read", name());
    }
    let mut file = BufReader::new(file);
    let mesh = match stl_io::read_stl(&mut file) {
        Ok(mesh) => mesh,
        Err(error) => {
            let wrong = wrong(path).unwrap_or_else(|| error.to_string());
            return Err(anyhow!("{}: not an STL file: {wrong}", name()));
        }
    };
    if mesh.faces.is_empty() {
        bail!(
            "{}: not an STL file: {}",
            name(),
            wrong(path).unwrap_or_else(|| "without a triangle".to_owned())
        );
    }
    let corner = |index: usize| {
        let vertex = mesh.vertices[index].0.map(|value| f64::from(value) * unit_m);
        Vector3::from(vertex)
    };
    let triangles: Vec<Triangle> = mesh.faces.iter().map(|face| face.vertices.map(corner)).collect();
    Ok(Mesh::closed(triangles).with_context(name)?.on_the_table())
}

/// Length of the header of a binary file with the number of its triangles, and of a triangle `[bytes]`.
const HEADER: u64 = 84;
/// Longest file that is read `[bytes]`: five million triangles.
const MOST: u64 = 256 << 20;
const TRIANGLE: u64 = 50;

/// What a file's size and first bytes tell of the reason; none where they tell nothing.
fn wrong(path: &Path) -> Option<String> {
    let length = std::fs::metadata(path).ok()?.len();
    if length == 0 {
        return Some("empty".to_owned());
    }
    let mut head = Vec::new();
    File::open(path).ok()?.take(HEADER).read_to_end(&mut head).ok()?;
    if head.starts_with(b"solid") {
        return None;
    }
    let Some(count) = head.get(80..84).and_then(|bytes| <[u8; 4]>::try_from(bytes).ok()) else {
        return Some(format!(
            "{length} bytes, neither the word 'solid' nor the {HEADER} bytes of a binary header at its begin"
        ));
    };
    let count = u64::from(u32::from_le_bytes(count));
    let wanted = HEADER + TRIANGLE * count;
    (wanted > length).then(|| {
        format!("no word 'solid' at its begin, and {length} bytes where {count} triangles of its header take {wanted}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(name: &str, bytes: &[u8]) -> String {
        let path = std::env::temp_dir().join(format!("fdm_{}_{name}", std::process::id()));
        std::fs::write(&path, bytes).unwrap();
        let error = read(&path, 1e-3).unwrap_err();
        std::fs::remove_file(&path).unwrap();
        format!("{error:#}")
    }

    /// Zeros without end, and a file of zeros longer than is read, which takes no room on the disk.
    #[test]
    fn a_device_and_an_endless_file_are_refused_unread() {
        let zero = format!("{:#}", read(Path::new("/dev/zero"), 1e-3).unwrap_err());
        assert!(zero.contains("/dev/zero: not a file"), "{zero}");
        let path = std::env::temp_dir().join(format!("fdm_{}_long.stl", std::process::id()));
        File::create(&path).unwrap().set_len(MOST + 1).unwrap();
        let long = read(&path, 1e-3).unwrap_err().to_string();
        std::fs::remove_file(&path).unwrap();
        assert!(long.contains("268435457 bytes: must be at most 268435456"), "{long}");
    }

    #[test]
    fn what_is_no_stl_file_says_why() {
        assert!(said("empty.stl", b"").ends_with("not an STL file: empty"));
        let text = said("text.stl", b"# a part");
        assert!(text.contains("not an STL file: 8 bytes, neither the word 'solid'"), "{text}");
        let mut short = vec![b' '; 80];
        short.extend(12_u32.to_le_bytes());
        short.extend([0; 50]);
        let short = said("short.stl", &short);
        assert!(short.contains("134 bytes where 12 triangles of its header take 684"), "{short}");
        let none = said("none.stl", b"solid nothing\nendsolid nothing\n");
        assert!(none.contains("not an STL file: without a triangle"), "{none}");
    }
}
