// Starts `meldsim debug --dap` for VS Code's debugger; everything else is done there.
"use strict";

const vscode = require("vscode");

// Without a launch.json, F5 debugs the program that is open.
function resolve(folder, configuration) {
    if (configuration.program) return configuration;
    const editor = vscode.window.activeTextEditor;
    if (!editor || editor.document.languageId !== "meld") {
        vscode.window.showErrorMessage('There is no program to debug: open a .meld file, or write its path as "program" into launch.json.');
        return undefined;
    }
    return { ...configuration, type: "meld", request: "launch", name: "Meld", program: editor.document.uri.fsPath };
}

function adapter(session) {
    const command = vscode.workspace.getConfiguration("meld").get("meldsim");
    const folder = session.workspaceFolder;
    return new vscode.DebugAdapterExecutable(command, ["debug", "--dap"], folder && { cwd: folder.uri.fsPath });
}

async function chooseCatom() {
    const session = vscode.debug.activeDebugSession;
    if (!session || session.type !== "meld") return;
    const text = await vscode.window.showInputBox({
        prompt: "The number of the catom whose facts are shown",
        validateInput: (value) => (/^@?\d+$/.test(value) ? undefined : "Write a number, such as 42"),
    });
    if (text === undefined) return;
    try {
        await session.customRequest("claymeld/catom", { catom: Number(text.replace("@", "")) });
    } catch (error) {
        vscode.window.showErrorMessage(error.message);
    }
}

function register(context) {
    context.subscriptions.push(
        vscode.debug.registerDebugConfigurationProvider("meld", { resolveDebugConfiguration: resolve }),
        vscode.debug.registerDebugAdapterDescriptorFactory("meld", { createDebugAdapterDescriptor: adapter }),
        vscode.commands.registerCommand("meld.chooseCatom", chooseCatom));
}

module.exports = { register };
