//! The bundled robots, campaigns and processes are part of the binary: a changed file must rebuild it.

fn main() {
    println!("cargo::rerun-if-changed=robots");
    println!("cargo::rerun-if-changed=campaigns");
    println!("cargo::rerun-if-changed=processes");
}
