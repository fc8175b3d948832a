//! Where the work of the robot goes.

/// Work and heat since the start of a push, in J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Work of the robot on the tip.
    pub pusher_work: f64,
    /// Work of tilt, cable, magnet, grooves and of a couple at a biased contact on the object.
    pub external_work: f64,
    /// Heat between object and table.
    pub support_heat: f64,
    /// Heat between tip and object.
    pub slip_heat: f64,
    /// Heat inside the tip and its holder.
    pub tip_heat: f64,
    /// Kinetic energy of the object now.
    pub kinetic: f64,
    /// Energy in the tip's springs now.
    pub elastic: f64,
}

impl Energy {
    /// Work put in that is found nowhere, in J; 0 but for errors of the integration.
    #[must_use]
    pub fn residual(&self) -> f64 {
        let input = self.pusher_work + self.external_work;
        let heat = self.support_heat + self.slip_heat + self.tip_heat;
        input - heat - self.kinetic - self.elastic
    }

    /// The sums of two half steps, extrapolated by those of a whole step.
    pub(crate) fn beyond(&self, whole: &Self) -> Self {
        let beyond = |half: f64, whole: f64| half + (half - whole);
        Self {
            pusher_work: beyond(self.pusher_work, whole.pusher_work),
            external_work: beyond(self.external_work, whole.external_work),
            support_heat: beyond(self.support_heat, whole.support_heat),
            slip_heat: beyond(self.slip_heat, whole.slip_heat),
            tip_heat: beyond(self.tip_heat, whole.tip_heat),
            kinetic: self.kinetic,
            elastic: self.elastic,
        }
    }
}
