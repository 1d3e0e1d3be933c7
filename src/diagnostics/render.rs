//! Renderers: terminal text and JSON lines.
