//! ROS message definitions as logs carry them: the type's text, then those of all it contains.

use std::collections::HashMap;

use super::split_path;

/// The definition of a message type and of everything inside it.
pub(crate) struct RosSchema {
    types: Vec<StructType>,
    /// Whether messages are CDR (ROS 2) and not the unaligned ROS 1 serialisation.
    pub(super) cdr: bool,
    /// How deep types may be nested.
    pub(super) nesting: usize,
}

struct StructType {
    name: String,
    fields: Vec<Field>,
}

pub(super) struct Field {
    pub(super) name: String,
    pub(super) kind: FieldKind,
    pub(super) count: Count,
}

pub(super) enum FieldKind {
    Number(NumberKind),
    Text,
    WideText,
    Struct(usize),
    /// A type that the schema uses but does not define.
    Undefined(String),
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Count {
    One,
    Fixed(usize),
    Sequence,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NumberKind {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl NumberKind {
    /// Bytes on the wire, which is also the alignment in CDR.
    pub(super) fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }
}

impl RosSchema {
    /// Reads the definition of `type_name`.
    ///
    /// - `cdr`: ROS 2 and not ROS 1.
    /// - `nesting`: how deep types may be nested.
    pub(crate) fn parse(
        type_name: &str,
        schema: &[u8],
        cdr: bool,
        nesting: usize,
    ) -> Result<Self, String> {
        let text = std::str::from_utf8(schema)
            .map_err(|error| format!("the schema is no UTF-8 text: {error}"))?;
        let mut sections = vec![(plain_name(type_name), Vec::new())];
        let mut after_separator = false;
        for line in text.lines().map(str::trim) {
            if line.starts_with("===") {
                after_separator = true;
            } else if let (true, Some(name)) = (after_separator, line.strip_prefix("MSG:")) {
                sections.push((plain_name(name.trim()), Vec::new()));
                after_separator = false;
            } else if let Some((_, lines)) = sections.last_mut() {
                lines.push(line);
            }
        }
        sections.extend(builtin_times(cdr));
        // Of several definitions of a type the first one counts.
        let mut names: HashMap<String, usize> = HashMap::new();
        for (i, (name, _)) in sections.iter().enumerate() {
            names.entry(name.clone()).or_insert(i);
        }
        let mut types = Vec::new();
        for (name, lines) in sections {
            let package = name.split_once('/').map_or("", |(package, _)| package);
            let mut fields = Vec::new();
            for line in lines {
                fields.extend(parse_field(line, package, &names)?);
            }
            types.push(StructType { name, fields });
        }
        Ok(Self { types, cdr, nesting })
    }

    /// How many types there are.
    pub(super) fn n_types(&self) -> usize {
        self.types.len()
    }

    /// The fields of a type; number 0 is the message itself.
    pub(super) fn fields(&self, type_index: usize) -> &[Field] {
        &self.types[type_index].fields
    }

    /// The name of a type, as `package/Type`.
    pub(super) fn type_name(&self, type_index: usize) -> &str {
        &self.types[type_index].name
    }

    /// Whether a path leads to a number, or to a text if `text`.
    pub(crate) fn has(&self, path: &str, text: bool) -> bool {
        let (mut type_index, mut rest) = (0, path);
        for _ in 0..self.nesting {
            let (name, is_list, tail) = split_path(rest);
            let Some(field) = self.fields(type_index).iter().find(|field| field.name == name)
            else {
                return false;
            };
            if is_list != (field.count != Count::One) {
                return false;
            }
            match (&field.kind, tail.is_empty()) {
                (FieldKind::Struct(inner), false) => (type_index, rest) = (*inner, tail),
                (FieldKind::Number(_), true) => return !text,
                (FieldKind::Text, true) => return text,
                _ => return false,
            }
        }
        false
    }
}

/// `package/msg/Type` without its middle part.
fn plain_name(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}

/// Types that every ROS serialisation knows, whether or not the schema spells them out.
fn builtin_times(cdr: bool) -> Vec<(String, Vec<&'static str>)> {
    if cdr {
        let lines = || vec!["int32 sec", "uint32 nanosec"];
        vec![
            ("builtin_interfaces/Time".into(), lines()),
            ("builtin_interfaces/Duration".into(), lines()),
        ]
    } else {
        vec![
            ("time".into(), vec!["uint32 sec", "uint32 nsec"]),
            ("duration".into(), vec!["int32 sec", "int32 nsec"]),
        ]
    }
}

/// The field that a line declares; none for a comment or a constant.
fn parse_field(
    line: &str,
    package: &str,
    names: &HashMap<String, usize>,
) -> Result<Option<Field>, String> {
    let line = line.split('#').next().unwrap_or_default().trim();
    let Some((type_text, rest)) = line.split_once(char::is_whitespace) else {
        if line.is_empty() {
            return Ok(None);
        }
        return Err(format!("the schema's line `{line}` is no field"));
    };
    let rest = rest.trim_start();
    let name = rest.split(|c: char| c.is_whitespace() || c == '=').next().unwrap_or_default();
    if rest[name.len()..].trim_start().starts_with('=') {
        return Ok(None);
    }
    let (element, count) = match type_text.split_once('[') {
        None => (type_text, Count::One),
        Some((element, bound)) => match bound.trim_end_matches(']') {
            "" => (element, Count::Sequence),
            bound if bound.starts_with("<=") => (element, Count::Sequence),
            number => {
                let count = number
                    .parse()
                    .map_err(|_| format!("the schema's line `{line}` has a wrong array size"))?;
                (element, Count::Fixed(count))
            }
        },
    };
    let element = element.split("<=").next().unwrap_or_default();
    Ok(Some(Field { name: name.into(), kind: field_kind(element, package, names), count }))
}

fn field_kind(element: &str, package: &str, names: &HashMap<String, usize>) -> FieldKind {
    let number = match element {
        "bool" | "byte" | "char" | "uint8" => NumberKind::U8,
        "int8" => NumberKind::I8,
        "uint16" => NumberKind::U16,
        "int16" => NumberKind::I16,
        "uint32" => NumberKind::U32,
        "int32" => NumberKind::I32,
        "uint64" => NumberKind::U64,
        "int64" => NumberKind::I64,
        "float32" => NumberKind::F32,
        "float64" => NumberKind::F64,
        "string" => return FieldKind::Text,
        "wstring" => return FieldKind::WideText,
        _ => {
            let plain = plain_name(element);
            let candidates = match element {
                "Header" => vec!["std_msgs/Header".to_owned(), format!("{package}/Header")],
                _ if element.contains('/') => vec![plain],
                _ => vec![format!("{package}/{element}"), plain],
            };
            let index = candidates.iter().find_map(|name| names.get(name).copied());
            return index.map_or_else(|| FieldKind::Undefined(element.into()), FieldKind::Struct);
        }
    };
    FieldKind::Number(number)
}

#[cfg(test)]
mod tests {
    use super::RosSchema;

    const SCHEMA: &str = "# a comment\nHeader header\nuint8 KIND=3 # constant\nstring A = \"x\"\n\
        string<=10[<=3] names\nOther other\nfloat64[3] v\ngeometry_msgs/msg/Point[] points\n\
        int32 count 5\n\
        ================================================================================\n\
        MSG: std_msgs/Header\ntime stamp\nstring frame_id\n\
        ===\nMSG: my_msgs/Other\nfloat32 depth\n===\nMSG: geometry_msgs/Point\nfloat64 x\n";

    #[test]
    fn paths_lead_through_relative_and_full_type_names() {
        let schema = RosSchema::parse("my_msgs/msg/Thing", SCHEMA.as_bytes(), false, 32).unwrap();
        for path in
            ["header.stamp.sec", "header.stamp.nsec", "other.depth", "points[].x", "v[]", "count"]
        {
            assert!(schema.has(path, false), "{path}");
        }
        assert!(schema.has("header.frame_id", true));
        for path in ["KIND", "A", "points.x", "other", "header.frame_id", "other.depth.x", ""] {
            assert!(!schema.has(path, false), "{path}");
        }
    }

    #[test]
    fn a_type_within_itself_is_no_endless_path() {
        let schema = RosSchema::parse("a/B", b"B b\nfloat64 x\n", true, 32).unwrap();
        assert!(schema.has("b.b.b.x", false));
        assert!(!schema.has(&"b.".repeat(100), false));
    }

    #[test]
    fn a_broken_schema_is_refused_with_its_line() {
        let refusal = |text: &[u8]| RosSchema::parse("a/B", text, true, 32).err().unwrap();
        assert!(refusal(b"float64\n").contains("`float64` is no field"));
        assert!(refusal(b"float64[x] y\n").contains("wrong array size"));
        assert!(refusal(b"\xff").contains("UTF-8"));
    }
}
