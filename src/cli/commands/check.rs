//! `check`: is the description sound, and what does it say?

use crate::Error;
use crate::cli::args::Check;
use crate::cli::{Output, Session};
use crate::render::robot;
use crate::snapshot::snapshot;

pub fn run(command: &Check, session: &Session) -> Result<Output, Error> {
    let loaded = session.reader.robot(&command.robot)?;
    let mut output = Output::new(
        robot::text(&loaded.model, &loaded.raw, session.terminal.screen),
        &robot::json(&loaded.model, &loaded.raw),
    )?;
    output.diagnostics = loaded.diagnostics;
    let Some(path) = &command.snapshot else { return Ok(output) };
    let new = snapshot(&loaded.model)?;
    match std::fs::read_to_string(path) {
        Ok(old) if old == new => {
            output.text = format!("{} agrees with {}\n", command.robot, path.display());
        }
        Ok(old) => {
            let mut text = format!("{} differs from {} (- snapshot, + now):\n", command.robot, path.display());
            let (old, new): (Vec<&str>, Vec<&str>) = (old.lines().collect(), new.lines().collect());
            for k in 0..old.len().max(new.len()) {
                let (before, now) = (old.get(k), new.get(k));
                if before != now {
                    before.iter().for_each(|line| text += &format!("- {line}\n"));
                    now.iter().for_each(|line| text += &format!("+ {line}\n"));
                }
            }
            text += "delete the file and run again to accept what is now\n";
            output.text = text;
            output.failed = true;
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            output.text = format!("wrote {}\n", path.display());
            output.files.push((path.clone(), new));
        }
        Err(error) => {
            return Err(Error::input(format!("`{}` cannot be read: {error}", path.display()), "give another file"));
        }
    }
    output.json["snapshot"] = serde_json::json!({"file": path.display().to_string(), "agrees": !output.failed});
    Ok(output)
}
