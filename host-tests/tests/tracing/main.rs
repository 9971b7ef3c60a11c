//! The tracing: what is said of a log, of the effects that a machine lacks, and of the experiment that would tell.

mod bench_residuals;
mod board_gap;
mod current_sensor;
mod declared_guesses;
mod disagreement;
mod effect_words;
mod emps;
mod gap_command;
mod gap_components;
mod gap_example;
mod gap_headline;
mod gap_report;
mod identify;
mod intervals;
mod late_drive;
mod light_machine;
mod log_of_counts;
mod lost_motion;
mod machine_out;
mod next_experiment;
mod pushed_slide;
mod real_benchmark;
mod settled_fits;
mod stepped;
mod undeclared_effects;
mod wrong_motor;
