#include "server/jobs/worker_message.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "server/jobs/json_line.h"

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
    if (progress.seconds_left) object["left"] = *progress.seconds_left;
    return object;
}

json to_json(const RatePoint& point) {
    return {{"type", "rate"},
            {"vertices", point.n_vertices},
            {"bytes", point.n_bytes},
            {"psi", point.psi},
            {"seconds", point.seconds}};
}

json to_json(const JobBegun& begun) { return {{"type", "begun"}, {"bytes", begun.n_bytes}}; }

constexpr std::array<const char*, 3> cause_names = {"capture", "machine", "no room"};

json to_json(const JobFailed& failed) {
    return {
        {"type", "failed"}, {"error", failed.error}, {"cause", cause_names[static_cast<std::size_t>(failed.cause)]}};
}

FailureCause cause_from(const std::string& name) {
    const auto found = std::ranges::find(cause_names, name);
    if (found == cause_names.end()) throw DecodeError("worker message: unknown cause \"" + name + "\"");
    return static_cast<FailureCause>(found - cause_names.begin());
}

json to_json(const JobDone&) { return {{"type", "done"}}; }

json to_json(const JobStopped&) { return {{"type", "stopped"}}; }

JobProgress progress_from(const json& object) {
    JobProgress progress{.stage = object.at("stage"),
                         .fraction = object.at("fraction"),
                         .n_vertices = whole_number<std::uint32_t>(object, "vertices"),
                         .n_bytes = whole_number<std::uint64_t>(object, "bytes"),
                         .psi = std::nullopt,
                         .seconds_left = std::nullopt};
    if (object.contains("psi")) progress.psi = object.at("psi").get<double>();
    if (object.contains("left")) progress.seconds_left = object.at("left").get<double>();
    return progress;
}

WorkerMessage from_json(const json& object) {
    const std::string type = object.at("type");
    if (type == "progress") return progress_from(object);
    if (type == "rate")
        return RatePoint{.n_vertices = whole_number<std::uint32_t>(object, "vertices"),
                         .n_bytes = whole_number<std::uint64_t>(object, "bytes"),
                         .psi = object.at("psi"),
                         .seconds = object.at("seconds")};
    if (type == "begun") return JobBegun{whole_number<std::uint64_t>(object, "bytes")};
    if (type == "failed") return JobFailed{.error = object.at("error"), .cause = cause_from(object.at("cause"))};
    if (type == "done") return JobDone{};
    if (type == "stopped") return JobStopped{};
    throw DecodeError("worker message of unknown type \"" + type + "\"");
}

}  // namespace

std::string encode_worker_message(const WorkerMessage& message) {
    return json_line(std::visit([](const auto& m) { return to_json(m); }, message));
}

WorkerMessage decode_worker_message(std::string_view line) { return from_json_line(line, "worker message", from_json); }

}  // namespace anyrate
