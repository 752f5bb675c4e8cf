// The keyboard, and the page that lists its keys.
import {h} from "./dom.js";

// Of each: keys as they are shown, as events name them, what they do, and which action.
const KEYS = [["space", [" "], "play or pause", "toggle"], ["→", ["ArrowRight"], "one tick on", "on"], ["←", ["ArrowLeft"],
    "one tick back", "back"],
    ["Home", ["Home"], "to the first tick", "start"], ["End", ["End"], "to the last tick that is known", "end"], ["f", ["f"],
        "show everything", "fit"],
    ["c", ["c"], "look at the selected catom", "centre"], ["1", ["1"], "from the front", "front"], ["3", ["3"], "from the side",
        "side"], ["7", ["7"], "from above", "top"],
    ["5", ["5"], "perspective or parallel rays", "projection"], ["+ −", ["+", "=", "-"], "nearer, farther", "zoom"], ["b", ["b"],
        "draw a box with the next drag", "box"],
    ["m", ["m"], "bookmark this tick, or not", "bookmark"], ["[ ]", ["[", "]"], "the bookmark before, the next one", "mark"],
    ["l", ["l"], "labels on or off", "labels"], ["d", ["d"], "light or dark", "theme"], ["/", ["/"], "search", "search"], ["Esc",
        ["Escape"], "select nothing", "nothing"], ["?", ["?"], "this page", "help"]];
const POINTER = [["drag", "turn"], ["Shift + drag", "move"], ["Ctrl + drag", "select what is in a box"], ["wheel", "zoom"], ["click",
    "select"],
    ["Shift + click", "select one more"], ["double click", "look at it"]];

export function listenToKeys(actions, dialog) {
    const row = (key, text) => h("tr", {}, h("td", {}, h("kbd", {}, key)), h("td", {}, text));
    dialog.append(h("table", {}, KEYS.map(([key, , text]) => row(key, text)), POINTER.map(([key, text]) => row(key, text))),
        h("form", {method: "dialog"}, h("button", {}, "Close")));
    addEventListener("keydown", (event) => {
        const typing = event.target.matches("input[type='text'], input[type='search'], select, textarea");
        if (typing && event.key !== "Escape") return;
        if (event.ctrlKey || event.metaKey || event.altKey || dialog.open) return;
        if (event.key === " " && event.target.matches("button, summary")) return;
        if (event.key === "Escape" && typing) event.target.blur();
        const found = KEYS.find(([, names]) => names.includes(event.key));
        if (!found) return;
        event.preventDefault();
        actions[found[3]](event.key);
    });
}
