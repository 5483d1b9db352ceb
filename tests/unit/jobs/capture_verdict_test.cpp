#include "server/jobs/capture_verdict.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/error.h"
#include "server/jobs/judge_upload.h"
#include "server/jobs/judgement_message.h"
#include "server/store/file.h"
#include "server/store/zip_writer.h"
#include "tests/unit/capture/capture_on_disk.h"

using namespace anyrate;

namespace {

/// A zip of a capture of six views, of which one thing may be changed before.
struct Zipped {
    CaptureOnDisk capture;
    TemporaryFolder folder;
    std::filesystem::path zip = folder.path() / "upload";

    /// @param top  "" or "folder/"
    JudgedCapture judge(const std::string& top = "") {
        ZipWriter out(zip);
        for (const auto& entry : std::filesystem::recursive_directory_iterator(capture.path()))
            if (entry.is_regular_file())
                out.add(top + std::filesystem::relative(entry.path(), capture.path()).string(),
                        read_file(entry.path()));
        out.finish();
        return judge_zip(zip);
    }
    /// The one fault, as "path: sentence"; else how many there are.
    std::string only_fault() {
        const CaptureVerdict verdict = judge().verdict;
        if (verdict.refused.size() != 1) return std::to_string(verdict.refused.size()) + " faults";
        return verdict.refused[0].first + ": " + verdict.refused[0].second;
    }
};

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("Verdict: a sound zip is complete, and every file that the job will read is told") {
    for (const std::string top : {"", "capture/"}) {
        Zipped zipped;
        zipped.capture.write("images/other.png", "no image, but no camera names it");
        const JudgedCapture judged = zipped.judge(top);
        CHECK(judged.verdict.is_complete());
        REQUIRE(judged.files.size() == 13);  // cameras.json, six images and their masks
        CHECK(judged.files[0].path == "cameras.json");
        CHECK(judged.files[1].path == "images/000.png");
        CHECK(judged.files[1].kind == "png");
        CHECK(judged.files[1].width == 48);
        CHECK(judged.files[1].sha256.size() == 64);
    }
}

TEST_CASE("Verdict: of each image that cannot be used the reason is told") {
    Zipped cut;
    cut.capture.truncate("images/002.png", 0.5);
    CHECK(contains(cut.only_fault(), "images/002.png: a damaged PNG"));
    Zipped none;
    none.capture.write("masks/001.png", "this is no image at all");
    CHECK(contains(none.only_fault(), "masks/001.png: expected a PNG or JPEG"));
    Zipped other_mask;
    other_mask.capture.write("masks/001.png", CaptureOnDisk(sphere_photographs(6, 8)).read("masks/001.png"));
    CHECK(contains(other_mask.only_fault(), "masks/001.png: 56 x 36 pixels: expected 48 x 36"));
    Zipped sizes;
    sizes.capture.change_entry(3, [](nlohmann::json& entry) { entry["width"] = 50; });
    CHECK(contains(sizes.only_fault(), "images/003.png: 48 x 36 pixels: cameras.json says 50 x 36"));
}

TEST_CASE("Verdict: every changed byte of a PNG's pixels is told") {
    const std::string png = CaptureOnDisk().read("images/000.png");
    const auto data = png.find("IDAT") + 4;
    for (std::size_t at = data; at < png.size() - 12; at += 37) {
        std::string changed = png;
        changed[at] = static_cast<char>(changed[at] ^ 0x10);
        CHECK_FALSE(inspect_capture_file("images/000.png", as_bytes(changed)).fault.empty());
    }
    CHECK(inspect_capture_file("images/000.png", as_bytes(png)).fault.empty());
    for (std::size_t n = 0; n < png.size(); n += 13)
        CHECK_FALSE(inspect_capture_file("images/000.png", as_bytes(png.substr(0, n))).fault.empty());
}

TEST_CASE("Verdict: of cameras the reason is told") {
    Zipped twice;
    twice.capture.change_entry(1, [](nlohmann::json& entry) { entry["file"] = "images/000.png"; });
    CHECK(contains(twice.only_fault(), "cameras.json: lists images/000.png twice"));
    Zipped flat;
    flat.capture.change_entry(1, [](nlohmann::json& entry) { entry["R"] = {{1, 0, 0}, {1, 0, 0}, {0, 0, 1}}; });
    CHECK_FALSE(flat.judge().verdict.is_complete());
    Zipped long_list;
    long_list.capture.write("cameras.json", std::string(9 << 20, ' '));
    CHECK(contains(long_list.only_fault(), "cameras.json: 9437184 bytes: expected at most"));
}

TEST_CASE("Verdict: what is missing is told") {
    Zipped no_image;
    std::filesystem::remove(no_image.capture.path() / "images/004.png");
    CHECK(no_image.judge().verdict.missing == std::vector<std::string>{"images/004.png"});
    Zipped no_list;
    std::filesystem::remove(no_list.capture.path() / "cameras.json");
    CHECK(no_list.judge().verdict.missing == std::vector<std::string>{"cameras.json"});
}

TEST_CASE("Verdict: what is no sound zip is refused with a sentence") {
    TemporaryFolder folder;
    replace_file(folder.path() / "upload", as_bytes("PK\x03\x04 and then nothing of a zip"));
    CHECK_THROWS_AS(judge_zip(folder.path() / "upload"), InputError);
    std::vector<JudgementMessage> said;
    say_judgement(folder.path() / "upload", [&](const JudgementMessage& message) { said.push_back(message); });
    REQUIRE(said.size() == 1);
    CHECK(contains(std::get<NotReadable>(said[0]).sentence, "capture.zip"));
}

TEST_CASE("Judgement: a message is the same after its line is read") {
    const std::vector<JudgementMessage> messages = {CaptureFile{.path = "images/\"1\".png",
                                                                .n_bytes = 1ull << 40,
                                                                .sha256 = "ab",
                                                                .fault = "a\nb",
                                                                .kind = "png",
                                                                .width = 3,
                                                                .height = 4},
                                                    MissingFile{"m"}, CaptureFault{"p", "s"}, NotReadable{"no"},
                                                    JudgementEnd{}};
    for (const JudgementMessage& message : messages)
        CHECK(decode_judgement_message(encode_judgement_message(message)) == message);
    for (const char* line :
         {"", "{}", "[]", "{\"type\":\"other\"}", "{\"type\":\"missing\"}",
          "{\"type\":\"file\",\"path\":\"\",\"bytes\":-1,\"sha256\":\"\",\"fault\":\"\",\"kind\":\"\","
          "\"width\":0,\"height\":0}"})
        CHECK_THROWS_AS(decode_judgement_message(line), DecodeError);
}

TEST_CASE("Judgement: what a process says is put together, and how it ends is told") {
    const auto shell = [](const std::string& script) { return judge_upload({"/bin/sh", "-c", script}); };
    const std::string file = "printf %s '" + encode_judgement_message(CaptureFile{.path = "cameras.json"}) + "';";
    const std::string end = "printf %s '" + encode_judgement_message(JudgementEnd{}) + "';";
    const JudgedCapture judged = shell(file + "echo '{\"type\":\"missing\",\"path\":\"m\"}';" + end);
    CHECK(judged.files.size() == 1);
    CHECK(judged.verdict.missing == std::vector<std::string>{"m"});
    CHECK_THROWS_AS(shell("echo '{\"type\":\"not readable\",\"fault\":\"f\"}'"), InputError);
    CHECK_THROWS_AS(shell(file + "kill -XCPU $$"), InputError);
    CHECK_THROWS_AS(shell(file + "kill -SEGV $$"), InputError);
    CHECK_THROWS_AS(shell(file + "kill -KILL $$"), IoError);
    CHECK_THROWS_AS(shell(file + "exit 1"), IoError);
    CHECK_THROWS_AS(shell("echo noise"), IoError);
    CHECK_THROWS_AS(judge_upload({"/nowhere/at/all"}), IoError);
}
