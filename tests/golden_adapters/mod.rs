//! The adapters, one file an area.

use serde_json::Value;

mod robots;

type Adapter = fn(&str, &Value, &Value, &Value) -> Option<Result<Value, String>>;

pub const ADAPTERS: &[Adapter] = &[robots::run];
