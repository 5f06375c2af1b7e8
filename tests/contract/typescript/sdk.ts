// Calls a server through the functions that hey-api generates. Usage: node sdk.js BASE_URL
import assert from "node:assert/strict";
import { client } from "./sdk/client.gen.js";
import { cutterRecommendationUpload, maxFeed, scallopHeight, stepOverBatch } from "./sdk/index.js";
import type { Contact, Cutter } from "./sdk/index.js";

client.setConfig({ baseUrl: process.argv[2] ?? "" });
const cutter: Cutter = { type: "toroidal", diameter_mm: 10, corner_radius_mm: 2, teeth: 4 };
const contact: Contact = { slope_deg: 40, feed_angle_deg: 30 };

const height = await scallopHeight({ body: { cutter, contact, step_over_mm: 0.687, feed_per_tooth_mm: 0.3 } });
assert(height.data && Math.abs(height.data.scallop_height_mm - 0.01305) < 1e-4, JSON.stringify(height));

const batch = await stepOverBatch({
  body: { cutter, scallop_tolerance_mm: 0.012, contacts: [{ slope_deg: 20, feed_angle_deg: 90 }, { slope_deg: 95, feed_angle_deg: 90 }] },
});
const stepOvers: (number | null)[] | undefined = batch.data?.step_over_mm;
assert(stepOvers?.length === 2 && stepOvers[1] === null, JSON.stringify(batch));

const refused = await maxFeed({ body: { cutter, contact, scallop_tolerance_mm: 0.013, step_over_mm: 0.987 } });
assert(refused.error && refused.error.type === "tolerance-exceeded" && "max_step_over_mm" in refused.error, JSON.stringify(refused));

const points = Array.from({ length: 20 }, (_, index) => `${15 * (index % 5)},${10 * Math.floor(index / 5)},${5 * Math.floor(index / 5)}`);
const upload = await cutterRecommendationUpload({
  body: {
    surface: new File([points.join("\n")], "surface.csv"),
    parameters: {
      cutters: [
        { name: "T10", type: "toroidal", diameter_mm: 10, corner_radius_mm: 2 },
        { name: "B10", type: "ball_end", diameter_mm: 10 },
      ],
      scallop_height_mm: 0.01,
      machine: { preset: "vmc" },
    },
  },
});
assert(upload.data && upload.data.candidates.length === 2, JSON.stringify(upload));
console.log("hey-api: a calculation, a batch, a typed problem and an upload");
