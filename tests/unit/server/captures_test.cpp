#include <doctest/doctest.h>

#include <string>

#include "server/http/capture_verdict.h"
#include "server/http/problem.h"
#include "server/store/capture_store.h"
#include "server/store/file.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

const std::string id(26, 'a');

std::filesystem::path upload(const TemporaryFolder& folder, const std::string& text) {
    const auto file = folder.path() / "upload";
    replace_file(file, as_bytes(text));
    return file;
}

}  // namespace

TEST_CASE("Capture store: what arrived is listed by path, also after a restart") {
    const TemporaryFolder folder;
    {
        CaptureStore store(folder.path());
        store.create(id, Timestamp(std::chrono::milliseconds(5)));
        CHECK(store.put(id, {.path = "images/b.png", .n_bytes = 1}, upload(folder, "b")));
        CHECK(store.put(id, {.path = "images/a.png", .n_bytes = 2}, upload(folder, "aa")));
        CHECK(store.put(id, {.path = "images/b.png", .n_bytes = 3}, upload(folder, "bbb")));
        CHECK_FALSE(store.put(std::string(26, 'b'), {.path = "images/b.png"}, upload(folder, "b")));
    }
    CaptureStore store(folder.path());
    const auto capture = store.create(id, {});  // it is there already, with what it has
    REQUIRE(capture.files.size() == 2);
    CHECK(capture.files[0].path == "images/a.png");
    CHECK(capture.n_bytes() == 5);
    CHECK(capture.created == Timestamp(std::chrono::milliseconds(5)));
    CHECK(as_text(read_file(folder.path() / "captures" / id / "files/images/b.png")) == "bbb");
}

TEST_CASE("Capture store: old captures go, younger ones stay") {
    const TemporaryFolder folder;
    CaptureStore store(folder.path());
    const std::string young(26, 'b');
    store.create(id, Timestamp(std::chrono::milliseconds(5)));
    store.create(young, Timestamp(std::chrono::milliseconds(50)));
    CHECK(store.remove_older(Timestamp(std::chrono::milliseconds(10))) == 1);
    CHECK_FALSE(store.find(id));
    CHECK(store.find(young));
    CHECK_FALSE(store.find("../etc"));
}

TEST_CASE("Capture path: only the three kinds of files, and none that leads elsewhere") {
    CHECK(expect_capture_path("images/000.png") == "images/000.png");
    CHECK(expect_capture_path("./masks//a b.jpg") == "masks/a b.jpg");
    CHECK(expect_capture_path("cameras.json") == "cameras.json");
    for (const std::string& path :
         {std::string(), std::string("/images/a.png"), std::string("images/../../a.png"), std::string("images"),
          std::string("images/a/b.png"), std::string("photo.png"), std::string("images/a.json"),
          std::string("a\\b.json"), "images/" + std::string(300, 'a')})
        CHECK_THROWS_AS_MESSAGE(expect_capture_path(path), HttpProblem, path);
}

TEST_CASE("Verdict: an image says what it is, what is none says so") {
    CHECK(inspect_capture_file("images/a.png", as_bytes("GIF89a")).fault.find("PNG or JPEG") != std::string::npos);
    CHECK_FALSE(inspect_capture_file("images/a.png", {}).fault.empty());
    CHECK_FALSE(inspect_capture_file("cameras.json", as_bytes("{}")).fault.empty());
}

TEST_CASE("Verdict: files that cameras.json names and that are not here are missing") {
    const std::string camera = R"("K": [[1,0,0],[0,1,0],[0,0,1]], "R": [[1,0,0],[0,1,0],[0,0,1]], "t": [0,0,0]})";
    const std::string cameras = R"({"images": [{"file": "images/a.png", "width": 5, )" + camera +
                                R"(, {"file": "images/b.png", )" + camera + "]}";
    CaptureRecord capture{
        .id = id, .created = {}, .files = {{.path = "images/a.png", .kind = "png", .width = 4, .height = 4}}};
    const CaptureVerdict verdict = judge_capture(capture, cameras);
    CHECK(verdict.missing == std::vector<std::string>{"images/b.png"});
    REQUIRE(verdict.refused.size() == 1);
    CHECK(verdict.refused[0].second.find("4 x 4") != std::string::npos);
    CHECK(judge_capture(capture, std::nullopt).missing == std::vector<std::string>{"cameras.json"});
}
