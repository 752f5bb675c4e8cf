// The run of a server, over a WebSocket: requests with numbers, responses with the same, events without any.
import {parseBlock} from "./block.js";

export class ServerSource {
    constructor() {
        this.waiting = new Map();
        this.ids = {next: 1};
        this.others = {};  // Of requests about the other run: which one.
        this.awaits = null;  // A response whose bytes come with the next message.
        this.onevent = () => {};
        this.onclosed = () => {};
        this.live = true;
        this.asks = true;
    }

    open() {
        const token = new URLSearchParams(location.search).get("token") || "";
        const scheme = location.protocol === "https:" ? "wss" : "ws";
        this.socket = new WebSocket(`${scheme}://${location.host}/ws?token=${encodeURIComponent(token)}`);
        this.socket.binaryType = "arraybuffer";
        this.socket.onmessage = ({data}) => typeof data === "string" ? this.told(JSON.parse(data)) : this.settled(this.awaits, data);
        return new Promise((done, fail) => {
            this.socket.onopen = done;
            this.socket.onclose = () => {
                const lost = {message: "The server has ended or does not know this page",
                    hint: "Start meldsim view again and open the link that it prints"};
                for (const {fail: refuse} of this.waiting.values()) refuse(lost);
                this.waiting.clear();
                fail(lost);
                this.onclosed(lost);
            };
        });
    }

    // Asks for all that the first picture needs.
    async begin(look) {
        await this.open();
        const asked = {hello: this.hello(), beside: this.beside(), frame: this.frame(look)};
        for (const each of Object.values(asked)) each.catch(() => {});
        return asked;
    }

    told(message) {
        if (message.id === undefined) this.onevent(message);
        else if (message.binary) this.awaits = message;
        else this.settled(message, null);
    }

    settled(message, bytes) {
        const waiting = this.waiting.get(message.id);
        this.waiting.delete(message.id);
        this.awaits = null;
        if (!waiting) return;
        if (message.ok) waiting.done({...message, bytes});
        else waiting.fail(message.error);
    }

    // Resolves to the response, with `bytes` if it has some; rejects with {message, hint}.
    request(what, parameters = {}) {
        return new Promise((done, fail) => {
            if (this.socket.readyState !== WebSocket.OPEN) {
                fail({message: "The server has ended", hint: "Start meldsim view again"});
                return;
            }
            const id = this.ids.next++;
            this.waiting.set(id, {done, fail});
            this.socket.send(JSON.stringify({id, do: what, ...this.others, ...parameters}));
        });
    }

    // The run beside this one, over the same socket; null: there is none.
    async beside() {
        const other = Object.assign(Object.create(this), {others: {run: 1}});
        try {
            other.info = await other.hello();
            return other;
        } catch {
            return null;
        }
    }

    async hello() {
        const info = await this.request("hello");
        this.live = info.live !== false;
        return info;
    }

    async frame(look, tick) {
        const words = await this.request("frame", {look, values: true, ...(tick === undefined ? {} : {tick})});
        return {words, frame: parseBlock(words.bytes, words)};
    }

    command(line) { return this.request("command", {line}); }
    metrics() { return this.request("metrics"); }
    // What a body says after each tick, as far as it is known; unless `done`, the next answer has more.
    series(body) { return this.request("series", {body}); }
    play(speed) { return this.request("play", {speed}); }
    world() { return this.worldOf(this.request("world")); }
    checkWorld(toml) { return this.worldOf(this.request("world-check", {toml})); }
    saveWorld(toml) { return this.worldOf(this.request("world-save", {toml})); }
    // With its catoms, if they are few enough to be shown.
    async worldOf(asked) {
        const said = await asked;
        return {...said, frame: said.bytes ? parseBlock(said.bytes, {compounds: said.compounds, lamps: said.lamps}) : null};
    }
    // Ends what the server is doing; that says so itself.
    interrupt() { this.socket.send(JSON.stringify({do: "interrupt"})); }
    pause() { return this.request("pause"); }
    async image(look, camera, size) { return (await this.request("image", {look, camera, size})).bytes; }
}
