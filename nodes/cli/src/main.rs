//! fdm
fn main() {}
