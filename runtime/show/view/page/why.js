// Why a fact holds or does not, as a tree that unfolds; its nodes may come again, so each is made when it is opened.
import {h, withCatoms} from "./dom.js";

export function whyTree(answer, choose) {
    const {nodes, roots} = answer;
    if (roots.length === 0) return h("p", {class: "quiet"}, answer.why === undefined ? "It holds." : "It does not hold.");

    const node = (at, open) => {
        const {fact, is, tick, note, ways = [], more} = nodes[at];
        const words = [h("span", {class: "fact"}, withCatoms(fact, choose)), h("span", {class: "is"}, [is,
            tick === undefined ? "" : `tick ${tick}`, note || ""].filter(Boolean).join(", "))];
        if (ways.length === 0) return h("div", {class: "leaf"}, words);
        const out = h("details", {ontoggle: unfold}, h("summary", {}, words));
        function unfold() {
            if (!out.open || out.children.length > 1) return;
            out.append(...ways.map(way), ...(more ? [h("div", {class: "quiet"}, `and ${more} more ways`)] : []));
        }
        if (open) {
            out.open = true;
            unfold();
        }
        return out;
    };
    const way = ({text, rule, file, line, note, catom, parts}) => h("div", {class: "way"},
        text || rule ? h("code", {title: file ? `${file}:${line}` : ""}, text || rule) : null,
        note || catom !== undefined ? h("div", {class: "is"}, withCatoms([catom !== undefined ? `at @${catom}` : "",
            note || ""].filter(Boolean).join(", "), choose)) : null,
        (parts || []).map((part) => part.node !== undefined ? node(part.node, false)
            : h("div", {class: "leaf"}, h("span", {class: "fact"}, withCatoms(part.text, choose)), h("span", {class: "is"}, [part.is,
                part.note || ""].filter(Boolean).join(", ")))));
    return h("div", {class: "tree", id: "why-tree"}, roots.map((root) => node(root, true)));
}
