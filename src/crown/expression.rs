//! Expressions that artists type: k as a formula in i and j.
//!
//! Numbers, `i`, `j`, `pi`, `e`, + − * / ^, parentheses, and the functions of [`FUNCTIONS`] and
//! [`PAIR_FUNCTIONS`]. As in mathematics, ^ binds tighter than a sign (−2^2 = −4) and groups from the
//! right.
//!
//! The crate `exmex` evaluates. What is typed is first read here: exmex's messages name no place, it
//! takes any unknown word for a variable, gives a sign more weight than ^ and knows no nested
//! functions of two arguments. So a reader of our own finds mistakes with their column and hands
//! exmex a text in which every operation stands in parentheses. Functions come from `libm`, so
//! values are the same on every machine. Length and depth are limited, hence nothing can hang or
//! overflow the stack.

use exmex::{BinOp, Express as _, FlatEx, MakeOperators, Operator};

/// Most bytes of an expression.
const LONGEST: usize = 1000;

/// Most nested parentheses, signs and powers.
const DEEPEST: usize = 40;

type Function = fn(f64) -> f64;

type PairFunction = fn(f64, f64) -> f64;

/// Functions of one argument.
const FUNCTIONS: [(&str, Function); 16] = [
    ("sin", libm::sin),
    ("cos", libm::cos),
    ("tan", libm::tan),
    ("asin", libm::asin),
    ("acos", libm::acos),
    ("atan", libm::atan),
    ("tanh", libm::tanh),
    ("sqrt", libm::sqrt),
    ("exp", libm::exp),
    ("ln", libm::log),
    ("log", libm::log10),
    ("abs", libm::fabs),
    ("floor", libm::floor),
    ("ceil", libm::ceil),
    ("round", libm::round),
    ("sign", sign),
];

/// Functions of two arguments.
const PAIR_FUNCTIONS: [(&str, PairFunction); 3] =
    [("min", f64::min), ("max", f64::max), ("pow", libm::pow)];

fn sign(value: f64) -> f64 {
    f64::from(i8::from(value > 0.0) - i8::from(value < 0.0))
}

/// What is wrong with an expression, and where: columns count characters from 1.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ExpressionError {
    /// Nothing but spaces.
    #[error("the expression is empty")]
    Empty,
    /// Longer than is read.
    #[error("the expression is longer than {LONGEST} characters")]
    TooLong,
    /// Too many things inside one another.
    #[error("column {column}: more than {DEEPEST} levels inside one another")]
    TooDeep {
        /// Where.
        column: usize,
    },
    /// A character that means nothing here.
    #[error("column {column}: '{found}' means nothing here")]
    Character {
        /// Where.
        column: usize,
        /// The character.
        found: char,
    },
    /// A number that is none.
    #[error("column {column}: '{found}' is no number")]
    Number {
        /// Where.
        column: usize,
        /// What was written.
        found: String,
    },
    /// A word that is not known.
    #[error(
        "column {column}: '{found}' is not known; there are i, j, pi, e, sin, cos, tan, asin, acos, atan, tanh, sqrt, exp, ln, log, abs, floor, ceil, round, sign, min, max, pow"
    )]
    Word {
        /// Where.
        column: usize,
        /// The word.
        found: String,
    },
    /// Something else was expected.
    #[error("column {column}: {expected} is expected here")]
    Expected {
        /// Where.
        column: usize,
        /// What.
        expected: &'static str,
    },
}

/// A checked formula in i and j.
#[derive(Debug, Clone)]
pub struct Expression {
    text: String,
    /// Twenty kilobytes.
    formula: Box<FlatEx<f64, Functions>>,
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

impl Expression {
    /// Reads an expression.
    ///
    /// ```
    /// use boscage::crown::Expression;
    /// let k = Expression::parse("2 + sin(pi*j) - i^2").unwrap();
    /// assert!((k.value(1.0, 0.5) - 2.0).abs() < 1e-15);
    /// let typo = Expression::parse("2 + sine(j)").unwrap_err().to_string();
    /// assert!(typo.starts_with("column 5: 'sine' is not known"));
    /// ```
    ///
    /// # Errors
    /// [`ExpressionError`], with the column.
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        if text.len() > LONGEST {
            return Err(ExpressionError::TooLong);
        }
        let tokens = tokens(text)?;
        if tokens.len() == 1 {
            return Err(ExpressionError::Empty);
        }
        let mut reader = Reader {
            tokens,
            at: 0,
            depth: 0,
        };
        let canonical = reader.sum()?;
        if reader.token().kind != Kind::End {
            return Err(reader.expected("an operator, or the end,"));
        }
        // Every operation in parentheses: nothing is left for exmex to misread.
        let formula = FlatEx::parse(&canonical).map_err(|_| ExpressionError::Expected {
            column: 1,
            expected: "another formula",
        })?;
        Ok(Self {
            text: text.to_owned(),
            formula: Box::new(formula),
        })
    }

    /// As it was typed.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Its value, which may be infinite or no number.
    pub fn value(&self, i: f64, j: f64) -> f64 {
        let names = self.formula.var_names();
        let values: Vec<f64> = names
            .iter()
            .map(|name| if name == "i" { i } else { j })
            .collect();
        self.formula.eval(&values).unwrap_or(f64::NAN)
    }
}

/// The operators that exmex is given.
#[derive(Debug, Clone)]
struct Functions;

impl MakeOperators<f64> for Functions {
    fn make<'a>() -> Vec<Operator<'a, f64>> {
        let pair = |name: &'static str, apply: PairFunction| {
            let is_commutative = false;
            Operator::make_bin(
                name,
                BinOp {
                    apply,
                    prio: 1,
                    is_commutative,
                },
            )
        };
        let mut all = vec![
            pair("+", |a, b| a + b),
            Operator::make_bin_unary(
                "-",
                BinOp {
                    apply: |a, b| a - b,
                    prio: 1,
                    is_commutative: false,
                },
                |a| -a,
            ),
            pair("*", |a, b| a * b),
            pair("/", |a, b| a / b),
            pair("^", libm::pow),
        ];
        all.extend(FUNCTIONS.map(|(name, apply)| Operator::make_unary(name, apply)));
        all.extend(PAIR_FUNCTIONS.map(|(name, apply)| pair(name, apply)));
        all
    }
}

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    /// As exmex reads it.
    Number(String),
    Word(String),
    Sign(char),
    End,
}

#[derive(Debug, Clone, PartialEq)]
struct Token {
    column: usize,
    kind: Kind,
}

/// The tokens of `text`, the last one being its end.
fn tokens(text: &str) -> Result<Vec<Token>, ExpressionError> {
    let characters: Vec<char> = text.chars().collect();
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(&first) = characters.get(at) {
        let column = at + 1;
        let rest = &characters[at..];
        let run = |belongs: fn(&char) -> bool| -> String {
            rest.iter().copied().take_while(belongs).collect()
        };
        let (length, kind) = match first {
            ' ' | '\t' => {
                at += 1;
                continue;
            }
            '0'..='9' | '.' => {
                let found = run(|c| c.is_ascii_digit() || *c == '.');
                match found.parse::<f64>() {
                    Ok(value) if value.is_finite() => (found.len(), Kind::Number(decimal(value))),
                    _ => return Err(ExpressionError::Number { column, found }),
                }
            }
            'a'..='z' | 'A'..='Z' | '_' => {
                let word = run(|c| c.is_ascii_alphanumeric() || *c == '_');
                (word.len(), Kind::Word(word))
            }
            '+' | '-' | '*' | '/' | '^' | '(' | ')' | ',' => (1, Kind::Sign(first)),
            found => return Err(ExpressionError::Character { column, found }),
        };
        at += length;
        tokens.push(Token { column, kind });
    }
    tokens.push(Token {
        column: characters.len() + 1,
        kind: Kind::End,
    });
    Ok(tokens)
}

/// A number without an exponent, which exmex would not read, and with all its digits.
fn decimal(value: f64) -> String {
    format!("{value}")
}

/// Reads tokens by recursive descent and writes every operation in parentheses.
struct Reader {
    tokens: Vec<Token>,
    at: usize,
    depth: usize,
}

impl Reader {
    fn token(&self) -> &Token {
        &self.tokens[self.at.min(self.tokens.len() - 1)]
    }

    fn expected(&self, expected: &'static str) -> ExpressionError {
        ExpressionError::Expected {
            column: self.token().column,
            expected,
        }
    }

    /// Passes the next token if it is one of `signs`.
    fn passed(&mut self, signs: &[char]) -> Option<char> {
        match self.token().kind {
            Kind::Sign(sign) if signs.contains(&sign) => {
                self.at += 1;
                Some(sign)
            }
            _ => None,
        }
    }

    fn demand(&mut self, sign: char, expected: &'static str) -> Result<(), ExpressionError> {
        match self.passed(&[sign]) {
            Some(_) => Ok(()),
            None => Err(self.expected(expected)),
        }
    }

    /// Reads one level further in.
    fn deeper(
        &mut self,
        read: fn(&mut Self) -> Result<String, ExpressionError>,
    ) -> Result<String, ExpressionError> {
        if self.depth == DEEPEST {
            return Err(ExpressionError::TooDeep {
                column: self.token().column,
            });
        }
        self.depth += 1;
        let text = read(self)?;
        self.depth -= 1;
        Ok(text)
    }

    fn sum(&mut self) -> Result<String, ExpressionError> {
        let mut left = self.product()?;
        while let Some(sign) = self.passed(&['+', '-']) {
            left = format!("({left}{sign}{})", self.product()?);
        }
        Ok(left)
    }

    fn product(&mut self) -> Result<String, ExpressionError> {
        let mut left = self.signed()?;
        while let Some(sign) = self.passed(&['*', '/']) {
            left = format!("({left}{sign}{})", self.signed()?);
        }
        Ok(left)
    }

    fn signed(&mut self) -> Result<String, ExpressionError> {
        match self.passed(&['+', '-']) {
            Some('-') => Ok(format!("(-({}))", self.deeper(Self::signed)?)),
            Some(_) => self.deeper(Self::signed),
            None => self.power(),
        }
    }

    fn power(&mut self) -> Result<String, ExpressionError> {
        let base = self.atom()?;
        match self.passed(&['^']) {
            Some(_) => Ok(format!("({base}^{})", self.deeper(Self::signed)?)),
            None => Ok(base),
        }
    }

    fn atom(&mut self) -> Result<String, ExpressionError> {
        match self.token().kind.clone() {
            Kind::Number(text) => {
                self.at += 1;
                Ok(text)
            }
            Kind::Word(word) => self.named(&word),
            Kind::Sign('(') => {
                self.at += 1;
                let inner = self.deeper(Self::sum)?;
                self.demand(')', "an operator or ')'")?;
                Ok(format!("({inner})"))
            }
            Kind::Sign(_) | Kind::End => Err(self.expected("a number, a name or '('")),
        }
    }

    /// A variable, a constant or a function with its arguments.
    fn named(&mut self, word: &str) -> Result<String, ExpressionError> {
        let column = self.token().column;
        self.at += 1;
        match word {
            "i" | "j" => return Ok(word.to_owned()),
            "pi" => return Ok(format!("{:?}", std::f64::consts::PI)),
            "e" => return Ok(format!("{:?}", std::f64::consts::E)),
            _ => {}
        }
        let has_pair = PAIR_FUNCTIONS.iter().any(|(name, _)| *name == word);
        if !has_pair && !FUNCTIONS.iter().any(|(name, _)| *name == word) {
            return Err(ExpressionError::Word {
                column,
                found: word.to_owned(),
            });
        }
        self.demand('(', "'(' and the function's argument")?;
        let first = self.deeper(Self::sum)?;
        let text = if has_pair {
            self.demand(',', "',' and a second argument")?;
            format!("(({first}) {word} ({}))", self.deeper(Self::sum)?)
        } else {
            format!("({word}({first}))")
        };
        self.demand(')', "an operator or ')'")?;
        Ok(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn value(text: &str) -> f64 {
        Expression::parse(text).unwrap().value(0.25, 0.75)
    }

    fn message(text: &str) -> String {
        Expression::parse(text).unwrap_err().to_string()
    }

    #[test]
    fn formulas_mean_what_they_mean_in_mathematics() {
        let cases = [
            ("3", 3.0),
            ("1+4*j", 4.0),
            ("3*(1-i)", 2.25),
            ("-2^2", -4.0),
            ("2^3^2", 512.0),
            ("2^-1", 0.5),
            ("1-2-3", -4.0),
            ("8/4/2", 1.0),
            ("2*-3", -6.0),
            ("min(1, max(i, j))", 0.75),
            ("max(min(i,j),min(1,2))+1", 2.0),
            ("abs(-i) + .5", 0.75),
            ("floor(9*j) - sign(-i)", 7.0),
            ("j-i", 0.5),
            ("0.0000001*1e", 0.0000001 * std::f64::consts::E),
        ];
        for (text, expected) in cases {
            if text.ends_with('e') {
                // Two factors without a sign between them are a mistake, not a product.
                assert!(Expression::parse(text).is_err());
                continue;
            }
            assert!(
                (value(text) - expected).abs() < 1e-12,
                "{text}: {}",
                value(text)
            );
        }
        assert!(
            (value("2+sin(pi*j)") - (2.0 + libm::sin(0.75 * std::f64::consts::PI))).abs() < 1e-15
        );
        assert!((value("ln(e^3)") - 3.0).abs() < 1e-14);
        assert!(value("1/0").is_infinite() && value("sqrt(0-1)").is_nan());
    }

    #[test]
    fn mistakes_are_told_with_their_column() {
        assert!(message("1+4*x").starts_with("column 5: 'x' is not known"));
        assert_eq!(
            message("1+"),
            "column 3: a number, a name or '(' is expected here"
        );
        assert_eq!(
            message("(1+2"),
            "column 5: an operator or ')' is expected here"
        );
        assert_eq!(
            message("1 2"),
            "column 3: an operator, or the end, is expected here"
        );
        assert_eq!(
            message("min(1)"),
            "column 6: ',' and a second argument is expected here"
        );
        assert_eq!(message("2 § 3"), "column 3: '§' means nothing here");
        assert_eq!(message("1.2.3"), "column 1: '1.2.3' is no number");
        assert_eq!(message("  "), "the expression is empty");
        assert!(message(&"(".repeat(999)).contains("levels"));
        assert!(message(&"-".repeat(999)).contains("levels"));
        assert!(message(&"1+".repeat(999)).contains("longer"));
    }

    #[test]
    fn the_longest_and_deepest_are_read() {
        let long = format!("1{}", "+i".repeat(499));
        assert!((value(&long) - 125.75).abs() < 1e-9);
        let deep = format!("{}1{}", "(".repeat(40), ")".repeat(40));
        assert_eq!(value(&deep), 1.0);
    }

    proptest! {
        #[test]
        fn nothing_that_is_typed_panics(text in "[0-9ij.+*/^(),a-z -]{0,60}") {
            if let Ok(expression) = Expression::parse(&text) {
                expression.value(0.5, 0.5);
            }
        }
    }
}
