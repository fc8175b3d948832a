//! Escaping of text for XML and HTML.

use std::borrow::Cow;

/// The text with `& < > " '` as entities and control characters, which XML forbids, left out.
pub(crate) fn escape(text: &str) -> Cow<'_, str> {
    let special = |c: char| {
        matches!(c, '&' | '<' | '>' | '"' | '\'' | '\u{fffe}' | '\u{ffff}')
            || (c.is_control() && !matches!(c, '\n' | '\t'))
    };
    if !text.contains(special) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            _ if special(c) => {}
            _ => out.push(c),
        }
    }
    Cow::Owned(out)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::{any, proptest};

    use super::escape;

    #[test]
    fn markup_becomes_text() {
        assert_eq!(
            escape("<b onclick=\"x('y')\">a & b</b>"),
            "&lt;b onclick=&quot;x(&#39;y&#39;)&quot;&gt;a &amp; b&lt;/b&gt;"
        );
    }

    proptest! {
        #[test]
        fn escaped_text_reads_back_from_an_element_and_an_attribute(text in any::<String>()) {
            let kept: String = text
                .chars()
                .filter(|&c| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}'))
                .collect();
            let xml = format!("<a b=\"{0}\">{0}</a>", escape(&kept));
            let document = roxmltree::Document::parse(&xml).expect("escaped text is valid XML");
            let root = document.root_element();
            assert_eq!(root.text().unwrap_or(""), kept);
            assert_eq!(root.attribute("b"), Some(kept.as_str()));
        }
    }
}
