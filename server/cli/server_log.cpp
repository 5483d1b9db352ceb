#include "server/cli/server_log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

namespace anyrate {
namespace {

using nlohmann::ordered_json;

/// The text behind the braces that the pattern opens; paths and names of clients may hold anything.
std::string members(const ordered_json& object) {
    const std::string text = object.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
    return text.substr(1, text.size() - 2);
}

std::string json_of(const AccessRecord& record) {
    ordered_json object = {{"message", "request"},    {"request_id", record.request_id},
                           {"client", record.client}, {"method", record.method},
                           {"path", record.path},     {"status", record.status},
                           {"bytes", record.n_bytes}, {"seconds", record.seconds}};
    if (!record.error.empty()) object["error"] = record.error;
    return members(object);
}

/// What is not printable becomes "?", so that nobody writes lines of his own into the log.
std::string printable(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < ' ' || c == 0x7F) c = '?';
    return text;
}

std::string plain_of(const AccessRecord& record) {
    std::string text =
        fmt::format("{} {} {} {} {} {} bytes {:.1f} ms", record.request_id, record.client, printable(record.method),
                    printable(record.path), record.status, record.n_bytes, 1e3 * record.seconds);
    if (!record.error.empty()) text += ": " + printable(record.error);
    return text;
}

spdlog::level::level_enum level_of(const AccessRecord& record) {
    return record.status >= 500 ? spdlog::level::err : spdlog::level::info;
}

}  // namespace

ServerLog make_server_log(LogFormat format, LogRequests requests) {
    const bool as_json = format == LogFormat::json;
    const auto logger = std::make_shared<spdlog::logger>("anyrate", std::make_shared<spdlog::sinks::stderr_sink_mt>());
    logger->set_pattern(as_json ? R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l",%v})" : "%Y-%m-%d %H:%M:%S.%e %l %v",
                        spdlog::pattern_time_type::utc);
    logger->flush_on(spdlog::level::info);
    ServerLog log;
    log.line = [logger, as_json](const std::string& line) {
        logger->info("{}", as_json ? members({{"message", line}}) : printable(line));
    };
    if (requests == LogRequests::none) return log;
    log.from_status = requests == LogRequests::errors ? 400 : 0;
    log.request = [logger, as_json](const AccessRecord& record) {
        logger->log(level_of(record), "{}", as_json ? json_of(record) : plain_of(record));
    };
    return log;
}

}  // namespace anyrate
