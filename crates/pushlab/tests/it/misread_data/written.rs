//! Recordings and manifests written as they are, for the tool to read.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use dataset::{Manifest, ObjectChoice, PoseStream, Recording};
use nalgebra::{UnitQuaternion, Vector3};
use planar::Shape;

/// How the yaw of the object is written.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Yaw {
    Angle,
    /// As quaternions with w first under the headers of x, y, z and w.
    ReorderedQuaternion,
}

/// Writes a set of CSV folders with every digit of its numbers.
pub(crate) fn write_set(
    folder: &Path,
    (recordings, manifest): &(Vec<Recording>, Manifest),
    yaw: Yaw,
) {
    for one in recordings {
        let push = folder.join("pushes").join(&one.name);
        fs::create_dir_all(&push).unwrap();
        fs::write(push.join("robot.csv"), poses(&one.robot, Yaw::Angle)).unwrap();
        fs::write(push.join("object.csv"), poses(&one.object, yaw)).unwrap();
        let wrench = one.wrench.as_ref().unwrap();
        let mut text = "t_s,fx_n,fy_n\n".to_owned();
        for ((t, x), y) in wrench.t.iter().zip(&wrench.fx).zip(&wrench.fy) {
            let _ = writeln!(text, "{t},{x},{y}");
        }
        fs::write(push.join("wrench.csv"), text).unwrap();
    }
    fs::write(folder.join("dataset.toml"), stated(manifest)).unwrap();
}

fn poses(stream: &PoseStream, yaw: Yaw) -> String {
    let mut text = match yaw {
        Yaw::Angle => "t_s,x_m,y_m,theta_rad\n".to_owned(),
        Yaw::ReorderedQuaternion => "t_s,x_m,y_m,qx,qy,qz,qw\n".to_owned(),
    };
    for (k, t) in stream.t.iter().enumerate() {
        let (x, y, theta) = (stream.x[k], stream.y[k], stream.theta[k]);
        let _ = match yaw {
            Yaw::Angle => writeln!(text, "{t},{x},{y},{theta}"),
            Yaw::ReorderedQuaternion => {
                let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), theta);
                let [i, j, k, w]: [f64; 4] = turn.coords.into();
                writeln!(text, "{t},{x},{y},{w},{i},{j},{k}")
            }
        };
    }
    text
}

fn stated(manifest: &Manifest) -> String {
    let ObjectChoice::Fixed(object) = &manifest.object else {
        panic!("the simulator writes the object into the manifest")
    };
    let Shape::Polygon(outline) = &object.shape else { panic!("a polygon is pushed") };
    let vertices: Vec<[f64; 2]> = outline.vertices().iter().map(|v| [v.x, v.y]).collect();
    let (pusher, support, center) = (manifest.pusher, manifest.support, object.center_of_mass);
    format!(
        "name = \"misread\"\n[object]\nshape = \"polygon\"\nvertices_m = {vertices:?}\n\
         mass_kg = {}\nmoment_of_inertia_kg_m2 = {}\ncenter_of_mass_m = [{:?}, {:?}]\n\
         [pusher]\nradius_m = {}\nfriction = {}\n[support]\nfriction = {}\ngravity_m_s2 = {}\n\
         [recordings]\nformat = \"csv\"\npath = \"pushes\"\n",
        object.mass,
        object.moment_of_inertia,
        center.x,
        center.y,
        pusher.radius,
        pusher.friction,
        support.friction,
        support.gravity,
    )
}
