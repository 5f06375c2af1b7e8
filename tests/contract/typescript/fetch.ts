// Calls a server through openapi-fetch with the types that openapi-typescript generates. Usage: node fetch.js BASE_URL
import assert from "node:assert/strict";
import createClient from "openapi-fetch";
import type { components, paths } from "./generated/scallopd.js";

const client = createClient<paths>({ baseUrl: process.argv[2] });
const cutter: components["schemas"]["Cutter"] = { type: "toroidal", diameter_mm: 10, corner_radius_mm: 2, teeth: 4 };
const contact: components["schemas"]["Contact"] = { slope_deg: 40, feed_angle_deg: 30 };

const height = await client.POST("/v1/scallop-height", { body: { cutter, contact, step_over_mm: 0.687, feed_per_tooth_mm: 0.3 } });
assert(height.data && Math.abs(height.data.scallop_height_mm - 0.01305) < 1e-4, JSON.stringify(height));

const query = await client.GET("/v1/step-over", {
  params: { query: { cutter: "ball_end", diameter_mm: 6, normal: [-0.64, 0, 0.77], feed: [1, 0, 0.84], scallop_tolerance_mm: 0.005 } },
});
assert(query.data && Math.abs(query.data.step_over_mm - 0.346266) < 1e-6, JSON.stringify(query));

const batch = await client.POST("/v1/max-feed/batch", {
  body: { cutter, scallop_tolerance_mm: 0.012, step_over_mm: 0.4, contacts: { slope_deg: [20, 95], feed_angle_deg: [90, 90] } },
});
const feeds: (number | null)[] | undefined = batch.data?.feed_per_tooth_mm;
assert(feeds?.length === 2 && feeds[1] === null && batch.data?.failures[0]?.code === "out-of-range", JSON.stringify(batch));

const refused = await client.POST("/v1/max-feed", { body: { cutter, contact, scallop_tolerance_mm: 0.013, step_over_mm: 0.987 } });
assert(refused.data === undefined && refused.error.type === "tolerance-exceeded" && "max_step_over_mm" in refused.error, JSON.stringify(refused));
const largest: number = refused.error.max_step_over_mm;
assert(Math.abs(largest - 0.783) < 1e-3);

const points = Array.from({ length: 20 }, (_, index) => `${15 * (index % 5)},${10 * Math.floor(index / 5)},${5 * Math.floor(index / 5)}`);
const upload = await client.POST("/v1/cutter-recommendation/upload", {
  body: {
    surface: points.join("\n"),
    parameters: {
      cutters: [
        { name: "T10", type: "toroidal", diameter_mm: 10, corner_radius_mm: 2 },
        { name: "B10", type: "ball_end", diameter_mm: 10 },
      ],
      scallop_height_mm: 0.01,
      machine: { preset: "vmc" },
    },
  },
  bodySerializer({ surface, parameters }) {
    const form = new FormData();
    form.set("surface", new Blob([surface]), "surface.csv");
    form.set("parameters", JSON.stringify(parameters));
    return form;
  },
});
assert(upload.data && upload.data.candidates.length === 2, JSON.stringify(upload));
console.log("openapi-fetch: a calculation, a query, a batch, a typed problem and an upload");
