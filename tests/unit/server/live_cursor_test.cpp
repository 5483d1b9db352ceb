#include "server/http/live_cursor.h"

#include <doctest/doctest.h>

#include <utility>
#include <vector>

#include "proto/header.h"
#include "proto/log_reader.h"
#include "server/http/log_bytes.h"
#include "server/jobs/durable_sink.h"
#include "tests/unit/server/small_model.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

struct Logs {
    TemporaryFolder folder;
    std::filesystem::path live = folder.path() / "log.live", sealed = folder.path() / "model.arl";

    LogView view() const { return open_live_log(sealed, live).value(); }
};

std::vector<std::byte> drain(LiveCursor& cursor, const LogView& log, std::size_t message_bytes) {
    std::vector<std::byte> all;
    const auto bytes = LogBytes::read(log, nullptr);
    while (const auto message = cursor.next_message(log, message_bytes))
        for (const auto part : bytes->slice(message->begin, message->end))
            all.insert(all.end(), part.begin(), part.end());
    return all;
}

}  // namespace

TEST_CASE("Live cursor: of a sealed model it counts the frames that it counted before") {
    Logs logs;
    DurableSink sink(7, logs.live, [](const RatePoint&) {});
    write_small_model(sink, 5);
    LiveCursor before(0, UINT32_MAX);
    before.hello(logs.view());
    auto bytes = drain(before, logs.view(), 1);
    CHECK_FALSE(before.is_complete(logs.view()));  // more might come
    const std::size_t n_live_rows = logs.view().rows.size();
    sink.seal(logs.sealed);
    CHECK(open_log(logs.sealed, logs.live)->rows.size() < n_live_rows);  // packets were joined

    LiveCursor again(before.next_sequence(), UINT32_MAX);
    CHECK(again.hello(logs.view()).find("\"sealed\":true") != std::string::npos);
    const auto rest = drain(again, logs.view(), 1);
    CHECK(again.is_complete(logs.view()));
    bytes.insert(bytes.end(), rest.begin(), rest.end());
    CHECK(read_layout(bytes).ended);
    CHECK(verify_log(bytes) == n_live_rows + 1);
}

TEST_CASE("Live cursor: without its live file a model is sent as its sealed form is packed") {
    Logs logs;
    DurableSink sink(7, logs.live, [](const RatePoint&) {});
    write_small_model(sink, 5);
    sink.seal(logs.sealed);
    std::filesystem::remove(logs.live);
    LiveCursor cursor(0, UINT32_MAX);
    cursor.hello(logs.view());
    const auto bytes = drain(cursor, logs.view(), 16384);
    CHECK_FALSE(read_layout(bytes).header.sealed);
    CHECK(verify_log(bytes) == open_log(logs.sealed, logs.live)->rows.size() + 1);
}

TEST_CASE("Live cursor: a sealed log and one that is watched while it grows give the same bytes") {
    Logs logs;
    LiveCursor watching(0, UINT32_MAX);
    std::vector<std::byte> watched;
    bool greeted = false;
    DurableSink sink(7, logs.live, [&](const RatePoint&) {
        if (!std::exchange(greeted, true)) watching.hello(logs.view());
        const auto news = drain(watching, logs.view(), 1);
        watched.insert(watched.end(), news.begin(), news.end());
        CHECK_FALSE(watching.is_complete(logs.view()));
    });
    write_small_model(sink, 5);
    sink.seal(logs.sealed);
    const auto rest = drain(watching, logs.view(), 1);
    watched.insert(watched.end(), rest.begin(), rest.end());
    CHECK(watching.is_complete(logs.view()));

    LiveCursor late(0, UINT32_MAX);
    late.hello(logs.view());
    CHECK(drain(late, logs.view(), 16384) == watched);
    CHECK(read_layout(watched).ended);
    CHECK(decode_mesh(watched, VertexBudget{UINT32_MAX}).vertices ==
          decode_mesh(read_file(logs.sealed), VertexBudget{UINT32_MAX}).vertices);
}

TEST_CASE("Live cursor: two connections that meet at any frame give what one gives") {
    Logs logs;
    DurableSink sink(7, logs.live, [](const RatePoint&) {});
    write_small_model(sink, 5);
    sink.seal(logs.sealed);
    const LogView log = logs.view();
    LiveCursor whole(0, UINT32_MAX);
    whole.hello(log);
    const auto expected = drain(whole, log, 16384);
    for (std::uint32_t from = 1; from <= log.rows.size(); ++from) {
        LiveCursor second(from, UINT32_MAX);
        second.hello(log);
        const auto tail = drain(second, log, 16384);
        const std::size_t met = header_size + log.rows[from - 1].end;
        CHECK(tail == std::vector<std::byte>(expected.begin() + static_cast<std::ptrdiff_t>(met), expected.end()));
    }
}

TEST_CASE("Live cursor: a budget is complete at its prefix, and a raise goes on from there") {
    Logs logs;
    DurableSink sink(7, logs.live, [](const RatePoint&) {});
    write_small_model(sink, 5);
    sink.seal(logs.sealed);
    const LogView log = logs.view();
    LiveCursor cursor(0, 9);
    cursor.hello(log);
    auto bytes = drain(cursor, log, 16384);
    CHECK(cursor.is_complete(log));
    CHECK(decode_mesh(bytes, VertexBudget{9}).n_vertices() == 9);
    cursor.set_max_vertices(UINT32_MAX);
    CHECK_FALSE(cursor.is_complete(log));
    const auto rest = drain(cursor, log, 16384);
    bytes.insert(bytes.end(), rest.begin(), rest.end());
    CHECK(decode_mesh(bytes, VertexBudget{UINT32_MAX}).n_vertices() == 21);
}

TEST_CASE("Live cursor: a preview gives way to the log, which starts anew") {
    Logs logs;
    std::vector<RatePoint> previews;
    DurableSink sink(
        7, logs.live, [](const RatePoint&) {}, [&](const RatePoint& point) { previews.push_back(point); });
    REQUIRE(sink.preview() != nullptr);
    write_octahedron(*sink.preview());
    const LogView preview = logs.view();
    REQUIRE(previews.size() == 1);
    CHECK(previews[0].n_vertices == 6);
    CHECK(previews[0].n_bytes == preview.size);

    LiveCursor cursor(0, 6);
    cursor.hello(preview);
    const auto picture = drain(cursor, preview, 16384);
    CHECK(decode_mesh(picture, VertexBudget{UINT32_MAX}).n_vertices() == 6);
    CHECK_FALSE(cursor.is_complete(preview));  // whatever the budget: it is not the model

    write_small_model(sink, 5);
    sink.seal(logs.sealed);
    const LogView log = logs.view();
    CHECK(log.log_id != preview.log_id);
    CHECK(cursor.hello(log).find("\"next_sequence\":0") != std::string::npos);
    cursor.set_max_vertices(UINT32_MAX);
    const auto model = drain(cursor, log, 16384);
    CHECK(decode_mesh(model, VertexBudget{UINT32_MAX}).n_vertices() == 21);
    CHECK(cursor.is_complete(log));
    // Who still reads the preview has its file.
    CHECK(read_at(*preview.file, 0, static_cast<std::size_t>(preview.size)) == picture);
}

TEST_CASE("Live cursor: without a listener there is no preview") {
    Logs logs;
    DurableSink sink(7, logs.live, [](const RatePoint&) {});
    CHECK(sink.preview() == nullptr);
}

TEST_CASE("Live cursor: header and base are messages of their own, what follows is coalesced") {
    Logs logs;
    DurableSink sink(7, logs.live, [](const RatePoint&) {});
    write_small_model(sink, 5);
    const LogView log = logs.view();
    REQUIRE(log.rows.size() > 3);
    LiveCursor cursor(0, UINT32_MAX);
    cursor.hello(log);
    CHECK(cursor.next_message(log, 1 << 20)->end == header_size);
    CHECK(cursor.next_message(log, 1 << 20)->end == log.frames_begin + log.rows[0].end);
    CHECK(cursor.next_message(log, 1 << 20)->end == log.frames_begin + log.rows.back().end);
}
