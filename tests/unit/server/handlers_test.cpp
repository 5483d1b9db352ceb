#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/capture/image_io.h"
#include "core/error.h"
#include "core/mesh/mesh_io.h"
#include "proto/log_reader.h"
#include "server/http/service.h"
#include "server/jobs/thumbnails.h"
#include "server/store/directory_log_store.h"
#include "server/store/model_id.h"
#include "server/store/sha256.h"
#include "server/store/sqlite_catalog.h"
#include "server/store/zip_writer.h"
#include "tests/unit/server/small_model.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

/// The interface over an empty data directory, without a socket.
struct Fixture {
    TemporaryFolder folder;
    ModelStore store{folder.path()};
    SqliteCatalog catalog{store.catalog_file()};
    CaptureStore captures{folder.path()};
    HotLogs hot_logs;
    Metrics metrics;
    int n_queued = 0;
    Service service{.catalog = catalog,
                    .store = store,
                    .captures = captures,
                    .hot_logs = hot_logs,
                    .metrics = metrics,
                    .on_queued = [this] { ++n_queued; },
                    .on_removed = [](const std::string&) {},
                    .min_free_bytes = 0};
    Router router = make_router(service);

    Response get(const std::string& path, std::map<std::string, std::string> query = {}, Headers headers = {}) {
        return answer(router,
                      {.method = "GET", .path = path, .query = std::move(query), .headers = std::move(headers)});
    }
    Response post(const std::string& body, std::map<std::string, std::string> query = {}, std::string key = "",
                  const Headers& headers = {}) {
        const auto file = store.upload_file("upload");
        replace_file(file, as_bytes(body));
        Request request{.method = "POST", .path = "/v1/models", .query = std::move(query)};
        request.headers = headers;
        request.headers.add("content-type", "application/zip; x=y");
        if (!key.empty()) request.headers.add("Idempotency-Key", key);
        request.upload = Upload{file, body.size()};
        return answer(router, request);
    }
    /// A finished model, made by a job that takes no time.
    std::string finished_model(int n_batches = 4) {
        const std::string id = nlohmann::json::parse(text(post("PK\x03\x04")))["id"];
        const Lease lease = lease_of(catalog.claim_next({}).value());
        DirectoryLogStore logs(folder.path());
        run_job({.model_id = id, .capture = store.paths(id).capture, .options = {}}, small_job_steps(n_batches), logs,
                [](const WorkerMessage&) {}, {});
        catalog.finish(lease, ModelState::done, "", {});
        return id;
    }
    static std::string text(const Response& response) { return std::get<std::string>(response.body); }
    static std::vector<std::byte> file_bytes(const Response& response) {
        const auto& body = std::get<FileBody>(response.body);
        return read_at(*body.file, body.begin, static_cast<std::size_t>(body.n_bytes));
    }
};

}  // namespace

TEST_CASE("POST: a zip becomes a queued model with its options, and its capture is kept") {
    Fixture f;
    const Response response = f.post("PK\x03\x04 rest", {{"vertices", "3000"}});
    REQUIRE(response.status == 202);
    const auto model = nlohmann::json::parse(f.text(response));
    CHECK(response.headers.find("Location") == "/v1/models/" + model["id"].get<std::string>());
    CHECK(model["state"] == "queued");
    CHECK(model["options"]["vertices"] == 3000);
    CHECK(as_text(read_file(f.store.paths(model["id"]).capture)) == "PK\x03\x04 rest");
    CHECK(f.n_queued == 1);
}

TEST_CASE("POST: what is no zip or has bad options makes no model") {
    Fixture f;
    CHECK(f.post("GIF89a").status == 400);
    CHECK(f.post("").status == 400);
    CHECK(f.post("PK\x03\x04", {{"vertices", "many"}}).status == 400);
    CHECK(f.post("PK\x03\x04", {{"vertices", "500"}, {"coarse", "501"}}).status == 400);
    CHECK(f.post("PK\x03\x04", {{"sides", "5"}}).status == 400);
    CHECK(f.catalog.list(10, Catalog::from_newest).models.empty());
    CHECK(f.n_queued == 0);
}

TEST_CASE("POST: one Idempotency-Key makes one model, and belongs to one request") {
    Fixture f;
    const auto first = f.text(f.post("PK\x03\x04", {}, "key"));
    CHECK(f.text(f.post("PK\x03\x04", {}, "key")) == first);
    CHECK(f.post("PK\x03\x04 other", {}, "key").status == 422);
    CHECK(f.post("PK\x03\x04", {{"vertices", "500"}}, "key").status == 422);
    CHECK(f.catalog.list(10, Catalog::from_newest).models.size() == 1);
}

TEST_CASE("POST: a key that comes back with another capture of the same length is refused") {
    Fixture f;
    CHECK(f.post("PK\x03\x04 one", {}, "key").status == 202);
    CHECK(f.post("PK\x03\x04 two", {}, "key").status == 422);
    CHECK(f.post("PK\x03\x04 one", {}, "key").status == 202);
}

TEST_CASE("POST: a body that has not the digest which the request says makes no model") {
    Fixture f;
    const std::string body = "PK\x03\x04 as it was";
    const std::string digest = "sha-256=:" + to_base64(sha256(as_bytes(body))) + ":";
    CHECK(f.post(body, {}, "", {{"Content-Digest", digest}}).status == 202);
    CHECK(f.post("PK\x03\x04 as it is!", {}, "", {{"Content-Digest", digest}}).status == 422);
    CHECK(f.post(body, {}, "", {{"Content-Digest", "sha-256=:no:"}}).status == 400);
    CHECK(f.catalog.list(10, Catalog::from_newest).models.size() == 1);
}

TEST_CASE("List: pages go on where they ended, also when models go meanwhile") {
    Fixture f;
    std::vector<std::string> ids;
    for (int i = 0; i < 3; ++i) ids.push_back(nlohmann::json::parse(f.text(f.post("PK\x03\x04")))["id"]);
    const auto page = [&](const std::string& after) {
        std::map<std::string, std::string> query{{"limit", "1"}};
        if (!after.empty()) query["after"] = after;
        const Response response = f.get("/v1/models", query);
        return response.status == 200 ? nlohmann::json::parse(f.text(response)) : nlohmann::json(response.status);
    };
    const auto first = page("");
    CHECK(first["models"][0]["id"] == ids[2]);
    const std::string next = first["next"];
    const std::string cursor = next.substr(next.rfind('=') + 1);
    CHECK(page(ids[2]) == page(cursor));
    CHECK(answer(f.router, {.method = "DELETE", .path = "/v1/models/" + ids[2]}).status == 204);
    CHECK(page(cursor)["models"][0]["id"] == ids[1]);
    CHECK(page(ids[2]) == 404);
    CHECK(page("99999999999999999999") == 400);
    CHECK(page("-1") == 400);
}

TEST_CASE("Log: a budget gets a prefix that decodes to 0 to 2 vertices below it") {
    Fixture f;
    const std::string id = f.finished_model(4);  // 6 to 18 vertices
    const auto whole = f.file_bytes(f.get("/v1/models/" + id + "/log"));
    CHECK(whole == read_file(f.store.paths(id).sealed_log));
    for (std::uint32_t n = 6; n <= 18; ++n) {
        CAPTURE(n);
        const auto prefix = f.file_bytes(f.get("/v1/models/" + id + "/log", {{"vertices", std::to_string(n)}}));
        CHECK(std::equal(prefix.begin(), prefix.end(), whole.begin()));
        const auto got = static_cast<std::uint32_t>(decode_mesh(prefix, VertexBudget{n}).n_vertices());
        CHECK(got <= n);
        CHECK(got + 2 >= n);
    }
}

TEST_CASE("Log: ranges, conditions and caching of a sealed log") {
    Fixture f;
    const std::string log = "/v1/models/" + f.finished_model() + "/log";
    const Response whole = f.get(log);
    const std::string etag(whole.headers.find("ETag").value());
    CHECK(whole.headers.find("Content-Type") == "model/vnd.anyrate");
    CHECK(whole.headers.find("Cache-Control")->find("immutable") != std::string_view::npos);
    CHECK_FALSE(whole.headers.find("Content-Encoding"));

    const Response part = f.get(log, {}, {{"Range", "bytes=8-15"}, {"If-Range", etag}});
    CHECK(part.status == 206);
    CHECK(f.file_bytes(part).size() == 8);
    CHECK(f.get(log, {}, {{"Range", "bytes=8-15"}, {"If-Range", "\"old\""}}).status == 200);
    CHECK(f.get(log, {}, {{"If-None-Match", etag}}).status == 304);
    const Response outside = f.get(log, {}, {{"Range", "bytes=99999999-"}});
    CHECK(outside.status == 416);
    CHECK(outside.headers.find("Content-Range")->substr(0, 8) == "bytes */");
}

TEST_CASE("Log: two budgets with different bytes have different tags") {
    Fixture f;
    const std::string log = "/v1/models/" + f.finished_model() + "/log";
    CHECK(f.get(log, {{"vertices", "6"}}).headers.find("ETag") !=
          f.get(log, {{"vertices", "18"}}).headers.find("ETag"));
}

TEST_CASE("Log: what a failed model leaves of a preview is no log") {
    Fixture f;
    const std::string id = nlohmann::json::parse(f.text(f.post("PK\x03\x04")))["id"];
    const Lease lease = lease_of(f.catalog.claim_next({}).value());
    JobSteps steps = small_job_steps(1);
    steps.reconstruct = [](const Capture&, const ReconstructOptions&, ModelSink& sink, const ProgressFn&,
                           std::stop_token, RefinementJournal&) -> ReconstructResult {
        write_octahedron(*sink.preview());
        throw InputError("nothing to see");
    };
    DirectoryLogStore logs(f.folder.path());
    run_job({.model_id = id, .capture = f.store.paths(id).capture, .options = {}}, steps, logs,
            [](const WorkerMessage&) {}, {});
    CHECK(f.get("/v1/models/" + id + "/log").status == 200);  // while it runs
    f.catalog.finish(lease, ModelState::failed, "nothing to see", {});
    for (const char* what : {"/log", "/index", "/mesh.ply"}) {
        const Response response = f.get("/v1/models/" + id + what);
        CHECK(response.status == 404);
        CHECK(f.text(response).find("nothing to see") != std::string::npos);
    }
}

TEST_CASE("Index: binary and JSON hold the same rows") {
    Fixture f;
    const std::string index = "/v1/models/" + f.finished_model(3) + "/index";
    const SideIndex binary = decode_index(as_bytes(f.text(f.get(index))));
    const auto json = nlohmann::json::parse(f.text(f.get(index, {}, {{"Accept", "application/json"}})));
    REQUIRE(json["rows"].size() == binary.rows.size());
    for (std::size_t i = 0; i < binary.rows.size(); ++i) CHECK(json["rows"][i]["end"] == binary.rows[i].end);
}

TEST_CASE("Index: of the live form on request, with the rows that live clients count") {
    Fixture f;
    const std::string index = "/v1/models/" + f.finished_model(3) + "/index";
    const SideIndex live = decode_index(as_bytes(f.text(f.get(index, {{"form", "live"}}))));
    CHECK(live.rows.size() == 2 * 4);  // base, three batches, their colours
    CHECK(decode_index(as_bytes(f.text(f.get(index)))).rows.size() == 2 * 2);
    CHECK(f.get(index, {{"form", "sealed"}}).status == 400);
}

TEST_CASE("Mesh: the file is the decoded mesh") {
    Fixture f;
    const std::string id = f.finished_model();
    const auto log = read_file(f.store.paths(id).sealed_log);
    const auto expected = encode_mesh_file(decode_mesh(log, VertexBudget{12}), MeshFormat::obj);
    CHECK(f.text(f.get("/v1/models/" + id + "/mesh.obj", {{"vertices", "12"}})) == as_text(expected));
}

TEST_CASE("DELETE: a model and its files are gone") {
    Fixture f;
    const std::string id = f.finished_model();
    CHECK(answer(f.router, {.method = "DELETE", .path = "/v1/models/" + id}).status == 204);
    CHECK_FALSE(std::filesystem::exists(f.store.paths(id).folder));
    CHECK(f.get("/v1/models/" + id).status == 404);
}

TEST_CASE("List: pages hold every model once, newest first") {
    Fixture f;
    std::vector<std::string> made;
    for (int i = 0; i < 5; ++i) made.push_back(nlohmann::json::parse(f.text(f.post("PK\x03\x04")))["id"]);
    std::vector<std::string> listed;
    std::map<std::string, std::string> query{{"limit", "2"}};
    for (bool more = true; more;) {
        const auto page = nlohmann::json::parse(f.text(f.get("/v1/models", query)));
        for (const auto& model : page["models"]) listed.push_back(model["id"]);
        more = page.contains("next");
        query["after"] = listed.back();
    }
    CHECK(listed == std::vector<std::string>(made.rbegin(), made.rend()));
}

TEST_CASE("Page: a sentence with markup stays text") {
    Fixture f;
    f.post("PK\x03\x04");
    const ModelRecord model = f.catalog.claim_next({}).value();
    f.catalog.finish(lease_of(model), ModelState::failed, "<script>alert(1)</script>", {});
    const std::string page = f.text(f.get("/"));
    CHECK(page.find("<script>") == std::string::npos);
    CHECK(page.find("&lt;script&gt;") != std::string::npos);
}

TEST_CASE("Readiness: a full disk is told, and takes no upload") {
    Fixture f;
    f.service.min_free_bytes = UINT64_MAX;
    CHECK(f.get("/healthz").status == 200);
    CHECK(f.get("/readyz").status == 503);
    CHECK(f.post("PK\x03\x04").status == 507);
}

TEST_CASE("Readiness: a data directory in which nothing can be written is told") {
    Fixture f;
    std::filesystem::remove_all(f.folder.path() / "uploads");
    const Response told = f.get("/readyz");
    CHECK(told.status == 503);
    CHECK(f.text(told).find(f.folder.path().string()) == std::string::npos);
    std::filesystem::create_directory(f.folder.path() / "uploads");
    CHECK(f.get("/readyz").status == 200);
    CHECK(std::filesystem::is_empty(f.folder.path() / "uploads"));
}

TEST_CASE("Readiness: a catalog whose file is gone or is none any more is told") {
    for (const bool is_removed : {false, true}) {
        Fixture f;
        CHECK(f.get("/readyz").status == 200);
        const auto file = f.store.catalog_file();
        if (is_removed)
            std::filesystem::remove(file);
        else
            std::ofstream(file, std::ios::in | std::ios::out) << "overwritten by mistake";
        CHECK(f.get("/readyz").status == 503);
        CHECK(f.get("/healthz").status == 200);
    }
}

TEST_CASE("Viewer: its page and files are served with their types, as packed as the client takes them") {
    Fixture f;
    CHECK(f.text(f.get("/")).find("no model yet") != std::string::npos);
    CHECK(f.get("/assets/a.js").status == 404);
    const TemporaryFolder folder;
    std::filesystem::create_directories(folder.path() / "assets");
    replace_file(folder.path() / "index.html", as_bytes("<title>viewer</title>"));
    replace_file(folder.path() / "assets" / "a.js", as_bytes("plain"));
    replace_file(folder.path() / "assets" / "a.js.br", as_bytes("packed"));
    f.service.viewer = ViewerFiles::load(folder.path());
    for (const char* path : {"/", "/models/aaaaaaaaaaaaaaaaaaaaaaaaaa"}) {
        const Response page = f.get(path);
        CHECK(f.text(page) == "<title>viewer</title>");
        CHECK(page.headers.find("Content-Security-Policy")
                  .value_or("")
                  .starts_with("default-src 'none'; script-src 'self'"));
    }
    CHECK(f.text(f.get("/assets/a.js")) == "plain");
    const Response packed = f.get("/assets/a.js", {}, {{"Accept-Encoding", "gzip, deflate, br"}});
    CHECK(f.text(packed) == "packed");
    CHECK(packed.headers.find("Content-Encoding") == "br");
    CHECK(packed.headers.find("Content-Type") == "text/javascript; charset=utf-8");
    CHECK(f.text(f.get("/assets/a.js", {}, {{"Accept-Encoding", "brotli"}})) == "plain");
    CHECK(f.get("/assets/..%2Findex.html").status == 404);
    CHECK(f.get("/assets/b.js").status == 404);
}

TEST_CASE("Photographs: each comes out of the zip as it went in, also from a folder of it, others unpacked or not") {
    Fixture f;
    const TemporaryFolder folder;
    const auto zip = folder.path() / "capture.zip";
    using namespace std::string_literals;  // keep the zeros
    const std::string png = "\x89PNG\r\n\x1A\n\0\0\0\rIHDR\0\0\0\4\0\0\0\3\b\2\0\0\0rest"s;
    {
        ZipWriter writer(zip);
        const auto camera = [](const std::string& file) {
            return R"({"file":")" + file +
                   R"(","K":[[4,0,2],[0,4,1.5],[0,0,1]],"R":[[1,0,0],[0,1,0],[0,0,1]],"t":[0,0,2]})";
        };
        writer.add("box/images/a.png", as_bytes(png));
        writer.add("box/cameras.json", as_bytes(R"({"pixel_center":[0.5,0.5],"images":[)" + camera("images/a.png") +
                                                "," + camera("images/gone.png") + "]}"));
        writer.finish();
    }
    const std::string id = nlohmann::json::parse(f.text(f.post(std::string(as_text(read_file(zip))))))["id"];
    CHECK(f.text(f.get("/v1/models/" + id + "/photographs/0")) == png);
    CHECK(f.get("/v1/models/" + id + "/photographs/0").headers.find("Content-Type") == "image/png");
    CHECK(f.get("/v1/models/" + id + "/photographs/1").status == 404);
    CHECK(f.get("/v1/models/" + id + "/photographs/2").status == 404);
    CHECK(nlohmann::json::parse(f.text(f.get("/v1/models/" + id + "/cameras")))["cameras"].size() == 2);
}

TEST_CASE("Thumbnails: a small JPEG of each photograph is there once a worker has loaded them") {
    Fixture f;
    const std::string id = nlohmann::json::parse(f.text(f.post("PK\x03\x04")))["id"];
    const std::string thumbnails = "/v1/models/" + id + "/thumbnails/";
    CHECK(f.get(thumbnails + "0").status == 404);
    JobSteps steps = small_job_steps(1);
    steps.load = [](const std::filesystem::path&) {
        Capture capture;
        capture.views.resize(2);
        capture.views[0].image = ColourImage(4000, 3000, {200, 40, 40});
        capture.views[1].image = ColourImage(90, 160);
        return capture;
    };
    DirectoryLogStore logs(f.folder.path());
    const ModelPaths paths = f.store.paths(id);
    run_job({.model_id = id, .capture = paths.capture, .thumbnails = paths.thumbnails, .options = {}}, steps, logs,
            [](const WorkerMessage&) {}, {});
    const std::vector<std::pair<int, int>> sizes{{thumbnail_side, thumbnail_side * 3 / 4}, {90, 160}};
    for (std::size_t i = 0; i < sizes.size(); ++i) {
        const Response response = f.get(thumbnails + std::to_string(i));
        CHECK(response.headers.find("Content-Type") == "image/jpeg");
        const std::string body = f.text(response);
        const std::vector<std::uint8_t> bytes(body.begin(), body.end());
        const ImageHeader header = read_image_header(bytes).value();
        CHECK(std::pair(header.width, header.height) == sizes[i]);
        const Rgb8 pixel = decode_colour(bytes, header)(40, 40);
        CHECK(pixel.r > (i == 0 ? 190 : -1));
        CHECK(pixel.r < (i == 0 ? 210 : 10));
    }
    for (const char* number : {"2", "x", "-1"}) CHECK(f.get(thumbnails + number).status == 404);
}

TEST_CASE("Photographs: of a capture that is none, 404 says why") {
    Fixture f;
    const std::string id = nlohmann::json::parse(f.text(f.post("PK\x03\x04 rest")))["id"];
    for (const char* rest : {"/cameras", "/photographs/0", "/photographs/x"})
        CHECK(f.get("/v1/models/" + id + rest).status == 404);
    CHECK(f.text(f.get("/v1/models/" + id + "/cameras")).find("has no photographs to show") != std::string::npos);
}
