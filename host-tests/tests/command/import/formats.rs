//! Files of other people's writers: `host-tests/formats/samples`, with the script that had them written.

use host_tests::workspace;

use super::*;

/// A file of the samples, under its own name.
pub(super) fn sample(name: &str) -> Place {
    let path = workspace::root()
        .join("host-tests/formats/samples")
        .join(name);
    Place::with(name, fs::read(path).expect("a sample"))
}

/// Position in rad, duty of 24 V in V and current in A of a sample, as its script has them.
fn motion(row: usize) -> [f64; 3] {
    let position = 30.0 * (TAU * row as f64 / 1000.0).sin();
    let duty = ((row % 100) as f64 - 50.0).abs() * 2.0 - 50.0;
    let current = ((row * 7) % 1000) as f64 - 500.0;
    [position.to_radians(), duty / 100.0 * 24.0, current / 1000.0]
}

#[track_caller]
fn is_at_one_kilohertz(log: &Log) {
    assert!((log.period_s - 1e-3).abs() < 1e-12, "{}", log.period_s);
    assert_eq!(log.start_s, 0.0);
}

/// That a log is the samples' motion, at 1 kHz from its beginning.
#[track_caller]
fn is_the_motion(log: &Log) {
    assert_eq!(log.samples(), 200);
    is_at_one_kilohertz(log);
    near(&log.position, |row| motion(row)[0]);
    near(&log.input, |row| motion(row)[1]);
    let current = log.current.as_ref().expect("a current");
    near(current, |row| motion(row)[2]);
}

#[test]
#[ignore = "at length: the readers are built"]
fn parquet() {
    for codec in ["snappy", "zstd"] {
        let name = format!("run-{codec}.parquet");
        let place = sample(&name);
        let words = |current: &str| {
            format!("{name} --time stamp --position pos:deg --input duty:%*24 --current {current}")
        };
        let (log, said) = place.import(&words("pos:A"));
        assert_eq!(log.samples(), 200, "{said}");
        assert!(
            said.contains("Parquet, columns of numbers: 5, others left out: 1"),
            "{said}"
        );
        is_at_one_kilohertz(&log);
        near(&log.position, |row| motion(row)[0]);
        near(&log.input, |row| motion(row)[1]);
        // One cell of the current is empty.
        place.refuses(
            &format!("import {} --out log.csv", words("i:mA")),
            &["the number for `current_a` is ", "--skip-bad"],
        );
        // A count without sign that passes 2³².
        let (log, _) = place.import(&words("count:A/1000"));
        let count = log.current.expect("a current");
        near(&count, |row| {
            ((row as u64 + 4_294_967_000) % (1 << 32)) as f64 / 1000.0
        });
    }
}

#[test]
#[ignore = "at length: the readers are built"]
fn mdf() {
    let place = sample("run.mf4");
    let call = "run.mf4 --time time --position pos:deg --input duty:%*24 --current i:mA";
    let (log, said) = place.import(call);
    assert!(said.contains("MDF 4.10, channel groups: 2"), "{said}");
    is_the_motion(&log);
    // Of another group, that comes less often.
    let (log, said) = place.import(&call.replace("i:mA", "oil"));
    assert!(said.contains("oil has its own times in "), "{said}");
    assert_eq!(log.samples(), 200);
}

#[test]
#[ignore = "at length: the readers are built"]
fn mcap_of_json() {
    let place = sample("run-json.mcap");
    let call = "--position pos:deg --input drive.duty:%*24 --current drive.i.0:mA";
    let (log, said) = place.import(&format!("run-json.mcap --time log_time {call}"));
    assert!(said.contains("MCAP, topics: 1"), "{said}");
    is_the_motion(&log);
    let (log, _) = place.import(&format!("run-json.mcap --time publish_time+5:us {call}"));
    assert_eq!(log.samples(), 200);
}

#[test]
#[ignore = "at length: the readers are built"]
fn mcap_of_ros_2() {
    let place = sample("run-ros2.mcap");
    let call = "--position position.0:deg --input duty:%*24 --current current.0:mA";
    for time in ["log_time", "header.stamp"] {
        let (log, _) = place.import(&format!("run-ros2.mcap --time {time} {call}"));
        is_the_motion(&log);
    }
    let (log, _) = place.import(
        "run-ros2.mcap --time log_time --position tips.0.y:deg --input tips.0.x --current mode",
    );
    near(&log.position, |row| motion(row)[0]);
    near(&log.input, |row| -(row as f64));
    near(&log.current.expect("a current"), |_| 1.0);
}

/// The call that `gap` prints takes the message's own time where it has one, else the recorder's, and no time for a
/// measurement.
#[test]
#[ignore = "at length: the readers are built"]
fn of_the_times_of_an_mcap_the_nearest_to_the_measurement_is_proposed() {
    for (name, words) in [
        (
            "run-ros2.mcap",
            "--time header.stamp --input duty --position position.0",
        ),
        (
            "run-json.mcap",
            "--time log_time --input drive.duty --position pos",
        ),
    ] {
        let place = sample(name);
        place.write("machine.toml", Machine::force_slide().to_toml());
        place.refuses(
            &format!("gap --machine machine.toml --train {name}"),
            &[words],
        );
    }
}

/// Times of the record, and the bytes, of each message.
type Messages = Vec<(u64, Vec<u8>)>;

/// An MCAP file of these messages of ROS 2 (*MCAP Format Specification*, version 0), without chunks and checksums: what
/// is damaged in it reaches the messages' reader.
pub(super) fn mcap(messages: &Messages) -> Vec<u8> {
    const DEFINITION: &str =
        "std_msgs/Empty[] marks\nfloat64 position\nfloat64 input\n===\nMSG: std_msgs/Empty\n";
    const MAGIC: &[u8] = b"\x89MCAP0\r\n";
    let text = |text: &str| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    let record = |kind: u8, content: &[u8]| {
        [&[kind][..], &(content.len() as u64).to_le_bytes(), content].concat()
    };
    let schema = ["motor_msgs/msg/Marked", "ros2msg", DEFINITION].map(text);
    let channel = ["/motor", "cdr"].map(text);
    let mut bytes = [
        MAGIC,
        &record(1, &["", "test"].map(text).concat()),
        &record(3, &[&[1, 0][..], &schema.concat()].concat()),
        &record(4, &[&[1, 0, 1, 0][..], &channel.concat(), &[0; 4]].concat()),
    ]
    .concat();
    for (time, message) in messages {
        let times = [time.to_le_bytes(); 2].concat();
        bytes.extend(record(
            5,
            &[&[1, 0, 0, 0, 0, 0][..], &times, message].concat(),
        ));
    }
    // The ends of the data and of the file.
    bytes.extend([record(15, &[0; 4]), record(2, &[0; 20])].concat());
    bytes.extend(MAGIC);
    bytes
}

/// The samples' motion in messages, each of which counts so many marks and has five. As plain CDR has them, a mark,
/// which has no field, is one byte: DDS knows no empty structure.
pub(super) fn motion_of_ros_2(marks: u32) -> Messages {
    let message = |row: usize| {
        let [position, input, _] = motion(row);
        let marks = [&marks.to_le_bytes()[..], &[0; 5]].concat();
        // Numbers of eight bytes stand at a multiple of eight behind the head.
        let numbers = [position, input].map(f64::to_le_bytes).concat();
        let message = [&[0, 1, 0, 0][..], &marks, &[0; 7], &numbers].concat();
        (1_000_000 * row as u64, message)
    };
    (0..200).map(message).collect()
}

const CALL_OF_MARKED: &str = "run.mcap --time log_time --position position --input input";

#[test]
#[ignore = "at length: the readers are built"]
fn a_message_of_ros_2_without_fields_has_its_byte() {
    let place = Place::with("run.mcap", mcap(&motion_of_ros_2(5)));
    let (log, _) = place.import(CALL_OF_MARKED);
    assert_eq!(log.samples(), 200);
    near(&log.position, |row| motion(row)[0]);
    near(&log.input, |row| motion(row)[1]);
}

/// As many elements, or bytes, as a damaged count says are neither looked for nor made room for.
#[test]
#[ignore = "at length: the readers are built"]
fn a_count_of_more_than_there_is_is_refused() {
    let words = format!("import {CALL_OF_MARKED} --out log.csv");
    let marked = Place::with("run.mcap", mcap(&motion_of_ros_2(u32::MAX)));
    marked.refuses(&words, &["run.mcap: ", "/motor", "ends too early"]);
    let mut bytes = mcap(&motion_of_ros_2(5));
    // The length of the first record, behind the magic bytes and its kind.
    bytes[9..17].copy_from_slice(&(1_u64 << 40).to_le_bytes());
    Place::with("run.mcap", bytes).refuses(&words, &["run.mcap: ", "damaged MCAP"]);
}
