#include "server/jobs/worker_message.h"

#include <nlohmann/json.hpp>

#include "core/error.h"

namespace anyrate {
namespace {

using nlohmann::json;

json to_json(const JobProgress& progress) {
    json object = {{"type", "progress"},
                   {"stage", progress.stage},
                   {"fraction", progress.fraction},
                   {"vertices", progress.n_vertices},
                   {"bytes", progress.n_bytes}};
    if (progress.psi) object["psi"] = *progress.psi;
    return object;
}

json to_json(const RatePoint& point) {
    return {{"type", "rate"},
            {"vertices", point.n_vertices},
            {"bytes", point.n_bytes},
            {"psi", point.psi},
            {"seconds", point.seconds}};
}

json to_json(const JobFailed& failed) { return {{"type", "failed"}, {"error", failed.error}, {"retry", failed.retry}}; }

json to_json(const JobDone&) { return {{"type", "done"}}; }

json to_json(const JobStopped&) { return {{"type", "stopped"}}; }

JobProgress progress_from(const json& object) {
    JobProgress progress{.stage = object.at("stage"),
                         .fraction = object.at("fraction"),
                         .n_vertices = object.at("vertices"),
                         .n_bytes = object.at("bytes"),
                         .psi = std::nullopt};
    if (object.contains("psi")) progress.psi = object.at("psi").get<double>();
    return progress;
}

WorkerMessage from_json(const json& object) {
    const std::string type = object.at("type");
    if (type == "progress") return progress_from(object);
    if (type == "rate")
        return RatePoint{.n_vertices = object.at("vertices"),
                         .n_bytes = object.at("bytes"),
                         .psi = object.at("psi"),
                         .seconds = object.at("seconds")};
    if (type == "failed") return JobFailed{.error = object.at("error"), .retry = object.at("retry")};
    if (type == "done") return JobDone{};
    if (type == "stopped") return JobStopped{};
    throw DecodeError("worker message of unknown type \"" + type + "\"");
}

}  // namespace

std::string encode_worker_message(const WorkerMessage& message) {
    // A file name inside an error sentence may be any bytes; what is not UTF-8 is replaced.
    return std::visit([](const auto& m) { return to_json(m); }, message)
               .dump(-1, ' ', false, json::error_handler_t::replace) +
           "\n";
}

WorkerMessage decode_worker_message(std::string_view line) {
    try {
        return from_json(json::parse(line));
    } catch (const json::exception& error) {
        throw DecodeError(std::string("worker message: ") + error.what());
    }
}

}  // namespace anyrate
