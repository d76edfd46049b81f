//! One fault, one file: each check takes what it needs, keeps its own state and answers on demand.

pub mod bad_values;
pub mod defect;
pub mod detached;
pub mod drift;
pub mod drive_history;
pub mod filament;
pub mod frozen;
pub mod hearts;
pub mod heater;
mod heater_observer;
pub mod heater_start;
pub mod impulse;
pub mod jump;
mod moved;
pub mod noise;
pub mod oscillation;
pub mod pace;
pub mod part_fan;
pub mod range;
pub mod rising;
mod roughness;
pub mod run_out;
pub mod shift;
pub mod stale;
pub mod stop_input;
pub mod unjudged;
pub mod work;
