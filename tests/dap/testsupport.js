// The debugger as VS Code's own test client meets it, the npm package @vscode/debugadapter-testsupport:
// node testsupport.js MELDSIM FOLDER, where FOLDER has node_modules with the package.
"use strict";

const assert = require("assert");
const path = require("path");
const [, , meldsim, folder] = process.argv;
const { DebugClient } = require(require.resolve("@vscode/debugadapter-testsupport", { paths: [folder] }));

const program = path.resolve(__dirname, "../../examples/meld/gradient.meld");

async function session(client) {
    await Promise.all([
        client.configurationSequence(),
        client.launch({ program, ticks: 30, stopOnEntry: true }),
        client.assertStoppedLocation("entry", { line: 1 }),
    ]);
    const set = await client.setBreakpointsRequest({ source: { path: program }, breakpoints: [{ line: 10, condition: "D > 5" }] });
    assert.deepStrictEqual(set.body.breakpoints.map((b) => [b.verified, b.line]), [[true, 10]]);
    await Promise.all([
        client.continueRequest({ threadId: 1 }),
        client.assertStoppedLocation("breakpoint", { path: program, line: 10, column: 1 }),
    ]);
    const stack = await client.stackTraceRequest({ threadId: 1 });
    assert.ok(stack.body.stackFrames.length > 5);
    const value = await client.evaluateRequest({ expression: "N = count : { dist(_, _) }", context: "watch" });
    assert.ok(Number(value.body.result) > 0);
    await Promise.all([client.stepBackRequest({ threadId: 1 }), client.waitForEvent("stopped")]);
    await assert.rejects(client.evaluateRequest({ expression: "nothing(A)", context: "watch" }), /E0301/);
    await Promise.all([client.terminateRequest(), client.waitForEvent("terminated")]);
}

async function main() {
    // It gives the adapter one argument; a shell makes two of it.
    const client = new DebugClient(`"${meldsim}"`, "debug --dap", "meld", { shell: true });
    await client.start();
    client.defaultTimeout = 20000;
    await session(client);
    await client.stop();
}

main().then(() => process.exit(0), (error) => { console.error(error); process.exit(1); });
