//! `docs/comparison.schema.json` against what the tool writes.

use serde_json::{Map, Value, json};

/// The schema of a comparison.
pub(crate) fn comparison() -> Value {
    read("comparison")
}

/// The schema of a diagnosis.
pub(crate) fn diagnosis() -> Value {
    read("diagnosis")
}

fn read(name: &str) -> Value {
    let docs = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs");
    let text = std::fs::read_to_string(format!("{docs}/{name}.schema.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Where a value breaks a schema made of the words that ours uses; none if nowhere.
pub(crate) fn fault(value: &Value, root: &Value) -> Option<String> {
    fault_at(value, root, root, "result")
}

fn fault_at(value: &Value, schema: &Value, root: &Value, place: &str) -> Option<String> {
    let rules = schema.as_object().unwrap();
    rules.iter().find_map(|(word, rule)| {
        let inner = fault_of_parts(value, word, rule, rules, root, place);
        inner.or_else(|| {
            let holds = holds(value, word, rule, rules);
            (!holds).then(|| format!("{place}: {word} {rule} is broken by {value}"))
        })
    })
}

/// The first fault inside of an object, an array, or a definition that the rule refers to.
fn fault_of_parts(
    value: &Value,
    word: &str,
    rule: &Value,
    rules: &Map<String, Value>,
    root: &Value,
    place: &str,
) -> Option<String> {
    match (word, value) {
        ("$ref", _) => {
            let target = root.pointer(&rule.as_str().unwrap()[1..]).unwrap();
            fault_at(value, target, root, place)
        }
        ("items", Value::Array(items)) => items
            .iter()
            .enumerate()
            .find_map(|(k, item)| fault_at(item, rule, root, &format!("{place}[{k}]"))),
        ("properties", Value::Object(fields)) => fields.iter().find_map(|(key, field)| {
            let inner = rule.get(key)?;
            fault_at(field, inner, root, &format!("{place}.{key}"))
        }),
        ("oneOf", _) => {
            let faults: Vec<_> = rule
                .as_array()
                .unwrap()
                .iter()
                .map(|rule| fault_at(value, rule, root, place))
                .collect();
            let n_good = faults.iter().filter(|fault| fault.is_none()).count();
            // Of null and something else the something says what is wrong.
            (n_good != 1).then(|| format!("{place}: {n_good} of oneOf hold; {:?}", faults.last()))
        }
        ("additionalProperties", Value::Object(fields)) => {
            let known = rules["properties"].as_object().unwrap();
            let unknown = fields.keys().find(|key| !known.contains_key(*key))?;
            Some(format!("{place}.{unknown} is not in the schema"))
        }
        _ => None,
    }
}

fn holds(value: &Value, word: &str, rule: &Value, rules: &Map<String, Value>) -> bool {
    let length = match value {
        Value::Array(items) => items.len() as f64,
        Value::String(text) => text.chars().count() as f64,
        _ => 0.0,
    };
    let number = value.as_f64();
    match word {
        "$schema" | "$id" | "$defs" | "title" | "description" | "$ref" | "items" | "properties"
        | "oneOf" => true,
        "additionalProperties" => rule == &json!(false) && rules.contains_key("properties"),
        "const" => value == rule,
        "enum" => rule.as_array().unwrap().contains(value),
        "required" => {
            rule.as_array().unwrap().iter().all(|key| value.get(key.as_str().unwrap()).is_some())
        }
        "type" => match rule.as_str().unwrap() {
            "object" => value.is_object(),
            "array" => value.is_array(),
            "string" => value.is_string(),
            "boolean" => value.is_boolean(),
            "null" => value.is_null(),
            "integer" => value.is_u64() || value.is_i64(),
            "number" => value.is_number(),
            other => panic!("type {other}"),
        },
        "minimum" => number.is_some_and(|number| number >= rule.as_f64().unwrap()),
        "maximum" => number.is_some_and(|number| number <= rule.as_f64().unwrap()),
        "minItems" | "minLength" => length >= rule.as_f64().unwrap(),
        "maxItems" => length <= rule.as_f64().unwrap(),
        other => panic!("the schema uses {other}, which this test does not know"),
    }
}

#[test]
fn what_is_missing_unknown_or_out_of_range_is_a_fault() {
    let schema = json!({
        "type": "object", "required": ["a"], "additionalProperties": false,
        "properties": { "a": { "type": "array", "items": { "$ref": "#/$defs/b" } } },
        "$defs": { "b": { "oneOf": [{ "type": "null" }, { "type": "number", "maximum": 1 }] } },
    });
    assert_eq!(fault(&json!({ "a": [null, 0.5] }), &schema), None);
    for (value, says) in [
        (json!({}), "required"),
        (json!({ "a": [], "b": 1 }), "result.b is not in the schema"),
        (json!({ "a": [0, 2] }), "result.a[1]"),
        (json!({ "a": 1 }), "type"),
    ] {
        let fault = fault(&value, &schema).unwrap();
        assert!(fault.contains(says), "{fault}");
    }
}
