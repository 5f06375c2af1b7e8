// Settings of hey-api's generator: Node needs suffixes in imports.
export default {
  output: { path: "sdk", importFileExtension: ".js" },
  plugins: ["@hey-api/client-fetch", "@hey-api/typescript", "@hey-api/sdk"],
};
