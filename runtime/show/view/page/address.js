// What the end of the link asks for, as in #images or #colour=dist(A, D)&map=magma.

const LOOK = ["colour", "only", "hide", "links", "arrows", "labels", "map", "form"];

const asked = () => new URLSearchParams(location.hash.slice(1));

// Pictures of the server, also where the browser could draw.
export const wantsImages = () => asked().has("images");

// What is shown at first, by the names of fields.
export const firstLook = () => Object.fromEntries([...asked()].filter(([name]) => LOOK.includes(name)));
