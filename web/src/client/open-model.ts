import { dracoInThread } from "./draco-service.js";
import { loadDraco3d } from "./draco3d.js";
import { Model } from "./model.js";
import type { ModelOptions } from "./model-options.js";
import { modelUrls } from "./model-urls.js";

/**
 * Opens a model by one request of 8 KB, which brings header, index and base, and replays what is in it. A base that is
 * larger takes a second request, as does a budget that is given.
 * @param url of a model of a server (.../v1/models/ID), or of a log as a file
 * @throws ServerError the server refuses, DecodeError it has no sound log, whatever fetch throws
 */
export async function openModel(url: string, options: ModelOptions = {}): Promise<Model> {
    const model = await newModel(url, options);
    try {
        await model.readFirst();
    } catch (error) {
        model.dispose();
        throw error;
    }
    return model;
}

/** Follows a model from its start while it is made; also one whose log has not begun. */
export async function followModel(url: string, options: ModelOptions = {}): Promise<Model> {
    const model = await newModel(url, options);
    void model.live();
    return model;
}

async function newModel(url: string, options: ModelOptions): Promise<Model> {
    const draco = options.draco ?? dracoInThread(await loadDraco3d());
    const model = new Model(modelUrls(url), draco, options);
    options.onModel?.(model);
    return model;
}
