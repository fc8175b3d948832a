//! Every number by which a diagnosis names, grades or stays silent, and where it comes from.
//!
//! *Convention*: a choice that others would make otherwise. *Derived*: it follows from such choices. *Trial*:
//! chosen on simulated sets, on seeds that no table in `docs/` reports.

/// Largest probability of a name. Convention: one in a hundred sets, all effects together.
pub(crate) const NAME: f64 = 0.01;
/// The same of a hint. Convention.
pub(crate) const HINT: f64 = 0.05;

/// Least difference of predictions, in the noise of a number, of an effect that is not small. Trial: what does
/// not matter came to 0.04 to 0.16.
pub(crate) const SIZE: f64 = 0.3;
/// The same of an effect that needs no other merit. Trial: a second name that takes up what another leaves came
/// to 0.31 to 0.37, effects that are wanted to 0.75 and more.
pub(crate) const LARGE: f64 = 0.75;
/// Share of the gain so far that any other later effect has to add. Convention.
pub(crate) const LATER_SHARE: f64 = 0.01;
/// Share of the gap to the floor that nothing small closes. Convention.
pub(crate) const SMALL_SHARE: f64 = 0.05;
/// Small effects that are kept at most. Convention: each costs another screen.
pub(crate) const MOST_SMALL: usize = 2;

/// Least gain that is sure, in nats. Convention: odds of 55 to 1.
pub(crate) const SURE_NATS: f64 = 4.0;
/// The same in standard errors. Derived: once in twenty, of one side.
pub(crate) const SURE_SE: f64 = 1.64;
/// Largest gain of one cluster, in nats. Convention: 20 000 to 1; where a model misses by many standard
/// deviations, the tails of the noise decide, which nobody knows, and few pushes hold it all.
pub(crate) const MOST_OF_ONE: f64 = 10.0;

/// Difference in twice the log likelihood that tells effects apart. Convention: odds of 20 to 1.
pub(crate) const APART: f64 = 6.0;
/// Share of what an effect explains by which a documented look-alike has to fall behind. Convention: no model of
/// a rig is true enough to tell them apart by less.
pub(crate) const SHARE_APART: f64 = 0.05;
/// Share of what an effect explains alone that is its own if it explains it beside another, too. Convention.
pub(crate) const OWN_SHARE: f64 = 0.5;
/// What points leave after a brief descent, over what the model leaves that they are tried in the place of, beyond
/// which they are given up. Trial: where feet were hidden it came to 0.4 to 0.9, on real pushes that points
/// explain better to 1.05, else to 1.1 to 12.
pub(crate) const FAR_ABOVE: f64 = 1.08;
/// Correlation of signatures beyond which two effects are one to the data. Convention: a twenty-fifth of
/// its square is its own.
pub(crate) const ALIKE: f64 = 0.98;
/// Tolerances, and standard errors beside them, within which a nominal number is as told. Derived: 95 % of each.
pub(crate) const TOLERANCES: f64 = 2.0;
/// Share of an estimate's size by which models of rigs miss the truth. Trial: without it intervals of strong
/// effects missed by four standard errors, 1 % of the value.
pub(crate) const MODEL_TOLERANCE: f64 = 0.01;

/// Share of what an effect takes off the squared error that more freedom of the same origin may take off
/// beside it. Convention.
pub(crate) const MORE_FREEDOM: f64 = 0.25;
/// Share of its size by which an effect may move beside a free component of its origin. Convention, the same.
pub(crate) const MOVED: f64 = MORE_FREEDOM;
/// Standard errors beyond which it surely moves. Derived: 95 %.
pub(crate) const SURE_MOVED: f64 = 2.0;
/// Standard errors beyond which an effect is sure beside such a component. Convention: once in a thousand.
pub(crate) const SURE_BESIDE: f64 = 3.0;
/// Share of the mean square of a number by which an effect may raise it. Convention, the same.
pub(crate) const RAISED: f64 = MORE_FREEDOM;
/// Groups of pushes along a covariate, over which a size has to be the same. Convention.
pub(crate) const N_GROUPS: usize = 5;
/// Fewest pushes of a group. Convention: fewer tell little of its size.
pub(crate) const FEWEST_IN_GROUP: usize = 4;
/// Normal quantile beyond which sizes of groups differ. Derived: [`NAME`] over the number of ways to group.
pub(crate) const DIFFERENT: f64 = 2.93;
/// Share of a size by which it may differ. Convention: models of rigs are not truer.
pub(crate) const DIFFERENT_SHARE: f64 = 0.25;
/// Half-width of the interval of a place, in the mean distance of the pressure, from which other places do as
/// well. Convention.
pub(crate) const WIDE: f64 = 0.2;

/// Whitened error from which what is left matters: more than half of the noise stands beside it. Trial: where
/// nothing is hidden less is seen, for a model of a rig is never quite the rig.
pub(crate) const MISSES: f64 = 1.15;
/// Share of what is left of some number that a region explains, with the same say. Trial.
pub(crate) const LEFT_SHARE: f64 = 0.2;
/// Whitened error that no noise has. Trial.
pub(crate) const FAR_OFF: f64 = 1.5;
/// Cook's distance from which pushes are influential. Convention (Cook & Weisberg, 1982).
pub(crate) const INFLUENTIAL: f64 = 1.0;
/// Standard deviations that no noise misses a push by. Convention.
pub(crate) const FAR: f64 = 8.0;
/// Least change of some number of a push, in its noise, from which an effect acts on it. Convention.
pub(crate) const ACTS: f64 = 1.0;
/// Fewest pushes missed by as much that share something. Convention: two always do.
pub(crate) const FEWEST_FAR: usize = 3;
/// Share of the pushes from which those missed by as much, or acted on, are no exception. Convention.
pub(crate) const MOST_FAR: f64 = 0.25;

/// Share of the noise that one quantity's differences from push to push make, from which the sentence tells it.
/// Convention: most.
pub(crate) const MOST_OF_NOISE: f64 = 0.5;
/// The same from which it is listed, and carried by a model. Convention: a twentieth.
pub(crate) const MUCH_OF_NOISE: f64 = 0.05;

/// Share of the pushes that may be excluded since a number rests on one of them, or on one session, alone.
/// Convention.
pub(crate) const MOST_ALONE: f64 = 0.1;

/// Measuring sessions from which sessions, not pushes, are taken for independent. Convention: three are held out,
/// and flips of the signs of nine are enough for [`NAME`].
pub(crate) const FEWEST_SESSIONS: usize = 12;
/// Sessions below which nothing is said of how much a parameter differs between them: three degrees of freedom
/// leave a standard deviation open by a factor of four (95 %). Convention.
pub(crate) const FEWEST_SESSIONS_OF_SPREAD: usize = 4;
/// Log likelihood in nats that a variance has to gain over none: half the 95 % quantile of ½χ²₀ + ½χ²₁ (Self &
/// Liang 1987). Derived.
pub(crate) const SURE_OF_SPREAD: f64 = 1.353;
/// Clusters below which nothing is asked of what is left. Derived: 2⁷ flips are the fewest for [`NAME`].
pub(crate) const FEWEST_CLUSTERS: usize = 8;
/// Pushes for each number that says where an object rests, below which nothing is asked of it. Convention.
pub(crate) const PUSHES_A_NUMBER: usize = 4;
/// Clusters for each number of an effect, below which no covariance of clusters tests it: with 22 for 20 numbers the
/// answer hung by the last digits of predictions. Convention.
pub(crate) const CLUSTERS_A_NUMBER: f64 = 2.0;
/// Factor within which speeds are one. Convention.
pub(crate) const ONE_SPEED: f64 = 1.5;
