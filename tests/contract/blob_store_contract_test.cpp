// What every BlobStore promises. Each implementation is a type with make() and a folder for files to adopt; a new one
// joins the list of every test.
#include <doctest/doctest.h>

#include <memory>
#include <string>
#include <vector>

#include "core/error.h"
#include "server/store/directory_blob_store.h"
#include "server/store/file.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

struct Directory {
    TemporaryFolder folder;
    std::unique_ptr<BlobStore> make() { return std::make_unique<DirectoryBlobStore>(folder.path() / "blobs"); }
};

std::string text_of(const BlobStore& store, const std::string& name) {
    return std::string(as_text(store.read(name, 0, 1000).value()));
}

}  // namespace

TEST_CASE_TEMPLATE("Blob store: what was put is there, also when it is opened again", Implementation, Directory) {
    Implementation place;
    place.make()->put("m/capture.zip", as_bytes("zip"));
    const auto store = place.make();
    CHECK(text_of(*store, "m/capture.zip") == "zip");
    CHECK(store->size("m/capture.zip") == 3u);
    CHECK_FALSE(store->read("m/other", 0, 1));
    CHECK_FALSE(store->size("m/other"));
    CHECK_FALSE(store->size("n/capture.zip"));
}

TEST_CASE_TEMPLATE("Blob store: later bytes replace earlier ones", Implementation, Directory) {
    Implementation place;
    const auto store = place.make();
    store->put("m/a", as_bytes("a long one"));
    store->put("m/a", as_bytes("short"));
    CHECK(text_of(*store, "m/a") == "short");
    store->put("m/a", {});
    CHECK(store->size("m/a") == 0u);
}

TEST_CASE_TEMPLATE("Blob store: any part can be read", Implementation, Directory) {
    Implementation place;
    const auto store = place.make();
    store->put("m/a", as_bytes("0123456789"));
    CHECK(as_text(store->read("m/a", 3, 4).value()) == "3456");
    CHECK(as_text(store->read("m/a", 8, 100).value()) == "89");
    CHECK(store->read("m/a", 10, 1)->empty());
    CHECK(store->read("m/a", 1ull << 40, 1)->empty());
}

TEST_CASE_TEMPLATE("Blob store: an adopted file is moved", Implementation, Directory) {
    Implementation place;
    const auto store = place.make();
    const auto file = place.folder.path() / "upload";
    replace_file(file, as_bytes("bytes"));
    store->adopt("m/capture.zip", file);
    CHECK(text_of(*store, "m/capture.zip") == "bytes");
    CHECK_FALSE(std::filesystem::exists(file));
    CHECK_THROWS_AS(store->adopt("m/capture.zip", file), IoError);
    CHECK(text_of(*store, "m/capture.zip") == "bytes");
}

TEST_CASE_TEMPLATE("Blob store: a model's blobs are listed in order, removed ones not", Implementation, Directory) {
    Implementation place;
    const auto store = place.make();
    for (const char* name : {"m/b", "m/a.x", "n/a"}) store->put(name, {});
    CHECK(store->list("m") == std::vector<std::string>{"m/a.x", "m/b"});
    store->remove("m/b");
    store->remove("m/b");
    CHECK(store->list("m") == std::vector<std::string>{"m/a.x"});
    CHECK(store->list("nobody").empty());
}

TEST_CASE_TEMPLATE("Blob store: no name leaves its folder", Implementation, Directory) {
    Implementation place;
    const auto store = place.make();
    for (const std::string name : {"", "a", "/a", "a/", "../a", "a/..", "a/../b", "a/b/c", "/etc/passwd", "a/.hidden",
                                   ".a/b", "a/b\n", "A/b", "a/b c", "a\\b/c"}) {
        CHECK_THROWS_AS(store->put(name, {}), InputError);
        CHECK_THROWS_AS(store->read(name, 0, 1), InputError);
        CHECK_THROWS_AS(store->remove(name), InputError);
    }
    CHECK_THROWS_AS(store->put("a/" + std::string(300, 'x'), {}), InputError);
    CHECK_THROWS_AS(store->put(std::string("a/b\0c", 5), {}), InputError);
    CHECK_THROWS_AS(store->list(".."), InputError);
}
