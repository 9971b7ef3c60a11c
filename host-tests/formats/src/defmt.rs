//! A board's defmt log, whose words are in the image that sent it.

use std::io::{self, BufWriter, ErrorKind, Read, Write};

use defmt_decoder::{DecodeError, Encoding, Table};
use serde_json::{Value, json};

use super::guard::guarded;

/// Bytes of the log that are read at once.
const READ: usize = 1 << 16;

/// The words of an image's log.
pub struct Dictionary {
    table: Table,
}

impl Dictionary {
    /// The words of the image in an ELF file.
    pub fn of_bytes(elf: &[u8]) -> Result<Self, String> {
        let table = guarded(|| Table::parse(elf))
            .unwrap_or_else(|| Ok(None))
            .map_err(|error| {
                format!("{error:#}; expected the board's image (ELF) with a defmt log")
            })?
            .ok_or("has no defmt log; expected the image that wrote the log")?;
        if table.encoding() == Encoding::Rzcobs {
            Ok(Self { table })
        } else {
            Err("logs in another encoding than defmt's default, rzcobs; expected that".to_owned())
        }
    }

    /// Writes a line for each frame of a log: `{"line": {"time", "level", "message"}}` or `"damaged"`. A frame ends
    /// with a zero byte, and is passed on when that has come; what follows the last is damaged.
    pub fn pass_on(&self, mut log: impl Read, to: impl Write) -> io::Result<()> {
        let mut to = BufWriter::new(to);
        let mut bytes = vec![0; READ];
        let mut begun = Vec::new();
        loop {
            let read = match log.read(&mut bytes) {
                Ok(0) => break,
                Ok(read) => read,
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
            for part in bytes[..read].split_inclusive(|&byte| byte == 0) {
                begun.extend(part);
                if part.ends_with(&[0]) {
                    self.write_frame(&begun, &mut to)?;
                    begun.clear();
                }
            }
            to.flush()?;
        }
        self.write_frame(&begun, &mut to)?;
        to.flush()
    }

    fn write_frame(&self, frame: &[u8], mut to: impl Write) -> io::Result<()> {
        // An empty frame is what defmt starts each one with.
        if matches!(frame, [] | [0]) {
            return Ok(());
        }
        let said = self.decode(frame).unwrap_or_else(|| json!("damaged"));
        writeln!(to, "{said}")
    }

    fn decode(&self, frame: &[u8]) -> Option<Value> {
        // A fresh decoder for each frame: one for the whole log moves all of what follows each time.
        let mut decoder = self.table.new_stream_decoder();
        // The decoder trusts its input in places, and a damaged frame may say anything.
        let line: Result<Value, DecodeError> = guarded(|| {
            decoder.received(frame);
            let frame = decoder.decode()?;
            let time = frame.display_timestamp().map(|time| time.to_string());
            let level = frame.level().map(|level| level.as_str().to_uppercase());
            Ok(json!({"line": {
                "time": time.unwrap_or_default(),
                "level": level.unwrap_or_default(),
                "message": frame.display_message().to_string(),
            }}))
        })?;
        line.ok()
    }
}
