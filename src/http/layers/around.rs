//! A layer as a function around what it surrounds. The framework's own copies the surrounded service, with all that is inside it, into a
//! box for every request; here it is called where it is.

use std::convert::Infallible;
use std::pin::Pin;
use std::task::{Context, Poll};

use axum::extract::Request;
use axum::response::{IntoResponse, Response};
use tower::{Layer, Service};

/// What a layer does with a request.
pub(super) trait Surround: Clone + Send + Sync + 'static {
    /// The answer to `request`, for which `inside` is called once or not at all.
    fn surround<F>(&self, request: Request, inside: impl FnOnce(Request) -> F) -> impl Future<Output = Response> + Send + 'static
    where
        F: Future<Output = Response> + Send + 'static;
}

/// The layer that does it.
#[derive(Clone)]
pub(super) struct Around<T>(pub(super) T);

impl<T: Surround, S> Layer<S> for Around<T> {
    type Service = Surrounded<T, S>;

    fn layer(&self, inside: S) -> Surrounded<T, S> {
        Surrounded { around: self.0.clone(), inside }
    }
}

/// A service inside the layer.
#[derive(Clone)]
pub(super) struct Surrounded<T, S> {
    around: T,
    inside: S,
}

impl<T, S> Service<Request> for Surrounded<T, S>
where
    T: Surround,
    S: Service<Request, Response: IntoResponse, Error = Infallible, Future: Send + 'static>,
{
    type Response = Response;
    type Error = Infallible;
    type Future = Pin<Box<dyn Future<Output = Result<Response, Infallible>> + Send>>;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        self.inside.poll_ready(context)
    }

    fn call(&mut self, request: Request) -> Self::Future {
        let answered = self.around.surround(request, |request| {
            let answered = self.inside.call(request);
            async { answered.await.into_response() }
        });
        Box::pin(async { Ok(answered.await) })
    }
}
