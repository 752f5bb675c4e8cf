// Runs before the program of the page, which is large, has been read: asks a server for all that the first picture needs, so that it is at
// work meanwhile. A page that holds its run has no server, and its link has no token.
import {firstLook} from "./address.js";
import {ServerSource} from "./source_server.js";

if (new URLSearchParams(location.search).has("token")) {
    const source = new ServerSource(), asked = source.begin(firstLook());
    // Whoever waits for it says what is wrong.
    asked.catch(() => {});
    window.early = {source, asked};
}
