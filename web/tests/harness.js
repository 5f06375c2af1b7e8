// The harness of the browser tests: a scallopd, a Chromium, pages that record errors, and files to upload.

import assert from 'node:assert/strict';
import { execFile, spawn } from 'node:child_process';
import { closeSync, mkdtempSync, openSync, readFileSync, rmSync, writeFileSync, writeSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, afterEach, before } from 'node:test';
import { promisify } from 'node:util';
import AxeBuilder from '@axe-core/playwright';
import { chromium } from 'playwright-core';
import { serve } from './development_server.js';

const FLAGS = ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'];
const { SCALLOPD_BINARY, PAGE_FROM, CHROMIUM } = process.env;

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

/** Starts service and browser; `close` ends them. */
export async function start() {
  const service = new Service();
  await service.start();
  const front = PAGE_FROM === '--page-from-folder' ? await serve(service.address) : null;
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
 * A page at a fragment such as "#contact". `watch` collects errors: console errors, exceptions, violations of the security policy, and requests to other hosts.
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

/**
 * Starts service and browser before the tests of a file and ends them afterwards. Returns {bench(), visit(fragment, options)}: the started programs, and a page of `open`, which is closed after the test.
 */
export function startForTests() {
  let bench;
  let opened = [];
  before(async () => {
    bench = await start();
  });
  after(async () => {
    await bench?.close();
    rmSync(folder, { recursive: true });
  });
  afterEach(async () => {
    for (const { context } of opened) await context.close();
    opened = [];
  });
  const visit = async (fragment, options) => {
    const visited = await open(bench, fragment, options);
    opened.push(visited);
    return visited;
  };
  return { bench: () => bench, visit };
}

/** Runs a command; not the synchronous form: a server of this process may have to answer. */
export const shell = async (command) => (await promisify(execFile)('sh', ['-c', command], { maxBuffer: 64e6 })).stdout;

/** The input of a field in the view that is shown. */
export const field = (page, name) => page.locator(`.view:not([hidden]) [data-field="${name}"] :is(input, textarea)`).first();

/** Asserts that no error was recorded. Browsers log every answer with an error status; `refused` allows these. */
export const clean = (watch, { refused = false } = {}) => assert.deepEqual(watch.filter((line) => !refused || !/status of 4/.test(line)), []);

/** The serious faults that axe finds. */
export async function graveFaults(page) {
  const { violations } = await new AxeBuilder({ page }).analyze();
  return violations.filter(({ impact }) => ['serious', 'critical'].includes(impact)).map(({ id, nodes }) => [id, nodes.map(({ target }) => target.join(' ')).slice(0, 4)]);
}

/** Moves the mouse over an element; the longest time in ms between two frames meanwhile. */
export async function longestFrame(page, locator) {
  await locator.scrollIntoViewIfNeeded();
  const box = await locator.boundingBox();
  await page.evaluate(() => {
    globalThis.frames = [];
    globalThis.isWatching = true;
    const each = (time) => {
      globalThis.frames.push(time);
      if (globalThis.isWatching) requestAnimationFrame(each);
    };
    requestAnimationFrame(each);
  });
  for (let i = 0; i < 60; i += 1) await page.mouse.move(box.x + box.width * (0.2 + 0.01 * i), box.y + box.height * (0.4 + 0.002 * i));
  return page.evaluate(() => {
    globalThis.isWatching = false;
    return Math.max(...globalThis.frames.slice(1).map((time, i) => time - globalThis.frames[i]));
  });
}

/** The text of the file that `click` downloads. */
export async function downloaded(page, click) {
  const [download] = await Promise.all([page.waitForEvent('download'), click()]);
  return readFileSync(await download.path(), 'utf8');
}

/** Writes a file to upload; returns its path. */
export function fileOf(name, text) {
  const file = path.join(folder, name);
  writeFileSync(file, text);
  return file;
}

/**
 * A shown figure, as [full precision, text], is the service's value: the precise one to the last digit, the text as rounded in the units
 * of the page, `factor` for each unit of the service, to four significant digits; shares have three.
 */
export function assertFigure([value, text], expected, factor, what, significant = factor === 100 ? 3 : 4) {
  if (expected === null) return assert.equal(text, '∞', what);
  // A cutter that was only estimated has no figures of a path.
  if (expected === undefined) return assert.ok(!value, `${what}: ${value}`);
  assert.equal(Number(value), expected, what);
  const shown = expected * factor;
  const digits = 5.1 * 10 ** -significant;
  return assert.ok(Math.abs(Number(text) - shown) <= digits * Math.abs(shown) + (shown === 0 ? 1e-12 : 0), `${what}: ${text} for ${shown}`);
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
