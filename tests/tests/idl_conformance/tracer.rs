//! Walks a type through its `Deserialize`: which primitives it asks for, under which names, in which order.
//! One element of every sequence is walked, so that the element's type shows too.

use serde::de::value::Error;
use serde::de::{DeserializeOwned, DeserializeSeed, Deserializer, Error as _, SeqAccess, Visitor};
use serde::forward_to_deserialize_any;

/// Flattened fields of a type.
pub(crate) fn trace<T: DeserializeOwned>() -> Vec<(String, String)> {
    let mut flat = Vec::new();
    T::deserialize(Tracer { path: String::new(), flat: &mut flat }).expect("a type that CDR can carry");
    flat
}

struct Tracer<'a> {
    path: String,
    flat: &'a mut Vec<(String, String)>,
}

/// Answers a primitive with its default and notes it.
macro_rules! primitives {
    ($($deserialize:ident, $visit:ident, $name:literal, $value:expr;)*) => {$(
        fn $deserialize<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
            self.flat.push((self.path, $name.to_owned()));
            visitor.$visit($value)
        }
    )*};
}

impl<'de> Deserializer<'de> for Tracer<'_> {
    type Error = Error;

    primitives! {
        deserialize_bool, visit_bool, "bool", false;
        deserialize_i8, visit_i8, "i8", 0;
        deserialize_i16, visit_i16, "i16", 0;
        deserialize_i32, visit_i32, "i32", 0;
        deserialize_i64, visit_i64, "i64", 0;
        deserialize_u8, visit_u8, "u8", 0;
        deserialize_u16, visit_u16, "u16", 0;
        deserialize_u32, visit_u32, "u32", 0;
        deserialize_u64, visit_u64, "u64", 0;
        deserialize_f32, visit_f32, "f32", 0.0;
        deserialize_f64, visit_f64, "f64", 0.0;
        deserialize_str, visit_str, "string", "";
        deserialize_string, visit_str, "string", "";
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let path = format!("{}[]", self.path);
        visitor.visit_seq(Elements { path, left: 1, flat: self.flat })
    }

    fn deserialize_byte_buf<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.flat.push((format!("{}[]", self.path), "u8".to_owned()));
        visitor.visit_bytes(&[])
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Error> {
        let path = format!("{}[{length}]", self.path);
        let noted = self.flat.len();
        let value = visitor.visit_seq(Elements { path: path.clone(), left: length, flat: self.flat })?;
        // Equal elements stand for one.
        let mut seen = false;
        let mut index = 0;
        self.flat.retain(|(known, _)| {
            index += 1;
            index <= noted || *known != path || !std::mem::replace(&mut seen, true)
        });
        Ok(value)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_seq(Members { path: self.path, fields: fields.iter(), flat: self.flat })
    }

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
        Err(Error::custom(format!("{}: CDR cannot carry this type", self.path)))
    }

    forward_to_deserialize_any! {
        i128 u128 char bytes option unit unit_struct newtype_struct tuple_struct map enum identifier ignored_any
    }
}

/// Elements of a sequence or an array.
struct Elements<'a> {
    path: String,
    left: usize,
    flat: &'a mut Vec<(String, String)>,
}

impl<'de> SeqAccess<'de> for Elements<'_> {
    type Error = Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Error> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        seed.deserialize(Tracer { path: self.path.clone(), flat: self.flat }).map(Some)
    }
}

/// Fields of a struct.
struct Members<'a> {
    path: String,
    fields: std::slice::Iter<'static, &'static str>,
    flat: &'a mut Vec<(String, String)>,
}

impl<'de> SeqAccess<'de> for Members<'_> {
    type Error = Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Error> {
        let Some(field) = self.fields.next() else { return Ok(None) };
        let path = if self.path.is_empty() { (*field).to_owned() } else { format!("{}.{field}", self.path) };
        seed.deserialize(Tracer { path, flat: self.flat }).map(Some)
    }
}
