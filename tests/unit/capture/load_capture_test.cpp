// What a sound capture turns into, in all the forms it may come in.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "core/error.h"
#include "tests/unit/capture/capture_on_disk.h"

using namespace anyrate;

namespace {

/// Checks that both hold the same photographs, whatever their names.
void check_equal(const Capture& a, const Capture& b) {
    REQUIRE(a.views.size() == b.views.size());
    for (std::size_t i = 0; i < a.views.size(); ++i) {
        const View &u = a.views[i], &v = b.views[i];
        CHECK((u.camera.K - v.camera.K).norm() < 1e-12);
        CHECK((u.camera.R - v.camera.R).norm() < 1e-12);
        CHECK(u.camera.t == v.camera.t);
        CHECK(u.camera.width == v.camera.width);
        CHECK(u.camera.height == v.camera.height);
        CHECK(u.image.pixels == v.image.pixels);
        CHECK(u.mask.pixels == v.mask.pixels);
    }
}

cv::Mat bgr(const ColourImage& image) {
    cv::Mat pixels(image.height, image.width, CV_8UC3);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            pixels.at<cv::Vec3b>(y, x) = {image(x, y).b, image(x, y).g, image(x, y).r};
    return pixels;
}

void write_image(const CaptureOnDisk& disk, const std::string& file, const cv::Mat& pixels) {
    REQUIRE(cv::imwrite((disk.path() / file).string(), pixels));
}

/// Rewrites image `i` as a cut-out: its mask as alpha, 0 or 200, and no mask file.
void make_cut_out(const CaptureOnDisk& disk, const Capture& capture, std::size_t i, int depth) {
    const View& view = capture.views[i];
    cv::Mat pixels(view.image.height, view.image.width, CV_8UC4);
    for (int y = 0; y < pixels.rows; ++y) {
        for (int x = 0; x < pixels.cols; ++x) {
            const Rgb8 c = view.image(x, y);
            pixels.at<cv::Vec4b>(y, x) = {c.b, c.g, c.r, static_cast<std::uint8_t>(view.mask(x, y) ? 200 : 0)};
        }
    }
    if (depth == CV_16U) pixels.convertTo(pixels, CV_16U, 257);
    write_image(disk, view.name, pixels);
    std::filesystem::remove(disk.path() / "masks" / view.name.substr(7));
    disk.change_entry(i, [](nlohmann::json& entry) { entry.erase("mask"); });
}

}  // namespace

TEST_CASE("Capture: loading what was saved gives it back") {
    const Capture saved = sphere_photographs();
    const CaptureOnDisk disk(saved);
    const Capture loaded = load_capture(disk.path());
    check_equal(saved, loaded);
    CHECK(loaded.name == disk.path().filename());
    CHECK(loaded.views[4].name == "images/004.png");
}

TEST_CASE("Capture: views may differ in size") {
    const Capture saved = sphere_photographs(5, 7);
    const CaptureOnDisk disk(saved);
    check_equal(saved, load_capture(disk.path()));
}

TEST_CASE("Capture: pixel_center moves the principal point, and is (0.5, 0.5) if not given") {
    const Capture saved = sphere_photographs();
    const CaptureOnDisk disk(saved);
    nlohmann::json cameras = disk.cameras();
    CHECK(cameras["pixel_center"] == nlohmann::json({0.5, 0.5}));
    CHECK(cameras["images"][0]["K"][0][2].get<double>() == saved.views[0].camera.K(0, 2) + 0.5);

    cameras.erase("pixel_center");
    disk.set_cameras(cameras);
    check_equal(saved, load_capture(disk.path()));

    cameras["pixel_center"] = {0, 0.25};
    disk.set_cameras(cameras);
    const Mat3 K = load_capture(disk.path()).views[0].camera.K;
    CHECK(K(0, 2) == doctest::Approx(saved.views[0].camera.K(0, 2) + 0.5));
    CHECK(K(1, 2) == doctest::Approx(saved.views[0].camera.K(1, 2) + 0.25));
}

TEST_CASE("Capture: K is scaled to K(2,2) = 1") {
    const Capture saved = sphere_photographs();
    const CaptureOnDisk disk(saved);
    disk.change_entry(1, [](nlohmann::json& entry) {
        for (auto& row : entry["K"])
            for (auto& value : row) value = value.get<double>() * -4.0;
    });
    check_equal(saved, load_capture(disk.path()));
}

TEST_CASE("Capture: a rotation of six digits becomes a rotation to the last bits") {
    const CaptureOnDisk disk;
    disk.change_entry(1, [](nlohmann::json& entry) {
        for (auto& row : entry["R"])
            for (auto& value : row) value = std::round(value.get<double>() * 1e6) / 1e6;
    });
    const Mat3 R = load_capture(disk.path()).views[1].camera.R;
    CHECK((R * R.transpose() - Mat3::Identity()).norm() < 1e-14);
    CHECK((R - sphere_photographs().views[1].camera.R).norm() < 1e-5);
}

TEST_CASE("Capture: the list may be called cameras, views or frames") {
    const CaptureOnDisk disk;
    const nlohmann::json cameras = disk.cameras();
    for (const char* name : {"cameras", "views", "frames"}) {
        disk.set_cameras({{"pixel_center", cameras["pixel_center"]}, {name, cameras["images"]}});
        CHECK(load_capture(disk.path()).views.size() == 6);
    }
}

TEST_CASE("Capture: another cameras file chooses which images are read") {
    const Capture saved = sphere_photographs();
    const CaptureOnDisk disk(saved);
    nlohmann::json cameras = disk.cameras();
    cameras["images"].erase(1);
    disk.set_cameras(cameras, "some.json");
    std::filesystem::remove(disk.path() / "images/001.png");
    std::filesystem::remove(disk.path() / "cameras.json");
    const Capture loaded = load_capture(disk.path(), {.cameras_file = "some.json"});
    REQUIRE(loaded.views.size() == 5);
    CHECK(loaded.views[1].name == "images/002.png");
    CHECK(loaded.views[1].image.pixels == saved.views[2].image.pixels);
}

TEST_CASE("Capture: a mask of the image's name is found without being listed") {
    const Capture saved = sphere_photographs();
    const CaptureOnDisk disk(saved);
    for (std::size_t i = 0; i < 6; ++i) disk.change_entry(i, [](nlohmann::json& entry) { entry.erase("mask"); });
    check_equal(saved, load_capture(disk.path()));
}

TEST_CASE("Capture: an alpha channel of 8 or 16 bits is the mask where there is no other") {
    const Capture saved = sphere_photographs();
    const CaptureOnDisk disk(saved);
    make_cut_out(disk, saved, 2, CV_8U);
    make_cut_out(disk, saved, 3, CV_16U);
    check_equal(saved, load_capture(disk.path()));
}

TEST_CASE("Capture: a mask named like its own image is that image's alpha channel") {
    const Capture saved = sphere_photographs();
    const CaptureOnDisk disk(saved);
    make_cut_out(disk, saved, 2, CV_8U);
    disk.change_entry(2, [](nlohmann::json& entry) { entry["mask"] = entry["file"]; });
    check_equal(saved, load_capture(disk.path()));
}

TEST_CASE("Capture: 16 bits, grey and palette images become 8-bit colours") {
    const Capture saved = sphere_photographs();
    const CaptureOnDisk disk(saved);
    cv::Mat deep;
    bgr(saved.views[0].image).convertTo(deep, CV_16U, 257);
    write_image(disk, "images/000.png", deep);
    const cv::Mat grey(36, 48, CV_8UC1, cv::Scalar(77));
    write_image(disk, "images/001.png", grey);

    const Capture loaded = load_capture(disk.path());
    CHECK(loaded.views[0].image.pixels == saved.views[0].image.pixels);
    CHECK(loaded.views[1].image(20, 10) == Rgb8{77, 77, 77});
}

TEST_CASE("Capture: JPEG images are read, and their orientation is ignored") {
    const Capture saved = sphere_photographs();
    const CaptureOnDisk disk(saved);
    write_image(disk, "images/000.jpg", bgr(saved.views[0].image));
    // An APP1 segment after the start of image: Exif, one directory with one entry, orientation (0x112) = 6, a quarter
    // turn.
    std::string jpeg = disk.read("images/000.jpg");
    const char exif[] =
        "\xFF\xE1\x00\x22"
        "Exif\0\0"
        "MM\0\x2A\0\0\0\x08"
        "\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0";
    jpeg.insert(2, exif, 36);
    disk.write("images/000.jpg", jpeg);
    disk.change_entry(0, [](nlohmann::json& entry) {
        entry["file"] = "images/000.jpg";
        entry.erase("mask");
    });
    const Capture loaded = load_capture(disk.path());
    CHECK(loaded.views[0].image.width == 48);
    CHECK(loaded.views[0].mask.pixels == saved.views[0].mask.pixels);
    const Rgb8 is = loaded.views[0].image(25, 17), was = saved.views[0].image(25, 17);
    CHECK(std::abs(is.r - was.r) + std::abs(is.g - was.g) + std::abs(is.b - was.b) < 60);
}

TEST_CASE("Capture: a zip, plain or with one top folder, equals its folder") {
    const CaptureOnDisk disk;
    const Capture from_folder = load_capture(disk.path());
    for (const std::string top : {"", "./", "my capture/"}) {
        const TemporaryFolder folder;
        std::vector<ZipEntry> entries = files_under(disk.path(), top);
        entries.push_back({"__MACOSX/cameras.json", "rubbish"});
        write_bytes(folder.path() / "sphere.zip", make_zip(entries));
        const Capture from_zip = load_capture(folder.path() / "sphere.zip");
        check_equal(from_folder, from_zip);
        CHECK(from_zip.name == "sphere");
        CHECK(from_zip.views[1].name == "images/001.png");
    }
}

TEST_CASE("Capture: saving makes the folders that are missing") {
    const TemporaryFolder folder;
    save_capture(sphere_photographs(3), folder.path() / "new" / "folders");
    CHECK(load_capture(folder.path() / "new" / "folders").views.size() == 3);
}

TEST_CASE("Capture: a place that cannot be written to is an IoError") {
    const TemporaryFolder folder;
    write_bytes(folder.path() / "file", "x");
    CHECK_THROWS_AS(save_capture(sphere_photographs(3), folder.path() / "file"), IoError);
}
