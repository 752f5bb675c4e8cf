"""Whether all text of a page can be read: its contrast to what is behind it, as WCAG 2.1 counts it, at level AA."""

# Returns {checked, bad: [what, ratio, least, colours]}. Whatever lies over a picture may have black or white behind it. Text of fields and
# what stands in empty ones counts; what cannot be used does not (WCAG 1.4.3).
LOOK = r"""
const parse = (css) => {
    const parts = (css.match(/[\d.]+%?/g) || []).map(parseFloat);
    if (css.startsWith("color(srgb")) return {rgb: parts.slice(0, 3).map((x) => 255 * x), alpha: parts[3] ?? 1};
    if (!/^rgba?\(/.test(css)) throw new Error(`no colour: ${css}`);
    return {rgb: parts.slice(0, 3), alpha: parts[3] ?? 1};
};
const over = ({rgb, alpha}, below) => rgb.map((x, i) => alpha * x + (1 - alpha) * below[i]);
const light = (rgb) => {
    const [r, g, b] = rgb.map((x) => x / 255).map((x) => x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};
const ratio = (a, b) => {
    const [more, less] = [light(a), light(b)].sort((x, y) => y - x);
    return (more + 0.05) / (less + 0.05);
};
// All that may be behind an element's text.
function behind(element) {
    const layers = [];
    for (let at = element; at; at = at.parentElement) {
        if (at.classList.contains("stage") && at !== element) return stacked(layers, [[0, 0, 0], [255, 255, 255]]);
        const {backgroundColor, backgroundImage} = getComputedStyle(at);
        if (backgroundImage !== "none" && at.tagName !== "SELECT") return null;
        const layer = parse(backgroundColor);
        if (layer.alpha > 0) layers.push(layer);
        if (layer.alpha === 1) return stacked(layers, [[255, 255, 255]]);
    }
    return stacked(layers, [[255, 255, 255]]);
}
const stacked = (layers, grounds) => grounds.map((ground) => layers.reduceRight((below, layer) => over(layer, below), ground));
function opacity(element) {
    let out = 1;
    for (let at = element; at; at = at.parentElement) out *= Number(getComputedStyle(at).opacity);
    return out;
}
const bad = [], seen = [];
function check(element, css, what) {
    const style = getComputedStyle(element), {width, height} = element.getBoundingClientRect();
    if (!what.trim() || !width || !height || !element.checkVisibility({checkVisibilityCSS: true})) return;
    if (element.closest(":disabled, [aria-disabled='true'], option")) return;
    const size = parseFloat(style.fontSize), large = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
    const least = large ? 3 : 4.5;
    const grounds = behind(element), colour = parse(css);
    colour.alpha *= opacity(element);
    if (!grounds) { bad.push([what.trim().slice(0, 40), 0, least, "behind it is a picture"]); return; }
    const worst = Math.min(...grounds.map((ground) => ratio(over(colour, ground), ground)));
    seen.push(what.trim());
    const colours = `${css} on ${grounds.map((ground) => ground.map(Math.round))}`;
    if (worst < least) bad.push([what.trim().slice(0, 40), Number(worst.toFixed(2)), least, colours]);
}
const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
while (walk.nextNode()) {
    const element = walk.currentNode.parentElement;
    if (!["SCRIPT", "STYLE", "OPTION", "TEXTAREA"].includes(element.tagName))
        check(element, getComputedStyle(element).color, walk.currentNode.textContent);
}
for (const field of document.querySelectorAll("input[type=text], input[type=search], input[type=number], select, textarea")) {
    const empty = !field.value && field.placeholder, chosen = field.selectedOptions && field.selectedOptions[0];
    const text = chosen ? chosen.textContent : field.value;
    check(field, getComputedStyle(field, empty ? "::placeholder" : undefined).color, empty || text);
}
return {checked: seen.length, words: seen, bad};
"""
