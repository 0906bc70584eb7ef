//! A wish for elements of their own size on some sheets or faces of a part.

/// Edge length wanted on some sheets and faces. Where several such wishes hold, the shortest length counts.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct LocalSize {
    /// Sheets by their numbers, from 1, as the outputs and `midshell inspect` have them.
    pub sheets: Vec<u32>,
    /// Faces by their numbers in the file that the part came from.
    pub faces: Vec<i32>,
    /// Edge length, mm.
    pub size: f64,
    /// Where the wish stands, for messages: file and line.
    pub origin: String,
}
