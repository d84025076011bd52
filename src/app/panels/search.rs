//! The pictures of the project by name: a field that shows once there are many, and what it finds.

use super::super::studio::Studio;
use crate::document::PhotoId;
use egui::{TextEdit, Ui, WidgetInfo};
use std::sync::Arc;

/// Pictures that an eye finds without a field for it.
const FEW: usize = 24;

/// What is looked for, and what was found.
#[derive(Default)]
pub(super) struct Search {
    text: String,
    /// What was found, with the state of the project and the words that it was found by.
    found: Option<(u64, String, Arc<[PhotoId]>)>,
}

impl Search {
    /// The field, where there are many pictures.
    pub(super) fn field(&mut self, ui: &mut Ui, studio: &Studio) {
        let count = studio.document().state().content().photos.len();
        if count <= FEW {
            self.text.clear();
            return;
        }
        let field = TextEdit::singleline(&mut self.text)
            .hint_text("Search")
            .desired_width(ui.available_width().min(180.0));
        let field = ui.add(field);
        field.widget_info(|| WidgetInfo {
            label: Some("Search pictures".to_owned()),
            ..WidgetInfo::text_edit(true, "", &self.text, "Search")
        });
        field.on_hover_text("Shows pictures whose names contain all these words.");
    }

    /// The pictures whose names contain all words of the field, in the order of the project.
    pub(super) fn found(&mut self, studio: &Studio) -> Arc<[PhotoId]> {
        let generation = studio.generation;
        if let Some((of, text, found)) = &self.found
            && (*of, text) == (generation, &self.text)
        {
            return Arc::clone(found);
        }
        let photos = &studio.document().state().content().photos;
        let words = words(&self.text);
        let found = photos
            .iter()
            .filter(|(_, photo)| matches(&photo.name, &words));
        let found: Arc<[PhotoId]> = found.map(|(id, _)| *id).collect();
        self.found = Some((generation, self.text.clone(), Arc::clone(&found)));
        found
    }
}

fn words(text: &str) -> Vec<String> {
    text.split_whitespace().map(str::to_lowercase).collect()
}

fn matches(name: &str, words: &[String]) -> bool {
    if words.is_empty() {
        return true;
    }
    let name = name.to_lowercase();
    words.iter().all(|word| name.contains(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_match_by_all_words_whatever_the_case() {
        let is_found = |name: &str, text: &str| matches(name, &words(text));
        assert!(is_found("Oak_03 Winter.png", "winter OAK"));
        assert!(is_found("Дерево.png", "дерев"));
        assert!(is_found("oak.png", "  "));
        assert!(!is_found("oak.png", "oak winter"));
    }
}
