// Answers for a scallopd that lacks newer endpoints: columns of contacts become arrays, the cutting parameters are searched for with
// batches, and recommendations come from a fixture. Removed once the service has them.

import { readFileSync } from 'node:fs';

const fixture = JSON.parse(readFileSync(new URL('./fixtures/cutter_recommendation.json', import.meta.url)));

async function bodyOf(request) {
  const parts = [];
  for await (const part of request) parts.push(part);
  return Buffer.concat(parts);
}

function reply(response, status, body) {
  response.writeHead(status, { 'content-type': status < 400 ? 'application/json' : 'application/problem+json' });
  response.end(JSON.stringify(body));
}

const problem = (pointer, code, detail, status = 422) => ({ type: 'invalid-request', title: 'The request cannot be answered', status, detail, errors: [{ pointer, code, detail }] });

async function ask(service, path, body) {
  const response = await fetch(new URL(path, service), { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(body) });
  return [response.status, await response.json()];
}

async function batch(request, response, service) {
  const body = JSON.parse(await bodyOf(request));
  const { contacts, columns, ...rest } = body;
  const known = { slope_deg: 1, feed_angle_deg: 1, normal: 1, feed: 1 };
  const count = Object.values(contacts)[0].length;
  const rows = Array.from({ length: count }, (_, i) => Object.fromEntries(Object.keys(contacts).filter((name) => name !== 'surface_curvature' && (contacts[name][i] !== null || known[name])).map((name) => [name, contacts[name][i]])));
  delete rest.surface_curvature;
  reply(response, ...(await ask(service, request.url, { ...rest, contacts: rows })));
}

async function fastest(request, response, service) {
  const { max_feed_per_tooth_mm: limit = 1, max_feed_rate_mm_min: rate, spindle_speed_rpm: speed, min_step_over_mm, max_step_over_mm, ...rest } = JSON.parse(await bodyOf(request));
  const most = Math.min(limit, rate && speed ? rate / speed / rest.cutter.teeth : Infinity);
  const { contact, ...setting } = rest;
  const contacts = Array.from({ length: 400 }, (_, i) => ({ ...contact, feed_per_tooth_mm: (most * (i + 1)) / 400 }));
  const [status, answer] = await ask(service, '/v1/step-over/batch', { ...setting, contacts });
  if (status !== 200) return reply(response, ...(await ask(service, '/v1/step-over', rest)));
  const best = contacts.map(({ feed_per_tooth_mm: feed }, i) => [feed * (answer.step_over_mm[i] ?? 0), i]).reduce((a, b) => (b[0] > a[0] ? b : a));
  const feed = contacts[best[1]].feed_per_tooth_mm;
  const single = (await ask(service, '/v1/step-over', { ...rest, feed_per_tooth_mm: feed }))[1];
  const feedRate = speed ? feed * rest.cutter.teeth * speed : undefined;
  return reply(response, 200, { ...single, feed_per_tooth_mm: feed, feed_rate_mm_min: feedRate, area_rate_mm2_min: feedRate * single.step_over_mm, limited_by: best[1] === 399 ? ['scallop_tolerance', 'max_feed_per_tooth'] : ['scallop_tolerance'] });
}

function recommend(response, parameters) {
  const faults = parameters.cutters.flatMap(({ corner_radius_mm: corner, diameter_mm: diameter }, i) => (corner >= diameter / 2 ? [`/cutters/${i}/corner_radius_mm`] : []));
  if (faults.length > 0) return reply(response, 422, problem(faults[0], 'corner-radius-too-large', 'the corner radius of a toroidal cutter must be under half its diameter'));
  const candidates = fixture.candidates.filter(({ cutter }) => cutter < parameters.cutters.length).map((candidate) => ({ ...candidate, name: parameters.cutters[candidate.cutter].name }));
  return reply(response, 200, { ...fixture, candidates, passes: parameters.include?.includes('passes') ? fixture.passes : undefined });
}

/** Answers the request, or returns false. */
export function standIn(request, response, service) {
  const { url } = request;
  if (url.endsWith('/batch')) batch(request, response, service);
  else if (url === '/v1/cutting-parameters') fastest(request, response, service);
  else if (url === '/v1/cutter-recommendation') bodyOf(request).then((body) => recommend(response, JSON.parse(body)));
  else if (url === '/v1/cutter-recommendation/upload') {
    bodyOf(request).then((body) => {
      const text = body.subarray(0, 20_000).toString('latin1');
      const parameters = JSON.parse(/name="parameters"[\s\S]*?\r\n\r\n(\{[\s\S]*?\})\r\n--/.exec(text)[1]);
      if (body.includes('broken')) reply(response, 400, { ...problem('/surface', 'malformed-file', 'line 3: expected a number, found "broken"', 400), type: 'malformed-file', title: 'The file is malformed' });
      else recommend(response, parameters);
    });
  } else return false;
  return true;
}
