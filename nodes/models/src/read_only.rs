//! Checked parameters are read through `Deref` to the raw struct and never written: there is no `DerefMut`.

/// Gives `$checked(raw)` read access to every field of its raw struct.
macro_rules! read_only {
    ($checked:ident($raw:ident)) => {
        impl std::ops::Deref for $checked {
            type Target = $raw;
            fn deref(&self) -> &$raw {
                &self.0
            }
        }
    };
}
