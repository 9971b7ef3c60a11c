//! MCAP: messages of JSON or of ROS 2, a row each.

use std::collections::HashMap;
use std::io::Cursor;

use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;
use serde_json::Value;

use crate::columns::{Column, Columns, check_size, seconds_since};
use crate::ros::Definition;

/// Elements of an array that become columns; behind these it is an image or a scan.
pub(crate) const LONGEST_ARRAY: usize = 64;

/// The name and the value of each number in a message.
pub(crate) type Numbers = Vec<(String, f64)>;

/// How a topic's messages are read.
enum Decoder {
    Json,
    Ros(Definition),
}

/// The rows of a topic.
struct Topic {
    name: String,
    decoder: Decoder,
    columns: Vec<Column>,
    places: HashMap<String, usize>,
    rows: usize,
}

impl Topic {
    fn new(name: &str, decoder: Decoder) -> Self {
        Self {
            name: name.to_owned(),
            decoder,
            columns: Vec::new(),
            places: HashMap::new(),
            rows: 0,
        }
    }

    fn set(&mut self, name: &str, unit: &str, value: f64) {
        let place = self.places.get(name).copied().unwrap_or_else(|| {
            self.columns.push(Column {
                name: name.to_owned(),
                unit: unit.to_owned(),
                group: 0,
                values: Vec::new(),
            });
            self.places.insert(name.to_owned(), self.columns.len() - 1);
            self.columns.len() - 1
        });
        let values = &mut self.columns[place].values;
        values.resize(self.rows, f64::NAN);
        values.push(value);
    }

    fn end_row(&mut self) {
        self.rows += 1;
    }
}

/// Reads each number of each message as a column: `position.0`, `header.stamp`; with the times of its record,
/// `log_time` and `publish_time`, in seconds since the file's first message. Behind the topic, `/motor.position.0`,
/// where the file has several.
pub fn read(bytes: Vec<u8>, most: usize) -> Result<Columns, String> {
    let damaged = |error: mcap::McapError| format!("is a damaged MCAP file ({error})");
    let mut topics: HashMap<u16, Option<usize>> = HashMap::new();
    let mut read: Vec<Topic> = Vec::new();
    let mut others: Vec<String> = Vec::new();
    let mut first = None;
    let options = LinearReaderOptions::default()
        // Else a flipped bit is a number like any other.
        .with_validate_chunk_crcs(true)
        // Else as much memory is taken as a damaged length says, which may be more than there is.
        .with_record_length_limit(most);
    for message in MessageReader::new_with_options(Cursor::new(bytes), options) {
        let message = message.map_err(damaged)?;
        let channel = &message.channel;
        let place = *topics
            .entry(channel.id)
            .or_insert_with(|| match decoder(channel) {
                Ok(decoder) => {
                    read.push(Topic::new(&channel.topic, decoder));
                    Some(read.len() - 1)
                }
                Err(encoding) => {
                    others.push(format!("{} ({encoding})", channel.topic));
                    None
                }
            });
        let Some(place) = place else { continue };
        let topic = &mut read[place];
        let numbers = match &topic.decoder {
            Decoder::Json => json(&message.data),
            Decoder::Ros(definition) => definition.decode(&message.data),
        };
        let numbers = numbers.map_err(|reason| {
            format!(
                "has in {} a message that cannot be read: {reason}",
                topic.name
            )
        })?;
        let log_time = i128::from(message.log_time);
        let first = *first.get_or_insert(log_time);
        topic.set("log_time", "s", seconds_since(first, log_time, 1e9));
        let publish_time = i128::from(message.publish_time);
        topic.set("publish_time", "s", seconds_since(first, publish_time, 1e9));
        for (name, value) in numbers {
            topic.set(&name, "", value);
        }
        topic.end_row();
        let size: usize = read
            .iter()
            .map(|topic| topic.rows * topic.columns.len())
            .sum();
        check_size(size, most)?;
    }
    columns(read, &others)
}

fn columns(read: Vec<Topic>, others: &[String]) -> Result<Columns, String> {
    let left_out = others.join(", ");
    if read.is_empty() {
        let which = match others {
            [] => "it has no message".to_owned(),
            _ => format!("it has {left_out}"),
        };
        return Err(format!(
            "has no message of JSON or of ROS 2 (CDR with its .msg definition): {which}; convert it to one of \
             them, or export the topic as CSV"
        ));
    }
    let alone = read.len() == 1;
    let mut layout = format!("MCAP, topics: {}", read.len());
    if !others.is_empty() {
        layout += &format!(", left out: {left_out}");
    }
    let mut columns = Vec::new();
    for (group, topic) in read.into_iter().enumerate() {
        for mut column in topic.columns {
            column.group = group;
            column.values.resize(topic.rows, f64::NAN);
            if !alone {
                column.name = format!("{}.{}", topic.name, column.name);
            }
            columns.push(column);
        }
    }
    Ok(Columns { layout, columns })
}

/// What reads a channel's messages, or how they are encoded.
fn decoder(channel: &mcap::Channel) -> Result<Decoder, String> {
    let schema = channel.schema.as_ref();
    let definition = schema.filter(|schema| schema.encoding == "ros2msg");
    match (channel.message_encoding.as_str(), definition) {
        ("json", _) => Ok(Decoder::Json),
        ("cdr", Some(schema)) => {
            let text = String::from_utf8_lossy(&schema.data);
            Definition::parse(&schema.name, &text).map(Decoder::Ros)
        }
        (encoding, _) => Err(encoding.to_owned()),
    }
}

/// The numbers of a JSON message.
fn json(data: &[u8]) -> Result<Numbers, String> {
    let value: Value = serde_json::from_slice(data).map_err(|error| error.to_string())?;
    let mut numbers = Numbers::new();
    flatten(&value, "", &mut numbers);
    Ok(numbers)
}

fn flatten(value: &Value, name: &str, into: &mut Numbers) {
    let below = |part: &str| match name {
        "" => part.to_owned(),
        _ => format!("{name}.{part}"),
    };
    match value {
        Value::Number(number) => {
            into.push((name.to_owned(), number.as_f64().unwrap_or(f64::NAN)));
        }
        Value::Bool(value) => into.push((name.to_owned(), f64::from(u8::from(*value)))),
        Value::Object(fields) => {
            for (field, value) in fields {
                flatten(value, &below(field), into);
            }
        }
        Value::Array(elements) => {
            for (at, value) in elements.iter().take(LONGEST_ARRAY).enumerate() {
                flatten(value, &below(&at.to_string()), into);
            }
        }
        Value::Null | Value::String(_) => {}
    }
}
