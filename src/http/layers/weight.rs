//! How much a route may ask of the server, by its path.

/// What a request asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Weight {
    /// Whether the server lives, is ready, what it counts: answered under any load.
    Probe,
    /// A calculation, a page.
    Single,
    /// A JSON body of many contacts or points.
    Heavy,
    /// A file.
    Upload,
}

impl Weight {
    pub(super) fn of(path: &str) -> Self {
        match path {
            "/livez" | "/readyz" | "/metrics" => Self::Probe,
            _ if path.ends_with("/upload") => Self::Upload,
            _ if path.ends_with("/batch") || path.ends_with("/cutter-recommendation") => Self::Heavy,
            _ => Self::Single,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_weigh_what_they_do() {
        for (path, weight) in [
            ("/livez", Weight::Probe),
            ("/v1/max-feed", Weight::Single),
            ("/v1/max-feed/batch", Weight::Heavy),
            ("/v1/cutter-recommendation", Weight::Heavy),
            ("/v1/cutter-recommendation/upload", Weight::Upload),
            ("/livez/more", Weight::Single),
        ] {
            assert_eq!(Weight::of(path), weight, "{path}");
        }
    }
}
