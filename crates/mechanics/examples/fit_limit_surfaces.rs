//! Fits ellipsoid, quartic and patch to measured wrench–twist pairs of the MIT objects.
//!
//! `cargo run --release -p mechanics --example fit_limit_surfaces -- wrench_twist_plywood.csv`
//!
//! Names of objects after the path restrict the table to them.

use mechanics::{MechanicsError, WrenchTwist, fit_ellipsoid, fit_patch, fit_quartic};
use nalgebra::Vector2;
use planar::{MIT_NAMES, Polygon, Shape, Twist, Wrench, mit_object};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("give the path of the CSV file of pairs")?;
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{path}: {error}"))?;
    println!("object  pairs   force error in N (rms)        twist error in ° (mean)");
    println!("                ellipsoid  quartic  patch     ellipsoid  quartic  patch   attempts");
    let asked: Vec<String> = std::env::args().skip(2).collect();
    for name in MIT_NAMES {
        if !asked.is_empty() && !asked.iter().any(|a| a == name) {
            continue;
        }
        let shape = about_centroid(&mit_object(name)?.shape)?;
        let length = shape.mean_distance(&Vector2::zeros());
        let pairs = pairs_of(name, &text, length)?;
        println!("{name:7} {}", row(&shape, &pairs, length)?);
    }
    Ok(())
}

fn row(shape: &Shape, pairs: &[WrenchTwist], length: f64) -> Result<String, MechanicsError> {
    let ellipsoid = fit_ellipsoid(pairs, length)?;
    let quartic = fit_quartic(pairs, length)?;
    let patch = fit_patch(shape, pairs, length)?;
    Ok(format!(
        "{:5}   {:9.3}  {:7.3}  {:5.3}     {:9.2}  {:7.2}  {:5.2}   {} {} {}",
        pairs.len(),
        ellipsoid.force_error_rms,
        quartic.force_error_rms,
        patch.force_error_rms,
        ellipsoid.twist_error_mean.to_degrees(),
        quartic.twist_error_mean.to_degrees(),
        patch.twist_error_mean.to_degrees(),
        ellipsoid.iterations,
        quartic.iterations,
        patch.iterations,
    ))
}

/// Rows are surface, shape, v_mm_s, fx, fy, M/ρ, vx, vy, ω ρ.
fn pairs_of(name: &str, text: &str, length: f64) -> Result<Vec<WrenchTwist>, Box<dyn Error>> {
    let mut pairs = Vec::new();
    for (index, line) in text.lines().enumerate().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        if cells.len() != 9 {
            return Err(
                format!("line {}: 9 columns expected, got {}", index + 1, cells.len()).into()
            );
        }
        if cells[1] != name {
            continue;
        }
        let numbers = cells[3..].iter().map(|cell| cell.trim().parse::<f64>());
        let n = numbers
            .collect::<Result<Vec<_>, _>>()
            .map_err(|e| format!("line {}: {e}", index + 1))?;
        let wrench = Wrench::new(n[0], n[1], n[2] * length);
        pairs.push(WrenchTwist { wrench, twist: Twist::new(n[3], n[4], n[5] / length) });
    }
    Ok(pairs)
}

fn about_centroid(shape: &Shape) -> Result<Shape, planar::PlanarError> {
    let center = shape.centroid();
    Ok(match shape {
        Shape::Polygon(polygon) => {
            let moved = polygon.vertices().iter().map(|v| v - center).collect();
            Shape::Polygon(Polygon::new(moved)?)
        }
        Shape::Ellipse(ellipse) => Shape::Ellipse(*ellipse),
    })
}
