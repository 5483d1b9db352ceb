// A zip file comes from strangers.
#include "core/capture/zip_archive.h"

#include <doctest/doctest.h>

#include <fstream>

#include "core/capture/relative_name.h"
#include "core/error.h"
#include "tests/unit/capture/capture_on_disk.h"

using namespace anyrate;

namespace {

ZipContents read(const std::string& zip, const ZipLimits& limits = {}) {
    return read_zip({reinterpret_cast<const std::uint8_t*>(zip.data()), zip.size()}, "x.zip", limits);
}

/// What read_zip() says when it refuses; empty if it does not.
std::string zip_refusal(const std::string& zip, const ZipLimits& limits = {}) {
    try {
        read(zip, limits);
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

}  // namespace

TEST_CASE("Zip: files come out as they went in") {
    const std::string bytes = "some\0bytes" + std::string(100000, 'z');
    const ZipContents contents = read(make_zip({{"a/b.txt", bytes}, {"empty", ""}}));
    REQUIRE(contents.size() == 2);
    CHECK(std::string(contents.at("a/b.txt").begin(), contents.at("a/b.txt").end()) == bytes);
    CHECK(contents.at("empty").empty());
}

TEST_CASE("Zip: files are handed out one by one, and what nobody wants is not unpacked") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "x.zip";
    std::string zip = make_zip({{"a", "first"}, {"b", std::string(1000, 'b')}, {"c", "third"}});
    std::ofstream(file, std::ios::binary) << zip;
    std::vector<std::string> names;
    const auto take = [&](const std::string& name, const std::vector<std::uint8_t>&) { names.push_back(name); };
    visit_zip(file, "x.zip", {}, take);
    CHECK(names == std::vector<std::string>{"a", "b", "c"});
    names.clear();
    // Too many bytes in b, which is passed over.
    visit_zip(file, "x.zip", {.max_bytes = 100}, take, [](const std::string& name) { return name != "b"; });
    CHECK(names == std::vector<std::string>{"a", "c"});
    CHECK_THROWS_AS(visit_zip(file, "x.zip", {.max_bytes = 100}, take), InputError);
    CHECK_THROWS_AS(visit_zip(folder.path() / "none.zip", "x.zip", {}, take), IoError);
}

TEST_CASE("Zip: names in UTF-8 are kept, whatever the locale") {
    // A stored file "\u00e4" of one byte "x", with the flag that its name is UTF-8.
    const std::string common("\0\x08\0\0\0\0!\0\x83\x16\xDC\x8C\1\0\0\0\1\0\0\0\2\0\0\0", 24);
    const std::string local = "PK\3\4\x14" + std::string(1, '\0') + common + "\xC3\xA4" + "x";
    const std::string central = std::string("PK\1\2\x14\0\x14\0", 8) + common + std::string(14, '\0') + "\xC3\xA4";
    std::string end("PK\5\6\0\0\0\0\1\0\1\0\0\0\0\0\0\0\0\0\0\0", 22);
    end[12] = static_cast<char>(central.size());
    end[16] = static_cast<char>(local.size());
    const ZipContents contents = read(local + central + end);
    CHECK(contents.contains("\u00e4"));
}

TEST_CASE("Zip: names that lead out of the capture are refused") {
    for (const std::string name : {"../evil", "a/../../evil", "/etc/evil", "a\\..\\evil", "C:evil"})
        CHECK(says(zip_refusal(make_zip({{"ok", "1"}, {name, "2"}})),
                   {"x.zip: holds \"", "expected names that stay inside"}));
}

TEST_CASE("Zip: links are refused") {
    CHECK(says(zip_refusal(make_zip({{"images/000.png", "", "/etc/passwd"}})),
               {"x.zip: holds images/000.png, a link", "expected plain files"}));
}

TEST_CASE("Zip: one name twice is refused, also in two spellings") {
    CHECK(says(zip_refusal(make_zip({{"a", "1"}, {"./a", "2"}})), {"x.zip: holds a twice"}));
}

TEST_CASE("Zip: too many entries, too many bytes and too good a packing are refused") {
    const std::string zip = make_zip({{"a", "12345"}, {"b", "12345"}, {"c", "12345"}});
    CHECK(says(zip_refusal(zip, {.max_files = 2}), {"x.zip: more than 2 entries"}));
    CHECK(says(zip_refusal(zip, {.max_bytes = 14}), {"x.zip: unpacks to more than 14 bytes"}));
    CHECK(zip_refusal(zip, {.max_files = 3, .max_bytes = 15}) == "");
    const std::string bomb = make_zip({{"zeros", std::string(20 << 20, '\0')}});
    CHECK(says(zip_refusal(bomb), {"x.zip: unpacks to more than 100 times its size"}));
}

TEST_CASE("Zip: a bomb is refused for the size it promises, before it is unpacked") {
    std::string bomb = make_zip({{"zeros", std::string(20 << 20, '\0')}});
    for (std::size_t i = 1000; i < 2000; ++i) bomb[i] = '\xff';  // nothing behind here can be unpacked
    CHECK(says(zip_refusal(bomb), {"x.zip: unpacks to more than 100 times its size"}));
}

TEST_CASE("Zip: a bomb that promises little is refused for what it delivers") {
    std::string bomb = make_zip({{"zeros", std::string(20 << 20, '\0')}});
    const auto directory = bomb.find("PK\1\2");
    REQUIRE(directory != std::string::npos);
    bomb.replace(directory + 24, 4, std::string("\5\0\0\0", 4));  // where it has the size
    CHECK(!zip_refusal(bomb).empty());
}

TEST_CASE("Zip: what is no zip is refused") {
    for (const std::string& bytes : {std::string(), std::string("hello"), std::string(100000, '\0')})
        CHECK(says(zip_refusal(bytes), {"x.zip: not a", "zip file", "expected"}));
}

TEST_CASE("Zip: every truncation is rejected") {
    const std::string zip = make_zip({{"a", "12345"}, {"b", "67890"}});
    for (std::size_t n = 0; n < zip.size(); ++n) {
        INFO(n);
        const std::vector<char> exact(zip.begin(), zip.begin() + static_cast<std::ptrdiff_t>(n));
        CHECK(!zip_refusal(std::string(exact.begin(), exact.end())).empty());
    }
}

TEST_CASE("Zip: a changed byte of the data is told") {
    std::string zip = make_zip({{"a", "incompressible"}});
    // The local header takes 30 bytes and the name and extra field, whose lengths it has at 26 and 28.
    const std::size_t data = 30 + 1 + static_cast<unsigned char>(zip[28]);
    zip[data + 5] ^= 1;
    CHECK(says(zip_refusal(zip), {"x.zip", "expected"}));
}

TEST_CASE("Zip: a capture that is not there, or there twice, is told") {
    const CaptureOnDisk disk;
    const TemporaryFolder folder;
    const auto zip = folder.path() / "x.zip";
    write_bytes(zip, make_zip({{"readme", "nothing"}}));
    CHECK(says(refusal(zip), {"cameras.json: missing from", "x.zip"}));
    write_bytes(zip, make_zip({{"a/cameras.json", "{}"}, {"b/cameras.json", "{}"}}));
    CHECK(says(refusal(zip), {"x.zip: cameras.json lies both in a/ and in b/", "expected one capture"}));
    write_bytes(zip, "not a zip");
    CHECK(says(refusal(zip), {"x.zip: not a", "expected"}));
}

TEST_CASE("Relative name: one spelling for each file, none for what leads out") {
    CHECK(relative_name("./a//b/./c.png") == "a/b/c.png");
    CHECK(relative_name("..a/b..") == "..a/b..");
    CHECK(relative_name("./c:a") == std::nullopt);
    for (const char* bad : {"", ".", "/", "/a", "..", "a/..", "a/../b", "a\\b", "C:\\x", "a\nb"})
        CHECK(!relative_name(bad));
}
