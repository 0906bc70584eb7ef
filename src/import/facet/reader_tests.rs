//! The readers on good files of every dialect, and on broken ones: cut at every byte, with any bit turned, and at random.

use glam::DVec3;
use proptest::prelude::*;

use super::FacetFormat;
use super::FacetFormat::{Obj, Ply, Stl};
use super::soup::{Place, ReadErrorKind, Soup};

/// A tetrahedron with three sides of length one.
pub(super) fn tetrahedron() -> Soup {
    Soup {
        points: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    }
}

fn stl_ascii(soup: &Soup) -> Vec<u8> {
    let mut text = String::from("solid t\n");
    for t in 0..soup.triangles.len() {
        text += " facet normal 0 0 0\n  outer loop\n";
        for p in soup.corners(t) {
            text += &format!("   vertex {:e} {:e} {:e}\n", p.x, p.y, p.z);
        }
        text += "  endloop\n endfacet\n";
    }
    (text + "endsolid t\n").into_bytes()
}

fn stl_binary(soup: &Soup) -> Vec<u8> {
    let mut bytes = b"solid, although it is binary".to_vec();
    bytes.resize(80, 0);
    bytes.extend((soup.triangles.len() as u32).to_le_bytes());
    for t in 0..soup.triangles.len() {
        bytes.extend([0; 12]);
        for p in soup.corners(t) {
            for x in p.to_array() {
                bytes.extend((x as f32).to_le_bytes());
            }
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn obj(soup: &Soup) -> Vec<u8> {
    let mut text = String::from("# a comment\no thing\n");
    for p in &soup.points {
        text += &format!("v {} {} {}\nvt 0 0\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &soup.triangles {
        text += &format!("f {}/1 {}//2 {}/1/2\n", a + 1, b + 1, c + 1);
    }
    text.into_bytes()
}

fn ply_header(soup: &Soup, format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment made here\nelement vertex {}\nproperty float x\nproperty double y\nproperty float z\nproperty uchar red\n\
         element face {}\nproperty list uchar int vertex_indices\nproperty short flag\nend_header\n",
        soup.points.len(),
        soup.triangles.len()
    )
}

fn ply_ascii(soup: &Soup) -> Vec<u8> {
    let mut text = ply_header(soup, "ascii");
    for p in &soup.points {
        text += &format!("{} {} {} 255\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &soup.triangles {
        text += &format!("3 {a} {b} {c} -7\n");
    }
    text.into_bytes()
}

fn ply_binary(soup: &Soup, big: bool) -> Vec<u8> {
    let name = if big {
        "binary_big_endian"
    } else {
        "binary_little_endian"
    };
    let mut bytes = ply_header(soup, name).into_bytes();
    let mut put = |raw: &[u8]| {
        let mut raw = raw.to_vec();
        if big {
            raw.reverse();
        }
        bytes.extend(raw);
    };
    for p in &soup.points {
        put(&(p.x as f32).to_le_bytes());
        put(&p.y.to_le_bytes());
        put(&(p.z as f32).to_le_bytes());
        put(&[255]);
    }
    for t in &soup.triangles {
        put(&[3]);
        for v in t {
            put(&v.to_le_bytes());
        }
        put(&(-7i16).to_le_bytes());
    }
    bytes
}

/// One small file of every dialect.
fn dialects() -> Vec<(&'static str, FacetFormat, Vec<u8>)> {
    let soup = tetrahedron();
    vec![
        ("ASCII STL", Stl, stl_ascii(&soup)),
        ("binary STL", Stl, stl_binary(&soup)),
        ("OBJ", Obj, obj(&soup)),
        ("ASCII PLY", Ply, ply_ascii(&soup)),
        ("little PLY", Ply, ply_binary(&soup, false)),
        ("big PLY", Ply, ply_binary(&soup, true)),
    ]
}

fn corners(soup: &Soup) -> Vec<[DVec3; 3]> {
    (0..soup.triangles.len()).map(|t| soup.corners(t)).collect()
}

#[test]
fn every_dialect_gives_the_same_triangles() {
    let truth = corners(&tetrahedron());
    for (name, format, bytes) in dialects() {
        let soup = format
            .parse(&bytes)
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(corners(&soup), truth, "{name}");
    }
}

/// Whatever is read has finite points and corners that exist.
fn is_sound(soup: &Soup) -> bool {
    soup.points.iter().all(|p| p.is_finite())
        && soup
            .triangles
            .iter()
            .flatten()
            .all(|&v| (v as usize) < soup.points.len())
        && !soup.triangles.is_empty()
}

#[test]
fn files_cut_at_any_byte_are_refused_or_whole() {
    for (name, format, bytes) in dialects() {
        for end in 0..bytes.len() {
            match format.parse(&bytes[..end]) {
                Err(_) => {}
                // What is lost is the end of a name, a last number's last digit, or whole lines of OBJ, which has no end mark.
                Ok(soup) => {
                    assert!(is_sound(&soup), "{name} cut at {end}");
                    let text = name != "binary STL" && !name.contains("le PLY");
                    assert!(text && name != "big PLY", "{name} cut at {end}");
                }
            }
        }
    }
}

#[test]
fn no_turned_bit_makes_a_reader_panic_or_lie() {
    for (name, format, bytes) in dialects() {
        for at in 0..bytes.len() {
            for bit in 0..8 {
                let mut broken = bytes.clone();
                broken[at] ^= 1 << bit;
                if let Ok(soup) = format.parse(&broken) {
                    assert!(is_sound(&soup), "{name}: bit {bit} of byte {at}");
                }
            }
        }
    }
}

#[track_caller]
fn refused(format: FacetFormat, bytes: &[u8], place: Place, kind: &ReadErrorKind) {
    let error = format.parse(bytes).unwrap_err();
    assert_eq!((error.place, &error.kind), (place, kind), "{error}");
}

#[test]
fn numbers_that_are_no_numbers_are_named_with_their_place() {
    let text = String::from_utf8(stl_ascii(&tetrahedron())).unwrap();
    let nan = text.replacen("vertex 0e0", "vertex nan", 1);
    refused(
        Stl,
        nan.as_bytes(),
        Place::Line(4),
        &ReadErrorKind::NotFinite,
    );
    let mut binary = stl_binary(&tetrahedron());
    binary[84 + 50 + 12 + 4..][..4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    refused(Stl, &binary, Place::Byte(146), &ReadErrorKind::NotFinite);
    refused(
        Obj,
        b"v 0 0 0\nv 1 0 inf\n",
        Place::Line(2),
        &ReadErrorKind::NotFinite,
    );
    let ply = String::from_utf8(ply_ascii(&tetrahedron())).unwrap();
    let nan = ply.replacen("1 0 0 255", "NaN 0 0 255", 1);
    refused(
        Ply,
        nan.as_bytes(),
        Place::Line(14),
        &ReadErrorKind::NotFinite,
    );
}

#[test]
fn absurd_counts_are_refused_before_anything_is_allocated() {
    let mut binary = stl_binary(&tetrahedron());
    binary[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    binary[..5].copy_from_slice(b"facet");
    let count = |what, count| ReadErrorKind::Count { what, count };
    refused(
        Stl,
        &binary,
        Place::Byte(80),
        &count("facets", u64::from(u32::MAX)),
    );
    let text = String::from_utf8(ply_ascii(&tetrahedron())).unwrap();
    let huge = text.replace("vertex 4", "vertex 99999999999");
    refused(
        Ply,
        huge.as_bytes(),
        Place::Line(13),
        &count("entries of an element", 99_999_999_999),
    );
}

#[test]
fn text_named_stl_and_points_that_do_not_exist_are_refused() {
    let text = "This is a letter, not a mesh.\n".repeat(20);
    let error = Stl.parse(text.as_bytes()).unwrap_err();
    assert!(error.to_string().contains("'solid'"), "{error}");
    refused(
        Obj,
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
        Place::Line(4),
        &ReadErrorKind::MissingPoint(4),
    );
    refused(
        Obj,
        b"v 0 0 0\nf -1 -2 -1\n",
        Place::Line(2),
        &ReadErrorKind::MissingPoint(-2),
    );
    let text = String::from_utf8(ply_ascii(&tetrahedron())).unwrap();
    let high = text.replace("3 1 2 3", "3 1 2 4");
    refused(
        Ply,
        high.as_bytes(),
        Place::Line(19),
        &ReadErrorKind::MissingPoint(4),
    );
}

#[test]
fn obj_counts_back_and_cuts_polygons() {
    let soup = Obj
        .parse(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 \\\n-2 -1\n")
        .unwrap();
    assert_eq!(soup.triangles.len(), 2);
    assert!(is_sound(&soup));
}

proptest! {
    #[test]
    fn random_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..400), head in 0usize..7) {
        let files = dialects();
        for format in [Stl, Obj, Ply] {
            let mut all = files.get(head).map_or_else(Vec::new, |f| f.2[..f.2.len() / 2].to_vec());
            all.extend(&bytes);
            if let Ok(soup) = format.parse(&all) {
                prop_assert!(is_sound(&soup));
            }
        }
    }
}
