#include <doctest/doctest.h>

#include <string>

#include "server/http/capture_handlers.h"
#include "server/http/problem.h"

using namespace anyrate;

TEST_CASE("Capture path: only the three kinds of files, and none that leads elsewhere") {
    CHECK(expect_capture_path("images/000.png") == "images/000.png");
    CHECK(expect_capture_path("./masks//a b.jpg") == "masks/a b.jpg");
    CHECK(expect_capture_path("cameras.json") == "cameras.json");
    CHECK(expect_capture_path("..json") == "..json");  // a name like another
    for (const std::string& path :
         {std::string(), std::string("/images/a.png"), std::string("images/../../a.png"), std::string("images"),
          std::string("images/a/b.png"), std::string("photo.png"), std::string("images/a.json"),
          std::string("a\\b.json"), "images/" + std::string(300, 'a')})
        CHECK_THROWS_AS_MESSAGE(expect_capture_path(path), HttpProblem, path);
}
