// Draco packets for tests, by the stock encoder of draco3d.
// @ts-expect-error no types
import draco3d from "draco3d";

const encoderModule = await draco3d.createEncoderModule({});
const pointCloudSequential = 0;

/** nComponents integers a point, point by point. */
export interface Attribute {
    readonly nComponents: number;
    readonly values: readonly number[];
}

/** A sequential point cloud. */
export function encodePointCloud(nPoints: number, attributes: readonly Attribute[]): Uint8Array {
    const builder = new encoderModule.PointCloudBuilder();
    const cloud = new encoderModule.PointCloud();
    for (const { nComponents, values } of attributes) {
        builder.AddInt32Attribute(cloud, encoderModule.GENERIC, nPoints, nComponents, Int32Array.from(values));
    }
    const encoder = new encoderModule.ExpertEncoder(cloud);
    encoder.SetEncodingMethod(pointCloudSequential);
    const bytes = new encoderModule.DracoInt8Array();
    encoder.EncodeToDracoBuffer(false, bytes);
    const encoded = Uint8Array.from({ length: bytes.size() }, (_, i) => bytes.GetValue(i));
    for (const object of [bytes, encoder, cloud, builder]) encoderModule.destroy(object);
    return encoded;
}
