//! What was built.

/// Version and commit of this build: `0.1.0+1ce8509a1b2c`.
#[must_use]
pub fn build() -> &'static str {
    concat!(env!("CARGO_PKG_VERSION"), "+", env!("FDM_COMMIT"))
}
