#pragma once
#include <memory>

#include "server/http/context.h"
#include "server/http/stream.h"
#include "server/http/wake_up.h"

namespace anyrate {

/// Sends the state of a model as Server-Sent Events, one `state` event with the model's JSON at once and one at every
/// change, until the state is final, the model is gone, the server stops or the connection breaks.
awaitable<void> serve_events(Stream& stream, ServerContext& context, const Response& response,
                             std::shared_ptr<WakeUp> wake_up);

}  // namespace anyrate
