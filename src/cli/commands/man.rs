//! `man`: manual pages.

use clap::CommandFactory;

use crate::Error;
use crate::cli::args::{Arguments, Man};
use crate::cli::output::Output;

pub fn run(command: &Man) -> Result<Output, Error> {
    let mut whole = Arguments::command();
    whole.build();
    let mut files = Vec::new();
    pages(&whole, &mut |name, page| files.push((command.folder.join(name), page)))?;
    let text = format!("{} pages in {}\n", files.len(), command.folder.display());
    let wrote: Vec<String> = files.iter().map(|(path, _)| path.display().to_string()).collect();
    let mut output = Output::new(text, &serde_json::json!({"wrote": wrote}))?;
    output.files = files;
    std::fs::create_dir_all(&command.folder).map_err(|error| {
        Error::input(format!("`{}` cannot be made: {error}", command.folder.display()), "give another folder")
    })?;
    Ok(output)
}

/// The page of a command and those of its subcommands.
fn pages(command: &clap::Command, take: &mut impl FnMut(String, String)) -> std::io::Result<()> {
    let name = command.get_display_name().unwrap_or_else(|| command.get_name()).to_string();
    let mut page = Vec::new();
    clap_mangen::Man::new(command.clone()).title(name.clone()).render(&mut page)?;
    take(format!("{name}.1"), String::from_utf8_lossy(&page).into_owned());
    command.get_subcommands().filter(|c| c.get_name() != "help" && !c.is_hide_set()).try_for_each(|c| pages(c, take))
}
