import { DecodeError, ServerError } from "../client/index.js";
import { RequestError } from "./api.js";
import type { Message } from "./notice.js";
import { goTo } from "./page.js";

/**
 * What a model's page says of what has failed: a request, a connection, or the decoding of a log.
 * @param isKnown whether the server has told of the model before
 * @param again   tries once more, where a visitor may ask for that
 */
export function failureMessage(error: unknown, isKnown: boolean, again?: () => void): Message {
    if (error instanceof DecodeError) {
        return { sentence: `The stream is damaged: ${error.message}. What was decoded before stays.` };
    }
    if (error instanceof RequestError || error instanceof ServerError) {
        return error.status === 404 && !isKnown ? noSuchModel : { sentence: error.message };
    }
    // So fetch() tells that there was no answer.
    if (error instanceof TypeError) return connectionLost(again);
    return { sentence: String(error) };
}

const noSuchModel: Message = {
    sentence: "There is no such model. It may have been deleted.",
    action: { label: "All models", run: () => goTo("/") },
};

function connectionLost(again: (() => void) | undefined): Message {
    return {
        sentence: "The connection is lost. What has arrived stays.",
        ...(again && { action: { label: "Try again", run: again } }),
        isOfConnection: true,
    };
}
