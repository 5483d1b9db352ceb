#include "server/http/hot_path.h"

#include <doctest/doctest.h>

#include <string>

#include "server/jobs/durable_sink.h"
#include "tests/unit/server/small_model.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

const std::string id(26, 'a');

struct Fixture {
    TemporaryFolder folder;
    HotLogs logs;
    std::uint64_t size = 0;
    std::string header;

    Fixture() {
        const auto live = folder.path() / "log.live", sealed = folder.path() / "model.arl";
        DurableSink sink(7, live, [](const RatePoint&) {});
        write_small_model(sink, 5);
        sink.seal(sealed);
        LogView view = open_log(sealed, live).value();
        size = view.size;
        logs.keep(id, std::move(view), "\"tag\"", logs.generation());
    }
    std::optional<HotAnswer> ask(const std::string& fields, const std::string& model = id) {
        return answer_hot("GET /v1/models/" + model + "/log HTTP/1.1\r\n" + fields + "\r\n", logs, header);
    }
};

}  // namespace

TEST_CASE("Hot path: a whole log and a range of it are answered from memory") {
    Fixture f;
    const auto whole = f.ask("Host: x\r\nConnection: keep-alive\r\n");
    REQUIRE(whole);
    CHECK(whole->status == 200);
    CHECK(whole->body.n_bytes == f.size);
    CHECK(f.header.find("ETag: \"tag\"\r\n") != std::string::npos);
    const auto range = f.ask("Host: x\r\nrange: bytes=10-19\r\n");
    REQUIRE(range);
    CHECK(range->status == 206);
    CHECK(range->body.begin == 10);
    CHECK(range->body.n_bytes == 10);
    CHECK(f.header.find("Content-Range: bytes 10-19/" + std::to_string(f.size) + "\r\n") != std::string::npos);
}

TEST_CASE("Hot path: every request that asks for more is left to the general one") {
    Fixture f;
    for (const char* fields :
         {"Content-Length: 3\r\n", "Transfer-Encoding: chunked\r\n", "Connection: close\r\n",
          "If-None-Match: \"tag\"\r\n", "If-Range: \"tag\"\r\n", "Origin: https://a.example\r\n", "X-Request-Id: a\r\n",
          "Range: bytes=999999-\r\n", "Range: bytes=0-1,3-4\r\n", "Range: bytes=0-1\r\nRange: bytes=3-4\r\n",
          "Host : x\r\n", "no colon\r\n", " folded\r\n", "Authorization: Bearer x\r\n"})
        CHECK_MESSAGE(!f.ask("Host: x\r\n" + std::string(fields)), fields);
    CHECK_FALSE(f.ask("Accept: */*\r\n"));
    CHECK_FALSE(f.ask("Host: x\r\nHost: y\r\n"));
    CHECK_FALSE(f.ask("Host: x\r\n", std::string(26, 'b')));
    CHECK_FALSE(f.ask("Host: x\r\n", std::string(26, '.')));
    const std::string request = "GET /v1/models/" + id + "/log HTTP/1.1\r\nHost: x\r\n\r\n";
    for (std::size_t n = 0; n < request.size(); ++n) CHECK_FALSE(answer_hot(request.substr(0, n), f.logs, f.header));
    CHECK(answer_hot(request + "GET", f.logs, f.header)->n_request_bytes == request.size());
}
