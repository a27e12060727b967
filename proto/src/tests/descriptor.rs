//! The protocol changes by addition only: everything in the committed descriptor is still there, unchanged.

use std::collections::BTreeSet;

use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, EnumDescriptorProto, FieldDescriptorProto, FileDescriptorSet};

use crate::wire;

const GOLDEN: &str = include_str!("descriptor.txt");

/// One line for each thing that a peer can depend on.
fn lines() -> Vec<String> {
    let set = FileDescriptorSet::decode(wire::DESCRIPTORS).unwrap();
    let mut lines = Vec::new();
    for file in set.file.iter().filter(|file| file.package() == "fsi.v2") {
        for service in &file.service {
            for method in &service.method {
                let stream = |streaming: bool| if streaming { "stream " } else { "" };
                lines.push(format!(
                    "rpc {}.{} ({}{}) ({}{})",
                    service.name(),
                    method.name(),
                    stream(method.client_streaming()),
                    method.input_type(),
                    stream(method.server_streaming()),
                    method.output_type()
                ));
            }
        }
        file.enum_type.iter().for_each(|item| enum_lines(item, &mut lines));
        file.message_type.iter().for_each(|item| message_lines("", item, &mut lines));
    }
    lines.sort();
    lines
}

fn enum_lines(item: &EnumDescriptorProto, lines: &mut Vec<String>) {
    for value in &item.value {
        lines.push(format!("enum {} {} = {}", item.name(), value.name(), value.number()));
    }
}

fn message_lines(scope: &str, item: &DescriptorProto, lines: &mut Vec<String>) {
    let name = format!("{scope}{}", item.name());
    lines.push(format!("message {name}"));
    for field in &item.field {
        lines.push(format!("field {name}.{} = {} {}", field.name(), field.number(), kind(item, field)));
    }
    item.enum_type.iter().for_each(|inner| enum_lines(inner, lines));
    item.nested_type.iter().for_each(|inner| message_lines(&format!("{name}."), inner, lines));
}

fn kind(item: &DescriptorProto, field: &FieldDescriptorProto) -> String {
    let label = match field.label() {
        Label::Repeated => "repeated ",
        _ if field.proto3_optional() => "optional ",
        _ => "",
    };
    let place = field.oneof_index.filter(|_| !field.proto3_optional());
    let oneof = place.and_then(|k| item.oneof_decl.get(usize::try_from(k).ok()?));
    let oneof = oneof.map_or_else(String::new, |oneof| format!(" in {}", oneof.name()));
    let name = match field.r#type() {
        Type::Message | Type::Enum => field.type_name().to_owned(),
        other => format!("{other:?}").to_lowercase(),
    };
    format!("{label}{name}{oneof}")
}

#[test]
fn the_protocol_only_grows() {
    let now = lines();
    // Set to accept additions: rewrites the file, and fails so that it is not left set.
    if std::env::var_os("UPDATE_DESCRIPTOR").is_some() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/tests/descriptor.txt");
        std::fs::write(path, now.join("\n") + "\n").unwrap();
        panic!(
            "descriptor.txt has been rewritten: read its difference, then test again without UPDATE_DESCRIPTOR"
        );
    }
    let golden: BTreeSet<&str> = GOLDEN.lines().collect();
    let present: BTreeSet<&str> = now.iter().map(String::as_str).collect();
    let lost: Vec<_> = golden.difference(&present).collect();
    assert!(lost.is_empty(), "peers depend on what is gone or changed: {lost:#?}");
    let added: Vec<_> = present.difference(&golden).collect();
    assert!(added.is_empty(), "record additions by a run with UPDATE_DESCRIPTOR=1: {added:#?}");
}

#[test]
fn field_numbers_are_used_once() {
    let set = FileDescriptorSet::decode(wire::DESCRIPTORS).unwrap();
    let messages =
        set.file.iter().filter(|file| file.package() == "fsi.v2").flat_map(|file| &file.message_type);
    for message in messages {
        let numbers: BTreeSet<i32> = message.field.iter().map(|field| field.number()).collect();
        assert_eq!(numbers.len(), message.field.len(), "{}", message.name());
    }
}
