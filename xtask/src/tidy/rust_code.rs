//! Rust source reduced to its code: strings, characters and comments are blanked.

/// The source with every character of a comment, string or character literal replaced by a space.
/// Line breaks stay, so that line numbers do.
pub(super) fn mask(source: &str) -> String {
    let letters: Vec<char> = source.chars().collect();
    let mut code = String::with_capacity(source.len());
    let mut at = 0;
    while at < letters.len() {
        let end = literal_end(&letters, at);
        if end == at {
            code.push(letters[at]);
            at += 1;
        } else {
            code.extend(letters[at..end].iter().map(|&c| if c == '\n' { '\n' } else { ' ' }));
            at = end;
        }
    }
    code
}

/// Index after the comment or literal that begins at `at`; `at` where none does.
fn literal_end(letters: &[char], at: usize) -> usize {
    match (letters[at], letters.get(at + 1)) {
        ('/', Some('/')) => position(letters, at, |rest| rest[0] == '\n'),
        ('/', Some('*')) => block_comment_end(letters, at),
        ('"', _) => quoted_end(letters, at, '"'),
        ('r', Some('"' | '#')) if is_word_start(letters, at) => raw_string_end(letters, at),
        // Anything else after a quotation mark is a lifetime.
        ('\'', Some('\\')) => quoted_end(letters, at, '\''),
        ('\'', Some(_)) if letters.get(at + 2) == Some(&'\'') => at + 3,
        _ => at,
    }
}

fn position(letters: &[char], from: usize, found: impl Fn(&[char]) -> bool) -> usize {
    (from..letters.len()).find(|&at| found(&letters[at..])).unwrap_or(letters.len())
}

fn block_comment_end(letters: &[char], at: usize) -> usize {
    let mut depth = 0;
    let mut at = at;
    while at < letters.len() {
        match (letters[at], letters.get(at + 1)) {
            ('/', Some('*')) => depth += 1,
            ('*', Some('/')) => depth -= 1,
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            return at;
        }
    }
    letters.len()
}

fn quoted_end(letters: &[char], at: usize, quote: char) -> usize {
    let mut at = at + 1;
    while at < letters.len() && letters[at] != quote {
        at += if letters[at] == '\\' { 2 } else { 1 };
    }
    letters.len().min(at + 1)
}

fn raw_string_end(letters: &[char], at: usize) -> usize {
    let n_hashes = letters[at + 1..].iter().take_while(|&&letter| letter == '#').count();
    let open = at + 1 + n_hashes;
    if letters.get(open) != Some(&'"') {
        return at;
    }
    let closes = |rest: &[char]| {
        rest[0] == '"' && rest.iter().skip(1).take_while(|&&c| c == '#').count() >= n_hashes
    };
    letters.len().min(position(letters, open + 1, closes) + 1 + n_hashes)
}

/// Whether a word begins at `at`, a `b` or `c` of a byte or C string before it aside.
fn is_word_start(letters: &[char], at: usize) -> bool {
    let is_part = |letter: char| letter.is_alphanumeric() || letter == '_';
    match at.checked_sub(1).map(|before| letters[before]) {
        Some('b' | 'c') => at < 2 || !is_part(letters[at - 2]),
        Some(before) => !is_part(before),
        None => true,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::proptest;
    use proptest::prop_assert_eq;

    use super::mask;

    #[test]
    fn comments_and_literals_are_blank_and_code_stays() {
        for (source, code) in [
            ("let a = 1; // todo!()", "let a = 1;           "),
            ("a /* b /* c */ d */ e", "a                   e"),
            (r#"f("x \" y", 'z')"#, r#"f(        ,    )"#),
            (r##"r#"a "b" c"# + d"##, "             + d"),
            (r##"br"a" + r#match"##, r##"b     + r#match"##),
            (r"fn f<'a>(c: &'a str) { c == '\'' }", "fn f<'a>(c: &'a str) { c ==      }"),
            ("\"two\nlines\" x", "    \n       x"),
        ] {
            assert_eq!(mask(source), code, "{source}");
        }
    }

    proptest! {
        #[test]
        fn any_text_keeps_its_length_and_lines(source in "[ar/*\"'\\\\#\n é]{0,40}") {
            let code = mask(&source);
            prop_assert_eq!(code.chars().count(), source.chars().count());
            prop_assert_eq!(code.matches('\n').count(), source.matches('\n').count());
        }
    }
}
