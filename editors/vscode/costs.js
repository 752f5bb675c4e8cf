// Shows a profile beside the rules; the language server reads it.
"use strict";

const vscode = require("vscode");

// client: a function that gives the connection to the language server, or nothing.
function register(context, client) {
    const tell = async (...profile) => {
        const server = client();
        if (!server) return;
        try {
            await server.sendRequest("workspace/executeCommand", { command: "meld.profile", arguments: profile });
        } catch (error) {
            vscode.window.showErrorMessage(error.message);
        }
    };
    context.subscriptions.push(
        vscode.commands.registerCommand("meld.showProfile", async () => {
            const chosen = await vscode.window.showOpenDialog({
                title: "A profile that meldsim run --profile has written",
                openLabel: "Show",
            });
            if (chosen) await tell(chosen[0].fsPath);
        }),
        vscode.commands.registerCommand("meld.hideProfile", () => tell()));
}

module.exports = { register };
