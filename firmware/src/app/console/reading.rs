//! What follows a command's name, command by command. Arguments are told by their place in the table.

use super::command::Command;
use super::error::{Flaw, ParseError};
use super::injection::INJECTIONS;
use super::parse::{Arguments, Line};
use super::request::{Destination, Dump, Home, Mode, Request};
use crate::app::capture::{CAPTURE_VALUES, Edge, Quantities, Quantity, Settings, Trigger};
use crate::app::ecu::loopback;
use crate::app::operation::homing::Switch;
use crate::app::operation::live::MOST_RATE;
use crate::app::operation::motion_limit::NO_POSITION;
use crate::app::profile::Signal;

/// A request, and nothing else to read.
pub fn request<'a>(request: Request) -> Result<Line, ParseError<'a>> {
    Ok(Line::Request(request))
}

/// `help`.
pub fn help<'a>(arguments: &mut Arguments<'a, '_>) -> Result<Line, ParseError<'a>> {
    let Some(word) = arguments.word() else {
        return request(Request::Help(None));
    };
    match Command::named(word.text) {
        Some(command) => request(Request::Help(Some(command))),
        None => Err(arguments.error(word.column, Flaw::UnknownCommand(word.text))),
    }
}

/// `mode`.
pub fn mode<'a>(arguments: &mut Arguments<'a, '_>) -> Result<Line, ParseError<'a>> {
    let mode = arguments.choice(0, |word| {
        Mode::ALL.into_iter().find(|mode| mode.name() == word)
    })?;
    request(Request::Mode(mode))
}

/// Least and most speed of a search, rad/s: at the least one a turn takes an hour and three quarters, and the most is that of the
/// limit.
const SEARCH_SPEEDS: [f32; 2] = [1e-3, 1e4];

/// `home`.
pub fn home<'a>(arguments: &mut Arguments<'a, '_>) -> Result<Line, ParseError<'a>> {
    let switch = arguments.choice(0, |word| {
        Switch::ALL.into_iter().find(|switch| switch.name() == word)
    })?;
    let position = arguments.number_in(1, "rad", -NO_POSITION, NO_POSITION)?;
    let [least, most] = SEARCH_SPEEDS;
    let speed = arguments.number_in(2, "rad/s", least, most)?;
    request(Request::Home(Home {
        switch,
        position,
        speed,
    }))
}

/// Largest magnitude of a signal's number: no drive goes there, and no sum or product of two of
/// them overflows.
const FARTHEST: f32 = 1e6;

/// Reads a signal's numbers, one for each of the command's arguments; an optional one that is not
/// there is 0.
pub fn signal<'a, const N: usize>(
    arguments: &mut Arguments<'a, '_>,
    make: impl FnOnce([f32; N]) -> Signal,
) -> Result<Line, ParseError<'a>> {
    let (mut numbers, mut columns) = ([0.0; N], [0; N]);
    for (index, (number, column)) in numbers.iter_mut().zip(&mut columns).enumerate() {
        *column = arguments.next_column();
        *number = arguments.number_within(index, -FARTHEST, FARTHEST)?;
    }
    arguments.end()?;
    let signal = make(numbers);
    match signal.build() {
        Ok(_) => request(Request::Signal(signal)),
        Err(refused) => {
            let named = arguments
                .command()
                .arguments
                .iter()
                .position(|argument| argument.name == refused.name);
            let column = named.and_then(|index| columns.get(index)).copied();
            Err(arguments.error(column.unwrap_or(1), Flaw::Refused(refused)))
        }
    }
}

/// `show`.
pub fn show<'a>(arguments: &mut Arguments<'a, '_>) -> Result<Line, ParseError<'a>> {
    if arguments.is_at_end() {
        return request(Request::ShowAll);
    }
    let parameter = arguments.parameter(0)?;
    request(Request::Show(parameter))
}

/// `set`.
pub fn set<'a>(arguments: &mut Arguments<'a, '_>) -> Result<Line, ParseError<'a>> {
    let parameter = arguments.parameter(0)?;
    let value = arguments.value_of(1, parameter)?;
    request(Request::Set { parameter, value })
}

/// `inject`.
pub fn inject<'a>(arguments: &mut Arguments<'a, '_>) -> Result<Line, ParseError<'a>> {
    let injection = arguments.choice(0, |word| {
        INJECTIONS.iter().find(|injection| injection.name == word)
    })?;
    let value = match &injection.value {
        Some(bounds) => {
            if arguments.is_at_end() {
                return Err(arguments.missing(1));
            }
            arguments.number_in(1, bounds.unit, bounds.lower, bounds.upper)?
        }
        None => 0.0,
    };
    let fault = (injection.fault)(value);
    request(Request::Body(loopback::Command::Inject(fault)))
}

/// What the sensor of the supply reads at most, V.
const MOST_SUPPLY: f32 = 20.0;

/// `supply`.
pub fn supply<'a>(arguments: &mut Arguments<'a, '_>) -> Result<Line, ParseError<'a>> {
    let volts = arguments.number_in(0, "V", 0.0, MOST_SUPPLY)?;
    request(Request::Body(loopback::Command::Supply(volts)))
}

/// What the word for a trigger says of it.
enum Awaited {
    Event(Trigger),
    /// Of a level, which follows.
    Crossing(Edge),
}

fn awaited(word: &str) -> Option<Awaited> {
    Some(match word {
        "now" => Awaited::Event(Trigger::Now),
        "command" => Awaited::Event(Trigger::Command),
        "fault" => Awaited::Event(Trigger::Fault),
        "rising" => Awaited::Crossing(Edge::Rising),
        "falling" => Awaited::Crossing(Edge::Falling),
        _ => return None,
    })
}

/// `record`.
pub fn record<'a>(arguments: &mut Arguments<'a, '_>) -> Result<Line, ParseError<'a>> {
    let column = arguments.next_column();
    let before = arguments.count(0)?;
    let after = arguments.count(1)?;
    let trigger = match arguments.choice(2, awaited)? {
        Awaited::Event(trigger) => trigger,
        Awaited::Crossing(edge) => Trigger::Level {
            edge,
            quantity: arguments.choice(3, Quantity::named)?,
            level: arguments.required_number(4)?,
        },
    };
    let mut quantities = Quantities::default();
    while !arguments.is_at_end() {
        quantities = quantities.with(arguments.choice(5, Quantity::named)?);
    }
    if quantities.is_empty() {
        quantities = Quantities::LOG;
    }
    let settings = Settings {
        quantities,
        trigger,
        before,
        after,
    };
    match settings.rows(CAPTURE_VALUES) {
        Ok(_) => request(Request::Record(settings)),
        Err(refused) => Err(arguments.error(column, Flaw::Refused(refused))),
    }
}

/// `dump`.
pub fn dump<'a>(arguments: &mut Arguments<'a, '_>) -> Result<Line, ParseError<'a>> {
    if arguments.is_at_end() {
        return request(Request::Dump(Dump::Capture));
    }
    let dump = arguments.choice(0, |word| match word {
        "capture" => Some(Dump::Capture),
        "log" => Some(Dump::Log(Destination::Rtt)),
        _ => None,
    })?;
    if dump == Dump::Capture || arguments.is_at_end() {
        return request(Request::Dump(dump));
    }
    let destination = arguments.choice(1, |word| match word {
        "rtt" => Some(Destination::Rtt),
        "console" => Some(Destination::Console),
        _ => None,
    })?;
    request(Request::Dump(Dump::Log(destination)))
}

/// `stream`.
pub fn stream<'a>(arguments: &mut Arguments<'a, '_>) -> Result<Line, ParseError<'a>> {
    let rate = arguments.number_in(0, "Hz", 0.0, MOST_RATE)?;
    request(Request::Stream(rate))
}
