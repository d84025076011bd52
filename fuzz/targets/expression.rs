//! Any text as a formula: a value at every place, or a mistake with its column.
#![no_main]

use boscage::crown::Expression;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    match Expression::parse(text) {
        Ok(formula) => {
            for (i, j) in [(0.0, 0.0), (0.25, 0.75), (1.0, 1.0)] {
                formula.value(i, j);
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
