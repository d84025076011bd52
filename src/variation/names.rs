//! What names of pictures tell of the trees in them.

/// What `words` tell of the picture `name`: the first of them counts that a word of the name begins with.
pub fn named<T: Copy>(name: &str, words: &[(&str, T)]) -> Option<T> {
    let name = name.to_lowercase();
    let own: Vec<&str> = name.split(|c: char| !c.is_alphabetic()).collect();
    let is_in_name = |word: &&(&str, T)| own.iter().any(|own| own.starts_with(word.0));
    words.iter().find(is_in_name).map(|word| word.1)
}
