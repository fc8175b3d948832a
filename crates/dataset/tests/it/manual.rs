//! The reference of `dataset.toml`: its examples are read, and every key is in it.

use std::path::Path;

use dataset::{Limit, Manifest, Quantity, ReadLimits, all_formats};

const REFERENCE: &str = include_str!("../../../../docs/dataset-toml.md");

fn examples() -> Vec<&'static str> {
    let blocks = REFERENCE.split("```toml\n").skip(1);
    blocks.map(|block| block.split_once("```").unwrap().0).collect()
}

#[test]
fn the_examples_are_read() {
    let examples = examples();
    assert_eq!(examples.len(), 4);
    for example in examples {
        Manifest::parse(example, Path::new("docs/dataset-toml.md")).unwrap();
    }
}

/// What the error on an unknown key lists as known.
fn known_keys(table: &str) -> Vec<String> {
    let text = format!("{}\n[{table}]\nno_such_key = 1\n", base(table));
    let message = Manifest::parse(&text, Path::new("x")).unwrap_err().to_string();
    let (_, list) =
        message.split_once("expected one of ").or(message.split_once("expected ")).unwrap();
    list.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// A manifest without one of its tables.
fn base(without: &str) -> String {
    let tables = [
        ("object", "shape = \"rect1\""),
        ("pusher", "radius_m = 0.005\nfriction = 0.25"),
        ("support", "friction = 0.25"),
        ("recordings", "path = \".\""),
    ];
    let kept = tables.iter().filter(|(name, _)| *name != without);
    kept.fold("name = \"x\"\n".to_owned(), |text, (name, keys)| format!("{text}[{name}]\n{keys}\n"))
}

#[test]
fn every_key_is_documented() {
    for table in ["object", "pusher", "support", "recordings", "streams.wrench", "limits"] {
        let keys = known_keys(table);
        assert!(keys.len() >= 2, "{table}: {keys:?}");
        for key in keys {
            assert!(REFERENCE.contains(&format!("`{key}`")), "[{table}] {key}");
        }
    }
    for limit in Limit::ALL {
        let row = format!("| `{}` | {} |", limit.key(), ReadLimits::default().of(limit));
        assert!(REFERENCE.contains(&row), "{row}");
    }
    for format in all_formats() {
        assert!(REFERENCE.contains(&format!("`{}`", format.id())), "{}", format.id());
    }
    for quantity in [Quantity::T, Quantity::Theta, Quantity::Qw, Quantity::Tz] {
        let name = serde_json::to_string(&quantity).unwrap();
        assert!(REFERENCE.contains(&format!("`{}`", name.trim_matches('"'))), "{name}");
    }
}
