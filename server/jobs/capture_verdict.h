#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/store/capture_store.h"

namespace anyrate {

/// The path of a file of a capture: `images/NAME`, `masks/NAME` or `NAME.json`.
/// @throws HttpProblem 400 saying what is expected
std::string expect_capture_path(std::string_view path);

/// What can be said of a file before any pixel is decoded: kind, size, and why a reconstruction could not use it. The
/// job looks closer.
CaptureFile inspect_capture_file(const std::string& path, std::span<const std::byte> bytes);

/// What is still wrong with a capture as a whole.
struct CaptureVerdict {
    std::vector<std::string> missing;                          ///< paths that cameras.json names and that are not here
    std::vector<std::pair<std::string, std::string>> refused;  ///< path and sentence
    bool is_complete() const { return missing.empty() && refused.empty(); }
};

/// @param cameras_json  the bytes of cameras.json, if it has arrived and was accepted
CaptureVerdict judge_capture(const CaptureRecord& capture, const std::optional<std::string>& cameras_json);

}  // namespace anyrate
