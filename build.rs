//! The bundled robots and campaigns are part of the binary: a changed file must rebuild it.

fn main() {
    println!("cargo::rerun-if-changed=robots");
    println!("cargo::rerun-if-changed=campaigns");
}
