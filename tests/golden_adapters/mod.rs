//! The adapters, one file an area.

mod dwell;
mod figures;
mod forms;
mod regions;
mod robots;
mod tools;

use serde_json::Value;

type Adapter = fn(&str, &Value, &Value, &Value) -> Option<Result<Value, String>>;

pub const ADAPTERS: &[Adapter] = &[dwell::run, figures::run, forms::run, regions::run, robots::run, tools::run];
