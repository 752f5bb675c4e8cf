// Starts `meldc lsp` and connects VS Code with it; everything else is done there. The debugger is in debug.js.
"use strict";

const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");
const costs = require("./costs");
const debug = require("./debug");

let client;

async function start() {
    const command = vscode.workspace.getConfiguration("meld").get("meldc");
    client = new LanguageClient("meld", "Meld", { command, args: ["lsp"] }, { documentSelector: [{ scheme: "file", language: "meld" }] });
    try {
        await client.start();
    } catch (error) {
        client = undefined;
        vscode.window.showErrorMessage(
            `Cannot start "${command} lsp" (${error.message}). Put meldc into PATH, or say in the setting meld.meldc where it is.`);
    }
}

async function stop() {
    const running = client;
    client = undefined;
    if (running) await running.stop();
}

function activate(context) {
    debug.register(context);
    costs.register(context, () => client);
    const changed = vscode.workspace.onDidChangeConfiguration(async (event) => {
        if (!event.affectsConfiguration("meld.meldc")) return;
        await stop();
        await start();
    });
    context.subscriptions.push(changed);
    return start();
}

module.exports = { activate, deactivate: stop };
