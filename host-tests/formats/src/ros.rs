//! Messages of ROS 2: their definition as text, their bytes as CDR.
//!
//! Sources: *ROS 2 Interface definition* (types, arrays, bounds, constants, default values); OMG *DDS-XTypes
//! 1.3*, 7.4.1: plain CDR, each number at a multiple of its size behind the head of four bytes. A message without
//! fields has one byte: rosidl gives it the field `structure_needs_at_least_one_member`. The crate `ros2_message` was
//! looked at: it says of itself that it is not tested.

use std::collections::HashMap;

use crate::mcap::{LONGEST_ARRAY, Numbers};

/// A message's definition, with those of the messages in it.
pub struct Definition {
    root: String,
    messages: HashMap<String, Vec<Field>>,
}

struct Field {
    name: String,
    kind: Kind,
    array: Array,
}

#[derive(Clone)]
enum Kind {
    /// Bytes of a number, and how they are read.
    Number(usize, Number),
    Text,
    Message(String),
}

#[derive(Clone, Copy)]
enum Number {
    Signed,
    Unsigned,
    Real,
}

enum Array {
    None,
    Of(usize),
    /// Its length stands in front of it.
    Sequence,
}

/// Messages in messages; a definition that goes deeper contains itself.
const DEEPEST: usize = 16;

/// Without these in its text a definition has them all the same.
const TIMES: [&str; 2] = ["builtin_interfaces/Time", "builtin_interfaces/Duration"];

impl Definition {
    /// Reads the text of a definition: the message's own, and behind lines of `=` those of the messages in it.
    pub fn parse(name: &str, text: &str) -> Result<Self, String> {
        let root = short(name);
        let mut messages = HashMap::new();
        for time in TIMES {
            let part = |name: &str, number| Field {
                name: name.to_owned(),
                kind: Kind::Number(4, number),
                array: Array::None,
            };
            let parts = vec![
                part("sec", Number::Signed),
                part("nanosec", Number::Unsigned),
            ];
            messages.insert(time.to_owned(), parts);
        }
        let mut current = root.clone();
        let mut fields = Vec::new();
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.len() > 2 && line.bytes().all(|byte| byte == b'=') {
                continue;
            }
            if let Some(next) = line.strip_prefix("MSG:") {
                messages.insert(current, std::mem::take(&mut fields));
                current = short(next.trim());
                continue;
            }
            let mut words = line.split_whitespace();
            let (Some(kind), Some(name)) = (words.next(), words.next()) else {
                continue;
            };
            let is_constant =
                name.contains('=') || words.next().is_some_and(|w| w.starts_with('='));
            if !is_constant {
                fields.push(field(kind, name, &current)?);
            }
        }
        messages.insert(current, fields);
        Ok(Self { root, messages })
    }

    /// The numbers of a message.
    pub fn decode(&self, bytes: &[u8]) -> Result<Numbers, String> {
        let little = match bytes.get(..2) {
            Some([0, 0]) => false,
            Some([0, 1]) => true,
            _ => return Err("it is not plain CDR".to_owned()),
        };
        let mut cdr = Cdr {
            bytes: bytes.get(4..).unwrap_or_default(),
            at: 0,
            little,
        };
        let mut numbers = Numbers::new();
        self.message(&self.root, "", &mut cdr, &mut numbers, DEEPEST)?;
        Ok(numbers)
    }

    fn message(
        &self,
        kind: &str,
        name: &str,
        cdr: &mut Cdr,
        into: &mut Numbers,
        depth: usize,
    ) -> Result<(), String> {
        let fields = self
            .messages
            .get(kind)
            .filter(|_| depth > 0)
            .ok_or_else(|| format!("the definition of {kind} is missing"))?;
        if fields.is_empty() {
            cdr.take(1)?;
        }
        let is_time = TIMES.contains(&kind);
        let begun = into.len();
        for field in fields {
            let name = match name {
                "" => field.name.clone(),
                _ => format!("{name}.{}", field.name),
            };
            let count = match field.array {
                Array::None => {
                    self.element(&field.kind, name, cdr, Some(&mut *into), depth)?;
                    continue;
                }
                Array::Of(count) => count,
                Array::Sequence => cdr.unsigned(4)? as usize,
            };
            for at in 0..count {
                let kept = (at < LONGEST_ARRAY).then_some(&mut *into);
                self.element(&field.kind, format!("{name}.{at}"), cdr, kept, depth)?;
            }
        }
        if is_time {
            // Seconds and nanoseconds are one time.
            if let [(_, seconds), (_, nanoseconds)] = into[begun..] {
                into.truncate(begun);
                into.push((name.to_owned(), seconds + nanoseconds * 1e-9));
            }
        }
        Ok(())
    }

    fn element(
        &self,
        kind: &Kind,
        name: String,
        cdr: &mut Cdr,
        into: Option<&mut Numbers>,
        depth: usize,
    ) -> Result<(), String> {
        match kind {
            Kind::Number(size, number) => {
                let value = cdr.number(*size, *number)?;
                if let Some(into) = into {
                    into.push((name, value));
                }
            }
            Kind::Text => {
                let length = cdr.unsigned(4)? as usize;
                cdr.take(length)?;
            }
            Kind::Message(kind) => {
                let mut unused = Numbers::new();
                let into = into.unwrap_or(&mut unused);
                self.message(kind, &name, cdr, into, depth - 1)?;
            }
        }
        Ok(())
    }
}

/// `pkg/Type` of `pkg/msg/Type`.
fn short(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}

fn field(kind: &str, name: &str, within: &str) -> Result<Field, String> {
    let (kind, array) = match kind.split_once('[') {
        None => (kind, Array::None),
        Some((kind, size)) => {
            let size = size.trim_end_matches(']');
            match size.parse() {
                // Of such messages any number fits into no bytes, and no end of them would be found.
                Ok(0) => return Err("an array of no elements".to_owned()),
                Ok(count) => (kind, Array::Of(count)),
                Err(_) if size.is_empty() || size.starts_with("<=") => (kind, Array::Sequence),
                Err(_) => return Err(format!("an array of {size:?}")),
            }
        }
    };
    // A text may have a bound.
    let kind = kind.split("<=").next().unwrap_or(kind);
    let kind = match kind {
        "bool" | "byte" | "char" | "uint8" => Kind::Number(1, Number::Unsigned),
        "int8" => Kind::Number(1, Number::Signed),
        "uint16" => Kind::Number(2, Number::Unsigned),
        "int16" => Kind::Number(2, Number::Signed),
        "uint32" => Kind::Number(4, Number::Unsigned),
        "int32" => Kind::Number(4, Number::Signed),
        "uint64" => Kind::Number(8, Number::Unsigned),
        "int64" => Kind::Number(8, Number::Signed),
        "float32" => Kind::Number(4, Number::Real),
        "float64" => Kind::Number(8, Number::Real),
        "string" => Kind::Text,
        "wstring" => return Err("a wstring".to_owned()),
        "Header" => Kind::Message("std_msgs/Header".to_owned()),
        _ if kind.contains('/') => Kind::Message(short(kind)),
        // Of the same package.
        _ => {
            let package = within.split('/').next().unwrap_or_default();
            Kind::Message(format!("{package}/{kind}"))
        }
    };
    Ok(Field {
        name: name.to_owned(),
        kind,
        array,
    })
}

/// The bytes behind the head.
struct Cdr<'b> {
    bytes: &'b [u8],
    at: usize,
    little: bool,
}

impl Cdr<'_> {
    fn take(&mut self, count: usize) -> Result<&[u8], String> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.bytes.get(self.at..end));
        self.at += count.min(self.bytes.len());
        taken.ok_or_else(|| "it ends too early".to_owned())
    }

    fn unsigned(&mut self, size: usize) -> Result<u64, String> {
        self.at = self.at.next_multiple_of(size);
        let little = self.little;
        let bytes = self.take(size)?;
        let shifted = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        Ok(if little {
            bytes.iter().rev().fold(0, shifted)
        } else {
            bytes.iter().fold(0, shifted)
        })
    }

    fn number(&mut self, size: usize, number: Number) -> Result<f64, String> {
        let bits = self.unsigned(size)?;
        Ok(match (number, size) {
            (Number::Unsigned, _) => bits as f64,
            (Number::Signed, _) => {
                let unused = 64 - 8 * size as u32;
                ((bits << unused).cast_signed() >> unused) as f64
            }
            (Number::Real, 4) => f64::from(f32::from_bits(bits as u32)),
            (Number::Real, _) => f64::from_bits(bits),
        })
    }
}
