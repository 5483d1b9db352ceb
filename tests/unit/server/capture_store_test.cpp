#include "server/store/capture_store.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "server/store/file.h"
#include "server/store/model_id.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

struct Fixture {
    TemporaryFolder folder;
    CaptureStore store{folder.path()};

    std::string capture() { return store.create(new_model_id(), {}).id; }
    /// Brings a file that has such bytes; the record says so by its digest.
    bool put(const std::string& id, const std::string& path, const std::string& bytes) {
        const auto upload = folder.path() / new_model_id();
        replace_file(upload, as_bytes(bytes));
        return store.put(id, {.path = path, .n_bytes = bytes.size(), .sha256 = bytes}, upload);
    }
    std::string bytes(const std::string& id, const std::string& path) {
        std::string found;
        store.with_files(id, [&](const std::filesystem::path& files) { found = as_text(read_file(files / path)); });
        return found;
    }
};

}  // namespace

TEST_CASE("Captures: what has arrived is listed, also after a restart") {
    Fixture f;
    const std::string id = f.capture();
    CHECK(f.put(id, "images/b.png", "two"));
    CHECK(f.put(id, "images/a.png", "one"));
    CHECK(f.put(id, "images/b.png", "three"));
    const auto listed = CaptureStore(f.folder.path()).find(id).value().files;
    REQUIRE(listed.size() == 2);
    CHECK(listed[0].path == "images/a.png");
    CHECK(listed[1].sha256 == "three");
    CHECK(f.bytes(id, "images/b.png") == "three");
    CHECK_FALSE(f.put(new_model_id(), "images/a.png", "one"));
}

TEST_CASE("Captures: files that arrive at the same time are all listed") {
    Fixture f;
    const std::vector<std::string> ids{f.capture(), f.capture()};
    std::vector<std::jthread> clients;
    for (int i = 0; i < 8; ++i)
        clients.emplace_back([&, i] {
            for (int k = 0; k < 5; ++k)
                f.put(ids[static_cast<std::size_t>(i % 2)], "images/" + std::to_string(10 * i + k) + ".png", "x");
        });
    clients.clear();
    for (const std::string& id : ids) CHECK(f.store.find(id)->files.size() == 20);
}

TEST_CASE("Captures: one that is in use holds up no other, and can itself be looked at") {
    Fixture f;
    const std::string used = f.capture(), other = f.capture();
    f.put(used, "images/a.png", "one");
    std::promise<void> begun, let_go;
    std::jthread user([&] {
        f.store.with_files(used, [&](const std::filesystem::path&) {
            begun.set_value();
            let_go.get_future().wait();
        });
    });
    begun.get_future().wait();
    CHECK(f.put(other, "images/a.png", "two"));  // all of this would wait for ever
    CHECK(f.store.find(used)->files.size() == 1);
    CHECK(f.store.remove(other));
    f.capture();
    auto replaced = std::async(std::launch::async, [&] { return f.put(used, "images/a.png", "three"); });
    CHECK(f.bytes(used, "images/a.png") == "one");  // the change waits
    let_go.set_value();
    CHECK(replaced.get());
    CHECK(f.bytes(used, "images/a.png") == "three");
}

TEST_CASE("Captures: old ones go, and what a crash left of one") {
    Fixture f;
    const std::string old = f.store.create(new_model_id(), Timestamp(std::chrono::milliseconds(5))).id;
    const std::string young = f.store.create(new_model_id(), Timestamp(std::chrono::milliseconds(50))).id;
    std::filesystem::create_directories(f.folder.path() / "captures" / new_model_id() / "files");
    CHECK(f.store.remove_older(Timestamp(std::chrono::milliseconds(20))) == 2);
    CHECK_FALSE(f.store.find(old));
    CHECK(f.store.find(young));
}

TEST_CASE("Captures: pages hold every capture once, in the order of their ids") {
    Fixture f;
    std::vector<std::string> made, listed;
    for (int i = 0; i < 5; ++i) made.push_back(f.capture());
    std::sort(made.begin(), made.end());
    CHECK(f.put(made[0], "images/a.png", "four"));
    std::string after;
    for (bool more = true; more;) {
        const CapturePage page = f.store.list(2, after);
        REQUIRE_FALSE(page.captures.empty());
        REQUIRE(page.captures.size() <= 2);
        for (const CaptureRecord& capture : page.captures) listed.push_back(capture.id);
        after = listed.back();
        more = page.more;
    }
    CHECK(listed == made);
    CHECK(f.store.list(1, "").captures[0].n_bytes() == 4);
    CHECK(f.store.list(5, made.back()).captures.empty());
}
