//! Axes of a sensor with their sign, as parameter files write them: `x`, `-y`.

use models::params::ParamError;

/// One axis of the sensor, in its direction or against it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Axis {
    index: usize,
    negative: bool,
}

/// Names of the axes in the order of their index.
const NAMES: [&str; 3] = ["x", "y", "z"];

impl Axis {
    /// Reads `x`, `y`, `z`, or one with a minus.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let (negative, name) = text.strip_prefix('-').map_or((false, text), |name| (true, name));
        let index = NAMES.iter().position(|known| *known == name)?;
        Some(Self { index, negative })
    }

    /// The axis along which a vector mostly lies; z where it is no vector.
    #[must_use]
    pub fn nearest(vector: [f64; 3]) -> Self {
        let mut index = 2;
        for candidate in [1, 0] {
            if vector[candidate].abs() > vector[index].abs() {
                index = candidate;
            }
        }
        Self { index, negative: vector[index] < 0.0 }
    }

    /// The component of a vector along this axis.
    #[must_use]
    pub fn of(self, vector: [f64; 3]) -> f64 {
        if self.negative { -vector[self.index] } else { vector[self.index] }
    }
}

impl std::fmt::Display for Axis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let sign = if self.negative { "-" } else { "" };
        write!(f, "{sign}{}", NAMES[self.index])
    }
}

/// Which axis of the sensor is x, y and z of the tool: a rotation, so that a shift and its sign stay what they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mounting([Axis; 3]);

impl Mounting {
    /// Three axes, each used once, right-handed.
    ///
    /// # Errors
    /// [`ParamError::OutOfRange`] with the determinant, which must be 1.
    pub fn new(axes: [Axis; 3]) -> Result<Self, ParamError> {
        let row = |axis: Axis| [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|unit| axis.of(unit));
        let [a, b, c] = axes.map(row);
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        let determinant: f64 = (0..3).map(|index| a[index] * cross[index]).sum();
        if determinant > 0.5 {
            return Ok(Self(axes));
        }
        let rule = "1: x, y and z once each, right-handed, as [x, y, z] or [y, -x, z]".into();
        Err(ParamError::OutOfRange { name: "axes determinant", value: determinant, unit: "-", rule })
    }

    /// A vector of the sensor in the tool's axes.
    #[must_use]
    pub fn tool_from_sensor(&self, sensor: [f64; 3]) -> [f64; 3] {
        self.0.map(|axis| axis.of(sensor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mounting(axes: [&str; 3]) -> Result<Mounting, ParamError> {
        Mounting::new(axes.map(|axis| Axis::parse(axis).unwrap()))
    }

    #[test]
    fn axes_are_read_and_written() {
        for text in ["x", "y", "z", "-x", "-y", "-z"] {
            assert_eq!(Axis::parse(text).unwrap().to_string(), text);
        }
        for text in ["", "-", "w", "xx", "+x"] {
            assert_eq!(Axis::parse(text), None);
        }
        assert_eq!(Axis::nearest([0.1, -9.0, 3.0]).to_string(), "-y");
    }

    #[test]
    fn a_mounting_is_a_rotation() {
        let turned = mounting(["y", "-x", "z"]).unwrap();
        let tool = turned.tool_from_sensor([1.0, 2.0, 3.0]);
        assert!(tool.iter().zip([2.0, -1.0, 3.0]).all(|(value, wanted)| (value - wanted).abs() < 1e-15));
        for wrong in [["x", "y", "-z"], ["y", "x", "z"], ["x", "x", "z"]] {
            assert!(mounting(wrong).unwrap_err().to_string().contains("right-handed"), "{wrong:?}");
        }
    }
}
