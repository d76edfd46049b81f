//! The file of an ensemble: JSON, with everything that inference needs, a checksum that tells a damaged one, and a probe
//! that tells one which this program would compute differently.

use super::ensemble::{Ensemble, Hull, SHAPE};
use crate::network::{
    Network, NetworkError, RawLayer, Scaling, Sealed, agree, check_seal, finite, length, refuse, seal,
};
use models::advance::{Condition, DriveKind};
use models::units::Celsius;
use serde::{Deserialize, Serialize};

/// First field of every file.
const FORMAT: &str = "fdm_loop advance network";
/// Changes with the fields and their meaning.
const VERSION: u32 = 2;

/// The file as it is written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawEnsemble {
    pub(super) format: String,
    pub(super) version: u32,
    pub(super) drive: DriveKind,
    /// What it was trained with, for people.
    pub(super) trained: String,
    /// A person's own lines among them; a file without any does not name them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) measured: Option<usize>,
    /// In the order of the inputs.
    pub(super) polymers: Vec<RawPolymerHull>,
    pub(super) range_s: [f64; 2],
    /// Least standard deviation that the interval is made of `[s]`.
    pub(super) floor_s: f64,
    /// Half width of the 95 % interval over the standard deviation `[-]`.
    pub(super) factor: f64,
    pub(super) centre: Vec<f64>,
    pub(super) scale: Vec<f64>,
    pub(super) clip: f64,
    pub(super) members: Vec<Vec<RawLayer>>,
    /// `K_A` of each polymer in the middle of its hull `[s]`.
    pub(super) probe: Vec<f64>,
    /// Of all other fields.
    #[serde(default)]
    pub(super) sha256: String,
}

impl Sealed for RawEnsemble {
    fn sha256(&mut self) -> &mut String {
        &mut self.sha256
    }
}

/// A polymer and its data's ranges.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPolymerHull {
    pub(super) name: String,
    pub(super) hull: Hull,
}

impl Hull {
    fn check(&self, polymer: &str) -> Result<(), NetworkError> {
        for (name, [low, high]) in
            [("temperature_c", self.temperature_c), ("height_m", self.height_m), ("width_m", self.width_m)]
        {
            // A NaN is in no order.
            if !(low > 0.0 && low <= high && high.is_finite()) {
                let field = format!("polymers: hull of {polymer}: {name}");
                return refuse(field, format!("[{low}, {high}]"), "above 0, in order");
            }
        }
        Ok(())
    }

    /// Its middle.
    #[must_use]
    pub fn middle(&self) -> Condition {
        let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
        Condition {
            temperature: Celsius(middle(self.temperature_c)),
            height_m: middle(self.height_m),
            width_m: middle(self.width_m),
        }
    }
}

impl Ensemble {
    /// Reads a file of networks for `drive`.
    ///
    /// # Errors
    /// [`NetworkError`] with the field: other format, another drive, sizes that do not fit, values that are not finite,
    /// and a checksum or a probe that does not come out as written.
    pub fn parse(text: &str, drive: DriveKind) -> Result<Self, NetworkError> {
        let raw: RawEnsemble = serde_json::from_str(text)?;
        let ensemble = raw.check()?;
        check_seal(&raw)?;
        if raw.drive != drive {
            return refuse("drive", raw.drive.name(), drive.name());
        }
        let probe = ensemble.probe();
        length("probe", raw.probe.len(), probe.len())?;
        for (place, (written, found)) in raw.probe.iter().zip(probe).enumerate() {
            agree(&format!("probe[{place}]"), *written, found)?;
        }
        Ok(ensemble)
    }

    fn probe(&self) -> Vec<f64> {
        let at = |(place, (_, hull)): (usize, &(String, Hull))| self.mean_and_spread(place, &hull.middle()).0;
        self.polymers.iter().enumerate().map(at).collect()
    }
}

impl RawEnsemble {
    pub(super) fn new(drive: DriveKind, trained: &str, range_s: [f64; 2], scaling: &Scaling) -> Self {
        Self {
            format: FORMAT.into(),
            version: VERSION,
            drive,
            trained: trained.into(),
            measured: None,
            polymers: vec![],
            range_s,
            floor_s: 0.0,
            factor: 1.0,
            centre: scaling.centre.clone(),
            scale: scaling.scale.clone(),
            clip: scaling.clip,
            members: vec![],
            probe: vec![],
            sha256: String::new(),
        }
    }

    /// Writes the probe that belongs to the weights, and the checksum.
    pub(super) fn sealed(mut self) -> Result<String, NetworkError> {
        self.probe = self.check()?.probe();
        seal(self)
    }

    pub(super) fn check(&self) -> Result<Ensemble, NetworkError> {
        if self.format != FORMAT || self.version != VERSION {
            let found = format!("{} {}", self.format, self.version);
            return refuse("format", found, format!("{FORMAT} {VERSION}"));
        }
        let inputs = self.polymers.len() + SHAPE;
        length("centre", self.centre.len(), inputs)?;
        length("scale", self.scale.len(), inputs)?;
        finite("centre", &self.centre)?;
        finite("scale", &self.scale)?;
        finite("range_s", &self.range_s)?;
        finite("floor_s, factor, clip", &[self.floor_s, self.factor, self.clip])?;
        if let Some(place) = self.scale.iter().position(|scale| *scale <= 0.0) {
            return refuse(format!("scale[{place}]"), self.scale[place], "above 0");
        }
        if self.range_s[0] < 0.0 || self.range_s[0] >= self.range_s[1] {
            return refuse("range_s", format!("{:?}", self.range_s), "0 or more, in order");
        }
        for (place, polymer) in self.polymers.iter().enumerate() {
            polymer.hull.check(&polymer.name)?;
            if self.polymers[..place].iter().any(|other| other.name == polymer.name) {
                return refuse(format!("polymers[{place}].name"), &polymer.name, "there once");
            }
        }
        let width_s = self.range_s[1] - self.range_s[0];
        if self.floor_s.max(self.floor_s * self.factor) > width_s {
            let wanted = format!("an interval within the range's width, {width_s}");
            return refuse("floor_s, factor", format!("{}, {}", self.floor_s, self.factor), wanted);
        }
        if self.floor_s < 0.0 || self.factor <= 0.0 || self.clip <= 0.0 {
            return refuse("floor_s, factor, clip", "negative or 0", "0 or more, above 0, above 0");
        }
        if self.polymers.is_empty() || self.members.is_empty() {
            return refuse("polymers, members", "empty", "one or more");
        }
        let member = |(place, layers): (usize, &Vec<RawLayer>)| {
            Network::read(&format!("members[{place}]"), inputs, layers)
        };
        Ok(Ensemble {
            drive: self.drive,
            trained: self.trained.clone(),
            measured: self.measured.unwrap_or(0),
            polymers: self.polymers.iter().map(|polymer| (polymer.name.clone(), polymer.hull)).collect(),
            range_s: self.range_s,
            floor_s: self.floor_s,
            factor: self.factor,
            scaling: Scaling { centre: self.centre.clone(), scale: self.scale.clone(), clip: self.clip },
            members: self.members.iter().enumerate().map(member).collect::<Result<_, _>>()?,
        })
    }
}
