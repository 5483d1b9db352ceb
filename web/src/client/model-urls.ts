/** Where the parts of a model are. */
export interface ModelUrls {
    readonly log: string;
    /** The side index of the log's live form. */
    readonly index: string;
    /** The WebSocket; undefined if the log is but a file. */
    readonly live: string | undefined;
}

/** @param url of a model (.../v1/models/ID), of its log, or of a log that any web server has as a file */
export function modelUrls(url: string): ModelUrls {
    const model = /^(.*\/v1\/models\/[a-z2-7]{26})(\/log)?$/.exec(url)?.[1];
    if (model === undefined) return { log: url, index: `${url}.idx`, live: undefined };
    return {
        log: `${model}/log`,
        index: `${model}/index?form=live`,
        live: `${model.replace(/^http/, "ws")}/live`,
    };
}
