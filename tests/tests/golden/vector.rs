//! Reading vectors and comparing figures.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::{Map, Value};

/// Computes a vector's figures from its inputs, under the names of the expected ones.
pub(crate) type Handler = fn(&Set, Inputs<'_>) -> Result<Value, String>;

/// One file.
#[derive(Deserialize)]
pub(crate) struct Set {
    #[serde(skip)]
    pub(crate) path: PathBuf,
    pub(crate) system: String,
    pub(crate) vectors: Vec<Vector>,
    /// Nominal parameters and whatever else stands beside the vectors.
    #[serde(flatten)]
    pub(crate) header: Map<String, Value>,
}

/// One reference computation.
#[derive(Deserialize)]
pub(crate) struct Vector {
    pub(crate) id: String,
    pub(crate) function: String,
    inputs: Value,
    expected: Map<String, Value>,
    tol: Tolerance,
}

/// `|got - expected| <= abs + rel |expected|`, element by element.
#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct Tolerance {
    rel: f64,
    abs: f64,
}

/// What became of one vector.
pub(crate) enum Outcome {
    Passed,
    Pending,
    Failed(String),
}

impl Set {
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let value = serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
        Self::parse(path.to_owned(), value)
    }

    pub(crate) fn parse(path: PathBuf, value: Value) -> Result<Self, String> {
        let set: Self =
            serde_json::from_value(value).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Self { path, ..set })
    }

    /// A block of the header.
    pub(crate) fn block(&self, name: &str) -> Result<Inputs<'_>, String> {
        self.header.get(name).map(Inputs).ok_or_else(|| format!("header has no `{name}`"))
    }
}

/// Named values of a vector or of a header block.
#[derive(Clone, Copy)]
pub(crate) struct Inputs<'a>(&'a Value);

impl<'a> Inputs<'a> {
    fn value(self, name: &str) -> Result<&'a Value, String> {
        self.0.get(name).ok_or_else(|| format!("no input `{name}`"))
    }

    pub(crate) fn block(self, name: &str) -> Result<Self, String> {
        self.value(name).map(Inputs)
    }

    pub(crate) fn num(self, name: &str) -> Result<f64, String> {
        self.value(name)?.as_f64().ok_or_else(|| format!("input `{name}` is not a number"))
    }

    /// A number, or `None` for null.
    pub(crate) fn optional(self, name: &str) -> Result<Option<f64>, String> {
        if self.value(name)?.is_null() { Ok(None) } else { self.num(name).map(Some) }
    }

    pub(crate) fn count(self, name: &str) -> Result<u32, String> {
        let number = self.value(name)?.as_u64().and_then(|number| u32::try_from(number).ok());
        number.ok_or_else(|| format!("input `{name}` is not a count"))
    }

    pub(crate) fn text(self, name: &str) -> Result<&'a str, String> {
        self.value(name)?.as_str().ok_or_else(|| format!("input `{name}` is not a text"))
    }

    pub(crate) fn nums(self, name: &str) -> Result<Vec<f64>, String> {
        numbers(self.value(name)?).ok_or_else(|| format!("input `{name}` is not a list of numbers"))
    }

    pub(crate) fn array<const N: usize>(self, name: &str) -> Result<[f64; N], String> {
        let list = self.nums(name)?;
        let length = list.len();
        list.try_into().map_err(|_| format!("input `{name}` has {length} numbers instead of {N}"))
    }

    pub(crate) fn pairs(self, name: &str) -> Result<Vec<[f64; 2]>, String> {
        let wrong = || format!("input `{name}` is not a list of pairs");
        let rows = self.value(name)?.as_array().ok_or_else(wrong)?;
        let pair = |row: &Value| numbers(row).and_then(|row| row.try_into().ok());
        rows.iter().map(pair).collect::<Option<_>>().ok_or_else(wrong)
    }

    pub(crate) fn matrix<const N: usize>(self, name: &str) -> Result<[[f64; N]; N], String> {
        let wrong = || format!("input `{name}` is not a {N} x {N} matrix");
        let rows = self.value(name)?.as_array().ok_or_else(wrong)?;
        let rows: Vec<[f64; N]> = rows
            .iter()
            .map(|row| numbers(row).and_then(|row| row.try_into().ok()))
            .collect::<Option<_>>()
            .ok_or_else(wrong)?;
        rows.try_into().map_err(|_| wrong())
    }
}

fn numbers(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(Value::as_f64).collect()
}

pub(crate) fn check(set: &Set, vector: &Vector, handler: Handler) -> Outcome {
    if vector.expected.is_empty() {
        return Outcome::Failed("nothing is expected".into());
    }
    let got = match handler(set, Inputs(&vector.inputs)) {
        Ok(got) => got,
        Err(reason) => return Outcome::Failed(reason),
    };
    let mut differences = Vec::new();
    for (name, expected) in &vector.expected {
        match got.get(name) {
            Some(got) => compare(name, got, expected, vector.tol, &mut differences),
            None => differences.push(format!("{name} was not computed")),
        }
    }
    if differences.is_empty() { Outcome::Passed } else { Outcome::Failed(differences.join(", ")) }
}

fn compare(name: &str, got: &Value, expected: &Value, tol: Tolerance, differences: &mut Vec<String>) {
    if let (Some(got), Some(expected)) = (got.as_f64(), expected.as_f64()) {
        // Negated, so that a NaN is a difference too.
        let met = (got - expected).abs() <= tol.abs + tol.rel * expected.abs();
        if !met {
            differences.push(format!("{name} = {got}, expected {expected}"));
        }
        return;
    }
    if got.is_null() && expected.is_null() {
        return;
    }
    match (got.as_array(), expected.as_array()) {
        (Some(got), Some(expected)) if got.len() == expected.len() => {
            for (index, (got, expected)) in got.iter().zip(expected).enumerate() {
                compare(&format!("{name}[{index}]"), got, expected, tol, differences);
            }
        }
        _ => differences.push(format!("{name} = {got}, expected {expected}")),
    }
}
