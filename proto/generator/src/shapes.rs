//! The table of lists that the codec of crate `proto` counts by.

use std::collections::BTreeMap;
use std::fmt::Write;

use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorSet};

/// The table of `codec.rs`: of each message the fields that are lists or messages, by their numbers.
pub(crate) fn shapes(descriptors: &FileDescriptorSet) -> Result<String, std::fmt::Error> {
    let mut messages = BTreeMap::new();
    let mut public = Vec::new();
    for file in &descriptors.file {
        for message in &file.message_type {
            let path = format!(".{}.{}", file.package(), message.name());
            collect(&path, message, &mut messages);
            public.push((message.name(), path));
        }
    }
    let index: BTreeMap<&String, usize> = messages.keys().enumerate().map(|(k, path)| (path, k)).collect();
    let mut text = String::from("pub(super) static SHAPES: &[Shape] = &[\n");
    let mut lists = 0;
    for message in messages.values() {
        writeln!(text, "    Shape {{ name: {:?}, fields: &[", message.name())?;
        let mut fields: Vec<_> = message.field.iter().collect();
        fields.sort_by_key(|field| field.number());
        for field in fields {
            let inner = index.get(&field.type_name().to_owned()).filter(|_| field.r#type() == Type::Message);
            let repeated = field.label() == Label::Repeated;
            let entry = match inner {
                Some(k) => format!("Entry::Message({k})"),
                None if repeated => match entry(field) {
                    Some(entry) => entry.to_owned(),
                    None => continue,
                },
                None => continue,
            };
            let list = if repeated { format!("Some({lists})") } else { "None".into() };
            lists += usize::from(repeated);
            let (number, name) = (field.number(), field.name());
            writeln!(
                text,
                "        Field {{ number: {number}, name: {name:?}, list: {list}, entry: {entry} }},"
            )?;
        }
        writeln!(text, "    ] }},")?;
    }
    writeln!(text, "];\npub(super) const LISTS: usize = {lists};")?;
    for (name, path) in &public {
        if let Some(k) = index.get(path) {
            writeln!(text, "impl Counted for crate::wire::{name} {{ const SHAPE: usize = {k}; }}")?;
        }
    }
    Ok(text)
}

fn collect<'a>(
    path: &str,
    message: &'a DescriptorProto,
    messages: &mut BTreeMap<String, &'a DescriptorProto>,
) {
    for nested in &message.nested_type {
        collect(&format!("{path}.{}", nested.name()), nested, messages);
    }
    messages.insert(path.to_owned(), message);
}

/// How an entry that is no message travels; `None` for numbers of fixed size, which take no more memory than bytes on the
/// wire and are not counted.
fn entry(field: &FieldDescriptorProto) -> Option<&'static str> {
    match field.r#type() {
        Type::String | Type::Bytes => Some("Entry::Text"),
        Type::Double | Type::Fixed64 | Type::Sfixed64 | Type::Float | Type::Fixed32 | Type::Sfixed32 => None,
        _ => Some("Entry::PackedVarint"),
    }
}
