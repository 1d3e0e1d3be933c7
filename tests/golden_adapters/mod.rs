//! The adapters, one file an area.

mod dwell;
mod robots;

use serde_json::Value;

type Adapter = fn(&str, &Value, &Value, &Value) -> Option<Result<Value, String>>;

pub const ADAPTERS: &[Adapter] = &[dwell::run, robots::run];
