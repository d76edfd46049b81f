//! What estimator and controller say of their own work, beside every estimate and every command.

macro_rules! health {
    ($(#[$about:meta])* $name:ident { $($(#[$doc:meta])* $variant:ident = $code:literal,)* }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
        #[repr(u8)]
        pub enum $name {
            $($(#[$doc])* $variant = $code,)*
        }

        impl $name {
            /// By its code on the wire; `None` for a code that means nothing.
            #[must_use]
            pub fn from_code(code: u8) -> Option<Self> {
                match code { $($code => Some(Self::$variant),)* _ => None }
            }
        }
    };
}

health! {
    /// Health of an estimate; greater is worse.
    EstimateHealth {
        /// Innovations and covariance agree.
        #[default]
        Sound = 0,
        /// The filter went back to its prior a moment ago (K4).
        Reset = 1,
        /// What is learnt of printer or noise has stood at its bound for long: another printer than the model's (K8).
        Mismatch = 2,
        /// The filter went back to its prior twice within a minute (K4).
        Diverging = 3,
    }
}

health! {
    /// Health of a command; greater is worse.
    ControlHealth {
        /// The plan is solved and leaves room to act.
        #[default]
        Sound = 0,
        /// An actuator has stood at its stop for long (K5).
        Saturated = 1,
        /// Several plans in a row came too late; the move goes back to the slicer's values (K2).
        Late = 2,
        /// The plan has no solution; the move goes back to the slicer's values (K1).
        Infeasible = 3,
        /// The plan or what it starts from is not finite, and was discarded (K3).
        NotFinite = 4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_lead_back_and_order_by_badness() {
        for code in 0..=u8::MAX {
            assert!(EstimateHealth::from_code(code).is_none_or(|health| health as u8 == code));
            assert!(ControlHealth::from_code(code).is_none_or(|health| health as u8 == code));
        }
        assert_eq!(
            (0..=u8::MAX).filter_map(EstimateHealth::from_code).max(),
            Some(EstimateHealth::Diverging)
        );
        assert_eq!((0..=u8::MAX).filter_map(ControlHealth::from_code).max(), Some(ControlHealth::NotFinite));
    }
}
