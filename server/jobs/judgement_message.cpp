#include "server/jobs/judgement_message.h"

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "server/jobs/json_line.h"

namespace anyrate {
namespace {

using nlohmann::json;

json to_json(const CaptureFile& file) {
    return {{"type", "file"},      {"path", file.path}, {"bytes", file.n_bytes}, {"sha256", file.sha256},
            {"fault", file.fault}, {"kind", file.kind}, {"width", file.width},   {"height", file.height}};
}
json to_json(const MissingFile& file) { return {{"type", "missing"}, {"path", file.path}}; }
json to_json(const CaptureFault& fault) { return {{"type", "fault"}, {"path", fault.path}, {"fault", fault.sentence}}; }
json to_json(const NotReadable& end) { return {{"type", "not readable"}, {"fault", end.sentence}}; }
json to_json(const JudgementEnd&) { return {{"type", "end"}}; }

CaptureFile file_from(const json& object) {
    return {.path = object.at("path"),
            .n_bytes = whole_number<std::uint64_t>(object, "bytes"),
            .sha256 = object.at("sha256"),
            .fault = object.at("fault"),
            .kind = object.at("kind"),
            .width = whole_number<int>(object, "width", 0),
            .height = whole_number<int>(object, "height", 0)};
}

JudgementMessage from_json(const json& object) {
    const std::string type = object.at("type");
    if (type == "file") return file_from(object);
    if (type == "missing") return MissingFile{object.at("path")};
    if (type == "fault") return CaptureFault{object.at("path"), object.at("fault")};
    if (type == "not readable") return NotReadable{object.at("fault")};
    if (type == "end") return JudgementEnd{};
    throw DecodeError("judgement: unknown type \"" + type + "\"");
}

}  // namespace

std::string encode_judgement_message(const JudgementMessage& message) {
    return json_line(std::visit([](const auto& m) { return to_json(m); }, message));
}

JudgementMessage decode_judgement_message(std::string_view line) {
    return from_json_line(line, "judgement", from_json);
}

}  // namespace anyrate
