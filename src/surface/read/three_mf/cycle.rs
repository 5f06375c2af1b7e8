//! Refuses objects of a 3MF package that contain themselves.

use super::package_model::{PackageModel, Reference};
use crate::file_fault::{FileFault, FileFaultKind, Flaw};
use std::collections::{HashMap, HashSet};

/// An object of a package: the path of its model in lower case, and its number.
type Key = (String, u32);

/// The numbers of a cycle that a fault names.
const MOST_NAMED: usize = 8;

/// Checks the objects that the build items of the model `root` place: none may contain itself.
///
/// The depth-first search does not use recursion, because a cycle can pass through all objects of a package.
pub(super) fn refuse_cycles(models: &HashMap<String, PackageModel>, root: &str, items: &[Reference]) -> Result<(), FileFault> {
    let mut done = HashSet::new();
    for item in items {
        // The objects from the item down to the current one, each with the number of its components that were followed.
        let mut chain: Vec<(Key, usize)> = vec![(key(item, root), 0)];
        let mut open: HashSet<Key> = chain.iter().map(|(key, _)| key.clone()).collect();
        while let Some((current, followed)) = chain.last_mut() {
            let components = models.get(&current.0).and_then(|model| model.objects.get(&current.1)).map(|object| &object.components);
            let next = components.and_then(|components| components.get(*followed)).filter(|_| !done.contains(&*current));
            let Some(component) = next else {
                open.remove(current);
                done.insert(current.clone());
                chain.pop();
                continue;
            };
            *followed += 1;
            let inner = key(component, &current.0);
            if open.contains(&inner) {
                return Err(cycle(&chain, &inner, root));
            }
            if !done.contains(&inner) {
                open.insert(inner.clone());
                chain.push((inner, 0));
            }
        }
    }
    Ok(())
}

/// The object that `reference` names in the model of this path.
fn key(reference: &Reference, path: &str) -> Key {
    (reference.path.as_deref().unwrap_or(path).to_lowercase(), reference.object)
}

/// The fault of the cycle that the last object of `chain` closes with its component `first`. It is located in the root
/// model, which places the objects.
fn cycle(chain: &[(Key, usize)], first: &Key, root: &str) -> FileFault {
    let start = chain.iter().position(|(key, _)| key == first).unwrap_or(0);
    let mut numbers: Vec<String> = chain[start..].iter().take(MOST_NAMED).map(|((_, number), _)| number.to_string()).collect();
    if chain.len() - start > MOST_NAMED {
        numbers.push("...".to_owned());
    }
    numbers.push(first.1.to_string());
    let found = format!("a cycle of objects: {}", numbers.join(" > "));
    Flaw::new(FileFaultKind::Malformed, "objects that do not contain themselves", found).in_entry(root, 0)
}
