//! Promise: `cargo hil track` says of many logs of one machine which numbers change, how fast, and when a limit is reached; its
//! intervals hold as often as they say, and its alarms are no more often false than they say.

mod command;
mod trend;
