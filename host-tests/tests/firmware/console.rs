//! The console: every command takes what it should and refuses the rest with its place and what was
//! expected; and whatever bytes come, each line has one response.

use firmware::app::capture::{Edge, Quantities, Quantity, Settings, Trigger};
use firmware::app::console::LONGEST_ANSWER;
use firmware::app::console::command::{COMMANDS, Command, Presence};
use firmware::app::console::editor::{Editor, Event, LINE};
use firmware::app::console::injection::INJECTIONS;
use firmware::app::console::parse::{Line, parse};
use firmware::app::console::request::{Destination, Dump, Home, Mode, Request};
use firmware::app::ecu::loopback;
use firmware::app::fault::{Fault as Latched, Faults};
use firmware::app::machine::THROTTLE;
use firmware::app::operation::homing::Switch;
use firmware::app::profile::Signal;
use host_tests::console_on_host::{ConsoleOnHost, PARAMETERS, exercise};
use model_core::numeric::random::Random;
use model_core::plant::potentiometer::TrackFault;
use model_core::plant::throttle::{Fault, Side};
use model_core::signal::{ramp, sine, step, sweep, triangle};
use proptest::prelude::*;

/// A line that is a request.
fn request(line: &str) -> Request {
    match parse(line, &PARAMETERS) {
        Ok(Line::Request(request)) => request,
        other => panic!("{line}: {other:?}"),
    }
}

/// The first line of what is said of a line, which is an error.
fn error(line: &str) -> String {
    let error = parse(line, &PARAMETERS).expect_err(line).to_string();
    error.lines().next().unwrap_or_default().to_owned()
}

#[test]
fn every_command_without_arguments_is_what_it_says() {
    let lines = [
        ("status", Request::Status),
        ("faults", Request::Faults),
        ("clear", Request::Clear),
        ("arm", Request::Arm),
        ("disarm", Request::Disarm),
        ("stop", Request::Disarm),
        ("ping", Request::Ping),
        ("hold", Request::Hold),
        ("zero", Request::Zero),
        ("heal", Request::Body(loopback::Command::Heal)),
        ("refit", Request::Refit),
        ("check", Request::Check),
        ("save", Request::Save),
    ];
    for (line, expected) in lines {
        assert_eq!(request(line), expected);
        assert_eq!(request(&format!("   {line}\t ")), expected);
        let column = line.len() + 2;
        assert_eq!(
            error(&format!("{line} now")),
            format!("error: column {column}: `now` is too much; expected the end of the line")
        );
    }
    let listed = COMMANDS
        .iter()
        .filter(|command| command.arguments.is_empty());
    assert_eq!(listed.count(), lines.len(), "a command that is not tested");
}

#[test]
fn a_switch_that_is_sought_has_a_place_and_a_speed() {
    let home = Request::Home(Home {
        switch: Switch::Lower,
        position: -0.9,
        speed: 0.2,
    });
    assert_eq!(request("home lower -0.9 0.2"), home);
    for (line, column) in [
        ("home", 5),
        ("home left 0 1", 6),
        ("home upper", 11),
        ("home upper 2000 1", 12),
        ("home upper nan 1", 12),
        ("home upper 0.9", 15),
        ("home upper 0.9 0", 16),
        ("home upper 0.9 -1", 16),
        ("home upper 0.9 1 2", 18),
    ] {
        let refused = parse(line, &PARAMETERS).expect_err(line);
        assert_eq!(refused.column, column, "{line}: {refused}");
    }
}

#[test]
fn what_is_dumped_where_and_how_often_the_drive_is_told_of() {
    let lines = [
        ("dump", Request::Dump(Dump::Capture)),
        ("dump capture", Request::Dump(Dump::Capture)),
        ("dump log", Request::Dump(Dump::Log(Destination::Rtt))),
        ("dump log rtt", Request::Dump(Dump::Log(Destination::Rtt))),
        (
            "dump log console",
            Request::Dump(Dump::Log(Destination::Console)),
        ),
        ("stream 0", Request::Stream(0.0)),
        ("stream 100", Request::Stream(100.0)),
    ];
    for (line, expected) in lines {
        assert_eq!(request(line), expected, "{line}");
    }
    for (line, place) in [
        ("dump logs", 6),
        ("dump capture console", 14),
        ("dump log uart", 10),
        ("dump log rtt now", 14),
        ("stream", 7),
        ("stream -1", 8),
        ("stream 101", 8),
        ("stream 10 Hz", 11),
    ] {
        let error = error(line);
        assert!(
            error.starts_with(&format!("error: column {place}:")),
            "{line}: {error}"
        );
    }
}

#[test]
fn signals_have_their_parameters_in_order_and_without_the_optional_one() {
    let lines = [
        (
            "step -1 2.5e-1 3",
            Signal::Step(step::Parameters {
                initial_value: -1.0,
                final_value: 0.25,
                time: 3.0,
            }),
        ),
        (
            "step 0 1",
            Signal::Step(step::Parameters {
                initial_value: 0.0,
                final_value: 1.0,
                time: 0.0,
            }),
        ),
        (
            "ramp 0 1 2 3",
            Signal::Ramp(ramp::Parameters {
                initial_value: 0.0,
                final_value: 1.0,
                start: 3.0,
                duration: 2.0,
            }),
        ),
        (
            "sine 0.1 0.2 3",
            Signal::Sine(sine::Parameters {
                offset: 0.1,
                amplitude: 0.2,
                frequency: 3.0,
                phase: 0.0,
            }),
        ),
        (
            "sweep 0 0.5 0.2 4 10",
            Signal::Sweep(sweep::Parameters {
                offset: 0.0,
                amplitude: 0.5,
                initial_frequency: 0.2,
                final_frequency: 4.0,
                duration: 10.0,
            }),
        ),
        (
            "triangle 0 0.7 0.5 1.5",
            Signal::Triangle(triangle::Parameters {
                offset: 0.0,
                amplitude: 0.7,
                frequency: 0.5,
                phase: 1.5,
            }),
        ),
    ];
    for (line, signal) in lines {
        assert_eq!(request(line), Request::Signal(signal), "{line}");
        assert_eq!(line.split(' ').next(), Some(signal.name()));
    }
}

#[test]
fn a_malformed_line_is_told_where_and_what_was_expected() {
    let lines = [
        ("stat", "column 1: `stat` is no command; `help` lists them"),
        (
            "  Status",
            "column 3: `Status` is no command; `help` lists them",
        ),
        (
            "help stat",
            "column 6: `stat` is no command; `help` lists them",
        ),
        (
            "mode",
            "column 5: the line ends; expected mode: position, voltage or wires",
        ),
        (
            "mode torque",
            "column 6: `torque` is unknown; expected mode: position, voltage or wires",
        ),
        (
            "step 0",
            "column 7: the line ends; expected final_value: rad or V, as the mode is",
        ),
        (
            "step 0 one",
            "column 8: `one` is no finite number; expected final_value: rad or V, as the mode is",
        ),
        (
            "step 0 nan",
            "column 8: `nan` is no finite number; expected final_value: rad or V, as the mode is",
        ),
        (
            "step 0 1e99",
            "column 8: `1e99` is no finite number; expected final_value: rad or V, as the mode is",
        ),
        (
            "step 0 1,5",
            "column 8: `1,5` is no finite number; expected final_value: rad or V, as the mode is",
        ),
        (
            "step 0 2e6",
            "column 8: 2e6 is out of bounds; expected -1000000.0 to 1000000.0 rad or V, as the mode is",
        ),
        (
            "step 0 1 -1",
            "column 10: time must be zero or positive, and below 2^32 periods",
        ),
        (
            "step 0 1 0 7",
            "column 12: `7` is too much; expected the end of the line",
        ),
        (
            "ramp 0 1 0",
            "column 10: duration must be at least one period",
        ),
        (
            "sine 0 1 501",
            "column 10: frequency must be between zero and half the sample rate",
        ),
        (
            "sweep 0 1 1 -1 1",
            "column 13: final_frequency must be between zero and half the sample rate",
        ),
        (
            "sweep 0 1 1 2",
            "column 14: the line ends; expected duration: s",
        ),
        (
            "triangle 0 1 -3",
            "column 14: frequency must be between zero and half the sample rate",
        ),
        (
            "show mass",
            "column 6: `mass` is unknown; expected parameter: a parameter's name; `show` lists them",
        ),
        (
            "set",
            "column 4: the line ends; expected parameter: a parameter's name; `show` lists them",
        ),
        (
            "set coulomb",
            "column 12: the line ends; expected value: in the parameter's unit",
        ),
        (
            "set coulomb x",
            "column 13: `x` is no finite number; expected value: in the parameter's unit",
        ),
        (
            "set coulomb -0.1",
            "column 13: -0.1 is out of bounds; expected 0.0 to 100.0 N·m",
        ),
        (
            "set resistance 0",
            "column 16: 0 is out of bounds; expected 0.001 to 1000.0 Ω",
        ),
        (
            "inject motor_shorted",
            "column 21: the line ends; expected value: a factor to friction_raised, ohm to motor_shorted, V to offset and noisy",
        ),
        (
            "inject motor_shorted 2",
            "column 22: 2 is out of bounds; expected 0.001 to 1.0 ohm",
        ),
        (
            "inject motor_open 1",
            "column 19: `1` is too much; expected the end of the line",
        ),
        (
            "supply 20.1",
            "column 8: 20.1 is out of bounds; expected 0.0 to 20.0 V",
        ),
        (
            "record 1 -2 now",
            "column 10: `-2` is no whole number from 0 to 4294967295; expected after: rows from the trigger's on",
        ),
        (
            "record 1 2 later",
            "column 12: `later` is unknown; expected trigger: now, command, fault, rising or falling",
        ),
        (
            "record 1 2 rising speed",
            "column 19: `speed` is unknown; expected of: command, input, position, current_a, true_position, true_velocity or true_current_a",
        ),
        (
            "record 1 2 rising position",
            "column 27: the line ends; expected level: in the quantity's unit",
        ),
        (
            "record 1 2 rising position inf",
            "column 28: `inf` is no finite number; expected level: in the quantity's unit",
        ),
        (
            "record 1 2 now speed",
            "column 16: `speed` is unknown; expected quantity: command, input, position, current_a, true_position, true_velocity or true_current_a",
        ),
        ("record 1 0 now", "column 8: after must be at least one row"),
        (
            "record 4294967295 4294967295 now",
            "column 8: before and after are more rows than there is room for; ask for less of either, or for fewer quantities",
        ),
    ];
    for (line, expected) in lines {
        assert_eq!(error(line), format!("error: {expected}"), "{line}");
    }
}

#[test]
fn an_error_behind_a_command_tells_how_it_is_used() {
    let error = parse("sine 0", &PARAMETERS).unwrap_err().to_string();
    let usage = "usage: sine offset amplitude frequency [phase]";
    assert_eq!(error.lines().nth(1), Some(usage));
}

#[test]
fn every_fault_can_be_injected_within_the_bounds_that_the_body_takes() {
    for injection in &INJECTIONS {
        let values = match injection.value {
            Some(bounds) => vec![
                format!(" {:?}", bounds.lower),
                format!(" {:?}", bounds.upper),
            ],
            None => vec![String::new()],
        };
        for value in values {
            let mut host = ConsoleOnHost::with_body(THROTTLE.plant);
            let line = format!("inject {}{value}", injection.name);
            assert_eq!(host.line_response(&line), "ok", "{line}");
        }
    }
    let lines = [
        ("plate_jammed", Fault::PlateJammed),
        ("friction_raised 1.8", Fault::FrictionRaised(1.8)),
        ("motor_shorted 0.2", Fault::MotorShorted(0.2)),
        (
            "first_track_stuck",
            Fault::Track(Side::First, TrackFault::Stuck),
        ),
        (
            "second_track_noisy 0.05",
            Fault::Track(Side::Second, TrackFault::Noisy(0.05)),
        ),
        (
            "first_track_offset -0.3",
            Fault::Track(Side::First, TrackFault::Offset(-0.3)),
        ),
    ];
    for (line, fault) in lines {
        let expected = Request::Body(loopback::Command::Inject(fault));
        assert_eq!(request(&format!("inject {line}")), expected);
    }
    let supply = Request::Body(loopback::Command::Supply(13.5));
    assert_eq!(request("supply 13.5"), supply);
}

#[test]
fn a_capture_is_asked_for_with_its_trigger_and_its_quantities() {
    let settings = |before, after, trigger, quantities| {
        Request::Record(Settings {
            quantities,
            trigger,
            before,
            after,
        })
    };
    let log = Quantities::LOG;
    assert_eq!(
        request("record 0 512 now"),
        settings(0, 512, Trigger::Now, log)
    );
    assert_eq!(
        request("record 10 20 fault"),
        settings(10, 20, Trigger::Fault, log)
    );
    let velocity = Quantities::default().with(Quantity::TrueVelocity);
    assert_eq!(
        request("record 48 2000 command true_velocity true_velocity"),
        settings(48, 2000, Trigger::Command, velocity)
    );
    let level = |edge| Trigger::Level {
        quantity: Quantity::Current,
        edge,
        level: -1.5,
    };
    let two = Quantities::default()
        .with(Quantity::Position)
        .with(Quantity::Command);
    assert_eq!(
        request("record 1 2 falling current_a -1.5 position command"),
        settings(1, 2, level(Edge::Falling), two)
    );
    assert_eq!(
        request("record 1 2 rising current_a -1.5"),
        settings(1, 2, level(Edge::Rising), log)
    );
    // Four quantities share 2048 values.
    assert!(error("record 1 512 now").contains("more rows"));
}

#[test]
fn help_lists_every_command_and_every_argument() {
    let mut host = ConsoleOnHost::new();
    let all = host.line_response("help");
    assert_eq!(all.lines().count(), COMMANDS.len());
    for command in &COMMANDS {
        let line = all
            .lines()
            .find(|line| line.split([' ', ':']).next() == Some(command.name));
        assert!(
            line.is_some_and(|line| line.contains(command.help)),
            "{}",
            command.name
        );
        let one = host.line_response(&format!("help {}", command.name));
        assert_eq!(one.lines().count(), 1 + command.arguments.len());
        for argument in command.arguments {
            assert!(one.contains(&format!("{}: {}", argument.name, argument.values)));
        }
    }
}

#[test]
fn what_is_set_is_shown_to_the_last_bit() {
    let mut host = ConsoleOnHost::new();
    let mut random = Random::new(1, 0);
    for round in 0..2000 {
        let place = round % PARAMETERS.len();
        let description = &PARAMETERS[place];
        let value = description.lower + (description.upper - description.lower) * random.uniform();
        let set = host.line_response(&format!("set {} {value}", description.name));
        assert_eq!(set, "ok");
        let shown = host.line_response(&format!("show {}", description.name));
        let mut words = shown.split(' ');
        assert_eq!(words.next(), Some(description.name));
        assert_eq!(words.next(), Some("="));
        let read: f32 = words.next().unwrap().parse().unwrap();
        assert_eq!(read.to_bits(), value.to_bits(), "{shown}");
        assert_eq!(words.next(), Some(description.unit));
        assert!(host.line_response("show").lines().any(|line| line == shown));
    }
}

#[test]
fn a_fault_is_seen_and_cleared_from_the_console() {
    let mut host = ConsoleOnHost::new();
    assert_eq!(host.line_response("faults"), "none");
    assert_eq!(host.line_response("arm"), "ok");
    host.latch.watch(Latched::OverVoltage.into(), 20_000);
    let faults = host.line_response("faults");
    assert!(
        faults.starts_with("first: over_voltage at 1.00000 s\nover_voltage, holds now: "),
        "{faults}"
    );
    let status = host.line_response("status");
    assert!(status.starts_with("armed, position mode"), "{status}");
    assert!(status.contains("\nlatched: over_voltage\n"), "{status}");
    assert_eq!(
        host.line_response("clear"),
        "refused: the drive is armed; `disarm` it first"
    );
    assert_eq!(host.line_response("disarm"), "ok");
    assert_eq!(
        host.line_response("clear"),
        "refused: still there: over_voltage; end that first"
    );
    host.latch.watch(Faults::NONE, 30_000);
    assert_eq!(
        host.line_response("arm"),
        "refused: latched: over_voltage; see `faults`, `clear`"
    );
    assert_eq!(host.line_response("clear"), "ok");
    assert_eq!(host.line_response("mode voltage"), "ok");
    assert!(
        host.line_response("status")
            .starts_with("disarmed, voltage mode")
    );
    assert_eq!(host.mode, Mode::Voltage);
}

/// What a terminal shows for these bytes, and the requests that they are.
fn typed(bytes: &[u8]) -> (String, Vec<Request>) {
    let mut host = ConsoleOnHost::new();
    let shown = bytes.iter().map(|&byte| host.take(byte)).collect();
    (shown, host.requests)
}

#[test]
fn a_line_is_edited_and_echoed() {
    let (shown, requests) = typed(b"arx\x7fm\r");
    assert_eq!(shown, "arx\x08 \x08m\r\nok\r\n> ");
    assert_eq!(requests, [Request::Arm]);
    // Nothing is taken back that is not there.
    assert_eq!(typed(b"\x08\x7farm\r").1, [Request::Arm]);
    assert_eq!(typed(b"disarm\x15arm\r").1, [Request::Arm]);
    let (shown, requests) = typed(b"disarm\x03arm\r\n");
    assert_eq!(shown, "disarm^C\r\n> arm\r\nok\r\n> ");
    assert_eq!(requests, [Request::Arm]);
    // Up and Ctrl-P fetch the last line, the other arrows and keys do nothing.
    let last = [Request::Arm, Request::Arm];
    assert_eq!(typed(b"arm\rxyz\x1b[A\r").1, last);
    assert_eq!(
        typed(b"arm\r\n\r\x10\r").1,
        last,
        "a blank line is none to fetch"
    );
    assert_eq!(
        typed(b"a\x1b[Br\x1b[1;5Cm\x1b[3~\x1bOP\x1b[D\r").1,
        [Request::Arm]
    );
    assert_eq!(typed(b"\x1b[A\r").1, []);
    // A line feed ends a line too, but not once more.
    assert_eq!(typed(b"arm\n").1, [Request::Arm]);
    assert_eq!(typed(b"arm\r\n").0.matches("> ").count(), 1);
    assert_eq!(typed(b"arm\n\n").0.matches("> ").count(), 2);
    // A key inside of an unfinished sequence counts.
    assert_eq!(typed(b"arm\x1b[\r").1, [Request::Arm]);
}

#[test]
fn a_line_that_is_too_long_or_damaged_is_refused_as_a_whole() {
    let longest = format!("arm{}", " ".repeat(LINE - 3));
    assert_eq!(typed(format!("{longest}\r").as_bytes()).1, [Request::Arm]);
    let (shown, requests) = typed(format!("{longest} \rarm\r").as_bytes());
    assert_eq!(requests, [Request::Arm]);
    let expected = format!(
        "error: column {}: the line is too long; expected at most {LINE} characters",
        LINE + 1
    );
    assert!(shown.contains(&expected), "{shown}");
    // Nor can it be shortened into another line that was not meant, unless as a whole.
    let back = "\x7f".repeat(4);
    assert_eq!(typed(format!("{longest} {back}\r").as_bytes()).1, []);
    assert_eq!(
        typed(format!("{longest} \x15arm\r").as_bytes()).1,
        [Request::Arm]
    );
    for damage in ["\0", "\x01", "\u{b5}", "\x19"] {
        let (shown, requests) = typed(format!("step 0 {damage}1\r").as_bytes());
        assert_eq!(requests, []);
        let expected = "error: column 8: a byte that is no text; expected printable ASCII";
        assert!(shown.contains(expected), "{shown}");
    }
}

/// Bytes that a terminal sends, more often those that mean something.
fn bytes() -> impl Strategy<Value = Vec<u8>> {
    let keys =
        prop::sample::select(b"\r\n\r\n\x03\x08\x7f\x10\x15\x1b[AOB \t0123456789.-+e".to_vec());
    let byte = prop_oneof![any::<u8>(), keys, b' '..=b'~'];
    prop::collection::vec(byte, 0..400)
}

/// Words that lines are made of, and some that they are not.
fn word() -> impl Strategy<Value = String> {
    let mut words: Vec<String> = Vec::new();
    words.extend(COMMANDS.iter().map(|command| command.name.to_owned()));
    words.extend(PARAMETERS.iter().map(|parameter| parameter.name.to_owned()));
    words.extend(INJECTIONS.iter().map(|injection| injection.name.to_owned()));
    words.extend(Quantity::ALL.map(|quantity| quantity.name().to_owned()));
    let others = "position voltage now fault rising falling lower upper inf -nan 1e39 0x1 -0 1e-46 .5 5. 4294967296";
    words.extend(others.split(' ').map(str::to_owned));
    let number = any::<f32>().prop_map(|number| format!("{number:e}"));
    let count = any::<u16>().prop_map(|count| count.to_string());
    prop_oneof![prop::sample::select(words), number, count]
}

fn lines() -> impl Strategy<Value = String> {
    let line = prop::collection::vec(word(), 0..9).prop_map(|words| words.join(" ") + "\r");
    prop::collection::vec(line, 1..12).prop_map(|lines| lines.concat())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn whatever_bytes_come_each_line_has_one_response(bytes in bytes()) {
        exercise(&bytes);
    }

    #[test]
    fn whatever_words_come_each_line_has_one_response(lines in lines()) {
        exercise(lines.as_bytes());
    }

    #[test]
    fn an_error_is_in_the_line_or_just_behind_it(lines in lines()) {
        for line in lines.split_terminator('\r') {
            if let Err(error) = parse(line, &PARAMETERS) {
                prop_assert!((1..=line.len() + 1).contains(&error.column), "{line}: {error}");
            }
        }
    }

    #[test]
    fn the_editor_gives_back_what_was_typed(line in "[ -~]{0,128}") {
        let mut editor = Editor::new();
        let mut echo = String::new();
        for byte in line.bytes() {
            prop_assert_eq!(editor.take(byte, &mut echo), None);
        }
        prop_assert_eq!(&echo, &line);
        prop_assert_eq!(editor.take(b'\r', &mut echo), Some(Event::Line(&line)));
    }
}

/// The same bytes on every machine, beside those that proptest draws: what the fuzzer of
/// `host-tests/fuzz` does, for a bounded time.
#[test]
fn a_million_random_bytes_are_borne() {
    let mut random = Random::new(2, 0);
    let mut bytes = Vec::new();
    for _ in 0..1_000_000 {
        let bits = random.bits();
        let text = b"\r\n\x08\x1b[Asethowcdumprl 0123456789.-";
        bytes.push(match bits >> 30 {
            0 => (bits & 0xff) as u8,
            _ => text[(bits & 0xffff) as usize % text.len()],
        });
    }
    for chunk in bytes.chunks(10_000) {
        exercise(chunk);
    }
}

#[test]
fn required_arguments_come_before_optional_ones_and_names_are_there_once() {
    for (place, command) in COMMANDS.iter().enumerate() {
        let named = Command::named(command.name).unwrap();
        assert!(
            std::ptr::eq(named, &COMMANDS[place]),
            "{} twice",
            command.name
        );
        let optional = command
            .arguments
            .iter()
            .skip_while(|argument| argument.presence == Presence::Required);
        for argument in optional {
            assert_ne!(argument.presence, Presence::Required, "{}", command.name);
        }
    }
}

#[test]
fn stop_is_understood_in_any_line_that_is_none() {
    let long = "x".repeat(3 * LINE);
    let garbage: [&[u8]; 12] = [
        b"",
        b"\x00\xff",
        b"status",
        b"arm ",
        b"set lower_",
        b"sto",
        b"st\x1b[",
        b"\x1bO",
        b"\x10\x08",
        b"step 0 1 ",
        b"\x1b[1;",
        long.as_bytes(),
    ];
    for before in garbage {
        for behind in [&b""[..], b"\x00", b" now", b"\x1b[A"] {
            let bytes = [before, b"stop", behind, b"\r"].concat();
            let (shown, requests) = typed(&bytes);
            assert_eq!(requests, [Request::Disarm], "{}", bytes.escape_ascii());
            assert!(shown.ends_with("ok\r\n> "), "{shown:?}");
        }
    }
    // What is meant otherwise, or was taken back, is none.
    let help = Request::Help(Command::named("stop"));
    assert_eq!(typed(b"help stop\r").1, [help]);
    for harmless in [
        &b"stop\x15\r"[..],
        b"stop\x15xyz\r",
        b"stop\x03xyz\r",
        b"st op\r",
    ] {
        assert_eq!(typed(harmless).1, [], "{}", harmless.escape_ascii());
    }
    assert_eq!(typed(b"stop\rxyz\r").1, [Request::Disarm]);
}

#[test]
fn stop_is_understood_behind_any_random_bytes() {
    let mut random = Random::new(5, 0);
    for _ in 0..20_000 {
        let mut host = ConsoleOnHost::new();
        let length = random.bits() as usize % 300;
        for _ in 0..length {
            host.take((random.bits() & 0xff) as u8);
        }
        assert!(host.latch.arm().is_ok());
        for byte in *b"stop\r" {
            host.take(byte);
        }
        assert!(!host.latch.is_armed());
    }
}

/// A board keeps as much free before it takes a byte.
#[test]
fn the_longest_answer_fits_the_room_that_is_kept_for_it() {
    let mut host = ConsoleOnHost::new();
    for byte in *b"help" {
        host.take(byte);
    }
    let sent = host.take(b'\r');
    assert!(sent.len() <= LONGEST_ANSWER, "{} bytes", sent.len());
}
