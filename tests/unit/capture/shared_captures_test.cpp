// The large captures that are not part of the repository, where they are at hand.
#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>

#include "core/capture/load_capture.h"

using namespace anyrate;

namespace {

std::filesystem::path shared_data() {
    const char* folder = std::getenv("ANYRATE_SHARED");
    return (folder ? std::filesystem::path(folder) : std::filesystem::path(ANYRATE_SOURCE_DIR) / ".." / "shared") /
           "data";
}

struct Expected {
    const char* name;
    std::size_t n_views;
    int width, height;
    const char* cameras_file = "cameras.json";
};

}  // namespace

TEST_CASE("Shared captures: all load without a fault") {
    for (const Expected& expected :
         {Expected{"oxford_dinosaur", 36, 720, 576}, Expected{"nefertiti", 22, 640, 480}, Expected{"pot", 22, 640, 480},
          Expected{"pot", 36, 640, 480, "cameras_2ring.json"}, Expected{"bowl", 22, 640, 480}}) {
        if (!std::filesystem::exists(shared_data() / expected.name)) {
            MESSAGE("skipped, not there: " << expected.name);
            continue;
        }
        const Capture capture = load_capture(shared_data() / expected.name, {.cameras_file = expected.cameras_file});
        CHECK(capture.name == expected.name);
        CHECK(capture.views.size() == expected.n_views);
        CHECK(capture.views.back().image.width == expected.width);
        CHECK(capture.views.back().image.height == expected.height);
    }
}
