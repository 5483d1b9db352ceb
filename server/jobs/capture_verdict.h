#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/store/capture_store.h"

namespace anyrate {

/// What can be said of a file before any pixel is decoded: kind, size, and why a reconstruction could not use it. The
/// job looks closer. `sha256` is left empty.
CaptureFile inspect_capture_file(const std::string& path, std::span<const std::byte> bytes);

/// What is still wrong with a capture as a whole.
struct CaptureVerdict {
    std::vector<std::string> missing;                          ///< paths that cameras.json names and that are not here
    std::vector<std::pair<std::string, std::string>> refused;  ///< path and sentence
    bool is_complete() const { return missing.empty() && refused.empty(); }
};

/// @param cameras_json  the bytes of cameras.json, if it has arrived and was accepted
CaptureVerdict judge_capture(const CaptureRecord& capture, const std::optional<std::string>& cameras_json);

/// A capture that came at once: what was found of each file that it needs, and of the whole.
struct JudgedCapture {
    std::vector<CaptureFile> files;  ///< by path, those that cameras.json names and itself
    CaptureVerdict verdict;
};

/// Looks through a zip of a capture as far as it can be told without decoding pixels. It unpacks what somebody
/// uploaded: call it in a process that has nothing to lose (judge_upload.h).
/// @throws InputError it is no zip, or one that read_zip() refuses @throws IoError
JudgedCapture judge_zip(const std::filesystem::path& zip);

}  // namespace anyrate
