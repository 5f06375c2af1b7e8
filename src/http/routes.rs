//! Routes, their classes and their documentation. The call that adds a route declares the limits of its requests.

use axum::Router;
use axum::routing::MethodRouter;
use utoipa::openapi::OpenApi;
use utoipa_axum::router::{OpenApiRouter, UtoipaMethodRouter};

use super::app_state::AppState;
use crate::settings::Settings;

/// The largest body of a single calculation in bytes, some thousand times what one needs. It is less than the limit of
/// batches, because the bodies of all requests in flight are in memory together.
const MAX_SINGLE_BYTES: u64 = 64 * 1024;

/// The class of a route, which determines body limit, worker pool and load shedding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RouteClass {
    /// Liveness, readiness and metrics: answered under any load and logged at level `debug`.
    Probe,
    /// One calculation or one page: microseconds on an async thread, or a short task for the worker pool.
    Single,
    /// A JSON body with many contacts or points, processed by the worker pool.
    Batch,
    /// A file, read by the worker pool as it arrives.
    Upload,
}

impl RouteClass {
    /// Whether requests beyond the limit of requests in flight are refused.
    pub(crate) fn is_shed(self) -> bool {
        self != Self::Probe
    }

    /// Whether handlers may use the worker pool.
    pub(crate) fn uses_workers(self) -> bool {
        self != Self::Probe
    }

    /// The largest body, in decompressed bytes.
    pub(crate) fn max_body_bytes(self, settings: &Settings) -> u64 {
        match self {
            Self::Probe | Self::Single => settings.max_json.min(MAX_SINGLE_BYTES),
            Self::Batch => settings.max_json,
            Self::Upload => settings.max_upload,
        }
    }
}

/// A set of routes, each with its class. The middleware accepts only this type, so every route has a class.
#[derive(Default)]
pub struct Routes {
    routers: Vec<(RouteClass, OpenApiRouter<AppState>)>,
    /// The files with examples of their operations.
    examples: Vec<&'static str>,
}

impl Routes {
    /// An empty set.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the operations of one path, as `utoipa_axum::routes!` collects them, to the service and to the OpenAPI
    /// document.
    #[must_use]
    pub fn documented(self, class: RouteClass, operations: UtoipaMethodRouter<AppState>) -> Self {
        self.add(class, OpenApiRouter::new().routes(operations))
    }

    /// Adds examples to the OpenAPI document: a file that the macro `examples!` embeds.
    pub(crate) fn with_examples(mut self, file: &'static str) -> Self {
        self.examples.push(file);
        self
    }

    /// Adds a path that the OpenAPI document leaves out.
    #[must_use]
    pub fn undocumented(self, class: RouteClass, path: &str, methods: MethodRouter<AppState>) -> Self {
        self.nested(class, Router::new().route(path, methods))
    }

    /// Adds a library's router, all of whose routes have one class.
    #[must_use]
    pub fn nested(self, class: RouteClass, router: Router<AppState>) -> Self {
        self.add(class, router.into())
    }

    /// Adds the routes of another set.
    #[must_use]
    pub fn merge(mut self, other: Self) -> Self {
        self.routers.extend(other.routers);
        self.examples.extend(other.examples);
        self
    }

    /// These routes without the operations of one path.
    pub(crate) fn without(mut self, path: &str) -> Self {
        self.routers.retain(|(_, router)| !router.get_openapi().paths.paths.contains_key(path));
        self
    }

    fn add(mut self, class: RouteClass, router: OpenApiRouter<AppState>) -> Self {
        self.routers.push((class, router));
        self
    }

    /// `outline` with the operations of these routes, and the files with their examples.
    pub(crate) fn openapi(self, outline: OpenApi) -> (OpenApi, Vec<&'static str>) {
        let all = self.routers.into_iter().fold(OpenApiRouter::with_openapi(outline), |all, (_, router)| all.merge(router));
        (all.into_openapi(), self.examples)
    }

    /// A router of all routes, each inside the layers that `surround` adds for its class.
    pub(crate) fn into_router(self, surround: impl Fn(RouteClass, Router<AppState>) -> Router<AppState>) -> Router<AppState> {
        self.routers.into_iter().fold(Router::new(), |all, (class, router)| all.merge(surround(class, router.into())))
    }
}
