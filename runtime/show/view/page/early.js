// Asks a server for all that the first picture needs before the program of the page, which is large, is read: so the server is at work
// meanwhile. A page that holds its run has no server, and its link has no token.
import {firstLook} from "./address.js";
import {ServerSource} from "./source_server.js";

const loaded = new Promise((done) => addEventListener("DOMContentLoaded", done));

// The program stands in the page as a text, which the browser does not read by itself.
async function runProgram() {
    await loaded;
    const script = document.createElement("script");
    script.textContent = document.getElementById("program").textContent;
    document.body.append(script);
}

if (new URLSearchParams(location.search).has("token")) {
    const source = new ServerSource(), asked = source.begin(firstLook());
    window.early = {source, asked};
    // Whoever waits for it says what is wrong.
    asked.then(runProgram, runProgram);
} else runProgram();
