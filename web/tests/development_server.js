// Serves web/ like the binary, but from the folder, so that changes are visible on reload, and passes other requests on to a scallopd.
//
// Usage: node web/tests/development_server.js http://127.0.0.1:8080 [port]

import { existsSync, readFileSync, statSync } from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

const WEB = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '..');
const POLICY = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
const TYPES = { '.html': 'text/html; charset=utf-8', '.js': 'text/javascript; charset=utf-8', '.css': 'text/css; charset=utf-8', '.svg': 'image/svg+xml', '.json': 'application/json' };

function fileOf(pathname) {
  if (pathname === '/') return path.join(WEB, 'index.html');
  if (pathname === '/favicon.ico') return path.join(WEB, 'favicon.svg');
  if (pathname === '/glossary') return path.join(WEB, 'glossary.html');
  if (pathname === '/workbench/codes.md') return path.join(WEB, '../docs/codes.md');
  if (!pathname.startsWith('/workbench/')) return null;
  const file = path.resolve(WEB, pathname.slice('/workbench/'.length));
  return file.startsWith(WEB + path.sep) && existsSync(file) && statSync(file).isFile() ? file : null;
}

const kept = new Map();

// The compressed file, compressed again after a change.
function compressed(file) {
  const changed = statSync(file).mtimeMs;
  if (kept.get(file)?.changed !== changed) kept.set(file, { changed, bytes: gzipSync(readFileSync(file)) });
  return kept.get(file).bytes;
}

function pass(request, response, service) {
  const target = new URL(request.url, service);
  const passed = http.request(target, { method: request.method, headers: { ...request.headers, host: target.host } }, (answer) => {
    response.writeHead(answer.statusCode, answer.headers);
    answer.pipe(response);
  });
  passed.on('error', () => response.destroy());
  request.pipe(passed);
}

/** Starts the server; resolves to it once it listens. */
export function serve(service, port = 0) {
  const server = http.createServer((request, response) => {
    const { pathname } = new URL(request.url, 'http://host');
    const file = fileOf(pathname);
    if (file) {
      response.writeHead(200, { 'content-type': TYPES[path.extname(file)] ?? 'text/plain', 'content-security-policy': POLICY, 'cache-control': 'no-cache', 'x-content-type-options': 'nosniff', 'content-encoding': 'gzip' });
      response.end(compressed(file));
    } else {
      pass(request, response, service);
    }
  });
  return new Promise((resolve) => server.listen(port, '127.0.0.1', () => resolve(server)));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [service, port] = process.argv.slice(2);
  const server = await serve(service, Number(port ?? 0));
  console.log(`http://127.0.0.1:${server.address().port}/`);
}
