//! Made complexes with their closed forms.

use super::forms::{Builder, Form, Forms};
use crate::model::complex::MidComplex;
use glam::DVec3;
use std::f64::consts::TAU;

pub fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// The planes that bound a box from the origin to `to`.
fn sides(to: DVec3) -> Vec<Form> {
    [DVec3::X, DVec3::Y, DVec3::Z]
        .into_iter()
        .flat_map(|n| [Form::Plane(DVec3::ZERO, n), Form::Plane(to, n)])
        .collect()
}

/// A rectangle 10 x 6 in z = 0.
pub fn plate(nu: usize, nv: usize) -> (MidComplex, Forms) {
    rectangle(v(10.0, 6.0, 0.0), nu, nv)
}

/// A rectangle from the origin to `to` in z = 0.
pub fn rectangle(to: DVec3, nu: usize, nv: usize) -> (MidComplex, Forms) {
    let forms = Forms {
        walls: vec![Form::Plane(DVec3::ZERO, DVec3::Z)],
        faces: sides(to + DVec3::Z)[..4].to_vec(),
        thickness: 0.5,
    };
    let mut b = Builder::default();
    b.grid(nu, nv, 0, |s, t| v(to.x * s, to.y * t, 0.0));
    (b.finish(&forms), forms)
}

/// A triangle in z = 0 with this angle, degrees, at the origin, 8 long.
pub fn wedge(angle: f64) -> (MidComplex, Forms) {
    let slope = angle.to_radians().tan();
    let normal = v(-slope, 1.0, 0.0).normalize();
    let forms = Forms {
        walls: vec![Form::Plane(DVec3::ZERO, DVec3::Z)],
        faces: vec![
            Form::Plane(DVec3::ZERO, DVec3::Y),
            Form::Plane(DVec3::ZERO, normal),
            Form::Plane(v(8.0, 0.0, 0.0), DVec3::X),
        ],
        thickness: 0.5,
    };
    let mut b = Builder::default();
    b.grid(20, 6, 0, |s, t| v(8.0 * s, 8.0 * s * t * slope, 0.0));
    (b.finish(&forms), forms)
}

/// Half planes 4 x 6 round the y axis, at these angles in degrees, each a wall of its own.
pub fn book(angles: &[f64], cells: usize) -> (MidComplex, Forms) {
    let direction = |a: f64| v(a.to_radians().cos(), 0.0, a.to_radians().sin());
    let mut forms = Forms {
        walls: angles
            .iter()
            .map(|&a| Form::Plane(DVec3::ZERO, direction(a + 90.0)))
            .collect(),
        faces: sides(v(1.0, 6.0, 1.0))[2..4].to_vec(),
        thickness: 0.5,
    };
    for &a in angles {
        forms
            .faces
            .push(Form::Plane(direction(a) * 4.0, direction(a)));
    }
    let mut b = Builder::default();
    for (i, &a) in angles.iter().enumerate() {
        b.grid(cells, cells + 2, i as u32, |s, t| {
            direction(a) * (4.0 * s) + v(0.0, 6.0 * t, 0.0)
        });
    }
    (b.finish(&forms), forms)
}

/// A through-going plate with a rib: two triangles of wall 0 and one of wall 1 at the junction.
pub fn tee(cells: usize) -> (MidComplex, Forms) {
    let mut faces = sides(v(8.0, 6.0, 1.0))[..4].to_vec();
    faces.push(Form::Plane(v(0.0, 0.0, 4.0), DVec3::Z));
    let forms = Forms {
        walls: vec![
            Form::Plane(DVec3::ZERO, DVec3::Z),
            Form::Plane(v(4.0, 0.0, 0.0), DVec3::X),
        ],
        faces,
        thickness: 0.5,
    };
    let mut b = Builder::default();
    b.grid(2 * cells, cells, 0, |s, t| v(8.0 * s, 6.0 * t, 0.0));
    b.grid(cells, cells, 1, |s, t| v(4.0, 6.0 * t, 4.0 * s));
    (b.finish(&forms), forms)
}

/// A tube about z, radius 3, height 8.
pub fn tube(round: usize, up: usize) -> (MidComplex, Forms) {
    let forms = Forms {
        walls: vec![Form::Cylinder(DVec3::ZERO, DVec3::Z, 3.0)],
        faces: sides(v(1.0, 1.0, 8.0))[4..].to_vec(),
        thickness: 0.3,
    };
    let mut b = Builder::default();
    b.grid(round, up, 0, |s, t| {
        v(3.0 * (TAU * s).cos(), 3.0 * (TAU * s).sin(), 8.0 * t)
    });
    (b.finish(&forms), forms)
}

/// A sphere of radius 3, from a cube.
pub fn sphere(cells: usize) -> (MidComplex, Forms) {
    let forms = Forms {
        walls: vec![Form::Sphere(DVec3::ZERO, 3.0)],
        faces: vec![],
        thickness: 0.3,
    };
    let mut b = Builder::default();
    for (x, y, z) in [
        (DVec3::X, DVec3::Y, DVec3::Z),
        (DVec3::Y, DVec3::Z, DVec3::X),
        (DVec3::Z, DVec3::X, DVec3::Y),
    ] {
        for side in [-1.0, 1.0] {
            b.grid(cells, cells, 0, |s, t| {
                let p = x * (2.0 * s - 1.0) + y * (2.0 * t - 1.0) + z * side;
                p.normalize() * 3.0
            });
        }
    }
    (b.finish(&forms), forms)
}

/// A disk of radius 5 with a hole of radius 1 in z = 0.
pub fn washer(round: usize, out: usize) -> (MidComplex, Forms) {
    let forms = Forms {
        walls: vec![Form::Plane(DVec3::ZERO, DVec3::Z)],
        faces: vec![
            Form::Cylinder(DVec3::ZERO, DVec3::Z, 1.0),
            Form::Cylinder(DVec3::ZERO, DVec3::Z, 5.0),
        ],
        thickness: 0.2,
    };
    let mut b = Builder::default();
    b.grid(round, out, 0, |s, t| {
        let r = 1.0 + 4.0 * t;
        v(r * (TAU * s).cos(), r * (TAU * s).sin(), 0.0)
    });
    (b.finish(&forms), forms)
}
