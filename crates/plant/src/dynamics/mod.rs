//! What is true of a rig and the path of its tip go in, the motion and the forces of one push come
//! out.

pub(crate) mod balance;
pub(crate) mod energy;
pub(crate) mod ground;
pub(crate) mod integrate;
pub(crate) mod numerics;
pub(crate) mod outline;
pub(crate) mod pads;
pub(crate) mod plant;
pub(crate) mod quad;
pub(crate) mod relief;
pub(crate) mod resistance;
pub(crate) mod rig;
pub(crate) mod stand;
pub(crate) mod state;
pub(crate) mod step;
pub(crate) mod surroundings;
pub(crate) mod tip_contact;
pub(crate) mod tip_path;
pub(crate) mod trajectory;
