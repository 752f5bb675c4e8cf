// Ticks that somebody wants to come back to. They last as long as the tab, also when the page is loaded again.
import {grouped, h} from "./dom.js";

// Some pages may not keep anything, as one within another page.
function kept(key, value) {
    try {
        if (value === undefined) return JSON.parse(sessionStorage.getItem(key)) || [];
        sessionStorage.setItem(key, JSON.stringify(value));
    } catch {
        // They last as long as the page.
    }
    return [];
}

export class Bookmarks {
    // `changed` is called when there are others.
    constructor(name, {go, changed}) {
        Object.assign(this, {go, changed, key: `bookmarks of ${name}`});
        this.button = h("button", {id: "bookmark", title: "Bookmark this tick, or not (m)", "aria-pressed": "false",
            onclick: () => this.toggle(this.now)}, "⚑");
        this.element = h("span", {id: "bookmarks", "aria-label": "Bookmarks", role: "group"});
        this.ticks = kept(this.key).filter(Number.isSafeInteger);
        this.list();
    }

    toggle(tick) {
        if (tick === undefined) return;
        this.ticks = this.ticks.includes(tick) ? this.ticks.filter((other) => other !== tick)
            : [...this.ticks, tick].sort((a, b) => a - b);
        kept(this.key, this.ticks);
        this.list();
        this.changed();
    }

    // The nearest one before (-1) or after (1) the tick that is shown.
    beside(way) {
        const all = this.ticks.filter((tick) => way * (tick - this.now) > 0);
        return way > 0 ? all[0] : all[all.length - 1];
    }

    at(tick) {
        this.now = tick;
        this.list();
    }

    list() {
        const on = this.ticks.includes(this.now);
        this.button.classList.toggle("on", on);
        this.button.setAttribute("aria-pressed", String(on));
        this.element.replaceChildren(...this.ticks.map((tick) => h("span", {class: tick === this.now ? "chip on" : "chip"},
            h("button", {class: "plain", title: "Go there", onclick: () => this.go(tick)}, `⚑ ${grouped(tick)}`),
            h("button", {class: "plain", title: "Forget it", "aria-label": `Forget the bookmark of tick ${tick}`,
                onclick: () => this.toggle(tick)}, "×"))));
    }
}
