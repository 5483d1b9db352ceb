// A photograph's camera as a graphics library wants it. Conventions of cameras.json: x ~ K (R X + t), camera axes x
// right, y down, z forward; of WebGL: x right, y up, z backward. Matrices are column by column.

export interface PinholeCamera {
    readonly K: readonly (readonly number[])[];
    readonly R: readonly (readonly number[])[];
    readonly t: readonly number[];
}

export interface Size {
    readonly width: number;
    readonly height: number;
}

export interface Rectangle extends Size {
    readonly left: number;
    readonly top: number;
}

/** Where an image of this size lies, as large as fits, in the middle of a free place. */
export function fittedRectangle(image: Size, { left, top, width, height }: Rectangle): Rectangle {
    const scale = Math.min(width / image.width, height / image.height);
    const fitted = { width: scale * image.width, height: scale * image.height };
    return { left: left + (width - fitted.width) / 2, top: top + (height - fitted.height) / 2, ...fitted };
}

/** Takes world points to WebGL's camera axes. */
export function viewMatrix({ R, t }: PinholeCamera): number[] {
    const sign = [1, -1, -1];
    const column = (j: number) => [0, 1, 2].map((i) => sign[i] * R[i][j]);
    return [...column(0), 0, ...column(1), 0, ...column(2), 0, ...[0, 1, 2].map((i) => sign[i] * t[i]), 1];
}

/**
 * Takes WebGL's camera axes to clip space, so that a pixel of the photograph is seen where it lies in its rectangle.
 * @param pixelCentre where the centre of the top-left pixel lies
 * @param image  pixels of the photograph
 * @param place  of it in the canvas
 * @param canvas the same unit
 */
export function projectionMatrix(
    { K }: PinholeCamera,
    pixelCentre: readonly number[],
    image: Size,
    { left, top, width }: Rectangle,
    canvas: Size,
    near: number,
    far: number,
): number[] {
    const scale = width / image.width;
    const ndcX = (2 * scale) / canvas.width; // of one pixel
    const ndcY = (2 * scale) / canvas.height;
    const centreX = (2 * left) / canvas.width - 1 + ndcX * (K[0][2] - pixelCentre[0] + 0.5);
    const centreY = 1 - (2 * top) / canvas.height - ndcY * (K[1][2] - pixelCentre[1] + 0.5);
    // Rows for x y z forward; y and z change their signs for WebGL's axes.
    return [
        ...[ndcX * K[0][0], 0, 0, 0],
        ...[-ndcX * K[0][1], ndcY * K[1][1], 0, 0],
        ...[-centreX, -centreY, -(far + near) / (far - near), -1],
        ...[0, 0, (-2 * far * near) / (far - near), 0],
    ];
}

/** The camera's place in the world. */
export function cameraCentre({ R, t }: PinholeCamera): [number, number, number] {
    const along = (j: number) => -(R[0][j] * t[0] + R[1][j] * t[1] + R[2][j] * t[2]);
    return [along(0), along(1), along(2)];
}

/** Which way is up for those who took the photographs: the mean of the cameras' own. */
export function meanUp(cameras: readonly PinholeCamera[]): [number, number, number] {
    const sum: [number, number, number] = [0, 0, 0];
    for (const { R } of cameras) for (let j = 0; j < 3; ++j) sum[j] -= R[1][j];
    const length = Math.hypot(...sum);
    return length > 1e-6 ? [sum[0] / length, sum[1] / length, sum[2] / length] : [0, 1, 0];
}
