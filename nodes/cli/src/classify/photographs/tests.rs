use super::*;
use std::path::PathBuf;

/// Stripes as wide as `period`: two of them are two different files.
fn picture(period: u8) -> Vec<u8> {
    let rows: Vec<u8> =
        (0..128_u8).flat_map(|y| [if y % period < period / 2 { 60 } else { 190 }; 128]).collect();
    let mut bytes = vec![];
    jpeg_encoder::Encoder::new(&mut bytes, 90)
        .encode(&rows, 128, 128, jpeg_encoder::ColorType::Luma)
        .unwrap();
    bytes
}

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str, manifest: &str) -> Self {
        let path = std::env::temp_dir().join(format!("fdm_photographs_{}_{name}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        std::fs::write(path.join("labels.csv"), manifest).unwrap();
        for (file, period) in [("a.jpg", 8), ("b.jpg", 16)] {
            std::fs::write(path.join(file), picture(period)).unwrap();
        }
        std::fs::copy(path.join("a.jpg"), path.join("a2.jpg")).unwrap();
        std::fs::write(path.join("nothing.jpg"), "").unwrap();
        Self(path)
    }

    fn read(&self, seen: &[u64]) -> anyhow::Result<Set> {
        read(&self.0.join("labels.csv"), Hidden(0.0), seen)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn refusal(name: &str, manifest: &str) -> String {
    format!("{:#}", Folder::new(name, manifest).read(&[]).unwrap_err())
}

#[test]
fn pictures_carry_their_label_and_a_group_of_their_own_where_none_is_given() {
    let folder =
        Folder::new("labels", "file,note,class,group\na.jpg,\"x, y\",strand,\nb.jpg,,clean,kitchen\n");
    let set = folder.read(&[]).unwrap();
    let rows: Vec<_> = set.photographs.iter().map(|row| (row.class.as_str(), row.group.as_str())).collect();
    assert_eq!(rows, [("strand", "a.jpg"), ("clean", "kitchen")]);
    assert_ne!(set.photographs[0].values, set.photographs[1].values);
}

#[test]
fn a_picture_that_was_trained_with_is_left_out() {
    let folder = Folder::new("seen", "file,class\na.jpg,strand\nb.jpg,clean\n");
    let set = folder.read(&[digest(&picture(8))]).unwrap();
    assert_eq!((set.left_out, set.photographs.len(), set.photographs[0].class.as_str()), (1, 1, "clean"));
}

#[test]
fn a_file_counts_once_and_has_one_label() {
    let set = Folder::new("twice", "file,class\na.jpg,strand\na.jpg,strand\n").read(&[]).unwrap();
    assert_eq!((set.merged, set.photographs.len()), (1, 1));
    let said = refusal("two", "file,class\na.jpg,strand\na.jpg,clean\n");
    assert!(said.ends_with("a.jpg is labelled strand and clean"), "{said}");
}

/// A copy under another name is the same picture; labels are counted with what is left out.
#[test]
fn a_picture_under_two_names_counts_once() {
    let manifest = "file,class\na.jpg,strand\na2.jpg,strand\nb.jpg,dragon\n";
    let set = Folder::new("copies", manifest).read(&[digest(&picture(16))]).unwrap();
    assert_eq!((set.merged, set.photographs.len(), set.left_out), (1, 1, 1));
    assert_eq!(set.labels, BTreeMap::from([("strand".to_owned(), 1), ("dragon".to_owned(), 1)]));
    let classes = ["ok", "strand"].map(str::to_owned);
    assert_eq!(set.unknown_labels(&classes), BTreeMap::from([("dragon".to_owned(), 1)]));
    assert!(set.check_labels(&classes).is_ok());
    let said = set.check_labels(&classes[..1]).unwrap_err().to_string();
    assert!(said.contains("dragon, strand") && said.ends_with("it knows ok"), "{said}");
    let said = refusal("copy", "file,class\na.jpg,strand\na2.jpg,clean\n");
    assert!(said.ends_with("a.jpg and a2.jpg are one picture, labelled strand and clean"), "{said}");
}

#[test]
fn what_cannot_be_read_is_named() {
    for (name, manifest, part) in [
        ("torn", "file,class\na.jpg,strand\nb.jpg\n", "line: 3"),
        ("column", "file,kind\na.jpg,strand\n", "missing field `class`"),
        ("picture", "file,class\nc.jpg,strand\n", "c.jpg"),
        ("itself", "file,class\nlabels.csv,strand\n", "labels.csv"),
        ("empty", "file,class\nnothing.jpg,strand\n", "nothing.jpg: an empty file"),
        ("head", "file,class\n", "no row"),
    ] {
        let said = refusal(name, manifest);
        assert!(said.contains(part), "{name}: {said}");
    }
    let said = read(Path::new("not/there.csv"), Hidden(0.0), &[]).unwrap_err().to_string();
    assert!(said.starts_with("not/there.csv is absent"), "{said}");
}

#[test]
fn the_list_of_seen_pictures_reads_as_it_was_written() {
    let folder = Folder::new("list", "file,class\n");
    assert!(seen(&folder.0).unwrap().is_empty());
    write_seen(&folder.0, BTreeSet::from([7, u64::MAX])).unwrap();
    assert_eq!(seen(&folder.0).unwrap(), [7, u64::MAX]);
}
