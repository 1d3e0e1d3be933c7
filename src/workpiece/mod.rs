//! workpiece
