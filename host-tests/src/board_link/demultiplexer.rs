//! What a board sends, taken apart: text for people, and frames for programs.

use firmware::app::console::frame;

/// Most bytes of a frame that are waited for: what is longer has lost its end.
const LONGEST: usize = frame::FRAME;

/// Takes the bytes that a board sends.
#[derive(Debug, Default)]
pub struct Demultiplexer {
    /// The frame so far, without its beginning; none outside one.
    frame: Option<Vec<u8>>,
    /// Text since it was last taken.
    text: Vec<u8>,
    /// Frames since they were last taken.
    frames: Vec<String>,
    /// Frames that were damaged on the line.
    damaged: usize,
}

impl Demultiplexer {
    /// Takes bytes.
    pub fn take(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            match (&mut self.frame, byte) {
                (before, 0x1e) => {
                    self.damaged += usize::from(before.is_some());
                    *before = Some(Vec::new());
                }
                (None, _) => self.text.push(byte),
                (Some(_), b'\n') => self.end(),
                (Some(frame), _) if frame.len() > LONGEST => {
                    self.frame = None;
                    self.damaged += 1;
                }
                (Some(frame), _) => frame.push(byte),
            }
        }
    }

    fn end(&mut self) {
        let bytes = self.frame.take().unwrap_or_default();
        let text = str::from_utf8(&bytes).ok();
        match text.and_then(|text| frame::read(text.trim_end())) {
            Some(text) => self.frames.push(text.to_owned()),
            None => self.damaged += 1,
        }
    }

    /// The frames since they were last taken.
    pub fn frames(&mut self) -> Vec<String> {
        std::mem::take(&mut self.frames)
    }

    /// The text since it was last taken. Bytes that are no text are replaced.
    pub fn text(&mut self) -> String {
        String::from_utf8_lossy(&std::mem::take(&mut self.text)).into_owned()
    }

    /// Frames that were damaged on the line, so far.
    pub fn damaged(&self) -> usize {
        self.damaged
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn framed(text: &str) -> String {
        let mut line = String::new();
        frame::write(&mut line, format_args!("{text}")).unwrap();
        line
    }

    #[test]
    fn text_and_frames_come_apart_wherever_the_bytes_are_cut() {
        let sent = format!("arm\r\n{}ok\r\n{}> ", framed("live 1"), framed("live 2"));
        for cut in 0..sent.len() {
            let (first, second) = sent.as_bytes().split_at(cut);
            let mut demultiplexer = Demultiplexer::default();
            demultiplexer.take(first);
            demultiplexer.take(second);
            assert_eq!(demultiplexer.text(), "arm\r\nok\r\n> ");
            assert_eq!(demultiplexer.frames(), ["live 1", "live 2"]);
            assert_eq!(demultiplexer.damaged(), 0);
        }
    }

    #[test]
    fn a_frame_with_a_lost_or_another_byte_is_damaged_and_the_next_one_is_not() {
        let whole = framed("row 0 00ff");
        for place in 1..whole.len() - 2 {
            let mut lost = whole.clone().into_bytes();
            lost.remove(place);
            let mut other = whole.clone().into_bytes();
            other[place] ^= 1;
            for damaged in [lost, other] {
                let mut demultiplexer = Demultiplexer::default();
                demultiplexer.take(&damaged);
                demultiplexer.take(framed("end 1").as_bytes());
                assert_eq!(demultiplexer.frames(), ["end 1"], "{place}");
                assert_eq!(demultiplexer.damaged(), 1, "{place}");
            }
        }
    }
}
