// Compiles only if the types that are generated from the document fit what callers write.
import type { components, paths } from "./generated/scallopd.js";

type Request<Path extends keyof paths> = paths[Path] extends { post: { requestBody: { content: { "application/json": infer Body } } } } ? Body : never;
type Answer<Path extends keyof paths> = paths[Path] extends { post: { responses: { 200: { content: { "application/json": infer Body } } } } } ? Body : never;

const height: Request<"/v1/scallop-height"> = {
  cutter: { type: "toroidal", diameter_mm: 10, corner_radius_mm: 2, teeth: 4 },
  contact: { slope_deg: 40, feed_angle_deg: 30 },
  step_over_mm: 0.687,
  feed_per_tooth_mm: 0.3,
};

const stepOver: Request<"/v1/step-over"> = {
  cutter: { type: "ball_end", diameter_mm: 6 },
  contact: { normal: [-0.64, 0, 0.77], feed: [1, 0, 0.84] },
  scallop_tolerance_mm: 0.005,
  model: "envelope",
};

const batch: Request<"/v1/max-feed/batch"> = {
  cutter: { type: "flat_end", diameter_mm: 10 },
  scallop_tolerance_mm: 0.012,
  contacts: [{ slope_deg: 40, feed_angle_deg: 90, step_over_mm: 0.4 }],
};

// @ts-expect-error: a toroidal cutter needs a corner radius
const incomplete: Request<"/v1/scallop-height"> = { ...height, cutter: { type: "toroidal", diameter_mm: 10 } };

export function share(answer: Answer<"/v1/scallop-height">): number | undefined {
  return answer.feed_share;
}

type Refusal<Path extends keyof paths> = paths[Path] extends { post: { responses: { 422: { content: { "application/problem+json": infer Body } } } } } ? Body : never;

export function firstFault(problem: components["schemas"]["Problem"]): string | undefined {
  return problem.errors?.[0]?.pointer;
}

// Codes are closed sets: the compiler knows the names, and the figures of each type of problem.
export function wayOut(problem: Refusal<"/v1/max-feed">): number | undefined {
  return problem.type === "tolerance-exceeded" ? problem.max_step_over_mm : undefined;
}

export function isFloor(answer: Answer<"/v1/max-feed/batch">): boolean {
  return answer.failures.some((failure) => failure.code === "flat-floor");
}

// @ts-expect-error: no warning has this code
export const unknown: components["schemas"]["WarningCode"] = "feed-too-funny";

// Operations share the types of their objects.
export const runout: components["schemas"]["Runout"] = { radial_mm: 0.005 };
export const machine: components["schemas"]["Machine"] = { preset: "five_axis_vmc" };
export const withRunout: Request<"/v1/step-over"> = { ...stepOver, runout, model: height.model };

export { batch, height, incomplete, stepOver };
