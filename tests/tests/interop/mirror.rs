//! Two nodes in one process: what the one hears on a topic, decoded, the other says on it, encoded anew.
#![allow(clippy::print_stdout, reason = "its lines are read by the script")]

use fdm_loop_msgs::RosType;
use runtime::topics::{self, Topic};
use runtime::{Args, Node};
use tokio::task::JoinSet;

/// Topics that have no namespace.
const ABSOLUTE: [&str; 5] = ["/clock", "/diagnostics", "/parameter_events", "/rosout", "/tf_static"];

/// Nodes that stand in the namespaces `/in` and `/out`, and what passes between them.
struct Mirror {
    ears: Node,
    mouth: Node,
    tasks: JoinSet<()>,
}

fn node(namespace: &str) -> Node {
    let remaps = ABSOLUTE.map(|name| (name.to_owned(), format!("{namespace}{name}")));
    let args = Args { namespace: Some(namespace.to_owned()), remaps: remaps.into(), ..Args::default() };
    Node::start_with("mirror", args).unwrap()
}

impl Mirror {
    fn reflect<T: RosType>(&mut self, topic: &Topic<T>) {
        let mut heard = self.ears.subscribe(topic).unwrap();
        let said = self.mouth.publish_on(topic).unwrap();
        let names = (self.ears.resolve(topic.name()), self.mouth.resolve(topic.name()));
        let offered = topic.qos().offered.reliability;
        println!(
            "mirror {} {} {}/{} {offered:?}",
            names.0,
            names.1,
            T::DEFINITION.package,
            T::DEFINITION.name
        );
        self.tasks.spawn_local(async move {
            loop {
                said.send(heard.recv().await.message);
            }
        });
    }
}

/// Runs until the process is ended; tells each topic in a line.
pub(crate) fn run() {
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    tokio::task::LocalSet::new().block_on(&executor, async {
        let mut mirror = Mirror { ears: node("/in"), mouth: node("/out"), tasks: JoinSet::new() };
        mirror.reflect(&topics::ADVANCE_PREDICTION);
        mirror.reflect(&topics::BEAD_WIDTH);
        mirror.reflect(&topics::CAMERA_INFO);
        mirror.reflect(&topics::CAMERA_IMAGE);
        mirror.reflect(&topics::CONTROL_COMMAND);
        mirror.reflect(&topics::CONTROL_SCHEDULE);
        mirror.reflect(&topics::DEFECTS);
        mirror.reflect(&topics::FILAMENT_MOTION);
        mirror.reflect(&topics::FILAMENT_REPORT);
        mirror.reflect(&topics::IMU_BATCH);
        mirror.reflect(&topics::IMU_DATA);
        mirror.reflect(&topics::LAYER_HEIGHT);
        mirror.reflect(&topics::LAYER_QUALITY);
        mirror.reflect(&topics::PRINTER_MOTION);
        mirror.reflect(&topics::PRINT_INFO);
        mirror.reflect(&topics::PRINTER_STATE);
        mirror.reflect(&topics::SAFETY_STATE);
        mirror.reflect(&topics::SIM_TRUTH);
        mirror.reflect(&topics::SIM_WIRE);
        mirror.reflect(&topics::ESTIMATE);
        mirror.reflect(&topics::HOTEND_TEMPERATURE);
        mirror.reflect(&topics::TEMPERATURE_REPORT);
        mirror.reflect(&topics::TRANSITION_EVENT);
        // Our own nodes speak on these too: beside what is asked, other messages come.
        mirror.reflect(&topics::CLOCK);
        mirror.reflect(&topics::EVENTS);
        mirror.reflect(&topics::HEARTBEAT);
        mirror.reflect(&topics::DIAGNOSTICS);
        mirror.reflect(&topics::PARAMETER_EVENTS);
        mirror.reflect(&topics::ROSOUT);
        mirror.reflect(&topics::TF_STATIC);
        println!("mirror end");
        let mut shutdown = mirror.ears.shutdown_handle();
        shutdown.wait().await;
    });
}
