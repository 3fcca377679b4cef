//! Which terms the torque has.

/// τ = Kp (q_d − q) + Kd (q̇_d − q̇) + τ_g(q; base): which of the terms, and which base.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Law {
    /// No gravity term.
    Pd,
    /// Gravity as it was when the arm was armed, whatever the base does afterwards.
    PdStaticGravity,
    /// The gravity of now, eqs (1)-(3) of Lewis & Hannaford.
    PdDynamicGravity,
    /// The base's full motion: f, ω and dω through the inverse dynamics of the arm at rest.
    PdBaseMotion,
    /// The gravity of now and nothing else: the arm stays where it is put.
    Passive,
}

impl Law {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Pd, Self::PdStaticGravity, Self::PdDynamicGravity, Self::PdBaseMotion, Self::Passive];

    /// Its name in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pd => "pd",
            Self::PdStaticGravity => "pd+sg",
            Self::PdDynamicGravity => "pd+dg",
            Self::PdBaseMotion => "pd+bm",
            Self::Passive => "passive",
        }
    }

    /// It has the terms with Kp and Kd.
    #[must_use]
    pub const fn has_pd(self) -> bool {
        !matches!(self, Self::Passive)
    }

    /// It has a gravity term.
    #[must_use]
    pub const fn has_gravity(self) -> bool {
        !matches!(self, Self::Pd)
    }
}
