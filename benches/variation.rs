//! Measurements of the variation pipeline.

fn main() {}
