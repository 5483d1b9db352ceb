#include "server/http/model_json.h"

#include <cstdio>
#include <nlohmann/json.hpp>

namespace anyrate {
namespace {

using nlohmann::ordered_json;

std::string to_text(const ordered_json& json) {
    return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

ordered_json links_of(const ModelRecord& model) {
    const std::string self = "/v1/models/" + model.id;
    return {{"self", self},
            {"log", self + "/log"},
            {"index", self + "/index"},
            {"live", self + "/live"},
            {"events", self + "/events"},
            {"ply", self + "/mesh.ply"},
            {"obj", self + "/mesh.obj"},
            {"glb", self + "/mesh.glb"}};
}

ordered_json to_json(const ModelRecord& model) {
    ordered_json json = {{"id", model.id},
                         {"state", state_name(model.state)},
                         {"stage", model.progress.stage},
                         {"fraction", model.progress.fraction},
                         {"vertices", model.progress.n_vertices},
                         {"bytes", model.progress.n_bytes},
                         {"distortion", nullptr},
                         {"seconds_left", nullptr},
                         {"attempts", model.attempts},
                         {"created", iso_time(model.created)},
                         {"updated", iso_time(model.updated)},
                         {"options", {{"vertices", model.options.n_vertices}, {"coarse", model.options.n_coarse}}}};
    if (model.progress.seconds_left) json["seconds_left"] = *model.progress.seconds_left;
    if (model.progress.psi) json["distortion"] = *model.progress.psi;
    if (!model.error.empty()) json["error"] = model.error;
    json["links"] = links_of(model);
    return json;
}

}  // namespace

std::string iso_time(Timestamp time) {
    const auto day = std::chrono::floor<std::chrono::days>(time);
    const std::chrono::year_month_day date(day);
    const std::chrono::hh_mm_ss clock(time - day);
    char text[40];
    std::snprintf(text, sizeof text, "%04d-%02u-%02uT%02d:%02d:%02d.%03dZ", static_cast<int>(date.year()),
                  static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                  static_cast<int>(clock.hours().count()), static_cast<int>(clock.minutes().count()),
                  static_cast<int>(clock.seconds().count()), static_cast<int>(clock.subseconds().count()));
    return text;
}

std::string model_json(const ModelRecord& model, std::span<const RatePoint> curve) {
    ordered_json json = to_json(model);
    json["curve"] = ordered_json::array();
    for (const RatePoint& point : curve)
        json["curve"].push_back({{"vertices", point.n_vertices},
                                 {"bytes", point.n_bytes},
                                 {"distortion", point.psi},
                                 {"seconds", point.seconds}});
    return to_text(json);
}

std::string model_json(const ModelRecord& model) { return to_text(to_json(model)); }

std::string new_model_json(const ModelRecord& model, const std::string& files_json) {
    ordered_json json = to_json(model);
    json["files"] = ordered_json::parse(files_json);
    return to_text(json);
}

std::string model_list_json(const ModelPage& page, std::size_t limit) {
    ordered_json json = {{"models", ordered_json::array()}};
    for (const ModelRecord& model : page.models) json["models"].push_back(to_json(model));
    if (page.more)
        json["next"] =
            "/v1/models?limit=" + std::to_string(limit) + "&after=" + std::to_string(page.models.back().number);
    return to_text(json);
}

}  // namespace anyrate
