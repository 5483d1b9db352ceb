#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/service.h"

namespace anyrate {

/// The path of a file of a capture: `images/NAME`, `masks/NAME` or `NAME.json`.
/// @throws HttpProblem 400 saying what is expected
std::string expect_capture_path(std::string_view path);

/// POST /v1/captures: begins a capture that arrives file by file. With an Idempotency-Key, a repeated request, also of
/// another day, gives the same capture, so that an upload that broke goes on.
Response create_capture(Service& service, const Request& request);
/// GET /v1/captures: a page of them.
Response list_captures(Service& service, const Request& request);
/// GET /v1/captures/{id}: what has arrived, whether each file can be used, and what is missing.
Response show_capture(Service& service, const Request& request);
Response delete_capture(Service& service, const Request& request);

/// PUT /v1/captures/{id}/files/{path}: what can be refused before the body is read.
void check_put_capture_file(Service& service, const Request& request);
/// Takes a file if its bytes have the digest that the request says; 201 for a new one, 200 for one that was replaced.
Response put_capture_file(Service& service, const Request& request);

/// @throws HttpProblem 404 there is no such capture, 422 it is not complete or a file of it cannot be used
void expect_complete_capture(Service& service, const std::string& id);
/// Has a zip looked through before any job begins. @return what was found of each file that the capture needs
/// @throws HttpProblem 422 with every fault @throws IoError
std::vector<CaptureFile> judge_uploaded_zip(Service& service, const std::filesystem::path& zip);
/// Writes the files of such a capture as a zip. @return what was found of them @throws HttpProblem, IoError
std::vector<CaptureFile> zip_arrived_capture(Service& service, const std::string& id, const std::filesystem::path& zip);
/// Replaces a multipart/form-data body in `file` by a zip of the capture in it: one part that is a zip, or its files by
/// their names. @return what was found of them @throws HttpProblem 400, 422 @throws IoError
std::vector<CaptureFile> zip_form(Service& service, std::string_view content_type, const std::filesystem::path& file);

/// A JSON array of such files, as the interface shows them.
std::string capture_files_json(const std::vector<CaptureFile>& files);

}  // namespace anyrate
