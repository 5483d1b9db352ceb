#include "server/jobs/judgement_message.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.h"

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

/// A whole number that an Integer can hold, and not below 0.
template <class Integer>
Integer whole(const json& object, const char* key) {
    const json& value = object.at(key);
    if (!value.is_number_unsigned() || !std::in_range<Integer>(value.get<std::uint64_t>()))
        throw DecodeError(std::string("judgement: ") + key + " is no whole number in range");
    return value.get<Integer>();
}

CaptureFile file_from(const json& object) {
    return {.path = object.at("path"),
            .n_bytes = whole<std::uint64_t>(object, "bytes"),
            .sha256 = object.at("sha256"),
            .fault = object.at("fault"),
            .kind = object.at("kind"),
            .width = whole<int>(object, "width"),
            .height = whole<int>(object, "height")};
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
    return std::visit([](const auto& m) { return to_json(m); }, message)
               .dump(-1, ' ', false, json::error_handler_t::replace) +
           "\n";
}

JudgementMessage decode_judgement_message(std::string_view line) {
    try {
        return from_json(json::parse(line));
    } catch (const json::exception& error) {
        throw DecodeError(std::string("judgement: ") + error.what());
    }
}

}  // namespace anyrate
