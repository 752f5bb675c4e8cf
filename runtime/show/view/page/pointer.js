// The pointer on the picture: drag turns, with Shift or another button moves, with Ctrl draws a box; a click selects, the wheel zooms.

// `picked(id or null, more, [x, y])`, `boxed(ids, more)`.
export function listen(stage, box, {picked, boxed}) {
    const {element, view} = stage;
    let drag = null;
    const place = ({clientX, clientY}) => {
        const {left, top} = element.getBoundingClientRect();
        return [clientX - left, clientY - top];
    };
    element.addEventListener("contextmenu", (event) => event.preventDefault());
    element.addEventListener("pointerdown", (event) => {
        element.focus({preventScroll: true});
        element.setPointerCapture(event.pointerId);
        const [x, y] = place(event);
        const does = event.ctrlKey || element.classList.contains("boxing") ? "box" : event.shiftKey || event.button !== 0 ? "pan" : "orbit";
        drag = {x, y, lastX: x, lastY: y, does, moved: false, button: event.button};
    });
    element.addEventListener("pointermove", (event) => {
        if (!drag) return;
        const [x, y] = place(event), dx = x - drag.lastX, dy = y - drag.lastY;
        if (!drag.moved && Math.hypot(x - drag.x, y - drag.y) < 4) return;
        drag.moved = true;
        if (drag.does === "orbit") view.orbit(dx, dy);
        else if (drag.does === "pan") view.pan(dx, dy);
        else Object.assign(box.style, {display: "block", left: `${Math.min(x, drag.x)}px`, top: `${Math.min(y, drag.y)}px`,
            width: `${Math.abs(x - drag.x)}px`, height: `${Math.abs(y - drag.y)}px`});
        Object.assign(drag, {lastX: x, lastY: y});
        if (drag.does !== "box") stage.draw();
    });
    element.addEventListener("pointerup", (event) => {
        if (!drag) return;
        const [x, y] = place(event), {does, moved, button} = drag, from = drag, more = event.shiftKey || (event.ctrlKey && !moved);
        drag = null;
        box.style.display = "none";
        if (moved && does === "box") {
            element.classList.remove("boxing");
            boxed(stage.within(Math.min(x, from.x), Math.min(y, from.y), Math.max(x, from.x), Math.max(y, from.y)), more);
        } else if (!moved && button === 0) picked(stage.at(x, y), more, [x, y]);
    });
    element.addEventListener("pointercancel", () => {
        drag = null;
        box.style.display = "none";
    });
    element.addEventListener("dblclick", (event) => {
        const id = stage.at(...place(event));
        if (id !== null) stage.lookTo(id);
    });
    element.addEventListener("wheel", (event) => {
        event.preventDefault();
        view.zoom(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015)), ...place(event));
        stage.draw();
    }, {passive: false});
}
