//! Hand-made bytes: what the reader must read, and what it must refuse.

use super::*;

/// Writes MSH 4.1 in either byte order.
#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
    big: bool,
}

impl Writer {
    fn text(&mut self, text: &str) -> &mut Self {
        self.bytes.extend(text.as_bytes());
        self
    }
    fn raw<const N: usize>(&mut self, mut bytes: [u8; N]) -> &mut Self {
        if self.big {
            bytes.reverse();
        }
        self.bytes.extend(bytes);
        self
    }
    fn i32(&mut self, values: &[i32]) -> &mut Self {
        for v in values {
            self.raw(v.to_le_bytes());
        }
        self
    }
    fn u64(&mut self, values: &[u64]) -> &mut Self {
        for v in values {
            self.raw(v.to_le_bytes());
        }
        self
    }
    fn f64(&mut self, values: &[f64]) -> &mut Self {
        for v in values {
            self.raw(v.to_le_bytes());
        }
        self
    }
}

/// One tet with its surface of one triangle, numbers of nodes 10, 20, 30, 40.
fn small(big: bool) -> Vec<u8> {
    let mut w = Writer {
        bytes: Vec::new(),
        big,
    };
    w.text("$MeshFormat\n4.1 1 8\n")
        .i32(&[1])
        .text("\n$EndMeshFormat\n");
    w.text("$PhysicalNames\n1\n2 7 \"top face\"\n$EndPhysicalNames\n");
    w.text("$Entities\n").u64(&[1, 1, 1, 1]);
    w.i32(&[5]).f64(&[0.0; 3]).u64(&[0]);
    w.i32(&[6]).f64(&[0.0; 6]).u64(&[0, 2]).i32(&[5, -5]);
    w.i32(&[8])
        .f64(&[0.0; 6])
        .u64(&[1])
        .i32(&[7])
        .u64(&[1])
        .i32(&[-6]);
    w.i32(&[9]).f64(&[0.0; 6]).u64(&[0, 1]).i32(&[8]);
    w.text("\n$EndEntities\n");
    w.text("$Nodes\n").u64(&[2, 4, 10, 40]);
    w.i32(&[2, 8, 1])
        .u64(&[3, 10, 20, 30])
        .f64(&[0.0, 0.0, 0.0, 0.1, 0.2])
        .f64(&[1.0, 0.0, 0.0, 0.1, 0.2])
        .f64(&[0.0, 1.0, 0.0, 0.1, 0.2]);
    w.i32(&[3, 9, 0]).u64(&[1, 40]).f64(&[0.0, 0.0, 1.0]);
    w.text("\n$EndNodes\n");
    w.text("$Periodic\nanything\n$EndPeriodic\n");
    w.text("$Elements\n").u64(&[2, 2, 1, 2]);
    w.i32(&[2, 8, 2]).u64(&[1, 1, 10, 20, 30]);
    w.i32(&[3, 9, 4]).u64(&[1, 2, 10, 20, 30, 40]);
    w.text("\n$EndElements\n");
    w.bytes
}

fn kind(bytes: &[u8]) -> MshErrorKind {
    Msh::parse(bytes).unwrap_err().kind
}

/// Where the bytes after a mark begin.
fn after(bytes: &[u8], mark: &str) -> usize {
    let at = bytes
        .windows(mark.len())
        .position(|w| w == mark.as_bytes())
        .unwrap();
    at + mark.len()
}

#[test]
fn a_small_file_is_read_whole_in_both_byte_orders() {
    for big in [false, true] {
        let msh = Msh::parse(&small(big)).unwrap();
        assert_eq!(msh.physical_names, [(2, 7, "top face".to_owned())]);
        assert_eq!(msh.entities[1][0].boundary, [5, -5]);
        assert_eq!(msh.entities[2][0].physical, [7]);
        assert_eq!(msh.entities[3][0].tag, 9);
        assert_eq!(msh.nodes[3], DVec3::Z);
        assert_eq!(msh.elements[0].kind, ElementKind::Triangle3);
        assert_eq!(msh.elements[1].nodes, [0, 1, 2, 3]);
    }
}

#[test]
fn a_file_cut_at_any_length_is_refused() {
    let bytes = small(false);
    let closing_line_break = 1;
    for length in 0..bytes.len() - closing_line_break {
        let error = Msh::parse(&bytes[..length]).unwrap_err();
        assert!(error.offset <= length, "{length}: {error}");
    }
}

#[test]
fn no_byte_that_is_wrong_makes_the_reader_panic() {
    let bytes = small(false);
    for at in 0..bytes.len() {
        for value in [0, 1, 0x7f, 0x80, 0xff] {
            let mut bad = bytes.clone();
            bad[at] = value;
            let _ = Msh::parse(&bad);
        }
    }
}

#[test]
fn a_count_that_the_file_cannot_hold_is_refused_before_allocation() {
    for mark in ["$Entities\n", "$Nodes\n", "$Elements\n"] {
        let mut bytes = small(false);
        let at = after(&bytes, mark);
        bytes[at..at + 8].copy_from_slice(&u64::MAX.to_le_bytes());
        let error = Msh::parse(&bytes).unwrap_err();
        assert_eq!(error.offset, at);
        assert!(
            matches!(error.kind, MshErrorKind::Count { count, .. } if count == u64::MAX),
            "{mark} {error}"
        );
    }
}

#[test]
fn nodes_that_are_missing_or_defined_twice_are_refused() {
    let good = small(false);
    let at = after(&good, "$Elements\n") + 32 + 20 + 8;
    let mut bytes = good.clone();
    bytes[at..at + 8].copy_from_slice(&11u64.to_le_bytes());
    assert_eq!(kind(&bytes), MshErrorKind::MissingNode(11));
    let at = after(&good, "$Nodes\n") + 32 + 20;
    let mut bytes = good.clone();
    bytes[at..at + 8].copy_from_slice(&20u64.to_le_bytes());
    assert_eq!(kind(&bytes), MshErrorKind::DoubleNode(20));
}

#[test]
fn node_numbers_with_wide_gaps_are_found() {
    let mut bytes = small(false);
    let far = (u64::MAX - 1).to_le_bytes();
    let node = after(&bytes, "$Nodes\n") + 32 + 20;
    let mates = after(&bytes, "$Elements\n") + 32 + 20 + 8;
    let tet = mates + 24 + 20 + 8;
    for at in [node, mates, tet] {
        bytes[at..at + 8].copy_from_slice(&far);
    }
    assert_eq!(Msh::parse(&bytes).unwrap().elements[1].nodes, [0, 1, 2, 3]);
}

#[test]
fn other_formats_and_element_types_are_refused() {
    for text in [
        "",
        "hello\n",
        "$MeshFormat\n2.2 1 8\n",
        "$MeshFormat\n4.1 0 8\n",
    ] {
        assert!(matches!(
            kind(text.as_bytes()),
            MshErrorKind::Format(_) | MshErrorKind::Truncated(_)
        ));
    }
    let mut bytes = small(false);
    let at = after(&bytes, "$Elements\n") + 32 + 8;
    bytes[at..at + 4].copy_from_slice(&3i32.to_le_bytes());
    assert_eq!(
        kind(&bytes),
        MshErrorKind::Value {
            what: "element type that is read here",
            value: 3
        }
    );
}
