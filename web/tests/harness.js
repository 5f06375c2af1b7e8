// What the browser tests share: a scallopd, a Chromium, pages that record what must not happen, and files to upload.

import { spawn } from 'node:child_process';
import { mkdtempSync, openSync, writeSync, closeSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { chromium } from 'playwright-core';
import { serve } from './development_server.js';

const FLAGS = ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'];
const { SCALLOPD_BINARY, STAND_IN, CHROMIUM } = process.env;

export const folder = mkdtempSync(path.join(os.tmpdir(), 'workbench-'));

/** A scallopd that can be stopped and started again on its port. */
export class Service {
  #process = null;
  #port = 0;

  async start() {
    const child = spawn(SCALLOPD_BINARY, ['--listen', `127.0.0.1:${this.#port}`, '--log-format', 'json'], { stdio: ['ignore', 'pipe', 'inherit'] });
    this.#process = child;
    this.#port = await new Promise((resolve, reject) => {
      child.once('exit', (code) => reject(new Error(`scallopd ended with ${code}`)));
      child.stdout.on('data', (lines) => {
        const found = /"address":"[^"]*:(\d+)"/.exec(lines);
        if (found) resolve(Number(found[1]));
      });
    });
  }

  get address() {
    return `http://127.0.0.1:${this.#port}`;
  }

  async stop() {
    const child = this.#process;
    if (!child || child.exitCode !== null) return;
    child.removeAllListeners('exit');
    const gone = new Promise((resolve) => child.once('exit', resolve));
    child.kill('SIGKILL');
    await gone;
  }

  async post(endpoint, body) {
    const response = await fetch(`${this.page ?? this.address}/v1/${endpoint}`, { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(body) });
    return response.json();
  }
}

/** Starts all; `close` ends it. */
export async function start() {
  const service = new Service();
  await service.start();
  const front = STAND_IN === '--stand-in' ? await serve(service.address, 0, true) : null;
  service.page = front ? `http://127.0.0.1:${front.address().port}` : service.address;
  const browser = await chromium.launch({ executablePath: CHROMIUM, args: FLAGS });
  return {
    service,
    browser,
    address: `${service.page}/`,
    async close() {
      await browser.close();
      front?.closeAllConnections();
      front?.close();
      await service.stop();
    },
  };
}

/**
 * A page at a fragment such as "#contact". `watch` collects what must not happen: console errors, exceptions, violations of the
 * security policy, and requests to other hosts.
 */
export async function open({ browser, address }, fragment, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 1000 }, permissions: ['clipboard-read', 'clipboard-write'], acceptDownloads: true, ...options });
  const page = await context.newPage();
  const watch = [];
  page.on('console', (message) => ['error', 'warning'].includes(message.type()) && watch.push(`console: ${message.text()}`));
  page.on('pageerror', (error) => watch.push(`exception: ${error.message}`));
  page.on('request', (request) => {
    const url = request.url();
    if (!url.startsWith(address) && !url.startsWith('blob:') && !url.startsWith('data:')) watch.push(`other host: ${url}`);
  });
  await page.addInitScript(() => document.addEventListener('securitypolicyviolation', (event) => console.error(`policy: ${event.violatedDirective} ${event.blockedURI}`)));
  await page.goto(address + fragment);
  return { page, context, watch };
}

/** A binary STL of a wavy surface with about `facets` facets; returns its path. */
export function writeStl(facets) {
  const side = Math.ceil(Math.sqrt(facets / 2));
  const file = path.join(folder, `wavy-${facets}.stl`);
  const out = openSync(file, 'w');
  const head = Buffer.alloc(84);
  head.writeUInt32LE(side * side * 2, 80);
  writeSync(out, head);
  const size = 80 / side;
  const at = (i, j) => [i * size, j * size, 6 * Math.sin(i * size * 0.11) + 4 * Math.cos(j * size * 0.13)];
  for (let j = 0; j < side; j += 1) {
    const row = Buffer.alloc(side * 100);
    let offset = 0;
    for (let i = 0; i < side; i += 1) {
      for (const corners of [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]) {
        offset += 12;
        for (const corner of corners) for (const value of corner) offset = row.writeFloatLE(value, offset);
        offset += 2;
      }
    }
    writeSync(out, row);
  }
  closeSync(out);
  return file;
}
