//! What is typed reaches the chip and what the chip says reaches who listens, whole and in order, however small the rings are;
//! and nothing that stands in the chip's memory leads a probe to read or write elsewhere.

use std::cell::RefCell;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use rtt::{Channel, FAILURES, Memory, serve};

const RAM: Range<u32> = 0x2000_0000..0x2000_4000;

/// A block with two rings up and two down, as the images have it, and the buffers of channel 1.
const BLOCK: u32 = RAM.start + 0x124;
const UP: u32 = BLOCK + 24 + 24;
const DOWN: u32 = BLOCK + 24 + 3 * 24;
const UP_BYTES: u32 = RAM.start + 0x1001;
const DOWN_BYTES: u32 = RAM.start + 0x2002;
const UP_SIZE: u32 = 37;
const DOWN_SIZE: u32 = 11;

/// The RAM of a chip; every access elsewhere fails the test.
struct Ram(Vec<u8>);

impl Ram {
    fn empty() -> Self {
        Self(vec![0; RAM.len()])
    }

    fn with_block(at: u32) -> Self {
        let mut ram = Self::empty();
        ram.put(at, b"SEGGER RTT\0\0\0\0\0\0");
        ram.put_word(at + 16, 2);
        ram.put_word(at + 20, 2);
        ram.put_word(at - BLOCK + UP + 4, UP_BYTES);
        ram.put_word(at - BLOCK + UP + 8, UP_SIZE);
        ram.put_word(at - BLOCK + DOWN + 4, DOWN_BYTES);
        ram.put_word(at - BLOCK + DOWN + 8, DOWN_SIZE);
        ram
    }

    fn place(address: u32, count: usize) -> Range<usize> {
        let start = address.checked_sub(RAM.start).expect("before the RAM") as usize;
        assert!(start + count <= RAM.len(), "behind the RAM: {address:#x}");
        start..start + count
    }

    fn put(&mut self, address: u32, bytes: &[u8]) {
        self.0[Self::place(address, bytes.len())].copy_from_slice(bytes);
    }

    fn put_word(&mut self, address: u32, word: u32) {
        self.put(address, &word.to_le_bytes());
    }

    fn word(&self, address: u32) -> u32 {
        let bytes = &self.0[Self::place(address, 4)];
        u32::from_le_bytes(bytes.try_into().unwrap())
    }

    /// The chip says something; gives how much of it had room.
    fn say(&mut self, text: &[u8]) -> usize {
        for (count, &byte) in text.iter().enumerate() {
            let written = self.word(UP + 12);
            let next = (written + 1) % UP_SIZE;
            if next == self.word(UP + 16) {
                return count;
            }
            self.put(UP_BYTES + written, &[byte]);
            self.put_word(UP + 12, next);
        }
        text.len()
    }

    /// The chip reads what was typed.
    fn hear(&mut self) -> Vec<u8> {
        let mut heard = Vec::new();
        while self.word(DOWN + 16) != self.word(DOWN + 12) {
            let read = self.word(DOWN + 16);
            heard.push(self.0[Self::place(DOWN_BYTES + read, 1)][0]);
            self.put_word(DOWN + 16, (read + 1) % DOWN_SIZE);
        }
        heard
    }
}

impl Memory for Ram {
    type Error = String;

    fn read(&mut self, address: u32, bytes: &mut [u8]) -> Result<(), String> {
        bytes.copy_from_slice(&self.0[Self::place(address, bytes.len())]);
        Ok(())
    }

    fn write(&mut self, address: u32, bytes: &[u8]) -> Result<(), String> {
        self.put(address, bytes);
        Ok(())
    }
}

fn pair() -> (TcpStream, TcpStream) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let client = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
    (client, listener.accept().unwrap().0)
}

/// A text that shows where a byte is missing or twice.
fn text(count: usize) -> Vec<u8> {
    (0..count).map(|at| (at * 7 % 251) as u8).collect()
}

/// A chip that says a text as far as there is room, and says back what it hears.
#[test]
fn a_program_that_connects_hears_and_types_many_times_what_the_rings_hold() {
    let ram = Arc::new(Mutex::new(Ram::with_block(BLOCK)));
    let (client, served) = pair();
    let chip = ram.clone();
    let is_running = Arc::new(AtomicBool::new(true));
    let runs = is_running.clone();
    let chip = thread::spawn(move || {
        let (said, mut at, mut heard) = (text(3000), 0, Vec::new());
        loop {
            // It hears once more behind the end.
            let is_last = !runs.load(Relaxed);
            let mut ram = chip.lock().unwrap();
            at += ram.say(&said[at..]);
            heard.extend(ram.hear());
            drop(ram);
            if is_last {
                return heard;
            }
            thread::sleep(Duration::from_millis(1));
        }
    });
    let bridge = thread::spawn(move || {
        let mut channel = Channel::new(RAM, 1);
        serve(
            served,
            |typed| channel.exchange(&mut *ram.lock().unwrap(), typed),
            || false,
        )
    });
    let mut heard = vec![0; 3000];
    (&client).write_all(&text(500)).unwrap();
    (&client).read_exact(&mut heard).unwrap();
    assert_eq!(heard, text(3000));
    // What is typed last is not lost.
    (&client).write_all(b"end").unwrap();
    client.shutdown(std::net::Shutdown::Write).unwrap();
    assert_eq!(bridge.join().unwrap(), Ok(()));
    is_running.store(false, Relaxed);
    let mut typed = text(500);
    typed.extend(b"end");
    assert_eq!(chip.join().unwrap(), typed);
}

#[test]
fn no_block_is_found_where_there_is_none_or_it_has_no_such_channel() {
    for (mut ram, number) in [
        (Ram::empty(), 1),
        (Ram::with_block(BLOCK), 2),
        // Its end is behind the RAM's.
        (
            {
                let mut ram = Ram::empty();
                ram.put(RAM.end - 16, b"SEGGER RTT\0\0\0\0\0\0");
                ram
            },
            1,
        ),
    ] {
        let mut channel = Channel::new(RAM, number);
        assert_eq!(channel.find(&mut ram), Ok(false));
        let mut typed = b"arm\r".to_vec();
        assert_eq!(channel.exchange(&mut ram, &mut typed), Ok(Vec::new()));
        assert!(
            typed.is_empty(),
            "an order that nobody heard is given later"
        );
    }
}

#[test]
fn a_block_that_goes_is_looked_for_again() {
    let mut ram = Ram::with_block(BLOCK);
    let mut channel = Channel::new(RAM, 1);
    assert_eq!(channel.find(&mut ram), Ok(true));
    let mut ram = Ram::with_block(BLOCK + 0x800);
    let mut typed = b"stop\r".to_vec();
    assert_eq!(channel.exchange(&mut ram, &mut typed), Ok(Vec::new()));
    assert_eq!(
        ram.0,
        Ram::with_block(BLOCK + 0x800).0,
        "it wrote where a block was"
    );
    typed = b"stop\r".to_vec();
    channel.exchange(&mut ram, &mut typed).unwrap();
    assert!(typed.is_empty());
    assert_eq!(ram.word(DOWN + 0x800 + 12), 5);
}

/// Any word of a ring's description may be anything: a chip that starts, or an image that writes over it.
#[test]
fn a_damaged_description_leads_nowhere_and_is_not_written_to() {
    let odd = [
        1,
        UP_SIZE,
        RAM.start - 1,
        RAM.end - 1,
        RAM.end,
        0x7FFF_FFFF,
        u32::MAX - 1,
        u32::MAX,
    ];
    for ring in [UP, DOWN] {
        for offset in [4, 8, 12, 16] {
            for word in odd {
                let mut ram = Ram::with_block(BLOCK);
                ram.say(b"hello");
                ram.put_word(ring + offset, word);
                let before = ram.0.clone();
                let mut channel = Channel::new(RAM, 1);
                let mut typed = b"typed".to_vec();
                // `Ram` sees to it that nothing outside is touched.
                channel.exchange(&mut ram, &mut typed).unwrap();
                for (at, (now, before)) in ram.0.iter().zip(&before).enumerate() {
                    let address = RAM.start + at as u32;
                    let describes = (BLOCK..DOWN + 12).contains(&address)
                        && !(UP + 16..UP + 20).contains(&address);
                    assert!(
                        !describes || now == before,
                        "{ring:#x} {offset} {word:#x}: {address:#x} was written"
                    );
                }
            }
        }
    }
}

#[test]
fn it_ends_when_it_is_told_to_and_where_the_chip_no_longer_answers() {
    let (_client, served) = pair();
    let ended = serve(served, |_| Ok::<_, String>(Vec::new()), || true);
    assert_eq!(ended, Ok(()));

    let (_client, served) = pair();
    let asked = RefCell::new(0);
    let fails = |_: &mut Vec<u8>| {
        *asked.borrow_mut() += 1;
        Err::<Vec<u8>, _>(format!("failure {}", asked.borrow()))
    };
    let ended = serve(served, fails, || false);
    assert_eq!(ended, Err(format!("failure {FAILURES}")));

    // What is disturbed now and then goes on, with all that was typed.
    let (client, served) = pair();
    let mut ram = Ram::with_block(BLOCK);
    let mut channel = Channel::new(RAM, 1);
    let mut rounds = 0;
    let mut heard = Vec::new();
    (&client).write_all(&text(25)).unwrap();
    let disturbed = |typed: &mut Vec<u8>| {
        rounds += 1;
        if rounds % FAILURES != 0 {
            return Err("disturbed".to_owned());
        }
        let said = channel.exchange(&mut ram, typed);
        heard.extend(ram.hear());
        if heard.len() == 25 {
            client.shutdown(std::net::Shutdown::Both).unwrap();
        }
        said
    };
    assert_eq!(serve(served, disturbed, || false), Ok(()));
    assert_eq!(heard, text(25));
}
