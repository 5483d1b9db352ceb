#include "server/store/catalog.h"

namespace anyrate {

const char* state_name(ModelState state) {
    switch (state) {
        case ModelState::queued:
            return "queued";
        case ModelState::running:
            return "running";
        case ModelState::done:
            return "done";
        case ModelState::failed:
            return "failed";
        case ModelState::cancelled:
            return "cancelled";
    }
    return "";
}

bool is_final(ModelState state) { return state != ModelState::queued && state != ModelState::running; }

}  // namespace anyrate
