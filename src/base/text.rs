//! Text that others wrote, made fit for one line of ours.

/// `text` on one line that does what it looks like: control characters, line breaks and invisible
/// marks that reorder or hide text become `\u{…}`.
///
/// File names and messages of decoders go through this before a terminal or a log sees them.
///
/// ```
/// use boscage::base::one_line;
/// assert_eq!(one_line("a\nb\u{202e}gnp.exe"), r"a\u{a}b\u{202e}gnp.exe");
/// ```
pub fn one_line(text: &str) -> String {
    let mut line = String::with_capacity(text.len());
    for character in text.chars() {
        if character.is_control() || is_invisible(character) {
            line.extend(character.escape_unicode());
        } else {
            line.push(character);
        }
    }
    line
}

/// [`one_line`] of a length that can be read: what is longer loses its middle, for the name of a file
/// stands at the beginning of a message and the reason at its end.
pub fn brief_line(text: &str) -> String {
    const LONGEST: usize = 400;
    let line = one_line(text);
    let count = line.chars().count();
    if count <= LONGEST {
        return line;
    }
    let half = LONGEST / 2;
    let begin: String = line.chars().take(half).collect();
    let end: String = line.chars().skip(count - half).collect();
    format!("{begin} … {end}")
}

/// Line and paragraph separators, zero-width characters, and the marks that turn the direction.
fn is_invisible(character: char) -> bool {
    matches!(character,
        '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}'
        | '\u{feff}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_can_be_seen_stays() {
        let text = "Ахорн 木 – tree (3).png";
        assert_eq!(one_line(text), text);
    }

    #[test]
    fn a_brief_line_keeps_both_ends() {
        let line = brief_line(&format!("ä.png: {}: the reason", "x".repeat(5000)));
        assert!(line.starts_with("ä.png: x") && line.ends_with("x: the reason"));
        assert!(line.chars().count() < 410);
        assert_eq!(brief_line("a\nb"), one_line("a\nb"));
    }

    #[test]
    fn nothing_moves_the_cursor() {
        let line = one_line("\x1b[2J\r\t\u{7f}\u{85}\u{2028}\u{200d}");
        assert!(line.chars().all(|c| c.is_ascii_graphic()), "{line}");
    }
}
