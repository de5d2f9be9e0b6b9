//! The native part of the Python package `elastogeo`: what has to be fast or needs the library's types. Everything that a user
//! meets is in `python/elastogeo`, and is typed and documented there. Arrays are numpy's, of 64-bit floats, SI.

mod arrays;
mod campaign;
mod command;
mod effect;
mod error;
mod faults;
mod inverse;
mod observation;
mod own;
mod pool;
mod problem;
mod robot;
mod words;
mod work;

use pyo3::prelude::*;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("Error", module.py().get_type::<error::Error>())?;
    module.add_function(wrap_pyfunction!(command::command, module)?)?;
    module.add_function(wrap_pyfunction!(command::main, module)?)?;
    module.add_function(wrap_pyfunction!(command::command_names, module)?)?;
    module.add_function(wrap_pyfunction!(command::bundled_robots, module)?)?;
    module.add_class::<robot::Robot>()?;
    module.add_class::<campaign::Campaign>()?;
    module.add_class::<problem::Problem>()?;
    module.add_class::<effect::Site>()?;
    module.add_class::<effect::Reading>()?;
    module.add_class::<observation::Kind>()?;
    module.add_class::<observation::Point>()
}
