//! A `ravengc.spec.RobotSpec` read attribute by attribute and built into a robot.

use crate::errors::{argument_error, cut, did_you_mean, model_error};
use crate::present::{Present, Tool};
use gravcomp::{Coupling, DhRow, Frame, Inertia, Joint, ModelError, Placement, RobotBuilder, Transmission};
use nalgebra::{Matrix3, Vector3};
use pyo3::prelude::*;
use std::collections::HashMap;

#[derive(FromPyObject)]
struct PoseSpec {
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
}

impl PoseSpec {
    fn checked(&self, field: &'static str) -> Result<gravcomp::Pose, ModelError> {
        let rotation = Matrix3::from_row_slice(self.rotation.as_flattened());
        gravcomp::Pose::new(rotation, self.translation.into(), field)
    }
}

#[derive(FromPyObject)]
enum PlacementSpec {
    Dh { alpha: f64, a: f64, d: f64, theta: f64 },
    Origin { pose: PoseSpec, axis: [f64; 3] },
}

#[derive(FromPyObject)]
struct LinkSpec {
    name: String,
    joint: String,
    parent: Option<String>,
    placement: PlacementSpec,
    mass: f64,
    com: [f64; 3],
    inertia: [f64; 6],
}

impl LinkSpec {
    fn kind(&self) -> Joint {
        match self.joint.as_str() {
            "prismatic" => Joint::Prismatic,
            "fixed" => Joint::Fixed,
            _ => Joint::Revolute,
        }
    }

    fn lowered(&self, convention: &str) -> Result<Placement, ModelError> {
        match &self.placement {
            PlacementSpec::Origin { pose, axis } => {
                gravcomp::dh::explicit(pose.checked("origin")?, &Vector3::from(*axis), self.kind())
            }
            &PlacementSpec::Dh { alpha, a, d, theta } => {
                let row = DhRow { alpha, a, d, theta };
                if convention == "standard" { row.standard() } else { row.modified() }
            }
        }
    }

    fn add(&self, builder: &mut RobotBuilder, parent: &Frame, convention: &str) -> Result<Frame, ModelError> {
        let inertia = Inertia::new(self.mass, Vector3::from(self.com), self.inertia)?;
        builder.link(parent, self.kind(), &self.lowered(convention)?, &inertia)
    }
}

#[derive(FromPyObject)]
struct CouplingSpec {
    matrix: Vec<Vec<f64>>,
    offset: Vec<f64>,
}

#[derive(FromPyObject)]
struct TransmissionSpec {
    joint_per_motor: Vec<Vec<f64>>,
    offset: Vec<f64>,
}

/// The parts of a `RobotSpec` that a robot is built from.
#[derive(FromPyObject)]
pub struct RobotSpec {
    pub name: String,
    convention: String,
    links: Vec<LinkSpec>,
    base: PoseSpec,
    tool: PoseSpec,
    tip: Option<String>,
    coupling: Option<CouplingSpec>,
    transmission: Option<TransmissionSpec>,
    coordinate_names: Vec<String>,
    disturbances: Vec<Columns>,
}

/// What the parameters of a disturbance element are called.
#[derive(FromPyObject)]
struct Columns {
    name: String,
    labels: Vec<String>,
}

/// What the parts of a robot are called.
pub struct Names {
    /// The robot itself.
    pub robot: String,
    /// Its coordinates.
    pub joints: Vec<String>,
    /// "base", the links in order, "tool".
    pub frame_order: Vec<String>,
    frames: HashMap<String, Frame>,
    /// The link that the tool stands on unless another is named.
    pub tip: String,
    /// The parameters of its disturbance elements.
    pub columns: Vec<String>,
}

/// A robot, its transmission if it has one, and the names of its parts.
pub type Built = (Present, Option<Transmission>, Names);

impl Names {
    /// A frame other than the tool.
    pub fn frame(&self, py: Python<'_>, name: &str) -> PyResult<Frame> {
        self.frames.get(name).copied().ok_or_else(|| {
            let (near, known) = (did_you_mean(py, name, &self.frame_order), self.frame_order.join(", "));
            argument_error(py, format!("no frame '{}' in {}{near} (there are {known})", cut(name), self.robot))
        })
    }
}

impl RobotSpec {
    /// Builds the robot; errors name the link or table.
    pub fn build(&self, py: Python<'_>) -> PyResult<Built> {
        let at = |place: &str, error: ModelError| model_error(py, &format!("{}: {place}", self.name), &error);
        let mut builder = RobotBuilder::new();
        let mut frames = HashMap::new();
        let mut frame_names = vec!["base".to_owned()];
        for link in &self.links {
            let place = format!("link '{}'", link.name);
            let parent = match &link.parent {
                None => Frame::ROOT,
                Some(parent) => *frames.get(parent).ok_or_else(|| {
                    argument_error(py, format!("{}: {place}: parent '{parent}' is no earlier link", self.name))
                })?,
            };
            let frame = link.add(&mut builder, &parent, &self.convention).map_err(|e| at(&place, e))?;
            frames.insert(link.name.clone(), frame);
            frame_names.push(link.name.clone());
        }
        frames.insert("base".to_owned(), Frame::BASE);
        frame_names.push("tool".to_owned());
        let last = self.links.last().map_or("base", |link| &link.name);
        let tip = self.tip.as_deref().unwrap_or(last).to_owned();
        let joints = self.coordinate_names.clone();
        let columns = self.disturbances.iter().flat_map(Columns::names).collect();
        let names = Names { robot: self.name.clone(), joints, frame_order: frame_names, frames, tip, columns };
        let tool = Tool::new(py, &names, &names.tip, self.tool.checked("tool").map_err(|e| at("tool", e))?)?;
        let base = self.base.checked("base").map_err(|e| at("base", e))?;
        let coupling = self.coupling.as_ref().map(CouplingSpec::checked).transpose().map_err(|e| at("coupling", e))?;
        let transmission =
            self.transmission.as_ref().map(|t| Transmission::new(&t.joint_per_motor.concat(), &t.offset));
        let transmission = transmission.transpose().map_err(|e| at("transmission", e))?;
        let robot = builder.build(base, tool.frame(), coupling).map_err(|e| at("robot", e))?;
        if let Some(found) = transmission.as_ref().filter(|t| t.motors() != robot.coordinates()) {
            let (motors, entries) = (robot.coordinates(), found.motors() * found.motors());
            return Err(at("transmission", ModelError::TransmissionShape { entries, motors }));
        }
        Ok((Present::new(robot, tool), transmission, names))
    }
}

impl Columns {
    fn names(&self) -> impl Iterator<Item = String> {
        self.labels.iter().map(|label| format!("{}.{label}", self.name))
    }
}

impl CouplingSpec {
    fn checked(&self) -> Result<Coupling, ModelError> {
        let columns = self.matrix.first().map_or(0, Vec::len);
        let ragged = self.matrix.len() != self.offset.len() || self.matrix.iter().any(|row| row.len() != columns);
        if ragged {
            return Err(ModelError::CouplingShape { found: (self.matrix.len(), columns), bodies: self.offset.len() });
        }
        Coupling::new(&self.matrix.concat(), &self.offset, columns)
    }
}
