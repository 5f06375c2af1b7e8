//! Middleware written as an async function that calls the inner service. The framework's `from_fn` clones and boxes the
//! inner service for every request; here it is called in place.

use std::convert::Infallible;
use std::pin::Pin;
use std::task::{Context, Poll};

use axum::extract::Request;
use axum::response::{IntoResponse, Response};
use tower::{Layer, Service};

/// A middleware, as an async function around the inner service.
pub(super) trait Middleware: Clone + Send + Sync + 'static {
    /// The answer to `request`. `inner` is called at most once.
    fn handle<F>(&self, request: Request, inner: impl FnOnce(Request) -> F) -> impl Future<Output = Response> + Send + 'static
    where
        F: Future<Output = Response> + Send + 'static;
}

/// The [`Layer`] of a middleware.
#[derive(Clone)]
pub(super) struct MiddlewareLayer<M>(pub(super) M);

impl<M: Middleware, S> Layer<S> for MiddlewareLayer<M> {
    type Service = MiddlewareService<M, S>;

    fn layer(&self, inner: S) -> MiddlewareService<M, S> {
        MiddlewareService { middleware: self.0.clone(), inner }
    }
}

/// A service with a middleware around it.
#[derive(Clone)]
pub(super) struct MiddlewareService<M, S> {
    middleware: M,
    inner: S,
}

impl<M, S> Service<Request> for MiddlewareService<M, S>
where
    M: Middleware,
    S: Service<Request, Response: IntoResponse, Error = Infallible, Future: Send + 'static>,
{
    type Response = Response;
    type Error = Infallible;
    type Future = Pin<Box<dyn Future<Output = Result<Response, Infallible>> + Send>>;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        self.inner.poll_ready(context)
    }

    fn call(&mut self, request: Request) -> Self::Future {
        let answer = self.middleware.handle(request, |request| {
            let answer = self.inner.call(request);
            async { answer.await.into_response() }
        });
        Box::pin(async { Ok(answer.await) })
    }
}
