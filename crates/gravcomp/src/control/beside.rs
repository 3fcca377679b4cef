//! What acts beside the masses: the torque of the disturbance elements, in laws that have a gravity term.

use super::feel::Weight;
use super::places::{Places, places};
use super::{Controller, Side, State, take};
use crate::robot::Joints;

impl Controller {
    /// τ_e(q, q̇) at the last good pose, as gravity is; at rest off stale data and in a fault, which pushes nothing along.
    #[inline(always)]
    pub(super) fn beside<const N: usize>(&mut self, fresh: bool, weight: &impl Weight) {
        let mut tau = [0.0; N];
        if self.holds() {
            let moves = fresh && self.state() != State::Fault;
            let rates = if moves { self.joint_rates::<N>() } else { [0.0; N] };
            let held = weight.beside(&self.output.q, &Joints::from_slice(&rates));
            tau = self.at_output(places(&held), Side::Joint);
        }
        take(&tau, &mut self.output.tau_disturbance, &mut self.watch);
    }

    /// q̇ of the coordinates: the encoders' rates, or q̇ = C ṁ.
    #[inline(always)]
    fn joint_rates<const N: usize>(&self) -> Places<N> {
        let rates = places(self.encoders.rate());
        match &self.settings.transmission {
            Some(transmission) if self.settings.feedback == Side::Motor => transmission.joint_rates_of(rates),
            _ => *rates,
        }
    }
}
