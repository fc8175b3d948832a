//! Why a claim does not hold where it does not, by its number.

/// What the figures show that settle the claims.
const REASONS: &[(u32, &str)] = &[
    (
        2,
        "The start is found nearly always, the end is not: a tip that has stopped may go on pressing \
         against the object, and a sensor that has lost its zero reads a force that never ends.",
    ),
    (
        5,
        "The longer a step is, the smaller a share of it is the noise of the poses, and where little \
         else scatters the error falls on beyond 0.2 s.",
    ),
    (
        6,
        "Where steps hardly scatter, the exact process errs so little that what few pseudo-inputs \
         leave out shows; where they scatter as real ones do, it does not.",
    ),
    (
        7,
        "The thesis' cosines come near the exact process slowly, and never where it errs next to \
         nothing; on real steps 100 are a tenth worse than it, and features that are fitted by their \
         own likelihood need no more than 100.",
    ),
    (
        9,
        "The hybrid does need fewer steps, but both need not meet: where the mechanics are nearly all \
         that there is, it stays ahead.",
    ),
    (
        10,
        "Where steps scatter little, the variance is what is not known of the function, and follows how \
         densely there are steps; so it does where pushes are few.",
    ),
    (
        13,
        "The end of a push is a sum of many small steps with independent errors, which is nearly \
         Gaussian unless the tip comes near a vertex.",
    ),
    (
        16,
        "The edges of the simulated object are more alike than steps on one edge are, so that what they \
         differ by is not seen.",
    ),
    (
        17,
        "Inertia spoils the analytical model at 200 and 400 mm/s, but what is left of it is still easier \
         to learn than the whole push.",
    ),
    (
        18,
        "FITC takes what it cannot describe for noise that changes from place to place, which costs most \
         where there is least noise; VFE, which does not, comes nearer.",
    ),
];

/// Why a claim of this number does not hold where it does not, if it is known.
pub(super) fn reason(number: u32) -> Option<&'static str> {
    REASONS.iter().find(|(own, _)| *own == number).map(|(_, reason)| *reason)
}
