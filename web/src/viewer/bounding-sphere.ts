import { Sphere, Vector3 } from "three";

import type { ProgressiveMesh } from "../client/index.js";

/** About the box of a mesh: its centre and half its diagonal, world units. */
export function boundingSphere({ positions, grid: { origin, unit } }: ProgressiveMesh): Sphere {
    const [low, high] = [new Vector3().setScalar(Infinity), new Vector3().setScalar(-Infinity)];
    const point = new Vector3();
    for (let i = 0; i < positions.length; i += 3) {
        point.set(positions[i], positions[i + 1], positions[i + 2]);
        low.min(point);
        high.max(point);
    }
    const centre = low.clone().add(high).multiplyScalar(0.5 * unit).add(new Vector3(...origin));
    return new Sphere(centre, 0.5 * unit * high.distanceTo(low));
}
