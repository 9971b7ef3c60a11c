//! Promise: `cargo hil export` gives another simulator the same machine, and names what it cannot say there.

mod bad_input;
mod c_file;
mod drive;
mod fmu;
mod mujoco;
