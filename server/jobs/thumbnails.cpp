#include "server/jobs/thumbnails.h"

#include <system_error>
#include <vector>

#include "core/capture/image_io.h"
#include "core/capture/shrink.h"
#include "core/error.h"
#include "core/parallel.h"
#include "server/store/file.h"
#include "server/store/zip_writer.h"

namespace anyrate {
namespace {

constexpr int jpeg_quality = 80;  // of 100

void write(const std::vector<std::vector<std::uint8_t>>& thumbnails, const std::filesystem::path& zip) {
    create_file(zip);  // with the mode of a model's other files
    ZipWriter writer(zip);
    for (std::size_t i = 0; i < thumbnails.size(); ++i)
        writer.add(thumbnail_name(i), std::as_bytes(std::span(thumbnails[i])));
    writer.finish();
    sync_file(open_if_exists(zip));
}

}  // namespace

std::string thumbnail_name(std::size_t view) { return std::to_string(view) + ".jpg"; }

void write_thumbnails(const Capture& capture, const std::filesystem::path& zip, std::uint64_t epoch) {
    if (open_if_exists(zip)) return;
    std::vector<std::vector<std::uint8_t>> thumbnails(capture.views.size());
    parallel_for(
        thumbnails.size(),
        [&](std::size_t i) {
            thumbnails[i] = encode_jpeg(shrink(capture.views[i].image, thumbnail_side), jpeg_quality);
        },
        1);
    std::filesystem::path part = zip;
    part += "." + std::to_string(epoch);
    try {
        write(thumbnails, part);
        std::error_code error;
        std::filesystem::rename(part, zip, error);
        if (error) throw IoError("cannot put " + zip.string() + " in its place: " + error.message());
    } catch (const IoError&) {
        remove_file(part);
        throw;
    }
}

}  // namespace anyrate
