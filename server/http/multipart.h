#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anyrate {

/// One part of a multipart/form-data body (RFC 7578).
struct FormPart {
    std::string name, filename;        ///< of Content-Disposition; empty if not given
    std::string content_type;          ///< empty if not given
    std::span<const std::byte> bytes;  ///< inside the body
};

/// The boundary of a Content-Type `multipart/form-data; boundary=...`.
/// @throws HttpProblem 400 there is none, or none that RFC 2046 allows
std::string multipart_boundary(std::string_view content_type);

/// The parts of a body, 20,000 at most. @throws HttpProblem 400 saying what is wrong with it
std::vector<FormPart> parse_multipart(std::span<const std::byte> body, const std::string& boundary);

}  // namespace anyrate
