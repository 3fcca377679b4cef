//! Gravity through elastic joints: where the motors belong, and the torque that [`crate::elastic`] adds to their PD.

use super::Controller;
use super::encoder::are_numbers;
use super::feel::Weight;
use super::places::Places;
use crate::elastic::{ElasticGravity, Variant};
use crate::error::SettingsError;
use crate::robot::Joints;

/// The springs of an arm in its law.
#[derive(Clone, Debug)]
pub(super) struct Springs {
    law: ElasticGravity,
    /// Where the links are, where a sensor measures them.
    links: Joints,
    /// θ_d, once it was found.
    aim: Option<Joints>,
    iterations: u32,
    error: f64,
}

impl Springs {
    pub(super) fn new(mut law: ElasticGravity) -> Self {
        law.reset();
        Self { law, links: Joints::default(), aim: None, iterations: 0, error: 0.0 }
    }

    /// Takes the links' positions of this cycle if they are needed; false where they are needed and not there.
    pub(super) fn see<const N: usize>(&mut self, links: Option<Places<N>>) -> bool {
        if self.law.settings().variant != Variant::Link {
            return true;
        }
        let Some(links) = links.filter(are_numbers) else { return false };
        for j in 0..N {
            self.links[j] = links[j];
        }
        true
    }

    /// g(at) with the motors at `motors`: on the way to `goal`, or without one, where the links hang.
    pub(super) fn hold(
        &mut self,
        hold: impl Fn(&Joints) -> Joints,
        field: f64,
        motors: &Joints,
        goal: Option<&Joints>,
    ) -> Joints {
        let Some(goal) = goal else { return self.hang(hold, field, motors) };
        let found = self.law.step(hold, field, motors, goal, &self.links);
        (self.iterations, self.error) = (found.iterations, found.error);
        if found.theta_d.iter().all(|x| x.is_finite()) {
            self.aim = Some(found.theta_d);
        }
        found.torque
    }

    fn hang(&mut self, hold: impl Fn(&Joints) -> Joints, field: f64, motors: &Joints) -> Joints {
        if self.law.settings().variant == Variant::Link {
            return hold(&self.links);
        }
        let found = self.law.hang(hold, field, motors);
        (self.iterations, self.error) = (found.iterations, found.error);
        found.torque
    }

    /// Where the links are with the motors at `motors`.
    pub(super) fn links(&self, hold: impl Fn(&Joints) -> Joints, field: f64, motors: &Joints) -> Joints {
        if self.law.settings().variant == Variant::Link { self.links } else { self.law.hanging(hold, field, motors).q }
    }

    /// Steps of the fixed point in the last cycle, and the bound on what is left of its error.
    pub(super) const fn found(&self) -> (u32, f64) {
        (self.iterations, self.error)
    }
}

impl Controller {
    /// The same for an arm with elastic joints, whose motors the encoders read.
    ///
    /// # Errors
    /// [`SettingsError`] for springs of another arm, a law without gravity, and gravity alone where the variant needs a goal.
    pub fn with_elastic(mut self, elastic: ElasticGravity) -> Result<Self, SettingsError> {
        let (law, joints) = (self.settings.law, elastic.stiffness().joints());
        let refused = |field, value, wanted| Err(SettingsError { field, joint: None, value, wanted });
        #[allow(clippy::cast_precision_loss)] // at most 16
        if joints != self.settings.coordinates {
            return refused("elastic (joints)", joints as f64, "as many joints as coordinates");
        }
        if !law.has_gravity() {
            return refused("elastic", f64::NAN, "left out, as the law has no gravity term");
        }
        if !law.has_pd() && !matches!(elastic.settings().variant, Variant::QuasiStatic | Variant::Link) {
            return refused("elastic", f64::NAN, "quasi-static or of the links, as gravity alone has no goal");
        }
        self.springs = Some(Springs::new(elastic));
        Ok(self)
    }

    /// Where the motors of an arm with elastic joints belong, θ_d in joint units; none before a goal was followed.
    #[must_use]
    pub fn theta_desired(&self) -> Option<&Joints> {
        self.springs.as_ref()?.aim.as_ref()
    }

    /// Steps of the fixed point in the last cycle, and how far at most gravity was taken from it (rad, m).
    #[must_use]
    pub fn fixed_point(&self) -> Option<(u32, f64)> {
        self.springs.as_ref().map(Springs::found)
    }

    /// θ_d; the goal of the links before it was found.
    pub(super) fn aim(&self) -> &Joints {
        self.theta_desired().unwrap_or(&self.targets.last().q)
    }

    /// Where there is no target yet, the links stay where they are.
    #[cold]
    pub(super) fn stay(&mut self, weight: &impl Weight) {
        if self.targets.is_known() {
            return;
        }
        let (law, feel) = (self.settings.law, &self.feel);
        self.targets.stay(&match &self.springs {
            Some(springs) => springs.links(|q| feel.hold(law, weight, q), feel.field(law), &self.start),
            None => self.start,
        });
    }

    /// The same through elastic joints: on the way to the target, or where the links hang.
    #[inline(never)]
    pub(super) fn weight_on_springs(&mut self, weight: &impl Weight) -> Joints {
        let (law, feel, motors) = (self.settings.law, &self.feel, &self.output.q);
        let follows = self.targets.is_known() || self.state().is_driven();
        let goal = if follows { &self.targets.last().q } else { motors };
        let goal = (law.has_pd() && !self.holds_after_fault()).then_some(goal);
        let Some(springs) = &mut self.springs else { return Joints::default() };
        springs.hold(|q| feel.hold(law, weight, q), feel.field(law), motors, goal)
    }
}
