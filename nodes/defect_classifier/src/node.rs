//! The shell: frames, moves, states and estimates in; defects, widths, quality and pictures out.

use fdm_loop_msgs::{BeadWidth, CompressedImage, DefectReport, LayerQuality, PrintEvent};
use models::units::Seconds;
use runtime::params::{ParamFileError, Parameters};
use runtime::{Diagnostics, Node, Publisher, RuntimeError, topics};
use std::path::{Path, PathBuf};

use crate::classifier::{Classifier, Counts, Models};
use crate::convert;
use crate::event::{Event, Output};
use crate::frame::LIVE;
use crate::fusion::FusionError;
use crate::layer::Nominal;
use crate::network::{Network, NetworkError};
use crate::params::{MachineParams, Params};
use crate::width::{EdgeError, EdgeModel};

/// Blocks of the parameters that other nodes share.
const SHARED: [&str; 3] = ["printer", "material", "quality"];
/// Oldest stamp that is taken `[s]`: a frame arrives late, and everything it needs is older still.
const AGE_LIMIT: Seconds = Seconds(3.0);
/// OpenCV works in the node's own thread: the machine's other cores belong to other nodes.
const THREADS: i32 = 1;

/// Why the node cannot run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NodeError {
    /// The graph.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// Parameters.
    #[error(transparent)]
    Parameters(#[from] ParamFileError),
    /// A model's file that cannot be read.
    #[error("models: {}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The network's file is refused.
    #[error("models: {}", path.display())]
    Network {
        /// The file.
        path: PathBuf,
        /// Why.
        source: NetworkError,
    },
    /// The edge's file is refused.
    #[error("models: {}", path.display())]
    Edge {
        /// The file.
        path: PathBuf,
        /// Why.
        source: EdgeError,
    },
    /// Parameters and network do not belong together.
    #[error("fusion: {0}")]
    Fusion(#[from] FusionError),
    /// OpenCV.
    #[error("OpenCV: {0}")]
    OpenCv(#[from] opencv::Error),
}

/// Runs the node to its end.
///
/// # Errors
/// [`NodeError`] where it cannot start.
pub async fn run(mut node: Node) -> Result<(), NodeError> {
    opencv::core::set_num_threads(THREADS)?;
    let mut setup = Setup::read(&node)?;
    let mut classifier = setup.classifier()?;
    let mut frames = node.inlet(&topics::CAMERA_IMAGE, AGE_LIMIT)?;
    let mut motion = node.inlet(&topics::PRINTER_MOTION, AGE_LIMIT)?;
    let mut printer = node.inlet(&topics::PRINTER_STATE, AGE_LIMIT)?;
    let mut estimates = node.inlet(&topics::ESTIMATE, AGE_LIMIT)?;
    let outlets = Outlets::open(&mut node, setup.params.machine)?;
    let (clock, work, diagnostics) = (node.clock(), node.work(), node.diagnostics());
    let mut jumps = clock.jumps_back();
    let mut live = node.live_parameters(&LIVE);
    node.activated().await;
    loop {
        // Moves and states first: a frame is judged by what is known of the path when it is looked at.
        let taken = tokio::select! {
            biased;
            () = node.shutdown() => return Ok(()),
            taken = motion.next(convert::motion) => taken,
            taken = printer.next(convert::printer) => taken,
            taken = estimates.next(convert::estimate) => taken,
            taken = frames.next(convert::frame) => taken,
            changed = live.next() => {
                setup.params = changed.without(&SHARED).parse()?;
                classifier.retune(setup.params.clone());
                continue;
            }
        };
        if std::mem::replace(&mut jumps, clock.jumps_back()) != clock.jumps_back() {
            classifier = setup.classifier()?;
        }
        if let Ok(event) = taken {
            let frame = matches!(event, Event::Frame { .. });
            let outputs = classifier.on_event(event);
            outputs.into_iter().for_each(|output| outlets.send(output, classifier.classes()));
            show(&diagnostics, &classifier.counts());
            // A frame that was looked at, whatever it shows: the supervisor misses that while frames come.
            if frame {
                work.done();
            }
        }
    }
}

/// What a classifier is made of.
struct Setup {
    params: Params,
    models: Models,
}

impl Setup {
    /// What is refused here are parameters and the files that they name.
    fn read(node: &Node) -> Result<Self, NodeError> {
        Self::of(node).inspect_err(|_| node.refuse())
    }

    fn of(node: &Node) -> Result<Self, NodeError> {
        node.check_parameters(|parameters| {
            nominal(parameters)?;
            parameters.without(&SHARED).parse::<Params>().map(drop)
        })?;
        let parameters = node.raw_parameters();
        let params: Params = parameters.without(&SHARED).parse()?;
        let (network, edge) = (params.models.network.clone(), params.models.edge.clone());
        let models = Models {
            network: Network::parse(&read(&network)?)
                .map_err(|source| NodeError::Network { path: network, source })?,
            edge: EdgeModel::parse(&read(&edge)?).map_err(|source| NodeError::Edge { path: edge, source })?,
            nominal: nominal(parameters)?,
        };
        Ok(Self { params, models })
    }

    /// A classifier that has seen nothing: at the start, and when time jumped back.
    fn classifier(&self) -> Result<Classifier, FusionError> {
        Classifier::new(self.params.clone(), self.models.clone())
    }
}

/// What the printer and its material are taken for.
fn nominal(parameters: &Parameters) -> Result<Nominal, ParamFileError> {
    Ok(Nominal {
        quality: parameters.block("quality")?,
        printer: parameters.block("printer")?,
        material: parameters.block("material")?,
    })
}

fn read(path: &Path) -> Result<String, NodeError> {
    runtime::input::text(path).map_err(|source| NodeError::File { path: path.to_path_buf(), source })
}

/// Everything that the node says.
struct Outlets {
    who: String,
    /// Stands beside every figure of quality.
    machine: MachineParams,
    defects: Publisher<DefectReport>,
    widths: Publisher<BeadWidth>,
    quality: Publisher<LayerQuality>,
    pictures: Publisher<CompressedImage>,
    events: Publisher<PrintEvent>,
}

impl Outlets {
    fn open(node: &mut Node, machine: MachineParams) -> Result<Self, RuntimeError> {
        Ok(Self {
            who: node.name(),
            machine,
            defects: node.publish_on(&topics::DEFECTS)?,
            widths: node.publish_on(&topics::BEAD_WIDTH)?,
            quality: node.publish_on(&topics::LAYER_QUALITY)?,
            pictures: node.publish_on(&topics::ANNOTATED)?,
            events: node.publish_on(&topics::EVENTS)?,
        })
    }

    fn send(&self, output: Output, classes: &[String]) {
        match output {
            Output::Defects(defects) => self.defects.send(convert::defects(&defects, classes)),
            Output::Width(width) => self.widths.send(convert::width(&width)),
            Output::Quality(figure) => self.quality.send(convert::quality(&figure, &self.machine)),
            Output::Picture { exposed, jpeg } => self.pictures.send(convert::picture(exposed, jpeg)),
            Output::Note(note) => self.events.send(convert::note(&note, &self.who)),
        };
    }
}

fn show(diagnostics: &Diagnostics, counts: &Counts) {
    for (name, count) in [
        ("frames_judged", counts.judged),
        ("frames_unusable", counts.unusable),
        ("frames_idle", counts.idle),
        ("estimates_refused", counts.estimates_refused),
        ("path_refused", counts.path_refused),
        ("widths", counts.widths),
    ] {
        diagnostics.set(name, count);
    }
}
