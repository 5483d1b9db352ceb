import type { OrbitCamera } from "./orbit-camera.js";

const turnRadians = 0.1;
const quickTurnRadians = 0.3; // with Shift
const zoomFactor = 0.88;
const moveShare = 0.05; // of the view's height

/** Turns, moves, zooms and fits a view by keys of a canvas that has the focus. @returns how to stop */
export function orbitByKeys(canvas: HTMLElement, orbit: OrbitCamera): () => void {
    const onKey = (event: KeyboardEvent): void => {
        const turn = event.shiftKey ? quickTurnRadians : turnRadians;
        const action = {
            ArrowLeft: () => orbit.turn(turn, 0),
            ArrowRight: () => orbit.turn(-turn, 0),
            ArrowUp: () => orbit.turn(0, turn),
            ArrowDown: () => orbit.turn(0, -turn),
            "+": () => orbit.zoom(zoomFactor),
            "=": () => orbit.zoom(zoomFactor),
            "-": () => orbit.zoom(1 / zoomFactor),
            a: () => orbit.pan(-moveShare, 0),
            d: () => orbit.pan(moveShare, 0),
            w: () => orbit.pan(0, moveShare),
            s: () => orbit.pan(0, -moveShare),
            f: () => orbit.fit(),
        }[event.key];
        if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
        event.preventDefault();
        action();
    };
    canvas.addEventListener("keydown", onKey);
    return () => canvas.removeEventListener("keydown", onKey);
}
