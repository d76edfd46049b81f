//! Reads `.msg` text.

use fdm_loop_msgs::Definition;

/// One field as written.
pub(crate) struct Field<'a> {
    pub(crate) type_name: &'a str,
    pub(crate) name: &'a str,
    pub(crate) comment: &'a str,
}

/// Fields of a definition, constants and comments left out.
pub(crate) fn fields_of(text: &str) -> impl Iterator<Item = Field<'_>> {
    text.lines().filter_map(|line| {
        let (code, comment) = line.split_once('#').unwrap_or((line, ""));
        let mut words = code.split_whitespace();
        let (type_name, name) = (words.next()?, words.next()?);
        (!name.contains('=')).then(|| Field { type_name, name, comment: comment.trim() })
    })
}

/// Rust name of a primitive type.
fn primitive(name: &str) -> Option<String> {
    let rust = match name {
        "bool" => "bool",
        "string" => "string",
        "byte" | "char" => "u8",
        "float32" => "f32",
        "float64" => "f64",
        _ => {
            let (sign, bits) = match name.strip_prefix("uint") {
                Some(bits) => ("u", bits),
                None => ("i", name.strip_prefix("int")?),
            };
            return Some(format!("{sign}{bits}"));
        }
    };
    Some(rust.to_owned())
}

/// Fields down to primitives; nested types are looked up among the dependencies of `definition`.
pub(crate) fn flatten(text: &str, definition: &Definition) -> Vec<(String, String)> {
    let mut flat = Vec::new();
    for field in fields_of(text) {
        let (element, suffix) = match field.type_name.split_once('[') {
            // A bound is no length: on the wire it is a sequence like any other.
            Some((element, length)) if length.starts_with("<=") => (element, "[]".to_owned()),
            Some((element, length)) => (element, format!("[{length}")),
            None => (field.type_name, String::new()),
        };
        let path = format!("{}{suffix}", field.name);
        if let Some(rust) = primitive(element) {
            flat.push((path, rust));
            continue;
        }
        let is_it = |part: &&&'static Definition| format!("{}/{}", part.package, part.name) == element;
        let part = definition.dependencies.iter().find(is_it).unwrap_or_else(|| {
            panic!("{}: {element} is not among the dependencies of {}", field.name, definition.name)
        });
        flat.extend(
            flatten(part.text, part).into_iter().map(|(below, rust)| (format!("{path}.{below}"), rust)),
        );
    }
    flat
}

/// Fields of a part of a service.
pub(crate) fn flatten_part(
    text: &str,
    dependencies: &'static [&'static Definition],
) -> Vec<(String, String)> {
    flatten(text, &Definition { package: "", name: "service", text: "", dependencies })
}
