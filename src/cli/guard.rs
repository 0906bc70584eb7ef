//! A panic is a bug: it is caught at the top, told as one, and leaves no output behind.

use super::complaint::Complaint;
use std::any::Any;
use std::panic::{self, AssertUnwindSafe};
use std::sync::{Arc, Mutex};

/// Runs `work`; a panic in it, in whatever thread it waits for, becomes a complaint.
pub fn guard<T>(work: impl FnOnce() -> Result<T, Complaint>) -> Result<T, Complaint> {
    let place = Arc::new(Mutex::new(None));
    let seen = Arc::clone(&place);
    panic::set_hook(Box::new(move |info| {
        let mut place = seen.lock().unwrap_or_else(|e| e.into_inner());
        // The first panic is the cause; those that follow are its wake.
        place.get_or_insert_with(|| info.location().map(ToString::to_string).unwrap_or_default());
    }));
    // Nothing of the work is looked at after a panic, so nothing half-done can be seen.
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    let _ = panic::take_hook();
    result.unwrap_or_else(|payload| {
        let place = place.lock().unwrap_or_else(|e| e.into_inner()).take();
        let place = place.unwrap_or_default();
        Err(Complaint::bug(&format!(
            "{} (at {place})",
            message(&*payload)
        )))
    })
}

fn message(payload: &(dyn Any + Send)) -> &str {
    payload
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("a panic without a message")
}

#[cfg(test)]
mod tests {
    use super::*;
    use midshell::exit_class::ExitClass;

    #[test]
    fn a_panic_becomes_a_bug_report_with_its_place() {
        let complaint = guard::<()>(|| panic!("wall {} has no side", 7)).unwrap_err();
        assert_eq!(complaint.class, ExitClass::Internal);
        assert!(complaint.cause.contains("wall 7 has no side"));
        assert!(complaint.cause.contains("guard.rs"), "{}", complaint.cause);
        assert_eq!(guard(|| Ok(5)), Ok(5));
    }
}
