// What `npm pack` makes of this folder, put where a program would have it.
import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { mkdirSync, symlinkSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";

import { test } from "vitest";

import { icosphereExpectations, repository } from "./golden.js";
import { inScratchFolder } from "./program.js";

const web = fileURLToPath(new URL("web/", repository));
const run = promisify(execFile);

const program = `
import { readFileSync } from "node:fs";
import { decodeLog, loadDraco3d } from "anyrate";
const { mesh } = decodeLog(readFileSync(process.argv[2]), await loadDraco3d());
console.log(mesh.nVertices, mesh.stateHash);
`;

test("Package: a program that has it installed decodes a log, and it holds the client and nothing else", () =>
    inScratchFolder(async (folder) => {
        const { stdout } = await run("npm", ["pack", "--json", "--offline", "--pack-destination", folder], { cwd: web });
        const [{ filename, files }] = JSON.parse(stdout);
        const names: string[] = files.map(({ path }: { path: string }) => path);
        const foreign = names.filter((name) => !/^(dist\/src\/client\/[a-z0-9-]+\.(js|d\.ts)|package\.json|README\.md)$/.test(name));
        assert.deepEqual(foreign, []);
        assert.ok(names.includes("dist/src/client/draco-worker.js"));
        const modules = join(folder, "node_modules");
        mkdirSync(join(modules, "anyrate"), { recursive: true });
        await run("tar", ["-xzf", join(folder, filename), "-C", join(modules, "anyrate"), "--strip-components=1"]);
        symlinkSync(join(web, "node_modules/draco3d"), join(modules, "draco3d")); // its one dependency
        writeFileSync(join(folder, "program.mjs"), program);
        const golden = fileURLToPath(new URL("tests/golden/icosphere.arl", repository));
        const printed = await run(process.execPath, [join(folder, "program.mjs"), golden]);
        const { vertices, stateHash } = icosphereExpectations.at(-1)!;
        assert.equal(printed.stdout.trim(), `${vertices} ${stateHash}`);
    }));
