// Every way a capture can be wrong has a sentence that names the file, what was found and what was expected.
#include <doctest/doctest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "core/capture/faults.h"
#include "core/error.h"
#include "tests/unit/capture/capture_on_disk.h"

using namespace anyrate;
using nlohmann::json;

namespace {

/// The refusal after entry 3 of the small capture was changed.
template <class Change>
std::string refusal_after(const Change& change) {
    const CaptureOnDisk disk;
    disk.change_entry(3, change);
    return refusal(disk.path());
}

std::string with_cameras(const std::string& text) {
    const CaptureOnDisk disk;
    disk.write("cameras.json", text);
    return refusal(disk.path());
}

std::string png_of(int width, int height, int value) {
    std::vector<std::uint8_t> bytes;
    cv::imencode(".png", cv::Mat(height, width, CV_8UC1, cv::Scalar(value)), bytes);
    return {bytes.begin(), bytes.end()};
}

/// Checks that the refusal is a single line with these parts.
template <class... Parts>
void check_says(const std::string& said, const Parts&... parts) {
    INFO(said);
    CHECK(n_lines(said) == 1);
    CHECK(says(said, {parts...}));
}

}  // namespace

TEST_CASE("Faults: the small capture of these tests has none") { CHECK(refusal(CaptureOnDisk().path()) == ""); }

TEST_CASE("Faults: nothing at the path") {
    check_says(refusal("/nowhere/at/all"), "/nowhere/at/all", "expected a capture's folder or zip file");
}

TEST_CASE("Faults: missing cameras.json") {
    const CaptureOnDisk disk;
    std::filesystem::remove(disk.path() / "cameras.json");
    check_says(refusal(disk.path()), "cameras.json: missing", "expected the list of images");
}

TEST_CASE("Faults: missing image") {
    const CaptureOnDisk disk;
    std::filesystem::remove(disk.path() / "images/003.png");
    check_says(refusal(disk.path()), "images/003.png: missing", "expected an image file");
}

TEST_CASE("Faults: a folder where an image should be") {
    const CaptureOnDisk disk;
    std::filesystem::remove(disk.path() / "images/003.png");
    std::filesystem::create_directory(disk.path() / "images/003.png");
    check_says(refusal(disk.path()), "images/003.png: missing", "expected an image file");
}

TEST_CASE("Faults: a listed mask is missing") {
    const CaptureOnDisk disk;
    std::filesystem::remove(disk.path() / "masks/003.png");
    check_says(refusal(disk.path()), "masks/003.png: missing");
}

TEST_CASE("Faults: no mask of any kind") {
    const CaptureOnDisk disk;
    std::filesystem::remove(disk.path() / "masks/003.png");
    disk.change_entry(3, [](json& entry) { entry.erase("mask"); });
    check_says(refusal(disk.path()), "images/003.png: has no mask", "alpha channel");
}

TEST_CASE("Faults: an image of another size than cameras.json says") {
    check_says(refusal_after([](json& entry) { entry["height"] = 35; }),
               "images/003.png: 48x36 pixels, but cameras.json says 48x35");
}

TEST_CASE("Faults: a mask of another size than its image") {
    const CaptureOnDisk disk;
    disk.write("masks/003.png", png_of(24, 18, 255));
    check_says(refusal(disk.path()), "masks/003.png: 24x18 pixels; expected 48x36 as images/003.png");
}

TEST_CASE("Faults: an empty mask, and one without background") {
    const CaptureOnDisk disk;
    disk.write("masks/003.png", png_of(48, 36, 0));
    check_says(refusal(disk.path()), "masks/003.png: an empty mask", "expected some pixels");
    disk.write("masks/003.png", png_of(48, 36, 1));
    check_says(refusal(disk.path()), "masks/003.png: a mask without background", "expected pixels of 0");
}

TEST_CASE("Faults: a singular K") {
    check_says(refusal_after([](json& entry) { entry["K"][1][1] = 0; }), "images/003.png: K is singular",
               "expected focal lengths");
    check_says(refusal_after([](json& entry) { entry["K"][2][2] = 0; }), "images/003.png: K is singular");
}

TEST_CASE("Faults: a K that is not upper triangular") {
    check_says(refusal_after([](json& entry) { entry["K"][1][0] = 0.5; }), "images/003.png: K is not upper triangular",
               "0.5", "expected [[fx, skew, cx]");
}

TEST_CASE("Faults: a negative focal length") {
    check_says(refusal_after([](json& entry) { entry["K"][1][1] = -55; }), "images/003.png", "-55",
               "expected positive");
}

TEST_CASE("Faults: a K of the wrong shape") {
    check_says(refusal_after([](json& entry) {
                   entry["K"] = {1, 2, 3, 4};
               }),
               "images[3] (images/003.png): K is a list of 4", "expected 3 rows of 3 finite numbers");
    check_says(refusal_after([](json& entry) { entry["K"][1] = {1, 2}; }), "K is a list of 2 in row 1");
    check_says(refusal_after([](json& entry) { entry["K"][1][2] = "x"; }), "K is a string in place 2 in row 1");
    check_says(refusal_after([](json& entry) { entry.erase("K"); }), "K is missing", "expected 3 rows of 3");
}

TEST_CASE("Faults: R is not a rotation") {
    check_says(refusal_after([](json& entry) { entry["R"][0][0] = 2.0; }), "images/003.png: R is not a rotation",
               "expected at most 1e-05");
}

TEST_CASE("Faults: R is a reflection") {
    check_says(refusal_after([](json& entry) {
                   for (auto& value : entry["R"][0]) value = -value.get<double>();
               }),
               "images/003.png: R is a reflection", "expected a rotation");
}

TEST_CASE("Faults: a t of the wrong shape") {
    check_says(refusal_after([](json& entry) {
                   entry["t"] = {1, 2};
               }),
               "cameras.json", "images/003.png", "t is a list of 2; expected 3 finite numbers");
}

TEST_CASE("Faults: NaN and infinity, as scripts write them, are told with line and column") {
    for (const std::string word : {"NaN", "Infinity", "-Infinity"}) {
        const std::string said = with_cameras("{\"images\": [\n {\"t\": [0, " + word + ", 0]}]}");
        check_says(said, "cameras.json: line 2, column 1", "NaN or Infinity; expected finite numbers");
    }
    check_says(with_cameras("{\"images\": [1e999]}"), "cameras.json", "1e999", "expected finite numbers");
    check_says(refusal_after([](json& entry) { entry["t"][1] = nullptr; }), "t is null in place 1",
               "expected 3 finite numbers");
}

TEST_CASE("Faults: not JSON is told with line and column") {
    check_says(with_cameras("{\"images\": [\n\n   oops]}"), "cameras.json: line 3, column 4: not JSON");
    check_says(with_cameras(""), "cameras.json: line 1, column 1: not JSON");
    check_says(with_cameras("{\"images\": []} more"), "not JSON");
    check_says(with_cameras(std::string("{\"a\": \"\xFF\xFE\"}")), "not JSON");
}

TEST_CASE("Faults: JSON without a list of photographs") {
    check_says(with_cameras("[1, 2]"), "cameras.json: holds a list of 2", "expected an object");
    check_says(with_cameras("{\"images\": 3}"), "cameras.json: has no list", "expected \"images\"");
    CHECK(says(with_cameras("{\"images\": [7, 7, 7]}"), {"images[1]: it is 7", "expected an object"}));
}

TEST_CASE("Faults: nesting without end is refused without using the stack") {
    CHECK(says(with_cameras(std::string(1 << 20, '[')), {"not JSON"}));
    const std::string deep = std::string(1 << 20, '[') + std::string(1 << 20, ']');
    CHECK(says(with_cameras("{\"images\": [{\"K\": " + deep + "}]}"), {"K is a list of 1", "expected 3 rows"}));
}

TEST_CASE("Faults: a pixel_center outside the pixel") {
    const CaptureOnDisk disk;
    json cameras = disk.cameras();
    for (const json& wrong : {json({320, 240}), json("centre"), json({0.5})}) {
        cameras["pixel_center"] = wrong;
        disk.set_cameras(cameras);
        check_says(refusal(disk.path()), "cameras.json: pixel_center", "expected 2 numbers from 0 to 1");
    }
}

TEST_CASE("Faults: a size that is no number of pixels") {
    check_says(refusal_after([](json& entry) { entry["width"] = -48; }), "width is -48",
               "expected a positive whole number");
    check_says(refusal_after([](json& entry) { entry["width"] = 48.5; }), "width is 48.5");
}

TEST_CASE("Faults: distortion of another length than 4 or 5") {
    check_says(refusal_after([](json& entry) { entry["distortion"] = {0.1}; }), "distortion is a list of 1",
               "expected the 4 or 5");
}

TEST_CASE("Faults: names that lead out of the capture") {
    for (const std::string name : {"../000.png", "/etc/passwd", "images/../../x.png", "..\\x.png", "C:/x.png", ""})
        check_says(refusal_after([&](json& entry) { entry["file"] = name; }), "file is \"" + name + "\"",
                   "expected a name that stays inside the capture");
    check_says(refusal_after([&](json& entry) { entry["mask"] = "../x.png"; }), "mask is \"../x.png\"");
    check_says(refusal(CaptureOnDisk().path(), {.cameras_file = "../cameras.json"}), "../cameras.json",
               "expected one like");
}

TEST_CASE("Faults: one image listed twice") {
    CHECK(says(refusal_after([](json& entry) { entry["file"] = "./images//002.png"; }),
               {"cameras.json: lists images/002.png more than once", "expected every image once"}));
}

TEST_CASE("Faults: fewer than three views") {
    const CaptureOnDisk disk;
    json cameras = disk.cameras();
    cameras["images"] = {cameras["images"][0], cameras["images"][1]};
    disk.set_cameras(cameras);
    check_says(refusal(disk.path()), "cameras.json: 2 views; expected at least 3");
}

TEST_CASE("Faults: a truncated PNG, at any length") {
    const CaptureOnDisk disk;
    for (const double left : {0.0, 0.005, 0.03, 0.5, 0.99}) {
        const CaptureOnDisk broken;
        broken.truncate("images/003.png", left);
        check_says(refusal(broken.path()), "images/003.png: ", "expected");
    }
}

TEST_CASE("Faults: a truncated JPEG") {
    const CaptureOnDisk disk;
    REQUIRE(cv::imwrite((disk.path() / "images/003.jpg").string(), cv::Mat(36, 48, CV_8UC3, cv::Scalar(9, 99, 199))));
    disk.change_entry(3, [](json& entry) { entry["file"] = "images/003.jpg"; });
    REQUIRE(refusal(disk.path()) == "");
    disk.truncate("images/003.jpg", 0.9);
    check_says(refusal(disk.path()), "images/003.jpg: the JPEG data is cut off", "expected a complete file");
}

TEST_CASE("Faults: a PNG whose bytes were changed") {
    const CaptureOnDisk disk;
    std::string bytes = disk.read("images/003.png");
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x55);
    disk.write("images/003.png", bytes);
    check_says(refusal(disk.path()), "images/003.png: the PNG data is cut off or damaged");
}

TEST_CASE("Faults: not an image") {
    const CaptureOnDisk disk;
    disk.write("images/003.png", "GIF89a, or so it says");
    check_says(refusal(disk.path()), "images/003.png: neither a PNG nor a JPEG", "expected an image file");
}

TEST_CASE("Faults: an image over the pixel limit is refused before it is decoded") {
    const CaptureOnDisk disk;
    // A header that promises 60000x60000 pixels, and no pixel.
    std::string bytes = disk.read("images/003.png").substr(0, 33);
    bytes.replace(16, 8, std::string("\0\0\xEA\x60\0\0\xEA\x60", 8));
    disk.write("images/003.png", bytes);
    CHECK(says(refusal(disk.path()), {"images/003.png: 60000x60000 pixels; expected at most 50000000"}));
    CHECK(
        says(refusal(CaptureOnDisk().path(), {.max_pixels = 1000}), {"images/005.png: 48x36 pixels", "at most 1000"}));
}

TEST_CASE("Faults: more pixels together than the limit") {
    LoadOptions options;
    options.max_capture_pixels = 6 * 48 * 36 - 1;
    check_says(refusal(CaptureOnDisk().path(), options), "cameras.json: lists images of 10368 pixels", "at most 10367");
    options.max_capture_pixels += 1;
    CHECK(refusal(CaptureOnDisk().path(), options) == "");
}

TEST_CASE("Faults: all faults are told together, in the order of the views") {
    const CaptureOnDisk disk;
    std::filesystem::remove(disk.path() / "images/001.png");
    disk.write("masks/004.png", png_of(48, 36, 0));
    disk.change_entry(2, [](json& entry) {
        entry["K"][1][1] = 0;
        entry["R"][0][0] = 2;
        entry["width"] = 47;
    });
    const std::string said = refusal(disk.path());
    INFO(said);
    CHECK(n_lines(said) == 5);
    CHECK(said.find("images/001.png") < said.find("images/002.png"));
    CHECK(said.find("images/002.png") < said.find("masks/004.png"));
}

TEST_CASE("Faults: a fault stays one printable line, whatever a file is called") {
    CHECK(says(refusal_after([](json& entry) { entry["file"] = "a\n\x1B[31mb"; }), {"file is \"a??[31mb\""}));
    const std::string said = refusal_after([](json& entry) { entry["file"] = "images/" + std::string(100000, 'x'); });
    CHECK(said.size() < 1000);
    CHECK(says(said, {"missing"}));
    Faults faults;
    faults.add("gr\xC3\xB6\xC3\x9F.png", "b\xF6se");
    CHECK_THROWS_WITH_AS(faults.throw_if_any(), "gr\xC3\xB6\xC3\x9F.png: b?se", InputError);
}

TEST_CASE("Faults: of very many, a hundred are told and the rest counted") {
    Faults faults;
    for (int i = 0; i < 250; ++i) faults.add("f", "s");
    std::string said;
    try {
        faults.throw_if_any();
    } catch (const InputError& error) {
        said = error.what();
    }
    CHECK(n_lines(said) == 101);
    CHECK(says(said, {"and 150 more faults"}));
}
