//! Messages in JSON: fields by name, the structure seen in a sample.

use serde_json::Value;

use super::{MessageError, Row, Slot, Wanted, split_path};

/// Longest message that is read, in bytes: the tree of a message takes many times its own bytes.
const LONGEST: usize = 1 << 26;
const TOO_LONG: &str = "a message of more than 64 MiB";

/// The structure of a JSON channel, taken from one of its messages.
pub(crate) struct JsonSchema {
    sample: Value,
}

impl JsonSchema {
    pub(crate) fn parse(sample: Option<&[u8]>) -> Result<Self, String> {
        let sample = sample.ok_or("the channel has no message to see its fields in")?;
        if sample.len() > LONGEST {
            return Err(format!("its first message is {TOO_LONG}"));
        }
        let sample = serde_json::from_slice(sample)
            .map_err(|error| format!("its first message is no JSON: {error}"))?;
        Ok(Self { sample })
    }

    /// Whether a path leads to a number, or to a text if `text`.
    pub(crate) fn has(&self, path: &str, text: bool) -> bool {
        let (mut value, mut rest) = (&self.sample, path);
        while !rest.is_empty() {
            let (name, is_list, tail) = split_path(rest);
            let Some(inner) = value.get(name) else { return false };
            let inner = if is_list { inner.get(0) } else { Some(inner) };
            let Some(inner) = inner else { return false };
            (value, rest) = (inner, tail);
        }
        if text { value.is_string() } else { value.is_number() }
    }
}

/// The wanted fields of a JSON channel.
pub(crate) struct JsonPlan {
    /// The list whose elements give the rows; empty if the message is one row.
    list: Vec<String>,
    outer: Vec<(Vec<String>, Slot)>,
    inner: Vec<(Vec<String>, Slot)>,
}

impl JsonPlan {
    pub(crate) fn compile(wanted: &[Wanted]) -> Self {
        let steps = |path: &str| -> Vec<String> { path.split('.').map(String::from).collect() };
        let mut plan = Self { list: Vec::new(), outer: Vec::new(), inner: Vec::new() };
        for Wanted { slot, path } in wanted {
            match path.split_once("[].") {
                Some((list, rest)) => {
                    plan.list = steps(list);
                    plan.inner.push((steps(rest), *slot));
                }
                None => plan.outer.push((steps(path), *slot)),
            }
        }
        plan
    }

    pub(crate) fn decode(
        &self,
        message: &[u8],
        emit: &mut dyn FnMut(&Row<'_>),
    ) -> Result<(), MessageError> {
        if message.len() > LONGEST {
            return Err(MessageError { byte: LONGEST, what: TOO_LONG });
        }
        let value: Value = serde_json::from_slice(message)
            .map_err(|error| MessageError { byte: error.column(), what: "no valid JSON" })?;
        let mut row = Row::default();
        fill(&mut row, &value, &self.outer)?;
        if self.list.is_empty() {
            emit(&row);
            return Ok(());
        }
        let elements = follow(&value, &self.list).and_then(Value::as_array);
        for element in elements.ok_or(MessageError { byte: 0, what: "no list of transforms" })? {
            fill(&mut row, element, &self.inner)?;
            emit(&row);
        }
        Ok(())
    }
}

fn fill<'m>(
    row: &mut Row<'m>,
    value: &'m Value,
    fields: &[(Vec<String>, Slot)],
) -> Result<(), MessageError> {
    for (path, slot) in fields {
        let field = follow(value, path);
        if slot.is_text() {
            let text = field.and_then(Value::as_str);
            let text = text.ok_or(MessageError { byte: 0, what: "a missing text" })?;
            row.set_text(*slot, text.as_bytes());
        } else {
            let number = field.and_then(Value::as_f64);
            let number = number.ok_or(MessageError { byte: 0, what: "a missing number" })?;
            row.set_number(*slot, number);
        }
    }
    Ok(())
}

fn follow<'v>(value: &'v Value, path: &[String]) -> Option<&'v Value> {
    path.iter().try_fold(value, |value, name| value.get(name))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::{any, prop, prop_assert, proptest};

    use super::{JsonPlan, JsonSchema};
    use crate::formats::decode::{Row, Slot, Wanted};

    const MESSAGE: &[u8] =
        br#"{"transforms": [{"x": 1.5, "child": "a"}, {"x": 2, "child": "b"}], "t": {"sec": 7}}"#;

    fn plan() -> JsonPlan {
        let wanted = |slot, path: &str| Wanted { slot, path: path.into() };
        JsonPlan::compile(&[
            wanted(Slot::Sec, "t.sec"),
            wanted(Slot::Value(0), "transforms[].x"),
            wanted(Slot::Child, "transforms[].child"),
        ])
    }

    #[test]
    fn each_element_of_a_list_is_a_row() {
        let mut rows = Vec::new();
        plan()
            .decode(MESSAGE, &mut |row: &Row<'_>| {
                rows.push((row.sec, row.values[0], row.child.to_vec()));
            })
            .unwrap();
        assert_eq!(rows, [(7.0, 1.5, b"a".to_vec()), (7.0, 2.0, b"b".to_vec())]);
    }

    #[test]
    fn fields_are_seen_in_the_sample() {
        let schema = JsonSchema::parse(Some(MESSAGE)).unwrap();
        assert!(schema.has("transforms[].x", false) && schema.has("transforms[].child", true));
        assert!(!schema.has("transforms.x", false) && !schema.has("t.nsec", false));
        assert!(JsonSchema::parse(None).is_err() && JsonSchema::parse(Some(b"{")).is_err());
    }

    #[test]
    fn a_message_without_the_field_is_an_error() {
        let error = plan().decode(br#"{"t": {"sec": 7}}"#, &mut |_| ()).unwrap_err();
        assert_eq!(error.what, "no list of transforms");
        let error = plan().decode(br#"{"t": {}}"#, &mut |_| ()).unwrap_err();
        assert_eq!(error.what, "a missing number");
    }

    proptest! {
        #[test]
        fn damaged_messages_never_panic(at in 0..MESSAGE.len(), byte in any::<u8>(),
                                        tail in prop::collection::vec(any::<u8>(), 0..8)) {
            let mut message = MESSAGE.to_vec();
            message[at] = byte;
            let mut n = 0;
            let _ = plan().decode(&message, &mut |_| n += 1);
            prop_assert!(n <= 2);
            prop_assert!(plan().decode(&tail, &mut |_| ()).is_err());
        }
    }
}
