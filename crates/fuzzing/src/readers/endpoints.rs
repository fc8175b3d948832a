//! End points of pushes, and pairs of wrench and twist, of the MIT set.

use std::fs;
use std::path::Path;

use anyhow::Result;
use dataset::{ReadLimits, read_end_points, read_wrench_twists};

use super::super::reader::{Reader, Verdict};

/// Both tables: a file is read as each.
pub(super) struct EndPoints;

impl Reader for EndPoints {
    fn name(&self) -> &'static str {
        "endpoints"
    }

    fn corpus(&self, _: &Path) -> Result<Vec<Vec<u8>>> {
        let ends = "surface,shape,v_mm_s,push,obj_x0,obj_y0,obj_th0,obj_x1,obj_y1,obj_th1,\
                    tip_x0,tip_y0,tip_x1,tip_y1\n\
                    plywood,hex,20,3,0.1,0.2,0.3,0.11,0.21,0.4,-0.1,0,0.5,0.6\n\
                    plywood,rect1,20,4,0.1,0.2,0.3,0.11,0.21,0.4,-0.1,0,0.5,0.6\n";
        let twists = "surface,shape,v_mm_s,fx,fy,tau_over_rho,vx,vy,omega_times_rho\n\
                      plywood,rect1,20,1,2,0.5,0.01,0.02,0.004\n\
                      plywood,ellip1,20,1,2,0.5,0.01,0.02,0.004\n";
        Ok([ends, twists].map(|text| text.as_bytes().to_vec()).into())
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        let path = dir.join("ends.csv");
        if let Err(error) = fs::write(&path, input) {
            return Verdict::Wrong(format!("scratch is not usable: {error}"));
        }
        let twists = read_wrench_twists(&path).is_ok();
        let ends = read_end_points(&path, &ReadLimits::default()).is_ok();
        if ends || twists { Verdict::Accepted } else { Verdict::Refused }
    }
}
