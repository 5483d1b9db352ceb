#include "server/http/hot_logs.h"

#include <doctest/doctest.h>

#include <string>

#include "server/http/log_bytes.h"
#include "server/jobs/durable_sink.h"
#include "tests/unit/server/small_model.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

struct SealedLog {
    TemporaryFolder folder;
    std::filesystem::path live = folder.path() / "log.live", sealed = folder.path() / "model.arl";

    SealedLog() {
        DurableSink sink(7, live, [](const RatePoint&) {});
        write_small_model(sink, 5);
        sink.seal(sealed);
    }
    LogView view() const { return open_log(sealed, live).value(); }
};

}  // namespace

TEST_CASE("Hot logs: a log that was kept is found with its bytes, until its model is removed") {
    const SealedLog log;
    HotLogs hot;
    CHECK(hot.find("a") == nullptr);
    hot.keep("a", log.view(), "\"tag\"", hot.generation());
    REQUIRE(hot.find("a") != nullptr);
    CHECK(*hot.find("a")->bytes == read_file(log.sealed));
    hot.forget("a");
    CHECK(hot.find("a") == nullptr);
}

TEST_CASE("Hot logs: a model that is removed while its log is read is not kept") {
    const SealedLog log;
    HotLogs hot;
    const auto generation = hot.generation();
    hot.forget("a");
    CHECK(hot.keep("a", log.view(), "\"tag\"", generation) != nullptr);
    CHECK(hot.find("a") == nullptr);
}

TEST_CASE("Hot logs: the one that was not asked for the longest goes when memory is short") {
    const SealedLog log;
    const std::uint64_t size = log.view().size;
    HotLogs hot(4 * size);
    for (int i = 0; i < 4; ++i) hot.keep(std::to_string(i), log.view(), "\"tag\"", hot.generation());
    CHECK(hot.find("0") != nullptr);
    hot.keep("4", log.view(), "\"tag\"", hot.generation());
    CHECK(hot.find("0") != nullptr);
    CHECK(hot.find("1") == nullptr);
    CHECK(hot.find("4") != nullptr);
}

TEST_CASE("Hot logs: a long log is kept open, not in memory") {
    const SealedLog log;
    HotLogs hot(log.view().size);
    CHECK(hot.keep("a", log.view(), "\"tag\"", hot.generation())->bytes == nullptr);
    CHECK(hot.find("a") != nullptr);
}

TEST_CASE("Log bytes: those of a log that grows are those that it has in the end, in any slices") {
    const TemporaryFolder folder;
    const auto live = folder.path() / "log.live", sealed = folder.path() / "model.arl";
    std::shared_ptr<const LogBytes> bytes;
    DurableSink sink(7, live,
                     [&](const RatePoint&) { bytes = LogBytes::read(open_live_log(sealed, live).value(), bytes); });
    write_small_model(sink, 40);
    const LogView log = open_live_log(sealed, live).value();
    bytes = LogBytes::read(log, bytes);
    const auto expected = read_at(*log.file, 0, static_cast<std::size_t>(log.size));
    for (const std::uint64_t step : {std::uint64_t(1), std::uint64_t(7), std::uint64_t(100), log.size}) {
        std::vector<std::byte> joined;
        for (std::uint64_t at = 0; at < log.size; at += step)
            for (const auto part : bytes->slice(at, std::min(at + step, log.size)))
                joined.insert(joined.end(), part.begin(), part.end());
        CHECK(joined == expected);
    }
    CHECK(LogBytes::read(log, bytes) == bytes);  // nothing new, nothing read
}
