//! Whether the normals of a sheet agree.

use super::edges::{Edges, is_inner};
use crate::model::ids::{ElementId, Id};
use crate::model::mesh_audit::SheetNormals;
use crate::model::shell::ShellMesh;

/// Goes over each sheet from element to element, turned as the first of its piece; what then disagrees with the greater part of the piece is turned over.
pub(super) fn normals(mesh: &ShellMesh, edges: &Edges) -> Vec<SheetNormals> {
    let mut sheets: Vec<SheetNormals> = (1..=mesh.sheets.len())
        .map(|sheet| SheetNormals {
            sheet,
            elements: 0,
            area: 0.0,
            opposite_edges: 0,
            turned: 0,
            one_sided: false,
        })
        .collect();
    // For each element its neighbours in the sheet, and whether they face the other way.
    let mut beside: Vec<Vec<(ElementId, bool)>> = vec![Vec::new(); mesh.elements.len()];
    for sides in edges.iter().filter(|sides| is_inner(mesh, sides)) {
        let [a, b] = [sides[0], sides[1]];
        let opposite = a.ahead == b.ahead;
        beside[a.element.index()].push((b.element, opposite));
        beside[b.element.index()].push((a.element, opposite));
        sheets[mesh.elements[a.element].sheet.index()].opposite_edges += usize::from(opposite);
    }
    let mut turned: Vec<Option<bool>> = vec![None; mesh.elements.len()];
    for start in mesh.elements.ids() {
        if turned[start.index()].is_some() {
            continue;
        }
        let sheet = &mut sheets[mesh.elements[start].sheet.index()];
        // Elements and area, of those that face as the first and of those that do not.
        let mut count = [0usize; 2];
        let mut area = [0.0; 2];
        turned[start.index()] = Some(false);
        let mut open = vec![start];
        while let Some(id) = open.pop() {
            let own = turned[id.index()] == Some(true);
            count[usize::from(own)] += 1;
            area[usize::from(own)] += area_of(mesh, id);
            for &(other, opposite) in &beside[id.index()] {
                match turned[other.index()] {
                    None => {
                        turned[other.index()] = Some(own != opposite);
                        open.push(other);
                    }
                    Some(there) => sheet.one_sided |= there != (own != opposite),
                }
            }
        }
        let lesser = usize::from(area[1] <= area[0]);
        sheet.turned += count[lesser];
        sheet.elements += count[0] + count[1];
        sheet.area += area[0] + area[1];
    }
    sheets
}

fn area_of(mesh: &ShellMesh, id: ElementId) -> f64 {
    mesh.doubled_area(&mesh.elements[id]).length() / 2.0
}
