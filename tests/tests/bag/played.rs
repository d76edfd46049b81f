//! `fdm sim --bag` and `fdm play`.

use crate::process::{Bag, Domain, program, root};
use serde_json::Value;
use std::process::Command;

/// Runs to the end; standard output.
fn done(command: &mut Command) -> Vec<u8> {
    let output = command.current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// Records a print of one layer in virtual time.
pub(crate) fn simulate(bag: &Bag) {
    let print = ["sim", "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode", "--layers", "1", "--bag"];
    done(Command::new(program("fdm")).args(print).arg(bag.path()));
}

/// Plays a bag, commands and permits too; what is told of it.
pub(crate) fn play(bag: &Bag, domain: Domain) -> Value {
    let how = ["--rate", "20", "--commands", "--wait", "5", "--json", "-"];
    let told = done(domain.command(&program("fdm")).arg("play").arg(bag.path()).args(how));
    serde_json::from_slice(&told).unwrap()
}
