//! A board's console, asked and answered.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use firmware::app::console::editor::PROMPT;
use firmware::app::operation::live::Live;

use super::Line;
use super::demultiplexer::Demultiplexer;
use crate::failure::Failure;

/// How long an answer may take: an emulated chip is slower than a real one, and the longest answer takes 0.3 s
/// at 115,200 baud.
const ANSWER: Duration = Duration::from_secs(10);

/// How long nothing at all may come of what is under way.
const SILENCE: Duration = Duration::from_secs(10);

/// What to look at where nothing comes.
const REMEDY: &str = "check that the board has power, that its image is `controller` or `throttle` of this version, and \
                      with a serial port that its PB6 and PB7 go to the adapter's RX and TX with the grounds joined";

/// A board's console.
pub struct Console<'l> {
    line: &'l mut dyn Line,
    received: Demultiplexer,
    /// Text that nothing was made of yet.
    text: String,
    /// Text beside the answers.
    announced: String,
}

impl<'l> Console<'l> {
    /// At the end of this line. What stood in it, a half line, is taken back.
    ///
    /// # Errors
    /// A board that does not answer.
    pub fn new(line: &'l mut dyn Line) -> Result<Self, Failure> {
        let mut console = Self {
            line,
            received: Demultiplexer::default(),
            text: String::new(),
            announced: String::new(),
        };
        console.send(b"\x03")?;
        console.quiet()?;
        Ok(console)
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        let sent = self.line.write_all(bytes).and_then(|()| self.line.flush());
        sent.map_err(|error| Failure::system("the line to the board", error))
    }

    /// Reads what is there; false if nothing came.
    fn receive(&mut self) -> Result<bool, Failure> {
        let mut bytes = [0; 1024];
        match self.line.read(&mut bytes) {
            Ok(0) => Err(Failure::other("the line to the board ended")),
            Ok(read) => {
                self.received.take(&bytes[..read]);
                self.text += &self.received.text();
                Ok(true)
            }
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {
                Ok(false)
            }
            Err(error) => Err(Failure::system("the line to the board", error)),
        }
    }

    /// What a line is answered, without the prompt.
    ///
    /// # Errors
    /// No answer.
    pub fn ask(&mut self, line: &str) -> Result<String, Failure> {
        self.announced += &std::mem::take(&mut self.text);
        self.send(format!("{line}\r").as_bytes())?;
        let echo = format!("{line}\r\n");
        let end = format!("\r\n{PROMPT}");
        let begun = Instant::now();
        while begun.elapsed() < ANSWER {
            self.receive()?;
            let answer = self.text.split_once(&echo).map(|(_, behind)| behind);
            if let Some((answer, behind)) = answer.and_then(|answer| answer.split_once(&end)) {
                let answer = answer.replace("\r\n", "\n");
                self.text = behind.to_owned();
                return Ok(answer);
            }
        }
        Err(Failure::other(format!(
            "the board does not answer `{line}`; {REMEDY}"
        )))
    }

    /// Has a line done.
    ///
    /// # Errors
    /// No answer; a line that is refused.
    pub fn order(&mut self, line: &str) -> Result<(), Failure> {
        match self.ask(line)?.as_str() {
            "ok" => Ok(()),
            answer => Err(Failure::other(format!("`{line}`: {answer}"))),
        }
    }

    /// Ends what the board says of its drive by itself, and drops what it has said so far.
    ///
    /// # Errors
    /// As [`Console::order`].
    pub fn quiet(&mut self) -> Result<(), Failure> {
        // The line may still hold what another program was answered, `stream 0` too. So the rate is a zero that nobody has
        // written before.
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let exponent = now.map_or(0, |now| now.as_micros() % 1_000_000_000);
        self.order(&format!("stream 0e{exponent}"))?;
        self.received.frames();
        Ok(())
    }

    /// The frames that came since, once there are any.
    ///
    /// # Errors
    /// None for so long that there will be none; a damaged one.
    pub fn frames(&mut self) -> Result<Vec<String>, Failure> {
        let begun = Instant::now();
        while begun.elapsed() < SILENCE {
            self.receive()?;
            if self.received.damaged() > 0 {
                return Err(Failure::other(
                    "what came over the line was damaged on its way; check the cable, the grounds and that \
                     nothing else reads the port, and do it again",
                ));
            }
            let frames = self.received.frames();
            if !frames.is_empty() {
                return Ok(frames);
            }
        }
        Err(Failure::other(format!(
            "the board has sent nothing for {} s; {REMEDY}",
            SILENCE.as_secs()
        )))
    }

    /// The frames that came since, if there are any. What was damaged is left out.
    ///
    /// # Errors
    /// A line that ends.
    pub fn poll(&mut self) -> Result<Vec<String>, Failure> {
        self.receive()?;
        Ok(self.received.frames())
    }

    /// What the board said by itself since this was last asked, line by line.
    pub fn announced(&mut self) -> Vec<String> {
        // What has no prompt behind it yet is not whole.
        if self.text.ends_with(PROMPT) {
            self.announced += &std::mem::take(&mut self.text);
        }
        let announced = std::mem::take(&mut self.announced);
        let lines = announced.lines();
        let lines = lines.map(|line| line.trim_start_matches(PROMPT).trim().to_owned());
        lines.filter(|line| !line.is_empty()).collect()
    }

    /// How the drive is, as it last said.
    ///
    /// # Errors
    /// As [`Console::frames`].
    pub fn live(&mut self) -> Result<Live, Failure> {
        loop {
            let frames = self.frames()?;
            if let Some(live) = frames.iter().rev().find_map(|frame| Live::read(frame)) {
                return Ok(live);
            }
        }
    }

    /// All parameters, as the board writes their numbers.
    ///
    /// # Errors
    /// As [`Console::ask`].
    pub fn parameters(&mut self) -> Result<BTreeMap<String, String>, Failure> {
        let shown = self.ask("show")?;
        let parameter = |line: &str| {
            let (name, rest) = line.split_once(" = ")?;
            let value = rest.split(' ').next()?;
            Some((name.to_owned(), value.to_owned()))
        };
        Ok(shown.lines().filter_map(parameter).collect())
    }

    /// Takes the drive's power, whatever else stands in the line.
    ///
    /// # Errors
    /// A drive that does not say that it has none any more.
    pub fn disarm(&mut self) -> Result<(), Failure> {
        self.send(b"\x03")?;
        let answered = match self.order("stop") {
            // An answer that was lost: once more.
            Err(_) => self.order("stop"),
            done => done,
        };
        answered.map_err(|failure| {
            Failure::other(format!(
                "the board did not say that its drive is disarmed: take the power of the bridge ({failure})"
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;
    use std::io::{self, Read, Write};

    use firmware::app::console::frame;

    use super::*;

    /// A board that answers `ok`, on a line that still holds what another program was sent.
    struct Used {
        held: VecDeque<String>,
        asked: String,
    }

    impl Read for Used {
        fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
            let said = self.held.pop_front().ok_or(ErrorKind::TimedOut)?;
            said.as_bytes().read(bytes)
        }
    }

    impl Write for Used {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.asked += str::from_utf8(bytes).unwrap().trim_start_matches('\x03');
            while let Some((line, rest)) = self.asked.split_once('\r') {
                self.held.push_back(format!("{line}\r\nok\r\n{PROMPT}"));
                self.asked = rest.to_owned();
            }
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn what_another_program_was_told_is_no_answer_and_no_news() {
        let live = Live::default();
        let mut told = String::new();
        frame::write(&mut told, format_args!("{live}")).unwrap();
        let answer = format!("stream 0\r\nok\r\n{PROMPT}");
        let mut line = Used {
            held: [answer, told].into(),
            asked: String::new(),
        };
        let mut console = Console::new(&mut line).unwrap();
        assert_eq!(console.poll().unwrap(), [""; 0]);
        console.quiet().unwrap();
    }
}
