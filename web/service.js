// Calls to the service, and its reachability. A call returns {answer} or {problem}, throws `Unreachable` if there is no service, and an AbortError if the caller aborted it.

export class Unreachable extends Error {}

const RETRY_EVERY_MS = 1000;
const listeners = new Set();
let reachable = true;

/** Calls `listener(reachable)` when the service becomes unreachable and when it is back. */
export function onReachable(listener) {
  listeners.add(listener);
}

function setReachable(now) {
  if (reachable === now) return;
  reachable = now;
  for (const listener of listeners) listener(now);
  if (!now) setTimeout(lookForService, RETRY_EVERY_MS);
}

async function lookForService() {
  try {
    const { ok } = await fetch('livez', { cache: 'no-store' });
    if (ok) return setReachable(true);
  } catch {
    // Still unreachable.
  }
  setTimeout(lookForService, RETRY_EVERY_MS);
}

/** The address of a path of the service, for commands outside of the page. */
export const addressOf = (path) => new URL(path, document.baseURI).href;

async function read(response) {
  const type = response.headers.get('content-type') ?? '';
  if (response.ok) return { answer: await response.json() };
  // A proxy before a stopped service answers 502 or 504 itself.
  if (!type.includes('json')) {
    if (response.status >= 502) throw new Unreachable(`status ${response.status}`);
    return { problem: { title: 'The request failed', detail: `status ${response.status}`, status: response.status } };
  }
  return { problem: await response.json() };
}

async function call(path, init) {
  let response;
  try {
    response = await fetch(path, init);
  } catch (error) {
    if (error.name === 'AbortError') throw error;
    setReachable(false);
    throw new Unreachable(error.message);
  }
  try {
    const result = await read(response);
    setReachable(true);
    return result;
  } catch (error) {
    if (error.name === 'AbortError') throw error;
    setReachable(false);
    throw new Unreachable(error.message);
  }
}

export const get = (path) => call(path, {});

export function post(path, body, signal) {
  return call(path, { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(body), signal });
}

/**
 * Sends a form with files. `onProgress(share)` gets the share of the bytes that are sent, 0 to 1. Unlike fetch, XMLHttpRequest reports
 * it. Aborting `signal` ends the upload.
 */
export function upload(path, form, onProgress, signal) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open('POST', path);
    request.responseType = 'text';
    request.upload.onprogress = ({ loaded, total }) => onProgress(total > 0 ? loaded / total : 0);
    request.onload = () => {
      try {
        const content = JSON.parse(request.responseText);
        setReachable(true);
        resolve(request.status < 400 ? { answer: content } : { problem: content });
      } catch {
        setReachable(request.status < 502);
        resolve({ problem: { title: 'The request failed', detail: `status ${request.status}`, status: request.status } });
      }
    };
    request.onerror = () => {
      setReachable(false);
      reject(new Unreachable('the connection broke'));
    };
    request.onabort = () => reject(new DOMException('given up', 'AbortError'));
    signal.addEventListener('abort', () => request.abort());
    request.send(form);
  });
}
