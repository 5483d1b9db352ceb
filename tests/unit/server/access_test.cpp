#include <doctest/doctest.h>

#include <string>

#include "core/error.h"
#include "server/http/bearer.h"
#include "server/http/cors.h"
#include "server/http/digest.h"
#include "server/http/problem.h"
#include "server/http/request_id.h"
#include "server/http/tokens.h"
#include "server/store/file.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

/// The status that a request gets, 200 if it may pass.
int status_of(const AccessRules& rules, const std::string& method, const std::string& field,
              const std::string& path = "/v1/models") {
    Request request{.method = method, .path = path};
    if (!field.empty()) request.headers.add("authorization", field);
    try {
        expect_authorized(request, rules);
        return 200;
    } catch (const HttpProblem& problem) {
        return problem.status;
    }
}

}  // namespace

TEST_CASE("Bearer: writing needs exactly the token, reading none") {
    Tokens tokens({}, "abc"), none({}, "");
    CHECK(status_of({tokens, false, false}, "POST", "Bearer abc") == 200);
    CHECK(status_of({tokens, false, false}, "GET", "") == 200);
    CHECK(status_of({none, false, false}, "POST", "") == 200);
    for (const char* field : {"", "Bearer", "Bearer ", "Bearer ab", "Bearer abcd", "Bearer abd", "abc", "Basic abc"})
        CHECK_MESSAGE(status_of({tokens, false, false}, "DELETE", field) == 401, field);
}

TEST_CASE("Bearer: a private server tells nobody without a token more than that it is there") {
    Tokens tokens({}, "abc");
    const AccessRules rules{tokens, true, false};
    CHECK(status_of(rules, "GET", "") == 401);
    CHECK(status_of(rules, "GET", "Bearer abc") == 200);
    CHECK(status_of(rules, "GET", "", "/healthz") == 200);
    Tokens none({}, "");
    CHECK(status_of({none, true, false}, "GET", "") == 401);
}

TEST_CASE("Bearer: the viewer's files are open on a private server, the list of models in their place is not") {
    Tokens tokens({}, "abc");
    for (const char* path : {"/", "/models/aaaa", "/assets/index.js"}) {
        CHECK_MESSAGE(status_of({tokens, true, false, true}, "GET", "", path) == 200, path);
        CHECK_MESSAGE(status_of({tokens, true, false, false}, "GET", "", path) == 401, path);
        CHECK_MESSAGE(status_of({tokens, true, false, true}, "POST", "", path) == 401, path);
    }
    for (const char* path : {"/v1/models", "/v1/models/aaaa/log", "/metrics", "/openapi.json"})
        CHECK_MESSAGE(status_of({tokens, true, false, true}, "GET", "", path) == 401, path);
}

TEST_CASE("Bearer: a WebSocket may offer its token as a protocol, nothing else may") {
    Tokens tokens({}, "abc");
    const AccessRules rules{tokens, true, false};
    const auto status = [&](const std::string& path, const std::string& protocols) {
        Request request{.path = path};
        request.headers.add("Sec-WebSocket-Protocol", protocols);
        try {
            expect_authorized(request, rules);
            return 200;
        } catch (const HttpProblem& problem) {
            return problem.status;
        }
    };
    const std::string live = "/v1/models/aaaa/live";
    CHECK(status(live, "anyrate.live, anyrate.bearer.abc") == 200);
    CHECK(status(live, "anyrate.bearer.abc,anyrate.live") == 200);
    for (const char* protocols :
         {"", ",", "anyrate.live", "anyrate.bearer.", "anyrate.bearer.ab", "anyrate.bearer.abcd", "abc"})
        CHECK_MESSAGE(status(live, protocols) == 401, protocols);
    CHECK(status("/v1/models/aaaa/log", "anyrate.live, anyrate.bearer.abc") == 401);
}

TEST_CASE("Bearer: beyond loopback nobody writes once the last token is revoked") {
    Tokens none({}, "");
    CHECK(status_of({none, false, true}, "POST", "") == 401);
    CHECK(status_of({none, false, true}, "POST", "Bearer ") == 401);
}

TEST_CASE("Tokens: a token of read scope reads and does not write") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "tokens.json";
    const std::string reader = new_token(), writer = new_token();
    write_tokens(
        file, {{"reader", Scope::read, sha256(as_bytes(reader))}, {"writer", Scope::write, sha256(as_bytes(writer))}});
    Tokens tokens(file, "");
    const AccessRules rules{tokens, true, false};
    CHECK(status_of(rules, "GET", "Bearer " + reader) == 200);
    CHECK(status_of(rules, "PUT", "Bearer " + reader) == 403);
    CHECK(status_of(rules, "PUT", "Bearer " + writer) == 200);
    CHECK(status_of(rules, "GET", "Bearer " + writer) == 200);
    CHECK(as_text(read_file(file)).find(writer) == std::string_view::npos);  // only its hash is kept
}

TEST_CASE("Tokens: fresh ones differ and are long") {
    const std::string one = new_token();
    CHECK(one.size() == 43);
    CHECK(one != new_token());
}

TEST_CASE("Tokens: a file that is none is refused with its name") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "tokens.json";
    for (const char* text : {"", "[]", R"({"tokens":[{"name":"a","scope":"all","sha256":""}]})",
                             R"({"tokens":[{"name":"a","scope":"read","sha256":"12"}]})"}) {
        replace_file(file, as_bytes(text));
        CHECK_THROWS_WITH_AS(read_tokens(file), doctest::Contains("tokens.json"), InputError);
    }
    CHECK(read_tokens(folder.path() / "none").empty());
}

TEST_CASE("SHA-256: the digest of abc is that of FIPS 180-4") {
    const Sha256 digest = sha256(as_bytes("abc"));
    CHECK(to_hex(digest) == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    CHECK(to_base64(digest) == "ungWv48Bz+pBQUDeXa4iI7ADYaOWF3qctBD/YfIAFa0=");
}

TEST_CASE("Digest: both header fields say the same, other algorithms are passed over") {
    const std::string abc = to_base64(sha256(as_bytes("abc")));
    const auto digest = [](const char* name, const std::string& value) {
        Request request;
        request.headers.add(name, value);
        return digest_of_request(request);
    };
    CHECK(digest("Content-Digest", "sha-256=:" + abc + ":") == sha256(as_bytes("abc")));
    CHECK(digest("content-digest", "sha-512=:AA==:, sha-256=:" + abc + ":") == sha256(as_bytes("abc")));
    CHECK(digest("Digest", "SHA-256=" + abc) == sha256(as_bytes("abc")));
    CHECK_FALSE(digest("Digest", "md5=xyz"));
    CHECK_FALSE(digest_of_request({}));
    for (const std::string& bad : {"sha-256=" + abc, std::string("sha-256=::"), "sha-256=:" + abc.substr(1) + ":",
                                   std::string("sha-256=:") + std::string(44, '!') + ":"})
        CHECK_THROWS_AS(digest("Content-Digest", bad), HttpProblem);
}

TEST_CASE("CORS: only pages of allowed origins may read answers") {
    const std::vector<std::string> origins = {"https://a.example"};
    const auto allowed = [](const std::string& origin, const std::vector<std::string>& list) {
        Request request;
        request.headers.add("Origin", origin);
        Response response;
        allow_origin(response, request, list);
        return std::string(response.headers.find("Access-Control-Allow-Origin").value_or(""));
    };
    CHECK(allowed("https://a.example", origins) == "https://a.example");
    CHECK(allowed("https://a.example.org", origins) == "");
    CHECK(allowed("https://b.example", {"*"}) == "*");
    CHECK(allowed("https://a.example", {}) == "");
}

TEST_CASE("CORS: a preflight is answered for allowed origins alone") {
    Request request{.method = "OPTIONS", .path = "/v1/models"};
    request.headers.add("Origin", "https://a.example");
    CHECK_FALSE(answer_preflight(request, {"*"}));  // a plain OPTIONS
    request.headers.add("Access-Control-Request-Method", "PUT");
    CHECK_FALSE(answer_preflight(request, {"https://b.example"}));
    const auto response = answer_preflight(request, {"https://a.example"});
    REQUIRE(response);
    CHECK(response->status == 204);
    CHECK(response->headers.find("Access-Control-Allow-Headers")->find("Content-Digest") != std::string_view::npos);
}

TEST_CASE("Request id: a client's own is kept if it is harmless, else there is a fresh one") {
    const auto id = [](const std::string& given) {
        Request request;
        request.headers.add("X-Request-Id", given);
        return request_id_of(request);
    };
    CHECK(id("job-7_a") == "job-7_a");
    for (const std::string& bad : {std::string(), std::string("a b"), std::string("a\"b"), std::string(65, 'a')})
        CHECK(id(bad) != bad);
    CHECK(request_id_of({}) != request_id_of({}));
}
