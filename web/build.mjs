// Makes the scripts that the program has in it: `dist/NAME.js`, and the hash by which a page allows
// it. With a folder as argument they go there.

import { createHash } from "node:crypto";
import { mkdir, readFile, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const folder = process.argv[2] ?? join(here, "dist");
const three = JSON.parse(await readFile(join(here, "node_modules/three/package.json"), "utf8"));
const licence = await readFile(join(here, "node_modules/three/LICENSE"), "utf8");
const banner = [
  "transect's report, GPL-3.0-or-later; made from web/ by ./x web.",
  `It holds parts of three.js ${three.version}:`,
  ...licence.trim().split("\n"),
];

const made = await build({
  absWorkingDir: here,
  entryPoints: ["src/report/report.js"],
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  charset: "ascii",
  legalComments: "none",
  banner: { js: `/*!\n${banner.map((line) => ` * ${line}`.trimEnd()).join("\n")}\n */` },
  write: false,
});
const [{ contents }] = made.outputFiles;
await mkdir(folder, { recursive: true });
await writeFile(join(folder, "report.js"), contents);
const hash = createHash("sha256").update(contents).digest("base64");
await writeFile(join(folder, "report.js.sha256"), `${hash}\n`);
console.log(`report.js: ${contents.length} bytes`);
